#!/usr/bin/env python3
"""The same bits on any number of ranks: 200 steps of a splash on 1, 2, 3, 4, 7 and 8 ranks under one partition method."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("splash.toml")
STEPS = 200
RANKS = (1, 2, 3, 4, 7, 8)
CHECKPOINT = f"checkpoint_{STEPS:09d}.h5"


def main():
    arguments = parse_arguments(__doc__, lambda p: p.add_argument("--partition", required=True))
    program, work = start(arguments)

    for ranks in RANKS:
        out = f"r{ranks}"
        # One rank needs no partition: its run is the reference for both methods, made with the default one.
        method = [] if ranks == 1 else ["--set", f"partition.method={arguments.partition}"]
        run = program.run(["run", str(SCENE), "--out", out, "--max-steps", str(STEPS), *method], ranks, work, 120)
        if run.code != 0:
            fail(f"the run on {ranks} ranks ended with {run.code}", run)
        if ranks == 1:
            continue
        compare = program.run(["compare", f"r1/{CHECKPOINT}", f"{out}/{CHECKPOINT}"], 1, work, 60)
        if compare.code != 0 or "identical" not in compare.text:
            fail(f"{ranks} ranks differ from one ({arguments.partition})", compare)
        print(f"{ranks} ranks, {arguments.partition}: identical ({run.seconds:.1f} s)")

    # The comparison must be able to say no.
    run = program.run(["run", str(SCENE), "--out", "other", "--max-steps", str(STEPS),
                       "--set", "bodies.ball.velocity=[1.0, 0.0, -5.000000000001]"], 2, work, 120)
    if run.code != 0:
        fail(f"the run with another velocity ended with {run.code}", run)
    compare = program.run(["compare", f"r1/{CHECKPOINT}", f"other/{CHECKPOINT}"], 1, work, 60)
    if compare.code != 1 or "identical" in compare.text:
        fail("a run from another initial velocity is called identical", compare)


if __name__ == "__main__":
    main()
