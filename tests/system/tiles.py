#!/usr/bin/env python3
"""Ranks and tiles in the frames of a run: who works on a tile holds its particles, also after a restart on fewer ranks."""

import pathlib
import sys
import xml.etree.ElementTree as ElementTree

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("splash.toml")
# Of the scene.
LOWER, CELL_SIZE = 0.0, 0.0125
RANKS = (4, 3)  # before and after the restart
MIDDLE = 2  # frame at whose time the first part ends
N_FRAMES = 5


def check_frame(path, n_ranks):
    with h5py.File(path, "r") as frame:
        position, holder = frame["particles/position"][:], frame["particles/rank"][:]
        rank, particles, load = (frame[f"tiles/{name}"][:] for name in ("rank", "particles", "load"))
    # Base node of a quadratic stencil, one node below the domain; four to a tile.
    tile = (numpy.floor((position - LOWER) / CELL_SIZE - 0.5).astype(int) + 1) // 4
    place = (tile[:, 2], tile[:, 1], tile[:, 0])
    counted = numpy.zeros_like(particles)
    numpy.add.at(counted, place, 1)
    if not numpy.array_equal(counted, particles):
        fail(f"{path.name}: {numpy.count_nonzero(counted != particles)} tiles do not hold the particles they are said to")
    if not numpy.array_equal(rank[place], holder):
        fail(f"{path.name}: {numpy.count_nonzero(rank[place] != holder)} particles are not on the rank of their tile")
    if set(numpy.unique(rank)) != set(range(n_ranks)):
        fail(f"{path.name}: tiles are on ranks {numpy.unique(rank)} and should be on all of {n_ranks}")
    if not numpy.all(load[particles > 0] > 0.0):
        fail(f"{path.name}: a tile with particles has no load")


def main():
    program, work = start(parse_arguments(__doc__))

    def run(ranks, *more):
        outcome = program.run(["run", str(SCENE), "--out", "run", "--set", "output.tiles=true",
                               "--set", "output.precision=float64", "--set", 'output.fields=["rank"]', *more],
                              ranks, work, 120)
        if outcome.code != 0:
            fail(f"the run on {ranks} ranks ended with {outcome.code}", outcome)

    run(RANKS[0], "--set", f"time.end={0.005 * MIDDLE}")
    run(RANKS[1], "--set", f"time.end={0.005 * (N_FRAMES - 1)}", "--restart")
    for index in range(N_FRAMES):
        check_frame(work / "run" / f"frame_{index:06d}.h5", RANKS[index > MIDDLE])
    moments = list(ElementTree.parse(work / "run" / "tiles.xdmf").iter("Time"))
    if len(moments) != N_FRAMES:
        fail(f"tiles.xdmf has {len(moments)} moments and should have those before and after the restart, {N_FRAMES}")


if __name__ == "__main__":
    main()
