#!/usr/bin/env python3
"""Plane Couette flow of a Herschel-Bulkley fluid: a uniform shear rate, and the stress that the flow curve gives for it."""

import numpy

from steady_shear import channel_sets, profile_error, unsteadiness
from study import Study

HEIGHT, SPEED, YIELD_STRESS, CONSISTENCY, INDEX = 0.01, 0.1, 10.0, 5.0, 0.5
XZ = 5  # of the components xx yy zz xy yz xz


def main():
    study = Study("couette", "Plane Couette flow", "`u = U z / H`, shear stress `yield stress + K (U / H)^n`")
    stress = YIELD_STRESS + CONSISTENCY * (SPEED / HEIGHT) ** INDEX
    for cells in (4, 8, 16, 32) if study.long else (4, 16):
        box = channel_sets(HEIGHT, cells, (0.0, 1.0))
        result = study.run_on_both(f"cells_{cells}", {**box, "bodies.0.shape.lower": box["domain.lower"],
                                                      "bodies.0.shape.upper": box["domain.upper"]})
        particles = result.checkpoint()
        z, speed = particles["position"][:, 2], particles["velocity"][:, 0]
        study.expect_at_most(f"{cells} cells: profile, L2 norm", profile_error(speed, SPEED * z / HEIGHT), 1e-6,
                             note="relative to the profile's norm; a linear profile is exact on any grid")
        shear = particles["kirchhoff_stress"][:, XZ] / particles["volume_ratio"]
        study.expect(f"{cells} cells: shear stress, mean of all particles", shear.mean(), stress, 1e-3, "Pa",
                     note="elastic strain takes (s / shear modulus)^2 / 3 off it")
        study.expect_at_most(f"{cells} cells: scatter of the shear stress", numpy.std(shear) / stress, 1e-6,
                             note="standard deviation over the mean")
        study.expect_at_most(f"{cells} cells: change of the mean speed over the last tenth of the run", unsteadiness(result),
                             1e-6)
    study.finish()


if __name__ == "__main__":
    main()
