#!/usr/bin/env python3
"""A viscometer: the speed of a free bob on an axis under a given torque, against the exact flow between two cylinders."""

import math

from study import Study

INNER, CENTER, LAYERS = 0.02, [0.0002, 0.0003], 4
# Stress on the bob (Pa), yield stress, viscosity, exact speed (rad/s): 1/2 of the integral of the rate over the stress, radii 20 and 30 mm.
FLUIDS = {"Newtonian": (15.0, 0.0, 5.0, 0.8333333333), "Bingham, all of it flows": (40.0, 10.0, 5.0, 1.411292006)}


def speed(study, name, cells):
    stress, yield_stress, viscosity, _ = FLUIDS[name]
    height = LAYERS * 0.01 / cells
    torque = 2.0 * math.pi * INNER**2 * height * stress
    sets = {"domain.cell_size": 0.01 / cells, "domain.upper": [0.033, 0.033, height],
            "bodies.0.shape.parts.0.end": [*CENTER, height], "rigid_bodies.0.shape.end": [*CENTER, height],
            "materials.fluid.yield_stress": yield_stress, "materials.fluid.consistency": viscosity,
            "rigid_bodies.0.torque": ["0", "0", f"{torque:.17g}"]}
    history = study.run(f"{name.split(',')[0]}_{cells}", sets).history()
    late = history["time_s"] > 0.2
    return history["bobspin_z_rads"][late].mean()


def main():
    study = Study("rigid_viscometer", "Viscometer with a given torque", "Exact flow between cylinders (Bingham)")
    levels = (5, 10, 20) if study.long else (5, 10)
    for name, (_, _, _, exact) in FLUIDS.items():
        if name == "Newtonian" and not study.long:
            continue
        errors = [abs(speed(study, name, cells) / exact - 1.0) for cells in levels]
        study.expect_convergence(f"{name}: speed", levels, errors, 0.03 if study.long else 0.05, 0.8,
                                 note="cells across the gap; 3 % with 20 of them, 5 % with 10")
    study.finish()


if __name__ == "__main__":
    main()
