"""A free rigid ball in a closed cube of fluid: what rigid_sphere and rigid_sphere_imex measure of it."""

import math
import pathlib

import numpy

SCENES = pathlib.Path(__file__).resolve().with_name("rigid_sphere")
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


def added_mass(study, cells, limits=None, label="", density=1.0, begin=0.005):
    """From the acceleration after `begin`, s, until the ball has moved a seventieth of its radius. `density`: over the fluid's."""
    sets = {**box(3.0 * RADIUS, OFF_NODES), "domain.cell_size": RADIUS / cells,
            "rigid_bodies.0.force": ["0", "0", f"{DISPLACED:.17g}"],
            "rigid_bodies.0.density": density * DENSITY, **(limits or {})}
    history = study.run(f"added_mass_{cells}{label}", sets, scene=SCENES / "water.toml").history()
    time, speed = column(history, "time_s"), column(history, "ballvelocity_z_ms")
    late = time > begin
    return 1.0 / numpy.polyfit(time[late], speed[late], 1)[0] - density


def steady_speed(study, cells, limits=None, label=""):
    sets = {**box(4.0 * RADIUS, OFF_NODES), "domain.cell_size": RADIUS / cells, "time.end": 0.12, **(limits or {})}
    history = study.run(f"stokes_{cells}{label}", sets, scene=SCENES / "scene.toml").history()
    time, speed = column(history, "time_s"), column(history, "ballvelocity_z_ms")
    return speed[time > 0.08].mean()


def late_speed(study, yield_number, limits=None):
    """Speed after 2 s over that in a Newtonian fluid of the same viscosity. The force grows for half a second: as a sudden one it would
    load the fluid twice, and the ball would ring in the elastic part of the fluid."""
    sets = {**box(4.0 * RADIUS, OFF_NODES), "domain.cell_size": RADIUS / 4, "time.end": 2.0,
            "materials.fluid.yield_stress": yield_number * WEIGHT / (2.0 * math.pi * RADIUS**2),
            "rigid_bodies.0.force": ["0", "0", f"{WEIGHT:.17g} * min(2 * t, 1)"], **(limits or {})}
    history = study.run(f"yield_{yield_number}", sets, scene=SCENES / "scene.toml").history()
    time, height = column(history, "time_s"), column(history, "ballposition_z_m")
    late = time > 1.8
    return numpy.polyfit(time[late], height[late], 1)[0] / (WEIGHT / STEADY_FORCE * SPEED)
