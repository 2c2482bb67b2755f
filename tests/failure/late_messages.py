#!/usr/bin/env python3
"""Messages that come late (delay_shim.c) change nothing and leave nothing hanging: short runs on many ranks, with new maps of tiles by every
method, rigid bodies and the implicit pressure, and restarts between other numbers of ranks, have the bits of the run on one rank."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from identity import expect_identical  # noqa: E402

SCENES = pathlib.Path(__file__).resolve().parents[1] / "system"
STEPS, INTERRUPTION = 40, 23
LIMIT = 200  # s, of a run of a few seconds
LEAST_LATE = 50  # calls of a rank: two or three a step, and some before the first
IMEX = ("time.integrator=imex", "materials.cream.bulk_modulus=2e9")
# name, scene, settings of all runs, (ranks, ranks after a restart, method of the map, steps between new ones)
CASES = (
    ("splash", "splash.toml", (), ((7, 4, "bisection", 3), (5, 3, "ranges", 4), (4, 7, "auto", 5), (3, 5, "hilbert", 2))),
    ("imex", "splash.toml", IMEX, ((5, 3, "bisection", 6),)),
    ("rigid", "rigid_bodies.toml", (), ((6, 4, "bisection", 7),)),
)


def main():
    arguments = parse_arguments(__doc__, lambda parser: parser.add_argument("--shim", required=True))
    program, work = start(arguments)
    seeds = iter(range(1, 100))

    def run(out, ranks, steps, scene, settings, *more, late=False):
        sets = [word for key in ("output.frame_interval=0.02", "output.history_interval=5", *settings) for word in ("--set", key)]
        log = work / f"{out}.late"
        log.unlink(missing_ok=True)
        environment = {"LD_PRELOAD": arguments.shim, "DELAY_SEED": str(next(seeds)), "DELAY_LOG": str(log)} if late else {}
        outcome = program.run(["run", str(SCENES / scene), "--out", out, "--max-steps", str(steps), *sets, *more], ranks, work, LIMIT,
                              environment)
        if outcome.code not in (0, 4):
            fail(f"{out} on {ranks} ranks ended with {outcome.code}" + " (it hangs)" * (outcome.code is None), outcome)
        if late:
            counts = [tuple(map(int, line.split())) for line in log.read_text().splitlines()]
            if sum(late_calls >= LEAST_LATE for _, late_calls in counts) < ranks:
                fail(f"{out}: calls and late ones of the {ranks} ranks are {counts}: too few come late")
        return work / out

    for name, scene, settings, ways in CASES:
        one = run(f"{name}_1", 1, STEPS, scene, settings)
        for ranks, after, method, interval in ways:
            balance = (f"partition.method={method}", f"partition.remake_interval={interval}", f"partition.decision_interval={interval}")
            out = f"{name}_{method}"
            run(out, ranks, INTERRUPTION, scene, (*settings, *balance), late=True)
            late = run(out, after, STEPS, scene, (*settings, *balance), "--restart", late=True)
            expect_identical(program, work, one, late, STEPS, f"{name}, {method}, {ranks} ranks and then {after}, with late messages")


if __name__ == "__main__":
    main()
