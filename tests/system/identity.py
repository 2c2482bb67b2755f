#!/usr/bin/env python3
"""The same bits on any number of ranks: 200 steps of a splash on several ranks, under one partition method whose map may be
made anew again and again, compared with the run on one rank that identity_reference.py has made."""

import pathlib
import sys

from identity_reference import CHECKPOINT, splash

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402


def main():
    def options(parser):
        parser.add_argument("--partition", required=True)
        parser.add_argument("--reference", required=True, help="folder that identity_reference.py has filled")
        parser.add_argument("--ranks", type=int, nargs="+", default=[2, 3, 4, 7, 8])
        parser.add_argument("--remake", type=int, default=0, help="steps between two new maps")
        parser.add_argument("--decide", type=int, default=100, help="partition.decision_interval")

    arguments = parse_arguments(__doc__, options)
    program, work = start(arguments)
    reference = pathlib.Path(arguments.reference) / "r1" / CHECKPOINT

    remade = False  # on some number of ranks: few tiles may allow one map alone
    for ranks in arguments.ranks:
        out = f"r{ranks}"
        run = splash(program, work, out, ranks, f"partition.method={arguments.partition}",
                     f"partition.remake_interval={arguments.remake}", f"partition.decision_interval={arguments.decide}")
        remade = remade or "\n0 new maps" not in run.text
        compare = program.run(["compare", str(reference), f"{out}/{CHECKPOINT}"], 1, work, 60)
        if compare.code != 0 or "identical" not in compare.text:
            fail(f"{ranks} ranks differ from one ({arguments.partition})", compare)
        print(f"{ranks} ranks, {arguments.partition}: identical ({run.seconds:.1f} s)")
    if arguments.remake > 0 and not remade:
        fail(f"no new map on any number of ranks ({arguments.partition})")


if __name__ == "__main__":
    main()
