#!/usr/bin/env python3
"""No rank holds what grows with the number of ranks, but for some bytes each: as a layer grows with them, the most that a rank allocates at
one time (allocation_shim.cpp) stays the same, through seeding, steps, new maps by bisection, checkpoints and a restart."""

import pathlib
import statistics
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

RANKS = (16, 64)  # powers of two: parts alike
BYTES = 48  # of a rank and rank: a map has 8, and 16 more while it is made
CELL, WIDTH, PARTICLES = 0.0125, 16, 4096  # m; cells across; particles of a rank
SCENE = """title = "layer"
gravity = [0.0, 0.0, -9.81]
[domain]
lower = [0.0, 0.0, 0.0]
upper = [{length}, {width}, {width}]
cell_size = {cell}
[time]
end = 1.0
[materials.cream]
preset = "cream"
[[bodies]]
name = "layer"
material = "cream"
shape = {{ type = "box", lower = [0.0, 0.0, 0.0], upper = [{length}, {width}, {height}] }}
[boundaries]
z_lower = "sticky"
[partition]
method = "bisection"
remake_interval = 7
[checkpoint]
steps = 10
"""
CASES = (("new", "10", ()), ("restart", "20", ("--restart",)))


def main():
    arguments = parse_arguments(__doc__, lambda parser: parser.add_argument("--shim", required=True))
    program, work = start(arguments)
    medians = {}
    for ranks in RANKS:
        scene = work / f"layer_{ranks}.toml"
        length, width = 4 * CELL * ranks, WIDTH * CELL  # four cells of the length for a rank
        scene.write_text(SCENE.format(length=length, width=width, height=width / 2, cell=CELL), encoding="utf-8")
        for name, steps, more in CASES:
            log = work / f"{name}_{ranks}.log"
            outcome = program.run(["run", str(scene), "--out", f"layer_{ranks}", "--max-steps", steps, *more], ranks, work, 200,
                                  {"LD_PRELOAD": arguments.shim, "ALLOCATION_LOG": str(log)})
            if outcome.code != 0 or f"{PARTICLES * ranks} particles" not in outcome.text:
                fail(f"{name} on {ranks} ranks ended with {outcome.code}", outcome)
            most = dict(tuple(map(int, line.split())) for line in log.read_text(encoding="utf-8").splitlines())
            if sorted(most) != list(range(ranks)):
                fail(f"{name} on {ranks} ranks: allocations of ranks {sorted(most)}")
            medians[name, ranks] = statistics.median(most[rank] for rank in most if rank > 0)  # the root writes more
            print(f"{name} on {ranks} ranks: {medians[name, ranks]:.0f} bytes a rank, the root {most[0]}", flush=True)
    few, many = RANKS
    for name, _, _ in CASES:
        growth = (medians[name, many] - medians[name, few]) / (many - few)
        if growth > BYTES:
            fail(f"{name}: {growth:.0f} bytes of a rank for each rank, at most {BYTES} are expected")


if __name__ == "__main__":
    main()
