#!/usr/bin/env python3
"""Material that enters through nozzles that move and turn gives the same bits on any number of ranks and through a restart between two
layers, also where steps are rejected, with an implicit pressure and with implicit viscosity; what has entered is counted, no particle is lost, and the accounts of energy and
momentum close."""

import csv
import math
import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from identity import expect_closed_account, expect_identical, last_row  # noqa: E402

SCENE = pathlib.Path(__file__).with_name("inflow.toml")
STEPS, INTERRUPTION = 200, 83
IMPLICIT_STEPS, IMPLICIT_INTERRUPTION = 80, 27
IMEX = ["time.integrator=imex", "materials.fluid.bulk_modulus=2e9", "time.dt_max=1e-3"]  # until material meets the floor
MEASURED = ["inflows.0.pressure=measured",  # with a block in front of the exit
            'bodies=[{name="block", material="fluid", shape={type="box", lower=[0.045, 0.06, 0.09], upper=[0.075, 0.1, 0.12]}}]']
PROFILES = [f"inflows.{n}.profile=poiseuille" for n in (0, 1)]
VARIANTS = (("apic", [], (2, 3, 7), (3, 2)), ("moment_flip", ['transfer.scheme="moment_flip"', *MEASURED], (3,), (2, 7)),
            ("trials", ['partition.method="metis"', "time.deformation_limit=0.01", "time.trial_interval=1", "time.growth=2"], (3,),
             (3, 2)), ("imex", [*IMEX, "rigid_bodies.0.velocity=[0, 0, 1.5]"], (2, 3, 7), (3, 2)),  # the rigid body is thrown up to the jets
            ("viscous", [*IMEX, "rigid_bodies=[]", "transfer.scheme=moment_flip", "transfer.order=cubic", "time.viscosity=implicit", *MEASURED],
             (3,), (2, 7)), ("profile", [*PROFILES, "transfer.scheme=apic"], (2, 3), (3, 2)),
            ("profile_imex", [*IMEX, *PROFILES, "rigid_bodies=[]", "transfer.scheme=moment_flip", "time.viscosity=implicit", *MEASURED], (2, 3), (2, 3)))
FEEDS = ("disc", "bar")
LUMP = 2000.0 * 4.0 / 3.0 * math.pi * 0.025**3  # kg, the rigid body
GRAVITY = numpy.array([0.0, 0.0, -9.81])


def run(program, work, out, ranks, steps, overrides, *more):
    sets = [word for override in overrides for word in ("--set", override)]
    outcome = program.run(["run", str(SCENE), "--out", out, "--max-steps", str(steps), *sets, *more], ranks, work, 120)
    if outcome.code not in (0, 4):
        fail(f"{out} on {ranks} ranks ended with {outcome.code}", outcome)
    return work / out


def expect_counted(folder, n_seeded):
    """Every row: particles are those of bodies, those that have entered and those in the feeds, and their mass is right within half a layer."""
    with open(folder / "history.csv", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    for row in rows:
        n = n_seeded + sum(int(row[f"{feed}.{kind}_particles"]) for feed in FEEDS for kind in ("entered", "feed"))
        if n != int(row["particles"]) + int(row["removed_particles"]):
            fail(f"{folder.name}: {n} particles have been born, {row['particles']} are there at step {row['step']}")
        for feed, half_layer in (("disc", 3.2e-3), ("bar", 1.5e-3)):
            off = abs(float(row[f"{feed}.entered [kg]"]) - float(row[f"{feed}.entered_by_particles [kg]"]))
            if not off <= 1.0001 * half_layer:
                fail(f"{folder.name}: inflow {feed} is off by {off} kg at step {row['step']}")
    if not all(float(rows[-1][f"{feed}.entered [kg]"]) > 0.0 for feed in FEEDS):
        fail(f"{folder.name}: nothing has entered")


def expect_momentum(folder):
    """Of the material and of the rigid body: what gravity, nozzles and the collider give in each step, but for rounding."""
    with open(folder / "history.csv", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))

    def column(name):
        return numpy.array([float(row[name]) for row in rows])

    def vectors(name, unit):
        return numpy.stack([column(f"{name}_{axis} [{unit}]") for axis in "xyz"], axis=1)

    duration = numpy.diff(column("time [s]"))[:, None]
    mass = column("mass [kg]")[:-1, None]
    momentum = vectors("momentum", "kg m/s")
    if "lump.velocity_x [m/s]" in rows[0]:
        mass = mass + LUMP
        momentum = momentum + LUMP * vectors("lump.velocity", "m/s")
    received = sum(vectors(f"{feed}.feed_force", "N") - vectors(f"{feed}.force", "N") for feed in FEEDS) - vectors("arm.force", "N")
    off = numpy.abs(numpy.diff(momentum, axis=0) - duration * (received[1:] + mass * GRAVITY)).max()
    if not off <= 1e-13 * numpy.abs(momentum).max():
        fail(f"{folder.name}: momentum is off by {off} kg m/s in a step")


def largest_pressure(folder):
    """At which the disc's material has entered, Pa."""
    with open(folder / "history.csv", encoding="utf-8") as table:
        return max(float(row["disc.pressure [Pa]"]) for row in csv.DictReader(table))


def expect_same_feeds(one, other, what):
    """What the nozzles remember, in the last rows."""
    for feed in FEEDS:
        for column in ("pressure [Pa]", "pushed_back_particles"):
            ours, theirs = (last_row(folder)[f"{feed}.{column}"] for folder in (one, other))
            if ours != theirs:
                fail(f"{what}: {feed}.{column} is {ours} and {theirs}")


def main():
    arguments = parse_arguments(__doc__)
    program, work = start(arguments)
    for name, overrides, rank_counts, (before, after) in VARIANTS:
        implicit = IMEX[0] in overrides
        steps, interruption = (IMPLICIT_STEPS, IMPLICIT_INTERRUPTION) if implicit else (STEPS, INTERRUPTION)
        n_seeded = 6 * 8 * 6 if MEASURED[0] in overrides else 0
        whole = run(program, work, f"{name}_1", 1, steps, overrides)
        expect_closed_account(whole, name)
        expect_counted(whole, n_seeded)
        expect_momentum(whole)
        if MEASURED[0] in overrides and not largest_pressure(whole) > 0.0:
            fail(f"{name}: no pressure was measured")
        if name == "trials" and not int(last_row(whole)["rejected_steps"]) > 0:
            fail("no step was rejected")
        for ranks in rank_counts:
            other = run(program, work, f"{name}_{ranks}", ranks, steps, overrides)
            expect_identical(program, work, whole, other, steps, f"{name}, 1 and {ranks} ranks")
            expect_same_feeds(whole, other, f"{name}, 1 and {ranks} ranks")
        run(program, work, f"{name}_restart", before, interruption, overrides)
        restarted = run(program, work, f"{name}_restart", after, steps, overrides, "--restart")
        expect_identical(program, work, whole, restarted, steps, f"{name}, restarted on {before} and {after} ranks")
        expect_same_feeds(whole, restarted, f"{name}, restarted")
        expect_counted(restarted, n_seeded)


main()
