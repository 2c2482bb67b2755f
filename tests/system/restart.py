#!/usr/bin/env python3
"""A run interrupted at three different steps and restarted on other rank counts equals the whole one, bit for bit; also where
every step makes a new map of tiles to ranks."""

import csv
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("splash.toml")
STEPS = 200
# (step of the interruption, ranks before, ranks after)
INTERRUPTIONS = ((37, 3, 2), (90, 1, 4), (151, 4, 3))
# step of the interruption, ranks and method before, ranks and method after; a new map after every step
FORCED = ((50, 5, "metis", 3, "hilbert"), (120, 2, "hilbert", 8, "metis"))


def checkpoint(step):
    return f"checkpoint_{step:09d}.h5"


def steps_of_history(folder):
    with open(folder / "history.csv", newline="", encoding="utf-8") as file:
        return [int(row[0]) for row in list(csv.reader(file))[1:]]


def main():
    program, work = start(parse_arguments(__doc__))

    def forced(method):
        return ["--set", f"partition.method={method}", "--set", "partition.remake_interval=1"]

    def run(out, ranks, max_steps, *more):
        outcome = program.run(["run", str(SCENE), "--out", out, "--max-steps", str(max_steps), *more], ranks, work, 120)
        if outcome.code != 0:
            fail(f"the run in {out} to step {max_steps} on {ranks} ranks ended with {outcome.code}", outcome)

    run("whole", 2, STEPS)
    cases = [(step, before, [], after, []) for step, before, after in INTERRUPTIONS]
    cases += [(step, before, forced(first), after, forced(second)) for step, before, first, after, second in FORCED]
    for step, before, settings_before, after, settings_after in cases:
        out = f"parted{step}"
        run(out, before, step, *settings_before)
        if not (work / out / checkpoint(step)).exists():
            fail(f"no checkpoint at step {step}")
        run(out, after, STEPS, "--restart", *settings_after)
        compare = program.run(["compare", f"whole/{checkpoint(STEPS)}", f"{out}/{checkpoint(STEPS)}"], 1, work, 60)
        if compare.code != 0 or "identical" not in compare.text:
            fail(f"interrupted at step {step} on {before} ranks, restarted on {after}: different", compare)
        if steps_of_history(work / out) != steps_of_history(work / "whole"):
            fail(f"history.csv of the run interrupted at step {step} does not have the rows of the whole run")
        print(f"interrupted at step {step} on {before} ranks, restarted on {after}: identical")


if __name__ == "__main__":
    main()
