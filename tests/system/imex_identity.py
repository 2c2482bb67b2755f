#!/usr/bin/env python3
"""The implicit pressure gives the same bits on any number of ranks and through restarts, with everything that takes part in its
system: walls of every kind, moving colliders, gauges, a periodic axis, free surfaces that part, laws without a volumetric part,
both orders and forms, all transfers; with explicit and with implicit viscosity. In each variant the energy account closes."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import parse_arguments, start  # noqa: E402
from identity import expect_closed_account, expect_identical  # noqa: E402
from imex_runs import ImexRuns  # noqa: E402

STEPS, INTERRUPTION = 40, 17

STUCK = ["boundaries.z_lower={type=\"sticky\"}"]
ROUND = [f"boundaries.{axis}_{side}=\"periodic\"" for axis in "y" for side in ("lower", "upper")]
AROUND = [f"boundaries.z_{side}=\"periodic\"" for side in ("lower", "upper")]
IMPLICIT = "time.viscosity=\"implicit\""
VISCOUS = ["materials.cream.background_viscosity=50.0", IMPLICIT]
# name, scene, overrides, ranks of the whole run, ranks before and after a restart
VARIANTS = (
    ("splash", "splash.toml", ["materials.cream.bulk_modulus=2e9"], (2, 3, 7), (3, 5)),
    ("cubic", "splash.toml", ["transfer.order=\"cubic\"", "transfer.scheme=\"moment_flip\""], (3,), (7, 2)),
    ("bspline", "splash.toml", ["transfer.gradient=\"bspline\"", "transfer.scheme=\"flip\"", *STUCK], (5,), (2, 7)),
    ("periodic", "splash.toml", ["transfer.scheme=\"pic\"", "domain.upper=[0.35,0.4,0.3]", *ROUND], (2, 7), (7, 3)),
    ("around", "splash.toml", ["gravity=[0.0, 0.0, 0.0]", "time.elastic_cfl=0.8", *AROUND], (3,), (5, 2)),
    ("mixed", "splash.toml", ["materials.rubber.law=\"fixed_corotated\""], (3,), (2, 5)),
    ("moving", "moving_colliders.toml", ["time.end=1.0", "time.growth=1.5"], (2, 7), (5, 3)),
    ("viscous", "splash.toml", ["materials.cream.bulk_modulus=2e9", *VISCOUS], (2, 3, 7), (3, 5)),
    ("viscous_flip", "splash.toml", ["transfer.gradient=\"bspline\"", "transfer.scheme=\"flip\"", *VISCOUS, *STUCK], (3,), (7, 2)),
    ("viscous_round", "splash.toml", ["transfer.order=\"cubic\"", "domain.upper=[0.35,0.4,0.3]", *VISCOUS, *ROUND], (5,), (2, 7)),
    ("viscous_moving", "moving_colliders.toml", ["time.end=1.0", "materials.fluid.background_viscosity=20.0", IMPLICIT], (2, 7), (5, 3)),
    ("viscous_tank", "tank.toml", ["time.end=2.0", "materials.water.viscosity=1e3", "transfer.scheme=\"moment_flip\"", IMPLICIT], (4,), (3, 2)),
    ("parting", "tank.toml", ["materials.water.tension=false", "gravity=[3.0, 0.0, -10.0]"], (4,), (3, 2)),
)


class Test(ImexRuns):
    def run(self, out, *arguments):
        super().run(out, *arguments)
        return self.work / out

    def expect_identical(self, one, other, what):
        expect_identical(self.program, self.work, one, other, STEPS, what)


def main():
    test = Test(*start(parse_arguments(__doc__)))
    for name, scene, overrides, ranks, (before, after) in VARIANTS:
        one = test.run(f"{name}_1", 1, STEPS, scene, overrides)
        expect_closed_account(one, name)
        for n in ranks:
            test.expect_identical(one, test.run(f"{name}_{n}", n, STEPS, scene, overrides), f"{name} on {n} ranks")
        parted = f"{name}_{before}to{after}"
        test.run(parted, before, INTERRUPTION, scene, overrides)
        test.expect_identical(one, test.run(parted, after, STEPS, scene, overrides, "--restart"),
                              f"{name} on {before} ranks, restarted on {after}")


if __name__ == "__main__":
    main()
