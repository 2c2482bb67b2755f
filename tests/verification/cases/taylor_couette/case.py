#!/usr/bin/env python3
"""Newtonian flow between a turning and a resting cylinder: speeds, and the torque that history.csv reports for both."""

import numpy

from steady_shear import profile_error
from study import Study

INNER, OUTER, SPIN, VISCOSITY = 0.01, 0.02, 1.0, 5.0
CENTER = (0.31, 0.17)  # of the cylinders, in cells from a node


def speed(r):
    """Azimuthal, m/s."""
    return SPIN * INNER**2 / (OUTER**2 - INNER**2) * (OUTER**2 / r - r)


def main():
    study = Study("taylor_couette", "Flow between cylinders",
                  "`u = Omega R1^2 / (R2^2 - R1^2) (R2^2 / r - r)`, torque per length `4 pi mu Omega R1^2 R2^2 / (R2^2 - R1^2)`")
    levels = (6, 12, 20) if study.long else (6, 12)  # cells across the gap
    errors, torque_errors = [], []
    for cells in levels:
        size = (OUTER - INNER) / cells
        side, height, center = (2 * cells + 2) * size, size, [n * size for n in CENTER]
        sets = {"domain.lower": [-side, -side, 0.0], "domain.upper": [side, side, height], "domain.cell_size": size,
                "colliders.shaft.center": [*center, 0.0], "colliders.cup.center": [*center, 0.0]}
        for cylinder, bottom, top in (("bodies.0.shape.parts.0", 0.0, height), ("bodies.0.shape.parts.1", -1.0, 1.0),
                                      ("colliders.shaft.shape", -1.0, 1.0), ("colliders.cup.shape.parts.0", -1.0, 1.0)):
            sets |= {f"{cylinder}.start": [*center, bottom], f"{cylinder}.end": [*center, top]}
        result = study.run_on_both(f"cells_{cells}", sets)
        particles, history = result.checkpoint(), result.history()
        x, y = (particles["position"][:, axis] - center[axis] for axis in (0, 1))
        r = numpy.hypot(x, y)
        azimuthal = (x * particles["velocity"][:, 1] - y * particles["velocity"][:, 0]) / r
        errors.append(profile_error(azimuthal, speed(r.clip(INNER, OUTER))))
        late = history["time_s"] > 0.9 * history["time_s"][-1]
        shaft, cup = (history[f"{name}torque_z_N_m"][late].mean() for name in ("shaft", "cup"))
        truth = 4.0 * numpy.pi * VISCOSITY * SPIN * INNER**2 * OUTER**2 / (OUTER**2 - INNER**2) * height
        torque_errors.append(abs(-shaft / truth - 1.0))
        study.expect(f"{cells} cells: torque on the cup over that on the shaft", cup / -shaft, 1.0, 0.02,
                     note="the flow is steady: what the one gives, the other takes")
    study.expect_convergence("profile, L2 norm", levels, errors, 0.07 if study.long else 0.12, 0.8,
                             note="relative to the profile's norm")
    study.expect_convergence("torque on the shaft", levels, torque_errors, 0.12 if study.long else 0.2, 0.8, note="relative")
    study.remark("The walls of sticky colliders act up to 0.6 cells in front of where they are stated. At 12 cells per gap and inner "
                 "radius half a cell alone makes a tenth of the torque: it converges to first order.")
    study.finish()


if __name__ == "__main__":
    main()
