#!/usr/bin/env python3
"""A free rigid ball: added mass in an inviscid fluid, Stokes' drag between walls, and the yield stress that holds it."""

from rigid_ball import ADDED_MASS, SPEED, added_mass, late_speed, steady_speed
from study import Study


def main():
    study = Study("rigid_sphere", "Rigid ball in a fluid",
                  "Wall factor 1.854 and added mass 0.5344 of a sphere in a cube (finite elements); threshold 0.143 of Beris et al. 1985")
    levels = (4, 6, 8) if study.long else (4,)
    speeds = [steady_speed(study, cells) for cells in levels]
    errors = [abs(speed / SPEED - 1.0) for speed in speeds]
    half, stiff = {"time.elastic_cfl": 0.2}, {"materials.fluid.bulk_modulus": 16e3}
    study.expect_at_most("speed with half the step", abs(steady_speed(study, 4, half, "_half") / speeds[0] - 1.0), 0.01)
    if not study.long:
        study.expect_at_most("speed of a sticky ball, over Stokes' between these walls", errors[0], 0.05,
                             note="4 cells a radius; Re = 0.05")
    else:
        study.expect_convergence("speed of a sticky ball, over Stokes' between these walls", levels, errors, 0.05, 0.8,
                                 note="cells a radius; Re = 0.05")
        study.expect_at_most("speed with four times the bulk modulus",
                             abs(steady_speed(study, 4, stiff, "_stiff") / speeds[0] - 1.0), 0.02)
        sinking, held = late_speed(study, 0.12), late_speed(study, 0.18)
        study.expect_at_most("what the speed at Y = 0.12 lacks of 1e-3", max(0.0, 1.0 - sinking / 1e-3), 0.0,
                             note="over the Newtonian speed; the ball sinks")
        study.expect_at_most("speed at Y = 0.18", abs(held), 1e-3, note="over the Newtonian speed; the ball stays")
        study.remark(f"After 2 s the ball moves at {sinking:.2e} of the Newtonian speed at Y = 2 pi a^2 tau_y / F = 0.12, and at "
                     f"{held:.2e} at 0.18.")
        masses = [added_mass(study, cells) for cells in levels]
        study.expect("added mass of a ball that slips, 6 cells a radius, speed of sound 10 m/s", masses[1], ADDED_MASS, 0.1,
                     note="of the displaced mass; as heavy as what it displaces")
        moduli = {20: 4e5, 40: 16e5}
        others = {c: added_mass(study, 4, {"materials.fluid.bulk_modulus": k}, f"_{c}") for c, k in moduli.items()}
        study.expect_at_most("added mass with 16 times the bulk modulus", abs(others[40] / masses[0] - 1.0), 0.02, note="4 cells")
        halved = added_mass(study, 4, half, "_half")
        study.expect_at_most("added mass with half the step", abs(halved / masses[0] - 1.0), 0.02, note="4 cells")
        own = {"transfer.dilation": "particle"}
        locked = {c: added_mass(study, 4, {"materials.fluid.bulk_modulus": k, **own}, f"_own_{c}")
                  for c, k in {10: 1e5, 20: 4e5}.items()}
        study.remark("Added mass with " + ", ".join(f"{n} cells: {mass:.3f}" for n, mass in zip(levels, masses))
                     + f" ({halved:.3f} with 4 cells and half the step); with 4 cells and a speed of sound of "
                     + ", ".join(f"{c} m/s: {mass:.3f}" for c, mass in others.items())
                     + ". With `dilation = \"particle\"`, where each particle next to the curved surface must keep its volume while the "
                     "nodes behind the surface have the body's velocity, 4 cells and a speed of sound of "
                     + ", ".join(f"{c} m/s: {mass:.3f}" for c, mass in locked.items()) + ".")
    study.finish()


if __name__ == "__main__":
    main()
