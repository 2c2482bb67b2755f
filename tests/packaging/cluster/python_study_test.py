#!/usr/bin/env python3
"""A study from Python as a job array in a real Slurm: cases finish on two ranks with the bits of a run without Slurm; one
that is refused and one that fails are rows with the program's sentence; the next array has only what is missing. Ends with
77, and the reason, where no Slurm can be started."""

import os
import pathlib
import sys
import time

import numpy as np

TESTS = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TESTS / "support"), str(TESTS.parent / "drivers/python")]
import bulkley  # noqa: E402
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from slurm_server import CannotRun, Slurm  # noqa: E402
from small_scene import small_scene  # noqa: E402

VELOCITY = "bodies.ball.velocity"
VALUES = [[0, 0, -1], [0, 0, -500], [0, 0], [0, 0, -2]]  # the second fails, the third is refused
LIMIT = 200.0  # s, for all jobs on a busy machine; a quiet one needs ten
SKIPPED = 77


def expect(condition, sentence):
    if not condition:
        for log in sorted(pathlib.Path("out/study").glob("*.log")):
            print(f"--- {log.name}\n{log.read_text(encoding='utf-8', errors='replace')}")
        fail(sentence)


def study(values):
    return bulkley.study(small_scene(), {VELOCITY: values}, ranks=2, slurm={"time": "00:10:00"})


def wait_for(slurm, number):
    """Until no task of the array is queued or runs."""
    end = time.monotonic() + LIMIT
    while slurm.call("squeue", "--noheader", "--jobs", number).stdout.strip():
        expect(time.monotonic() < end, f"the array is not done within {LIMIT:.0f} s: {slurm.call('squeue').stdout}")
        time.sleep(0.5)


def check(slurm):
    made = study(VALUES)
    number = made.submit()
    expect(number.isdigit(), f"sbatch said '{number}'")
    wait_for(slurm, number)
    table = made.table()
    expect(list(table["state"]) == ["finished", "failed", "refused", "finished"], f"states {table['state']}")
    expect("crushed" in table["error"][1] and "'bodies.0.velocity' has 2 entries" in table["error"][2]
           and "\n" not in table["error"][2] and table["error"][0] == "", f"errors {table['error']}")
    expect(np.isfinite(table["reach.reach"][[0, 3]]).all() and np.isnan(table["reach.reach"][2]), "the last rows")
    mine = bulkley.run("out/study/scene.toml", out="mine", sets={VELOCITY: VALUES[0]}).checkpoints[-1]
    theirs = bulkley.open_run("out/study/1")
    rows = theirs.checkpoints[-1].rows_of(mine.ids)
    expect(theirs.status["ranks"] == 2 and np.array_equal(
        theirs.checkpoints[-1]["velocity"][rows], mine["velocity"]), "the bits")
    again = study([*VALUES, [0, 0, -3]])
    array = next(line for line in again.script.read_text(
        encoding="utf-8").splitlines() if line.startswith("#SBATCH --array"))
    expect(array == "#SBATCH --array=3,5", f"the next array: {array}")
    wait_for(slurm, again.submit())
    expect(list(again.table()["state"]) == ["finished", "failed",
           "refused", "finished", "finished"], f"{again.table()['state']}")
    print(f"job {number}: cases finished, failed and refused as they must; then those that were missing")


def main():
    program, work = start(parse_arguments(__doc__))
    os.environ["BULKLEY"] = str(pathlib.Path(program.path).resolve())
    os.chdir(work)
    try:
        with Slurm(pathlib.Path("slurm").resolve()) as slurm:
            os.environ.update(slurm.environment)
            check(slurm)
    except CannotRun as reason:
        print(f"SKIPPED: no Slurm can be run here: {reason}")
        sys.exit(SKIPPED)


if __name__ == "__main__":
    main()
