#!/usr/bin/env python3
"""Free rigid bodies, with explicit and with implicit pressure: the same bits on any number of ranks and through a restart between two
rows of history.csv; momentum and angular momentum of bodies and material conserved, at a body heavier and one far lighter than the
material that it holds; both energy accounts closed, with guides, springs, forces and torques too. Bodies that separate: Coulomb's law,
and no force where material leaves."""

import csv
import math
import pathlib
import re
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from identity import expect_closed_account, expect_identical  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("rigid_bodies.toml")
SEPARATING = SCENE.with_name("separating_bodies.toml")
FRICTION, SLAB = 0.5, 300.0  # of the separating scene: coefficient, mass of the slab in kg
ROUNDING = 1e-12
DRIVEN = {"ball": 'force = ["0", "0", "500"]\nspring = 1e4\n',
          "brick": 'axis = [0.0, 2.0, 0.0]\naxis_point = [0.62, 0.5, 0.6]\nspring = 5.0\ntorque = ["0", "40 * cos(40 * t)", "0"]\n'}
# The jelly as stiff as water, and as many steps in the same time; but where bodies must get through it.
IMEX = ["--set", "time.integrator=imex"]
STIFF = ["--set", "materials.jelly.bulk_modulus=2e9", "--set", "time.dt_max=4e-4"]
BALL = 7800.0 * 4.0 / 3.0 * math.pi * 0.13**3
MASSES = {"ball": BALL, "brick": 0.1}
OF_RANKS = {"imbalance", "repartitions", "moved_particles", "migrated_particles", "halo_bytes_largest [B]",
            "halo_bytes_mean [B]", "wall_time_per_step [s]"}


def rows(folder):
    with open(folder / "history.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def vectors(table, name, unit):
    return numpy.array([[float(row[f"{name}_{axis} [{unit}]"]) for axis in "xyz"] for row in table])


def column(table, name):
    return numpy.array([float(row[name]) for row in table])


def expect_small(error, scale, what):
    worst = numpy.abs(error).max() / scale
    if not worst <= ROUNDING:
        fail(f"{what}: off by {worst:.3g}")
    print(f"{what}: to {worst:.2g}")


def check_sliding(table):
    """The slab loses what the block gains, by the friction's share of what it carries while it slides; the ball leaves as if there were
    no block."""
    expect_small(column(table, "momentum_x [kg m/s]") + SLAB * (column(table, "slab.velocity_x [m/s]") - 3.0), 3.0 * SLAB,
                 "momentum of slab and block")
    pressed = column(table, "slab.force_z [N]")[1:]
    if not (pressed < 0.0).all():
        fail("the slab carries nothing")
    worst = numpy.abs(column(table, "slab.force_x [N]")[1:] / pressed / FRICTION - 1.0).max()
    if not worst <= 1e-3:  # waves in the jelly turn the slip at a node a little
        fail(f"friction is off by {worst:.3g} of Coulomb's")
    print(f"friction: to {worst:.2g}")
    flight = column(table, "ball.velocity_z [m/s]") - 1.0 + 10.0 * column(table, "time [s]")
    expect_small(flight, 1.0, "flight of the ball")


def momentum(table):
    return vectors(table, "momentum", "kg m/s") + sum(
        mass * vectors(table, f"{name}.velocity", "m/s") for name, mass in MASSES.items())


def check_momentum(table):
    """Of all together: that of the weight."""
    total = momentum(table)
    mass = column(table, "mass [kg]")[0] + sum(MASSES.values())
    fall = numpy.outer(column(table, "time [s]"), [0.0, 0.0, -10.0]) * mass
    expect_small(total - fall - total[0], numpy.abs(total).max(), "momentum")


def check_turn(table):
    """Without weight, and with the ball alone: its inertia is the same about any axis."""
    center, velocity = vectors(table, "ball.position", "m"), vectors(table, "ball.velocity", "m/s")
    own = 0.4 * BALL * 0.13**2 * vectors(table, "ball.spin", "rad/s") + BALL * numpy.cross(center, velocity)
    total = vectors(table, "angular_momentum", "kg m^2/s") + own
    expect_small(total - total[0], numpy.abs(own).max(), "angular momentum")


def check_energy(table):
    """What a body gains is the work of gravity, of what drives it and of collisions, less its work on the material and what merging
    takes."""
    for name in MASSES:
        kinetic = column(table, f"{name}.kinetic_energy [J]")
        error = kinetic - kinetic[0] - column(table, f"{name}.gravity_work [J]") - column(
            table, f"{name}.applied_work [J]") + column(table, f"{name}.contact_work [J]") + column(
                table, f"{name}.merging_loss [J]") - column(table, f"{name}.collision_work [J]")
        expect_small(error, kinetic.max(), f"energy of the {name}")
        if not column(table, f"{name}.merging_loss [J]")[-1] > 0.0:
            fail(f"the {name} never met the material")


def driven_scene(work):
    """The brick on an axis with a spring and a torque, the ball on a spring with a force."""
    first, _, second = SCENE.read_text(encoding="utf-8").partition('[[rigid_bodies]]\nname = "brick"\n')
    head, name, ball = first.partition('name = "ball"\n')
    second = second.replace("velocity = [0.0, 0.0, 1.0]\nangular", "angular", 1)
    scene = work / "driven.toml"
    scene.write_text(
        f'{head}{name}{DRIVEN["ball"]}{ball}[[rigid_bodies]]\nname = "brick"\n{DRIVEN["brick"]}{second}', encoding="utf-8")
    return scene


def check_axis(table):
    """The brick's centre stays on its circle."""
    arm = vectors(table, "brick.position", "m") - [0.62, 0.5, 0.6]
    expect_small(numpy.linalg.norm(arm, axis=1) - numpy.linalg.norm(arm[0]), numpy.linalg.norm(arm[0]), "circle of the brick")
    turn = column(table, "brick.turn [rad]")
    angle = numpy.arctan2(arm[:, 0], arm[:, 2])
    expect_small(angle - angle[0] - turn, 1.0, "turn of the brick")
    if not numpy.abs(turn).max() > 0.03:
        fail("the brick does not turn")


def check_reaction(table, name, gravity):
    """What changes a guided body's momentum: material, weight and guide."""
    time, velocity = column(table, "time [s]"), vectors(table, f"{name}.velocity", "m/s")
    guide = vectors(table, f"{name}.guide_force", "N")
    force = vectors(table, f"{name}.force", "N") + guide + MASSES[name] * numpy.array(gravity)
    change = MASSES[name] * numpy.diff(velocity, axis=0)
    given = numpy.diff(time)[:, None] * force[1:]
    expect_small(change - given, numpy.abs(given).max(), f"momentum of the guided {name}")
    if not numpy.abs(guide).max() > 0.0:
        fail(f"the guide of the {name} gives nothing")


def expect_same_history(table, other, what):
    for one, two in zip(table[::-1], other[::-1], strict=False):
        for name in one:
            if name not in OF_RANKS and one[name] != two[name]:
                fail(f"{what}: {name} is {two[name]}, {one[name]} on one rank")


class Test:
    """The runs of one integrator; `stiff`: further settings of all but `collide`."""

    def __init__(self, program, work, name, sets, stiff):
        self.program, self.work, self.name, self.sets, self.stiff = program, work, name, sets, stiff

    def folder(self, out):
        return self.work / f"{self.name}_{out}"

    def run(self, out, ranks, *more, scene=SCENE):
        outcome = self.program.run(["run", str(scene), "--out", self.folder(out), *self.sets, *more], ranks, self.work, 120)
        if outcome.code != 0:
            fail(f"the run {self.name}_{out} on {ranks} ranks ended with {outcome.code}", outcome)
        return rows(self.folder(out))

    def restart(self, out, ranks, source, step, *more, scene=SCENE):
        return self.run(out, ranks, *more, "--restart", str(self.folder(source) / f"checkpoint_{step:09d}.h5"), scene=scene)

    def expect_identical(self, one, other, step):
        expect_identical(self.program, self.work, self.folder(one), self.folder(other), step, f"{self.name}: {other}")

    def steps(self, out):
        """The last checkpoint and one in the middle."""
        steps = sorted(int(re.findall(r"\d+", path.name)[0]) for path in self.folder(out).glob("checkpoint_*.h5"))
        return steps[-1], steps[len(steps) // 2]

    def identity(self):
        table = self.run("one", 1, *self.stiff)
        check_momentum(table)
        check_energy(table)
        expect_closed_account(self.folder("one"), "one")
        last, middle = self.steps("one")
        for ranks in (2, 3, 7):
            other = self.run(f"ranks_{ranks}", ranks, *self.stiff)
            self.expect_identical("one", f"ranks_{ranks}", last)
            expect_same_history(table, other, f"history on {ranks} ranks")
        again = self.restart("again", 3, "one", middle, *self.stiff)
        self.expect_identical("one", "again", last)
        expect_same_history(table, again, "restarted history")

    def drive(self):
        driven = driven_scene(self.work)
        table = self.run("driven", 1, *self.stiff, scene=driven)
        check_energy(table)
        check_axis(table)
        check_reaction(table, "brick", [0.0, 0.0, -10.0])
        last, middle = self.steps("driven")
        again = self.restart("driven_again", 3, "driven", middle, *self.stiff, scene=driven)
        self.expect_identical("driven", "driven_again", last)
        expect_same_history(table, again, "restarted, driven")

    def collide(self, bottom, end):
        """Both bodies fall through jelly down to `bottom` and air onto the floor and each other: on one rank, on three, and restarted in
        between."""
        sets = ["--set", f"time.end={end}", "--set", f"bodies.block.shape.parts.0.lower=[0.15,0.2,{bottom}]", "--set",
                "rigid_bodies.0.velocity=[3,0,-6]", "--set", "rigid_bodies.1.mass=20", "--set", "rigid_bodies.1.velocity=[-3,0,-6]",
                "--set", "rigid_bodies.0.restitution=0.5", "--set", "rigid_bodies.1.restitution=0.5"]
        table = self.run("falls", 1, *sets)
        check_energy(table)
        expect_closed_account(self.folder("falls"), "falls")
        for name in MASSES:
            if not numpy.abs(vectors(table, f"{name}.collision_force", "N")).max() > 0.0:
                fail(f"the {name} hits nothing")
        last, middle = self.steps("falls")
        others = [self.run("falls_3", 3, *sets), self.restart("falls_again", 2, "falls", middle, *sets)]
        for out, other in zip(("falls_3", "falls_again"), others):
            self.expect_identical("falls", out, last)
            expect_same_history(table, other, f"collisions, {out}")

    def separate(self):
        """A block on a slab that slides away below it; then ball and brick in the jelly, which hold what comes towards them only."""
        slides = self.run("slides", 1, *self.stiff, scene=SEPARATING)
        check_sliding(slides)
        loose = ["--set", "rigid_bodies.0.contact=separating", "--set", "rigid_bodies.1.contact=separating", "--set",
                 "rigid_bodies.0.material_friction=0.3", *self.stiff]
        table = self.run("loose", 1, *loose)
        check_momentum(table)
        check_energy(table)
        for out, scene, sets, one in (("slides", SEPARATING, self.stiff, slides), ("loose", SCENE, loose, table)):
            expect_closed_account(self.folder(out), out)
            last, middle = self.steps(out)
            others = [self.run(f"{out}_3", 3, *sets, scene=scene),
                      self.restart(f"{out}_again", 2, out, middle, *sets, scene=scene)]
            for name, other in zip((f"{out}_3", f"{out}_again"), others):
                self.expect_identical(out, name, last)
                expect_same_history(one, other, f"separating, {name}")

    def turn(self):
        """The ball alone, without weight; then with it on a level line, which carries what the jelly does not."""
        text = SCENE.read_text(encoding="utf-8")
        first, _, rest = text.partition('[[rigid_bodies]]\nname = "brick"')
        alone, line = self.work / "alone.toml", self.work / "line.toml"
        alone.write_text(first + rest[rest.index("[output]"):], encoding="utf-8")
        check_turn(self.run("alone", 2, "--set", "gravity=[0,0,0]", *self.stiff, scene=alone))
        guided = alone.read_text(encoding="utf-8").replace("angular_velocity = [0.0, 5.0, 10.0]", "line = [1.0, 0.0, 0.0]")
        line.write_text(guided, encoding="utf-8")
        table = self.run("line", 2, *self.stiff, scene=line)
        check_reaction(table, "ball", [0.0, 0.0, -10.0])
        carried = vectors(table, "ball.guide_force", "N")[1:, 2] + vectors(table, "ball.force", "N")[1:, 2]
        expect_small(carried - 10.0 * BALL, 10.0 * BALL, "weight on the line")


    def warns(self):
        """`check` says that the explicit step makes bodies slow and heavy where particles keep their own volume, and only there."""
        outcome = self.program.run(["check", str(SCENE), *self.sets, *self.stiff], 1, self.work, 60)
        if outcome.code != 0 or ("rigid bodies with the explicit step" in outcome.text) != (self.name == "particle"):
            fail(f"check, {self.name}: exit code {outcome.code}, or a wrong word about rigid bodies", outcome)


def main():
    program, work = start(parse_arguments(__doc__))
    for name, sets, stiff, falls in (("explicit", [], [], (0.15, 0.1)), ("imex", IMEX, STIFF, (0.4, 0.15))):
        test = Test(program, work, name, sets, stiff)
        test.warns()
        test.identity()
        test.drive()
        test.collide(*falls)
        test.turn()
        test.separate()
    Test(program, work, "particle", ["--set", 'transfer.dilation="particle"'], []).warns()
    test = Test(program, work, "cell", ["--set", 'transfer.dilation="cell"'], [])
    test.warns()
    test.identity()
    test.drive()
    test.turn()


if __name__ == "__main__":
    main()
