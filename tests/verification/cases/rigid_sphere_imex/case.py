#!/usr/bin/env python3
"""The rigid ball of rigid_sphere with the implicit pressure, in a fluid as stiff as water."""

from rigid_ball import ADDED_MASS, SPEED, added_mass, late_speed, steady_speed
from study import Study

IMEX = {"time.integrator": "imex", "materials.fluid.bulk_modulus": 2e9}
STEP = 5e-4  # s, in the inviscid fluid, which has no limit of its own


def main():
    study = Study("rigid_sphere_imex", "Rigid ball in a fluid, implicit pressure",
                  "Wall factor 1.854 and added mass 0.5344 of a sphere in a cube (finite elements); threshold 0.143 of Beris et al. 1985")
    tight = "speed of a sticky ball, over Stokes' between these walls"
    slow = steady_speed(study, 4, IMEX)
    study.expect_at_most(f"{tight}, 4 cells a radius", abs(slow / SPEED - 1.0), 0.05, note="Re = 0.05")
    water = {**IMEX, "time.end": 0.02, "time.dt_max": STEP}
    masses = {cells: added_mass(study, cells, water) for cells in ((4, 6, 8) if study.long else (4, 6))}
    study.expect_convergence("added mass of a ball that slips", list(masses), [abs(m / ADDED_MASS - 1.0) for m in masses.values()],
                             0.1, 0.0, note="as heavy as what it displaces; at once: no sound has to cross the box")
    halved = added_mass(study, 4, {**water, "time.dt_max": STEP / 2}, "_half")
    study.expect_at_most("added mass with half the step", abs(halved / masses[4] - 1.0), 0.05)
    light = added_mass(study, 4, {**water, "time.end": 0.01}, "_light", 0.05, 0.002)
    study.expect_at_most("added mass of a light ball", abs(light / masses[4] - 1.0), 0.05,
                         note="a twentieth of the fluid's density, against the ball as heavy as the fluid")
    study.remark(f"The sticky ball moves at {slow / SPEED:.3f} of Stokes' speed; added mass with "
                 + ", ".join(f"{n} cells: {mass:.3f}" for n, mass in masses.items()) + f", {halved:.3f} with 4 cells and half the step.")
    if not study.long:
        return study.finish()
    levels = (4, 6, 8)
    errors = [abs(slow / SPEED - 1.0)] + [abs(steady_speed(study, cells, IMEX) / SPEED - 1.0) for cells in levels[1:]]
    study.expect_convergence(tight, levels, errors, 0.05, 0.0, note="cells a radius")
    half, soft = {**IMEX, "time.elastic_cfl": 0.2}, {**IMEX, "materials.fluid.bulk_modulus": 1e4}
    study.expect_at_most("speed with half the step", abs(steady_speed(study, 4, half, "_half") / slow - 1.0), 0.01)
    study.expect_at_most("speed with a soft fluid", abs(steady_speed(study, 4, soft, "_soft") / slow - 1.0), 0.02,
                         note="speed of sound 3 instead of 1414 m/s")
    sinking, held = late_speed(study, 0.12, IMEX), late_speed(study, 0.18, IMEX)
    study.expect_at_most("what the speed at Y = 0.12 lacks of 1e-3", max(0.0, 1.0 - sinking / 1e-3), 0.0,
                         note="over the Newtonian speed; the ball sinks")
    study.expect_at_most("speed at Y = 0.18", abs(held), 1e-3, note="over the Newtonian speed; the ball stays")
    study.remark(f"After 2 s the ball moves at {sinking:.2e} of the Newtonian speed at Y = 2 pi a^2 tau_y / F = 0.12, and at "
                 f"{held:.2e} at 0.18.")
    study.finish()


if __name__ == "__main__":
    main()
