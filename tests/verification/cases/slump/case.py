#!/usr/bin/env python3
"""The slump of a slender cylinder, in time: every slice shortens under the weight above it until its section carries that weight.
At rest the slump is S = H - h_0 (1 + ln(H / h_0)) with an unyielded top h_0 = sqrt(3) tau_c / (rho g)."""

import math

import numpy

from slump_theory import G, quarter_cylinder
from study import Study

YIELD, CONSISTENCY, DENSITY, HEIGHT = 100.0, 50.0, 1000.0, 0.1
END = 2.0  # s
DECAY = math.exp(-math.sqrt(3.0) * YIELD * END / (3.0 * CONSISTENCY))
TOP = math.sqrt(3.0) * YIELD / (DENSITY * G)


def section(weight, decay=DECAY):
    """Area over its first value of the slice under the column `weight` >= TOP [m]: 3 K de/dt = rho g w exp(-e) - sqrt(3) tau_c."""
    return weight / TOP * (1.0 - decay) + decay


def slump(decay=DECAY):
    """HEIGHT less the integral of dw / section over the yielded slices and TOP. At rest: decay = 0."""
    return HEIGHT - TOP * (1.0 + math.log(section(HEIGHT, decay)) / (1.0 - decay))


def outline(particles, edges):
    """Radii of slices between `edges`, from the particles' present volumes."""
    volume = particles["reference_volume"] * particles["volume_ratio"]
    return numpy.sqrt(4.0 * numpy.histogram(particles["position"][:, 2], edges, weights=volume)[0] / numpy.diff(edges)
                      / math.pi)


def main():
    study = Study("slump", "Slump of a slender cylinder",
                  "Slices under the weight above them: `3 K de/dt = rho g w exp(-e) - sqrt(3) tau_c` for their strain e, solved "
                  "exactly; at rest that is Pashias et al. 1996, `S = H - h_0 (1 + ln(H/h_0))`, with `h_0 = sqrt(3) tau_c/(rho "
                  "g)` for the yield condition of von Mises, which this law has, in place of Tresca's `2 tau_c/(rho g)`")
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
    ratios = sorted(slenderness for slenderness, cells in slumps if cells == 4)
    truth, finest = slump(), 0.03 if study.long else 0.05
    study.expect_convergence(f"slump after {END:g} s over the slenderness, 4 cells over R", ratios,
                             [abs(slumps[ratio, 4] / truth - 1.0) for ratio in ratios], finest, 1.0,
                             note="the numbers before the colons are H/R: the theory requires R small compared with h_0")
    study.expect(f"slump after {END:g} s, H/R = {ratios[-1]:g}", 1e3 * slumps[ratios[-1], 4], 1e3 * truth, finest, "mm")
    if study.long:
        study.expect_at_most("change of the slump from 4 to 8 cells over R, H/R = 8",
                             abs(slumps[8.0, 8] / slumps[8.0, 4] - 1.0), 0.04)
    study.remark(f"At rest the theory has {1e3 * slump(0.0):.1f} mm. A real cylinder spreads further: its base, by then as wide as "
                 f"h_0, spreads like a puddle, with a speed that falls as the inverse square of the time. With H/R = 12.5 the slump "
                 f"has passed 55 mm after 5 s. The floor is without friction.")

    def draw(axes):
        middles = 0.5 * (edges[1:] + edges[:-1])
        for (slenderness, cells), radii in outlines.items():
            axes.plot(radii, 1e3 * middles, ".", label=f"H/R = {slenderness:g}, {cells} cells over R")
        weights = numpy.linspace(TOP, HEIGHT, 200)  # height of the column whose weight rests on a section
        below = TOP / (1.0 - DECAY) * numpy.log(section(HEIGHT) / section(weights))
        axes.plot(numpy.sqrt(section(weights)), 1e3 * below, "k-", label="theory")
        axes.plot([1.0, 1.0], [1e3 * below[0], 1e3 * (HEIGHT - truth)], "k-")
        axes.set(xlabel="radius over R", ylabel="height [mm]")
        axes.legend()
    study.plot(draw, f"The outline after {END:g} s.")
    study.finish()


if __name__ == "__main__":
    main()
