#!/usr/bin/env python3
"""Gauges and fronts of a whole run: water at rest presses with its weight on walls of every kind, in a slab too; columns of
history.csv are the same bits on any number of ranks and through restarts between two rows; empty patches are refused."""

import csv
import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
G, DENSITY, DEPTH, WIDTH = 9.81, 1000.0, 0.1, 0.1
BULK = 1e5
WEIGHT = DENSITY * G * DEPTH * WIDTH**2
SHRINKAGE = DENSITY * G * DEPTH / BULK  # of the lowest water; the linear theory of a column that settles
SIDE = 0.5 * DENSITY * G * DEPTH**2 * WIDTH * (1.0 - 2.0 / 3.0 * SHRINKAGE)
MEASURED = (".reach [m]", " [N]", ".pressure [Pa]", "thickness_decile [cells]")

# Kind of the walls, and how far pressure (of the disc and the strip) and the force on a side wall may be off. Next to a sticky wall
# half a cell of the water does not settle; a separating wall acts within a cell of its plane.
TANKS = (("slip", 0.002, 0.002), ("sticky", 0.02, 0.07), ("separating", 0.04, 0.005))


def pressure_at(height):
    """Of the settled column, Pa: the weight of what was above the point that has sunk to `height`."""
    sunk = SHRINKAGE * (height - 0.5 * height**2 / DEPTH)
    return DENSITY * G * (DEPTH - height - sunk)


def table_of(folder):
    with open(folder / "history.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def measured(folder):
    return [{name: value for name, value in row.items() if name.endswith(MEASURED)} for row in table_of(folder)]


class Test:
    def __init__(self, program, work):
        self.program, self.work = program, work

    def run(self, out, scene, ranks, *settings, arguments=()):
        more = [word for setting in settings for word in ("--set", setting)]
        outcome = self.program.run(["run", str(HERE / scene), "--out", out, "--quiet", *more, *arguments], ranks, self.work, 300)
        if outcome.code != 0:
            fail(f"the run in {out} on {ranks} ranks ended with {outcome.code}", outcome)
        return self.work / out

    def expect(self, what, value, truth, tolerance):
        error = value / truth - 1.0
        print(f"{what}: {value:.5g}, {truth:.5g} expected: {100.0 * error:+.2f} %")
        if not abs(error) <= tolerance:
            fail(f"{what} is {100.0 * error:.2f} % off, more than {100.0 * tolerance:g} %")

    def tank(self, kind, pressure_error, side_error):
        walls = [f"boundaries.{face}={kind}" for face in ("x_lower", "x_upper", "y_lower", "y_upper", "z_lower")]
        if kind == "separating":  # by cells the pressure of a cell is a constant, and the strip reads 4.4 % low (docs/known-limits.md)
            walls.append("transfer.dilation=particle")
        self.at_rest(kind, walls, pressure_error, side_error, WIDTH)

    def at_rest(self, kind, settings, pressure_error, side_error, width, radius=0.03):
        rows = [row for row in table_of(self.run(kind, "tank.toml", 2, *settings)) if float(row["time [s]"]) > 0.4]

        def mean(name):
            return float(numpy.mean([float(row[name]) for row in rows]))
        self.expect(f"{kind}: pressure amid the floor", mean("disc.pressure [Pa]"), DENSITY * G * DEPTH, pressure_error)
        self.expect(f"{kind}: force on the disc", -mean("disc.force_z [N]"), DENSITY * G * DEPTH * numpy.pi * radius**2,
                    pressure_error)
        self.expect(f"{kind}: pressure on the strip", mean("strip.pressure [Pa]"), pressure_at(0.0425),
                    pressure_error)
        self.expect(f"{kind}: force on a side wall", mean("right.force_x [N]"), SIDE * width / WIDTH, side_error)
        self.expect(f"{kind}: both side walls", mean("right.force_x [N]"), -mean("left.force_x [N]"), 1e-6)
        if kind != "sticky":  # there the side walls carry some of it
            self.expect(f"{kind}: force on the floor", -mean("floor.force_z [N]"), WEIGHT * width / WIDTH, 0.001)
        self.expect(f"{kind}: top", mean("top.reach [m]"), DEPTH - 0.25 * 0.0125, 0.02)
        self.expect(f"{kind}: thickness", mean("thickness_decile [cells]"), 8.0, 1e-9)

    def same_on_any_ranks(self):
        extra = ['output.gauge=[{name="all",face="z_lower"},{name="disc",face="z_lower",center=[0.2,0.2,0],radius=0.09},'
                 '{name="rod",collider="bar",lower=[0,0,0],upper=[0.3,0.2,1]}]',
                 'output.front=[{name="r",axis=[0,0,1],origin=[0.15,0.17,0],quantile=0.9,material="cream"},'
                 '{name="x",direction=[1,0,0],eye=[0.1,0.1,2]}]',
                 'colliders=[{name="bar",velocity=[0.1,0,0],shape={type="box",lower=[0.1,0.1,0.02],upper=[0.2,0.3,0.08]}}]',
                 "output.history_interval=7", "domain.cell_size=0.025", "output.frame_interval=0"]
        steps = ("--max-steps", "40")
        one = measured(self.run("one", "splash.toml", 1, *extra, arguments=steps))
        moved = {name for name in one[0] if len({row[name] for row in one}) > 2}
        if len(one) < 6 or len(moved) < 15:
            fail(f"little is measured: {len(one)} rows, {sorted(moved)} change")
        for ranks in (2, 3, 7):
            if measured(self.run(f"r{ranks}", "splash.toml", ranks, *extra, arguments=steps)) != one:
                fail(f"what is measured on {ranks} ranks differs from one rank")
        self.run("parted", "splash.toml", 3, *extra, arguments=("--max-steps", "25"))
        if measured(self.run("parted", "splash.toml", 2, *extra, arguments=(*steps, "--restart"))) != one:
            fail("what is measured differs after a restart between two rows")
        print(f"{len(one)} rows of {len(one[0])} columns: the same on 1, 2, 3 and 7 ranks and through a restart")

    def refuses_empty_patches(self):
        for command in ("run", "check"):
            outcome = self.program.run([command, str(HERE / "tank.toml"), "--set", "output.gauge.3.center=[0.04,0.05,0.06]",
                                        *(("--out", "refused") if command == "run" else ())], 2, self.work, 60)
            if outcome.code != 2 or "gauge 'disc' covers nothing of face 'z_lower'" not in outcome.text:
                fail(f"{command} of an empty patch", outcome)
            if "tank.toml:" not in outcome.text:
                fail("the place is missing", outcome)
        check = self.program.run(["check", str(HERE / "tank.toml")], 1, self.work, 60)
        if check.code != 0 or "disc: 0.002827 m^2 of z_lower, 28 nodes" not in check.text:
            fail("check does not tell what a patch covers", check)


def main():
    test = Test(*start(parse_arguments(__doc__)))
    test.refuses_empty_patches()
    test.same_on_any_ranks()
    for tank in TANKS:
        test.tank(*tank)
    # A slab four cells thick, whose gauges reach across both ends of the periodic axis.
    test.at_rest("slab", ["domain.upper=[0.1,0.05,0.15]", "bodies.0.shape.upper=[0.1,0.05,0.1]", "boundaries.y_lower=periodic",
                          "boundaries.y_upper=periodic", "output.gauge.3.center=[0.04,0.025,0]",
                          "output.gauge.3.radius=0.024", "output.gauge.4.lower=[0.1,0.01,0.03]",
                          "output.gauge.4.upper=[0.1,0.04,0.055]"], 0.002, 0.002, 0.05, 0.024)


if __name__ == "__main__":
    main()
