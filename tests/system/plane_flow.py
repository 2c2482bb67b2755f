#!/usr/bin/env python3
"""A plane flow, a domain of one cell between periodic faces and one layer of particles, is the slice of a slab of four cells: the same
motion of every particle, across any axis, with either integrator; the same bits on any number of ranks and through a restart, and the same nodes in frames."""

import csv
import pathlib
import sys

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

DX, CELLS = 0.01, (24, 12)  # along the flow and up
STEPS, STOP = 80, 40
IMEX = ["time.integrator=imex", "materials.paste.bulk_modulus=1e8", "time.pressure.tolerance=1e-10"]
AXES = {"x": "yz", "y": "xz", "z": "xy"}     # by axis across the flow: those of the flow
SLICED = {"explicit": 1e-12, "imex": 1e-8}   # of the largest number, what a slab's may differ by: rounding; the tolerance of the pressure


def vector(axis, flow, up, across):
    values = dict(zip(AXES[axis], (flow, up))) | {axis: across}
    return f"[{values['x']:.6g}, {values['y']:.6g}, {values['z']:.6g}]"


def scene(axis, width):
    """A box of paste falls from a wall onto a floor with a step and an elastic bar on it; all of it `width` cells thick along `axis`."""
    flow, up = AXES[axis]
    depth, length, height = width * DX, CELLS[0] * DX, CELLS[1] * DX
    return f"""
gravity = {vector(axis, 0.0, -9.81, 0.0)}
[domain]
lower = [0.0, 0.0, 0.0]
upper = {vector(axis, length, height, depth)}
cell_size = {DX}
[time]
end = 1.0
[materials.paste]
law = "herschel_bulkley"
density = 1000.0
bulk_modulus = 5e4
shear_modulus = 5e3
yield_stress = 20.0
consistency = 1.0
flow_index = 0.5
[materials.rubber]
law = "neo_hookean"
density = 1100.0
bulk_modulus = 5e4
shear_modulus = 2e4
[[bodies]]
name = "dam"
material = "paste"
shape = {{ type = "box", lower = [0.0, 0.0, 0.0], upper = {vector(axis, 0.08, 0.08, depth)} }}
velocity = {vector(axis, 1.0, 0.0, 0.0)}
[[bodies]]
name = "bar"
material = "rubber"
shape = {{ type = "cylinder", start = {vector(axis, 0.13, 0.03, 0.0)}, end = {vector(axis, 0.13, 0.03, depth)}, radius = 0.025 }}
[[colliders]]
name = "step"
shape = {{ type = "box", lower = {vector(axis, 0.18, -1.0, -1.0)}, upper = {vector(axis, 1.0, 0.033, 1.0)} }}
contact = "separating"
friction = 0.3
[boundaries]
{axis}_lower = "periodic"
{axis}_upper = "periodic"
{up}_upper = "outflow"
[[output.gauge]]
name = "floor"
face = "{up}_lower"
[output]
frame_interval = 0.01
grid = true
history_interval = 10
[checkpoint]
keep = 9
"""


class Test:
    def __init__(self, program, work):
        self.program, self.work = program, work

    def run(self, out, file, ranks, steps, *more):
        sets = [word for override in more if override != "--restart" for word in ("--set", override)]
        restart = ["--restart"] if "--restart" in more else []
        outcome = self.program.run(["run", file, "--out", out, "--max-steps", str(steps), *restart, *sets], ranks, self.work, 200)
        if outcome.code != 0:
            fail(f"the run in {out} on {ranks} ranks ended with {outcome.code}", outcome)
        return self.work / out / f"checkpoint_{steps:09d}.h5"

    def expect_identical(self, one, other, what):
        compare = self.program.run(["compare", str(one), str(other)], 1, self.work, 60)
        if compare.code != 0 or "identical" not in compare.text:
            fail(f"{what}: different", compare)
        print(f"{what}: identical")


def particles_of(checkpoint):
    with h5py.File(checkpoint) as file:
        return {name: file["particles"][name][...] for name in ("id", "position", "velocity", "volume_ratio")}


def slice_of(slab, axis):
    """The particles of a slab of four cells that began in the first layer of two in its first, by their ids in the plane flow, which has
    one layer."""
    cell, place = numpy.divmod(slab["id"], 64)
    n = [{AXES[axis][0]: CELLS[0], AXES[axis][1]: CELLS[1], axis: 4}[letter] for letter in "xyz"]
    body, cell = numpy.divmod(cell, n[0] * n[1] * n[2])
    at = dict(zip("xyz", (cell // (n[1] * n[2]), cell // n[2] % n[1], cell % n[2])))
    first = (at[axis] == 0) & (place >> (2 - "xyz".index(axis)) & 1 == 0)
    flat = (body * CELLS[0] + at[AXES[axis][0]]) * CELLS[1] + at[AXES[axis][1]]
    order = numpy.argsort((64 * flat + place)[first])
    return (64 * flat + place)[first][order], {name: values[first][order] for name, values in slab.items()}


def expect_slice(plane, slab, axis, kind):
    ids, found = slice_of(slab, axis)
    order = numpy.argsort(plane["id"])
    if not numpy.array_equal(plane["id"][order], ids):
        fail(f"plane flow across {axis}: other particles than in the slab")
    along = [letter in AXES[axis] for letter in "xyz"]
    for name in ("position", "velocity", "volume_ratio"):
        one, four = plane[name][order], found[name]
        if name == "position":
            one, four = one[:, along], four[:, along]
        off = numpy.abs(one - four).max() / numpy.abs(four).max()
        print(f"across {axis}, {kind}: {name} of {len(ids)} particles within {off:.1e} of the slab's")
        if not off <= SLICED[kind]:
            fail(f"plane flow across {axis}, {kind}: {name} is {off:.2e} off that of the slab")
    across = numpy.abs(plane["velocity"][:, "xyz".index(axis)]).max()
    if not across <= 1e-12 * numpy.abs(plane["velocity"]).max():
        fail(f"plane flow across {axis}: particles move across it with {across:.2e} m/s")


def force_on_floor(run, up):
    """N, the mean since the row before the last."""
    with open(run / "history.csv", newline="") as file:
        return float(list(csv.DictReader(file))[-1][f"floor.force_{up} [N]"])


def check_slices(test):
    for axis in AXES:
        for width in (1, 4):
            (test.work / f"{axis}{width}.toml").write_text(scene(axis, width))
        for kind, sets in (("explicit", []), ("imex", IMEX)):
            dt = ["time.mode=fixed", f"time.dt={2e-4 if kind == 'explicit' else 5e-4}"]
            files = [test.run(f"{kind}_{axis}{width}", f"{axis}{width}.toml", 1, STEPS, *dt, *sets) for width in (1, 4)]
            expect_slice(*(particles_of(file) for file in files), axis, kind)
            one, four = (force_on_floor(file.parent, AXES[axis][1]) for file in files)
            if not abs(4.0 * one / four - 1.0) <= SLICED[kind] or not abs(one) > 0.1:
                fail(f"plane flow across {axis}, {kind}: {one} N on the floor, a slab of four cells has {four} N")


def check_bits(test):
    for axis, kind, sets in (("y", "explicit", []), ("z", "imex", IMEX), ("x", "explicit", ["transfer.order=cubic", "transfer.scheme=apic"])):
        one = test.run(f"one_{axis}", f"{axis}1.toml", 1, STEPS, *sets)
        for ranks, method in ((2, "auto"), (3, "hilbert"), (5, "metis")):
            many = test.run(f"r{ranks}_{axis}", f"{axis}1.toml", ranks, STEPS, f"partition.method={method}", *sets)
            test.expect_identical(one, many, f"across {axis}, {kind}, {ranks} ranks, {method}")
        test.run(f"parted_{axis}", f"{axis}1.toml", 2, STOP, *sets)
        parted = test.run(f"parted_{axis}", f"{axis}1.toml", 3, STEPS, "--restart", *sets)
        test.expect_identical(one, parted, f"across {axis}, {kind}, 2 ranks continued on 3")
        frames = sorted((test.work / f"one_{axis}").glob("frame_*.h5"))
        if len(frames) < 2:
            fail(f"across {axis}: {len(frames)} frames")
        with h5py.File(frames[-1]) as of_one, h5py.File(test.work / f"r3_{axis}" / frames[-1].name) as of_three:
            mass = of_one["grid"]["mass_density"][...]
            if not (mass == of_three["grid"]["mass_density"][...]).all() or not mass.max() > 500.0:
                fail(f"across {axis}: nodes of {frames[-1].name} differ, or are empty")
            if mass.shape["zyx".index(axis)] != 1:
                fail(f"across {axis}: the frame has {mass.shape} nodes")


def main():
    test = Test(*start(parse_arguments(__doc__)))
    check_slices(test)
    check_bits(test)


if __name__ == "__main__":
    main()
