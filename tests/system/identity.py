#!/usr/bin/env python3
"""The same bits on any number of ranks: 200 steps of a splash on one rank and on others under one partition method, whose map
may be made anew again and again."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("splash.toml")
STEPS = 200
CHECKPOINT = f"checkpoint_{STEPS:09d}.h5"


def main():
    def options(parser):
        parser.add_argument("--partition", required=True)
        parser.add_argument("--ranks", type=int, nargs="+", default=[2, 3, 4, 7, 8])
        parser.add_argument("--remake", type=int, default=0, help="steps between two new maps")
        parser.add_argument("--decide", type=int, default=100, help="partition.decision_interval")

    arguments = parse_arguments(__doc__, options)
    program, work = start(arguments)

    for ranks in [1, *arguments.ranks]:
        out = f"r{ranks}"
        # One rank needs no partition: its run is the reference for all methods, made with the default one.
        method = [] if ranks == 1 else ["--set", f"partition.method={arguments.partition}",
                                        "--set", f"partition.remake_interval={arguments.remake}",
                                        "--set", f"partition.decision_interval={arguments.decide}"]
        run = program.run(["run", str(SCENE), "--out", out, "--max-steps", str(STEPS), *method], ranks, work, 120)
        if run.code != 0:
            fail(f"the run on {ranks} ranks ended with {run.code}", run)
        if ranks == 1:
            continue
        if arguments.remake > 0 and " 0 new maps" in run.text:
            fail(f"no new map on {ranks} ranks ({arguments.partition})", run)
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
