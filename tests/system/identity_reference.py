#!/usr/bin/env python3
"""The run on one rank that identity.py compares others with, that its energy account closes, and that the comparison can say no:
200 steps of a splash, and of one with another velocity."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from identity import expect_closed_account  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("splash.toml")
STEPS = 200
CHECKPOINT = f"checkpoint_{STEPS:09d}.h5"


def splash(program, work, out, ranks, *sets):
    """A run of the splash into work/out on `ranks` ranks; each of `sets` is a key and its value."""
    settings = [word for key in sets for word in ("--set", key)]
    run = program.run(["run", str(SCENE), "--out", out, "--max-steps", str(STEPS), *settings], ranks, work, 120)
    if run.code != 0:
        fail(f"the run {out} on {ranks} ranks ended with {run.code}", run)
    return run


def main():
    program, work = start(parse_arguments(__doc__))
    splash(program, work, "r1", 1)  # one rank needs no partition: the default method
    expect_closed_account(work / "r1", "splash")
    splash(program, work, "other", 2, "bodies.ball.velocity=[1.0, 0.0, -5.000000000001]")
    compare = program.run(["compare", f"r1/{CHECKPOINT}", f"other/{CHECKPOINT}"], 1, work, 60)
    if compare.code != 1 or "identical" in compare.text:
        fail("a run from another initial velocity is called identical", compare)


if __name__ == "__main__":
    main()
