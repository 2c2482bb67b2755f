#!/usr/bin/env python3
"""A slug of yield-stress fluid comes to rest on an incline; its front has the profile D = -H - (1 - k) ln(1 - H), from H = 2 k on."""

import math

import numpy

from slump_theory import G, Layer, columns, front, means, misplaced, speed
from study import Study

PASTE = Layer(density=1000.0, yield_stress=10.0, consistency=0.05, index=2.0, angle=math.radians(3.0))
LENGTH, HEIGHT, WIDTH = 0.24, 0.02, 0.48  # of the slug, of the domain
THRESHOLD = 2e-3                          # m/s: at rest, root mean square
PARTICLES = 27  # in a cell, in long versions: 9 in a plane flow
# The scene has the implicit pressure and water's modulus; long versions also have the explicit step with 80 times the pressure at the floor.
SOFTENED = {"time.integrator": "explicit", "materials.paste.bulk_modulus": 16000.0}


def front_profile(paste, volume):
    """Reach of the layer at rest, and its height as a function. Where the floor carries tau_c everywhere and the layer above is at yield as
    well, stretched along the slope, (rho g cos a h - (pi/2) tau_c) h_x = rho g sin a h - tau_c; with H = rho g h sin a / tau_c and
    D = rho g d sin^2 a / (tau_c cos a) for the distance d from the front that is D = -H - (1 - k) ln(1 - H) + constant, k = (pi/2) tan a. The
    front bears no force: H = 2 k there (Layer.arrested is the same on a level floor). To first order k = 0."""
    stress, lean = paste.yield_stress / paste.density / G, math.sin(paste.angle)
    k = 0.5 * math.pi * math.tan(paste.angle)
    depth = numpy.linspace(2.0 * k, 0.9999, 100001)
    beyond = -depth - (1.0 - k) * numpy.log1p(-depth)
    height, distance = depth * stress / lean, (beyond - beyond[0]) * stress * math.cos(paste.angle) / lean**2
    content = numpy.concatenate([[0.0], numpy.cumsum(0.5 * (height[1:] + height[:-1]) * numpy.diff(distance))])
    reach = numpy.interp(volume, content, distance)
    return reach, lambda x: numpy.where(x < reach, numpy.interp(reach - x, distance, height), 0.0)


def scene(cell, end):
    return {"domain.cell_size": cell, "domain.upper": [WIDTH, cell, 0.032], "time.end": end, "bodies.slug.shape.upper": [LENGTH, cell, HEIGHT]}


def lubrication(particles, edges, cell, end):
    """Heights between `edges`, and those of the lubrication equation for as much fluid; the fluid and its volume per width."""
    heights = columns(particles, edges, cell)
    volume = float(heights.sum() * (edges[1] - edges[0]))
    grid = numpy.linspace(0.0, WIDTH, 181)
    paste = PASTE.as_it_lies(particles)
    (truth,) = paste.spread(grid, numpy.where(grid[:-1] < LENGTH, volume / LENGTH, 0.0), [end], second_order=True)
    return heights, numpy.interp(0.5 * (edges[1:] + edges[:-1]), 0.5 * (grid[1:] + grid[:-1]), truth), paste, volume


def compare(study, cells, end, softened=False):
    """Runs the slug on `cells` and compares it; returns heights by cell, the lubrication layer and the formula's."""
    moving, rest, reach, found = [], [], [], {}
    for cell in cells:
        sets = {**scene(cell, end), **({"bodies.slug.particles_per_cell": PARTICLES} if study.long else {}), **(SOFTENED if softened else {})}
        start = study.run if softened or (study.long and cell == cells[-1]) else study.run_on_both
        particles = list(start(f"cell_{1e3 * cell:.2g}mm{'_explicit' * softened}", sets).frames())[-1]
        edges = numpy.linspace(0.0, WIDTH, 61)
        middles = 0.5 * (edges[1:] + edges[:-1])
        heights, expected, paste, volume = lubrication(particles, edges, cell, end)
        found[cell] = heights
        moving.append(misplaced(heights, expected, 1.0))
        length, shape = front_profile(paste, volume)
        formula = means(shape, edges)
        rest.append(misplaced(heights, formula, 1.0))
        reach.append(abs(front(middles, heights, 0.004) / front(middles, expected, 0.004) - 1.0))
    height = float(shape(0.0))
    depth = [height / cell for cell in cells]
    kind = ", explicit step" if softened else ""
    study.expect_convergence(f"volume out of place after {end:g} s, against lubrication{kind}", depth, moving, 0.06, 0.6)
    if not softened:
        study.remark(f"Cells are counted over the height of the arrested layer at the wall, {1e3 * height:.1f} mm. Its "
                     f"aspect ratio is {height / length:.3f}.")
    if study.long:
        study.expect_convergence(f"volume out of place at rest, against the formula{kind}", depth, rest, 0.06, 0.6)
        study.expect_convergence(f"run-out after {end:g} s (height 4 mm), against lubrication{kind}", depth, reach, 0.06, 0.6)
        study.expect_at_most(f"speed at the end, root mean square{kind}", speed(particles), THRESHOLD, "m/s",
                             note="finest resolution")
    return found, middles, expected, shape


def eight_particles(study, cell, end):
    """A sentence on the run with as many particles as scenes have that say nothing."""
    particles = list(study.run(f"cell_{1e3 * cell:.2g}mm_8", scene(cell, end)).frames())[-1]
    edges = numpy.linspace(0.0, WIDTH, 61)
    heights, expected, _, _ = lubrication(particles, edges, cell, end)
    return (f"Cells hold {PARTICLES} particles, 9 of them in the plane. With 8 (4), the default, {100.0 * misplaced(heights, expected, 1.0):.1f} % of the "
            f"volume are out of place on {1e3 * cell:.2g} mm after {end:g} s (`imex`).")


def main():
    study = Study("incline_profile", "Arrest on an incline",
                  "Thin layer at yield on a slope, to second order: `D = -H - (1 - k) ln(1 - H)` with `H = rho g h sin a / tau_c`, "
                  "`D = rho g d sin^2 a / (tau_c cos a)` and `k = (pi/2) tan a` for the tension of the plug; on the way there, the lubrication "
                  "equation with that tension")
    cells = (0.004, 0.00266666666666667, 0.0016) if study.long else (0.004, 0.00266666666666667)
    end = 16.0 if study.long else 4.0
    found, middles, expected, shape = compare(study, cells, end)
    if study.long:
        compare(study, cells, end, softened=True)
        study.remark("The fluid has the implicit pressure and a bulk modulus of 2.2e9 Pa, with the explicit step 80 times the pressure at the floor.")
        study.remark(eight_particles(study, cells[-1], end))

    def draw(axes):
        for cell, profile in found.items():
            axes.plot(middles, 1e3 * profile, ".", label=f"cells of {1e3 * cell:.2g} mm")
        axes.plot(middles, 1e3 * expected, "k-", label="lubrication")
        axes.plot(middles, 1e3 * shape(middles), "k--", label="formula, at rest")
        axes.set(xlabel="distance down the slope [m]", ylabel="height [mm]")
        axes.legend()
    study.plot(draw, f"The layer after {end:g} s.")
    study.finish()


if __name__ == "__main__":
    main()
