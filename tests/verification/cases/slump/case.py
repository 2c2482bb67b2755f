#!/usr/bin/env python3
"""The slump of a slender cylinder: S = H - h_0 (1 + ln(H / h_0)) with an unyielded top h_0 = sqrt(3) tau_c / (rho g)."""

import math

import numpy

from slump_theory import G, quarter_cylinder, speed
from study import Study

YIELD, DENSITY, HEIGHT = 100.0, 1000.0, 0.1
THRESHOLD = 1e-3  # m/s: at rest, root mean square


def slump(top):
    return HEIGHT - top * (1.0 + math.log(HEIGHT / top))


def outline(particles, edges):
    """Radii of slices between `edges`, from the particles' present volumes."""
    volume = particles["reference_volume"] * particles["volume_ratio"]
    return numpy.sqrt(4.0 * numpy.histogram(particles["position"][:, 2], edges, weights=volume)[0] / numpy.diff(edges)
                      / math.pi)


def main():
    study = Study("slump", "Slump of a slender cylinder",
                  "Pashias et al. 1996: `S = H - h_0 (1 + ln(H/h_0))`, with `h_0 = sqrt(3) tau_c/(rho g)` for the "
                  "yield condition of "
                  "von Mises, which this law has, in place of Tresca's `2 tau_c/(rho g)`")
    mises, tresca = (slump(factor * YIELD / (DENSITY * G)) for factor in (math.sqrt(3.0), 2.0))
    cylinders = [(8.0, 4), (12.5, 4), (20.0, 4), (8.0, 8)] if study.long else [(8.0, 4), (12.5, 4)]  # H/R, cells a radius
    edges = numpy.linspace(0.0, 0.06, 16)
    slumps, outlines = {}, {}
    for slenderness, cells in cylinders:
        radius, cell = HEIGHT / slenderness, HEIGHT / slenderness / cells
        width, height = 3 * cells * cell, (math.ceil(HEIGHT / cell - 1e-9) + 4) * cell
        sets = {"domain.cell_size": cell, "domain.upper": [width, width, height],
                "bodies.cylinder.shape": quarter_cylinder(radius, HEIGHT, cell)}
        start = study.run_on_both if cells * slenderness <= 50.0 else study.run
        frames = list(start(f"slenderness_{slenderness:g}_cells_{cells}", sets).frames())
        top = [float(frame["position"][:, 2].max()) for frame in (frames[0], frames[-1])]
        slumps[slenderness, cells] = top[0] - top[1]
        outlines[slenderness, cells] = outline(frames[-1], edges) / radius
        study.expect_at_most(f"speed at the end, root mean square, H/R = {slenderness:g}, {cells} cells over R",
                             speed(frames[-1]), THRESHOLD, "m/s")
    ratios = sorted(slenderness for slenderness, cells in slumps if cells == 4)
    study.expect_convergence("slump over the slenderness, 4 cells over R", ratios, [abs(slumps[ratio, 4] / mises - 1.0)
                                                                                    for ratio in ratios],
                             0.03 if study.long else 0.07, 1.0,
                             note="the numbers before the colons are H/R: the theory wants R small beside h_0")
    study.expect(f"slump, H/R = {ratios[-1]:g}", 1e3 * slumps[ratios[-1], 4], 1e3 * mises, 0.03 if study.long else 0.07, "mm")
    if study.long:
        study.expect_at_most("change of the slump from 4 to 8 cells over R, H/R = 8",
                             abs(slumps[8.0, 8] / slumps[8.0, 4] - 1.0), 0.04)
    study.remark(f"Tresca's condition would give {1e3 * tresca:.1f} mm in place of von Mises' {1e3 * mises:.1f} mm; "
                 f"the most slender "
                 f"cylinder gives {1e3 * slumps[ratios[-1], 4]:.1f} mm. The floor is without friction.")

    def draw(axes):
        middles = 0.5 * (edges[1:] + edges[:-1])
        for (slenderness, cells), radii in outlines.items():
            axes.plot(radii, 1e3 * middles, ".", label=f"H/R = {slenderness:g}, {cells} cells over R")
        top = math.sqrt(3.0) * YIELD / (DENSITY * G)
        weights = numpy.linspace(top, HEIGHT, 200)  # height of the column whose weight rests on a section
        axes.plot(numpy.sqrt(weights / top), 1e3 * top * numpy.log(HEIGHT / weights), "k-", label="theory")
        axes.plot([1.0, 1.0], [1e3 * top * math.log(HEIGHT / top), 1e3 * (HEIGHT - mises)], "k-")
        axes.set(xlabel="radius over R", ylabel="height [mm]")
        axes.legend()
    study.plot(draw, "The outline at the end.")
    study.finish()


if __name__ == "__main__":
    main()
