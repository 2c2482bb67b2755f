#!/usr/bin/env python3
"""A cylinder of yield-stress fluid spreads on a floor: (h - c)^2 = c^2 + 2 t (R - r), t = tau_c / (rho g), c = (sqrt(3) pi/4) t."""

import math

import numpy

from slump_theory import Layer, front, misplaced, quarter_cylinder, rings, speed
from study import Study

PASTE = Layer(density=1000.0, yield_stress=10.0, consistency=0.05, index=2.0, axisymmetric=True)
RADIUS, HEIGHT, WIDTH = 0.12, 0.03, 0.24  # of the cylinder, of the domain
THRESHOLD = 1e-3                          # m/s: at rest, root mean square
RINGS, FINE = 24, 10                      # rings of the comparison; parts of a ring in the truth


def averaged(heights, radii):
    """Means over rings of what is known on their parts."""
    ends = numpy.arange(0, len(heights), FINE)
    return numpy.add.reduceat(heights * radii, ends) / numpy.add.reduceat(radii, ends)


def main():
    study = Study("axisymmetric_spread", "Axisymmetric spread",
                  "Thin layer at yield (Roussel, Coussot 2005), to second order: `(h - c)^2 = c^2 + 2 t (R - r)` with `t = tau_c/(rho g)` and "
                  "`c = (sqrt(3) pi/4) t` for the tension of the plug; on the way there, the lubrication equation about an axis with that tension")
    cells = (0.008, 0.005, 0.00333333333333333) if study.long else (0.008, 0.005)
    end = 6.0 if study.long else 2.0
    edges = numpy.linspace(0.0, WIDTH, RINGS + 1)
    fine = numpy.linspace(0.0, WIDTH, RINGS * FINE + 1)
    middles, radii = 0.5 * (edges[1:] + edges[:-1]), 0.5 * (fine[1:] + fine[:-1])
    areas = math.pi * numpy.diff(edges**2)
    moving, rest, reach, found = [], [], [], {}
    for cell in cells:
        shape = quarter_cylinder(RADIUS, HEIGHT, cell)
        sets = {"domain.cell_size": cell, "time.end": end, "bodies.cylinder.shape": shape}
        start = study.run_on_both if cell > cells[-1] or not study.long else study.run
        particles = list(start(f"cell_{1e3 * cell:g}mm", sets).frames())[-1]
        found[cell] = heights = rings(particles, edges, 0.25)
        volume = float(numpy.sum(heights * areas))
        paste = PASTE.as_it_lies(particles)
        (truth,) = paste.spread(fine, numpy.where(radii < RADIUS, volume / (math.pi * RADIUS**2), 0.0), [end],
                               second_order=True)
        expected = averaged(truth, radii)
        moving.append(misplaced(heights, expected, areas))
        edge, height = paste.arrested(volume, second_order=True)
        profile = height(radii)
        formula = averaged(profile, radii)
        rest.append(misplaced(heights, formula, areas))
        reach.append(abs(front(middles, heights, 0.004) / front(middles, formula, 0.004) - 1.0))
    depth = [profile[0] / cell for cell in cells]
    aspect = float(profile[0] / edge)
    study.expect_convergence(f"volume out of place after {end:g} s, against lubrication", depth, moving, 0.5 * aspect, 0.7)
    study.remark(f"Cells are counted over the height of the arrested layer at the axis, {1e3 * profile[0]:.1f} mm. "
                 f"Its aspect ratio "
                 f"is {aspect:.3f}, of which the tolerances are half; what the truth leaves out is of its square.")
    if study.long:
        study.expect_convergence("volume out of place at rest, against the formula", depth, rest, 0.5 * aspect, 0.7)
        study.expect_convergence("run-out at rest (height 4 mm), against the formula", depth, reach, 0.5 * aspect, 0.7,
                                 truth_error=aspect**2)
        study.expect_at_most("speed at the end, root mean square", speed(particles), THRESHOLD, "m/s",
                             note="finest resolution")

    def draw(axes):
        for cell, heights in found.items():
            axes.plot(middles, 1e3 * heights, ".", label=f"cells of {1e3 * cell:g} mm")
        axes.plot(middles, 1e3 * expected, "k-", label="lubrication")
        axes.plot(middles, 1e3 * formula, "k--", label="formula, at rest")
        axes.set(xlabel="radius [m]", ylabel="height [mm]")
        axes.legend()
    study.plot(draw, f"The layer after {end:g} s, mean heights over rings.")
    study.finish()


if __name__ == "__main__":
    main()
