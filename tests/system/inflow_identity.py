#!/usr/bin/env python3
"""Material that enters through nozzles that move and turn gives the same bits on any number of ranks and through a restart between two
layers, also where steps are rejected; what has entered is counted, no particle is lost, and the energy account closes."""

import csv
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from identity import expect_closed_account, expect_identical, last_row  # noqa: E402

SCENE = pathlib.Path(__file__).with_name("inflow.toml")
STEPS, INTERRUPTION = 200, 83
VARIANTS = (("apic", [], (2, 3, 7), (3, 2)), ("moment_flip", ['transfer.scheme="moment_flip"'], (3,), (2, 7)),
            ("trials", ['partition.method="metis"', "time.deformation_limit=0.01", "time.trial_interval=1", "time.growth=2"], (3,),
             (3, 2)))
FEEDS = ("disc", "bar")


def run(program, work, out, ranks, steps, overrides, *more):
    sets = [word for override in overrides for word in ("--set", override)]
    outcome = program.run(["run", str(SCENE), "--out", out, "--max-steps", str(steps), *sets, *more], ranks, work, 120)
    if outcome.code not in (0, 4):
        fail(f"{out} on {ranks} ranks ended with {outcome.code}", outcome)
    return work / out


def expect_counted(folder):
    """Every row: particles are those that have entered and those in the feeds, and their mass is right within half a layer."""
    with open(folder / "history.csv", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    for row in rows:
        n = sum(int(row[f"{feed}.{kind}_particles"]) for feed in FEEDS for kind in ("entered", "feed"))
        if n != int(row["particles"]) + int(row["removed_particles"]):
            fail(f"{folder.name}: {n} particles have been born, {row['particles']} are there at step {row['step']}")
        for feed, half_layer in (("disc", 3.2e-3), ("bar", 1.5e-3)):
            off = abs(float(row[f"{feed}.entered [kg]"]) - float(row[f"{feed}.entered_by_particles [kg]"]))
            if not off <= 1.0001 * half_layer:
                fail(f"{folder.name}: inflow {feed} is off by {off} kg at step {row['step']}")
    if not all(float(rows[-1][f"{feed}.entered [kg]"]) > 0.0 for feed in FEEDS):
        fail(f"{folder.name}: nothing has entered")


def main():
    arguments = parse_arguments(__doc__)
    program, work = start(arguments)
    for name, overrides, rank_counts, (before, after) in VARIANTS:
        whole = run(program, work, f"{name}_1", 1, STEPS, overrides)
        expect_closed_account(whole, name)
        expect_counted(whole)
        if name == "trials" and not int(last_row(whole)["rejected_steps"]) > 0:
            fail("no step was rejected")
        for ranks in rank_counts:
            other = run(program, work, f"{name}_{ranks}", ranks, STEPS, overrides)
            expect_identical(program, work, whole, other, STEPS, f"{name}, 1 and {ranks} ranks")
        run(program, work, f"{name}_restart", before, INTERRUPTION, overrides)
        restarted = run(program, work, f"{name}_restart", after, STEPS, overrides, "--restart")
        expect_identical(program, work, whole, restarted, STEPS, f"{name}, restarted on {before} and {after} ranks")
        expect_counted(restarted)


main()
