#!/usr/bin/env python3
"""Free rigid bodies: the same bits on any number of ranks and through a restart between two rows of history.csv; momentum and
angular momentum of bodies and material conserved, at a body heavier and one far lighter than the material that it holds; both
energy accounts closed, with guides, springs, forces and torques too."""

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
ROUNDING = 1e-12
DRIVEN = {"ball": 'force = ["0", "0", "500"]\nspring = 1e4\n',
          "brick": 'axis = [0.0, 2.0, 0.0]\naxis_point = [0.62, 0.5, 0.6]\nspring = 5.0\ntorque = ["0", "40 * cos(40 * t)", "0"]\n'}
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
    (work / "driven.toml").write_text(
        f'{head}{name}{DRIVEN["ball"]}{ball}[[rigid_bodies]]\nname = "brick"\n{DRIVEN["brick"]}{second}', encoding="utf-8")


def check_axis(table):
    """The brick's centre stays on its circle."""
    arm = vectors(table, "brick.position", "m") - [0.62, 0.5, 0.6]
    expect_small(numpy.linalg.norm(arm, axis=1) - numpy.linalg.norm(arm[0]), numpy.linalg.norm(arm[0]), "circle of the brick")
    turn = column(table, "brick.turn [rad]")
    angle = numpy.arctan2(arm[:, 0], arm[:, 2])
    expect_small(angle - angle[0] - turn, 1.0, "turn of the brick")
    if not numpy.abs(turn).max() > 0.05:
        fail("the brick does not turn")


def collide(program, work, run):
    """Both bodies fall through jelly and air onto the floor and each other: on one rank, on three, and restarted in between."""
    sets = ["--set", "time.end=0.1", "--set", "bodies.block.shape.parts.0.lower=[0.15,0.2,0.15]", "--set",
            "rigid_bodies.0.velocity=[3,0,-6]", "--set", "rigid_bodies.1.mass=20", "--set", "rigid_bodies.1.velocity=[-3,0,-6]",
            "--set", "rigid_bodies.0.restitution=0.5", "--set", "rigid_bodies.1.restitution=0.5"]
    run("falls", 1, *sets)
    table = rows(work / "falls")
    check_energy(table)
    for name in MASSES:
        if not numpy.abs(vectors(table, f"{name}.collision_force", "N")).max() > 0.0:
            fail(f"the {name} hits nothing")
    steps = sorted(int(re.findall(r"\d+", path.name)[0]) for path in (work / "falls").glob("checkpoint_*.h5"))
    last, middle = steps[-1], steps[len(steps) // 2]
    run("falls_3", 3, *sets)
    expect_identical(program, work, work / "falls", work / "falls_3", last, "collisions on 3 ranks")
    run("falls_again", 2, *sets, "--restart", str(work / "falls" / f"checkpoint_{middle:09d}.h5"))
    expect_identical(program, work, work / "falls", work / "falls_again", last, "collisions, restarted on 2 ranks")
    for one, *others in zip(table[::-1], rows(work / "falls_3")[::-1], rows(work / "falls_again")[::-1], strict=False):
        for name in one:
            if name not in OF_RANKS and any(other[name] != one[name] for other in others):
                fail(f"collisions: {name} is {one[name]} on one rank, {[other[name] for other in others]} on others")


def main():
    program, work = start(parse_arguments(__doc__))

    def run(out, ranks, *more, scene=SCENE):
        outcome = program.run(["run", str(scene), "--out", out, *more], ranks, work, 120)
        if outcome.code != 0:
            fail(f"the run in {out} on {ranks} ranks ended with {outcome.code}", outcome)

    run("one", 1)
    table = rows(work / "one")
    check_momentum(table)
    check_energy(table)
    expect_closed_account(work / "one", "one")
    steps = sorted(int(re.findall(r"\d+", path.name)[0]) for path in (work / "one").glob("checkpoint_*.h5"))
    last, middle = steps[-1], steps[len(steps) // 2]
    for ranks in (2, 3, 7):
        run(f"ranks_{ranks}", ranks)
        expect_identical(program, work, work / "one", work / f"ranks_{ranks}", last, f"on {ranks} ranks")
        for one, other in zip(table, rows(work / f"ranks_{ranks}"), strict=True):
            for name in one:
                if name not in OF_RANKS and one[name] != other[name]:
                    fail(f"history on {ranks} ranks: {name} is {other[name]}, {one[name]} on one")
    run("again", 3, "--restart", str(work / "one" / f"checkpoint_{middle:09d}.h5"))
    expect_identical(program, work, work / "one", work / "again", last, "restarted on 3 ranks")
    if rows(work / "again")[-1]["ball.force_x [N]"] != table[-1]["ball.force_x [N]"]:
        fail("the restarted run gives another force")
    driven_scene(work)
    run("driven", 1, scene="driven.toml")
    table = rows(work / "driven")
    check_energy(table)
    check_axis(table)
    run("driven_again", 3, "--restart", str(work / "driven" / f"checkpoint_{middle:09d}.h5"), scene="driven.toml")
    if rows(work / "driven_again")[-1]["brick.turn [rad]"] != table[-1]["brick.turn [rad]"]:
        fail("the restarted run turns the brick elsewhere")
    collide(program, work, run)
    text = SCENE.read_text(encoding="utf-8")
    first, _, rest = text.partition('[[rigid_bodies]]\nname = "brick"')
    (work / "alone.toml").write_text(first + rest[rest.index("[output]"):], encoding="utf-8")
    outcome = program.run(["run", "alone.toml", "--out", "alone", "--set", "gravity=[0,0,0]"], 2, work, 120)
    if outcome.code != 0:
        fail("the run with the ball alone failed", outcome)
    check_turn(rows(work / "alone"))


if __name__ == "__main__":
    main()
