#!/usr/bin/env python3
"""A free rigid ball: added mass in an inviscid fluid, Stokes' drag between walls, and the yield stress that holds it."""

import math

import numpy

from study import Study

RADIUS, DENSITY, VISCOSITY = 0.01, 1000.0, 5.0
DISPLACED = 4.0 / 3.0 * math.pi * RADIUS**3 * DENSITY
OFF_NODES = [0.0007, 0.0003, 0.0011]
# Sphere in the middle of a cube of half width 3 a (inviscid, slip) and 4 a (Stokes, no slip): finite elements.
ADDED_MASS, WALL_FACTOR = 0.5344, 1.854
STEADY_FORCE = 0.020546
SPEED = STEADY_FORCE / (6.0 * math.pi * VISCOSITY * RADIUS * WALL_FACTOR)
# Beris et al. (1985): a sphere rests where 2 pi a^2 tau_y / F is above 0.143.
WEIGHT = DISPLACED * 9.81


def box(half, center):
    return {"domain.lower": [-half] * 3, "domain.upper": [half] * 3, "bodies.0.shape.parts.0.lower": [-half] * 3,
            "bodies.0.shape.parts.0.upper": [half] * 3, "bodies.0.shape.parts.1.center": center,
            "rigid_bodies.0.shape.center": center}


def column(history, name):
    return numpy.array(history[name], dtype=float)


def added_mass(study, cells, limits=None, label=""):
    """From the acceleration once sound has crossed the box three times, before the ball has moved a twentieth of its radius."""
    sets = {**box(3.0 * RADIUS, OFF_NODES), "domain.cell_size": RADIUS / cells,
            "rigid_bodies.0.force": ["0", "0", f"{DISPLACED:.17g}"], **(limits or {})}
    history = study.run(f"added_mass_{cells}{label}", sets, scene=study.scene.with_name("water.toml")).history()
    time, speed = column(history, "time_s"), column(history, "ballvelocity_z_ms")
    late = time > 0.015
    return 1.0 / numpy.polyfit(time[late], speed[late], 1)[0] - 1.0


def steady_speed(study, cells, limits=None, label=""):
    sets = {**box(4.0 * RADIUS, OFF_NODES), "domain.cell_size": RADIUS / cells, "time.end": 0.12, **(limits or {})}
    history = study.run(f"stokes_{cells}{label}", sets).history()
    time, speed = column(history, "time_s"), column(history, "ballvelocity_z_ms")
    return speed[time > 0.08].mean()


def late_speed(study, yield_number):
    """Speed after 2 s over that in a Newtonian fluid of the same viscosity."""
    sets = {**box(4.0 * RADIUS, OFF_NODES), "domain.cell_size": RADIUS / 4, "time.end": 2.0,
            "materials.fluid.yield_stress": yield_number * WEIGHT / (2.0 * math.pi * RADIUS**2),
            "rigid_bodies.0.force": ["0", "0", f"{WEIGHT:.17g}"]}
    history = study.run(f"yield_{yield_number}", sets).history()
    time, height = column(history, "time_s"), column(history, "ballposition_z_m")
    late = time > 1.8
    return numpy.polyfit(time[late], height[late], 1)[0] / (WEIGHT / STEADY_FORCE * SPEED)


def main():
    study = Study("rigid_sphere", "Rigid ball in a fluid",
                  "Wall factor 1.854 and added mass 0.5344 of a sphere in a cube (finite elements); threshold 0.143 of Beris et al. 1985")
    levels = (4, 6, 8) if study.long else (4, 6)
    speeds = [steady_speed(study, cells) for cells in levels]
    study.expect_convergence("speed of a sticky ball, over Stokes' between these walls", levels,
                             [abs(speed / SPEED - 1.0) for speed in speeds], 0.05, 0.8, note="cells a radius; Re = 0.05")
    half, stiff = {"time.elastic_cfl": 0.2}, {"materials.fluid.bulk_modulus": 4e3}
    study.expect_at_most("speed with half the step", abs(steady_speed(study, 4, half, "_half") / speeds[0] - 1.0), 0.01)
    if study.long:
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
        moduli = {2.5: 6.25e3, 5: 25e3, 20: 4e5}
        others = {c: added_mass(study, 4, {"materials.fluid.bulk_modulus": k}, f"_{c}") for c, k in moduli.items()}
        halved = added_mass(study, 4, half, "_half")
        study.remark("Added mass with " + ", ".join(f"{n} cells: {mass:.3f}" for n, mass in zip(levels, masses))
                     + f" ({halved:.3f} with 4 cells and half the step); with 4 cells and a speed of sound of "
                     + ", ".join(f"{c} m/s: {mass:.3f}" for c, mass in others.items())
                     + ". The stiffer the fluid, the more the particles next to a curved surface lock: each must keep its volume while the "
                     "nodes behind the surface have the body's velocity. Cells that share a pressure, as those of imex do, would not; imex has "
                     "no rigid bodies yet.")
    study.finish()


if __name__ == "__main__":
    main()
