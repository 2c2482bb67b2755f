#!/usr/bin/env python3
"""The slump of a slender cylinder: S = H - h_0 (1 + ln(H / h_0)) with an unyielded top h_0 = sqrt(3) tau_c / (rho g)."""

import math

import numpy

from slump_theory import G, quarter_cylinder, speed
from study import Study

YIELD, DENSITY, HEIGHT, RADIUS = 100.0, 1000.0, 0.1, 0.008
THRESHOLD = 5e-4  # m/s: at rest, root mean square


def slump(top):
    return HEIGHT - top * (1.0 + math.log(HEIGHT / top))


def main():
    study = Study("slump", "Slump of a slender cylinder",
                  "Pashias et al. 1996: `S = H - h_0 (1 + ln(H/h_0))`, with `h_0 = sqrt(3) tau_c/(rho g)` for the yield condition of "
                  "von Mises, which this law has, in place of Tresca's `2 tau_c/(rho g)`")
    mises, tresca = (slump(factor * YIELD / (DENSITY * G)) for factor in (math.sqrt(3.0), 2.0))
    cells = (0.00266666666666667, 0.002, 0.00133333333333333) if study.long else (0.00266666666666667, 0.002)
    errors, slumps, outlines = [], [], {}
    for cell in cells:
        shape = quarter_cylinder(RADIUS, HEIGHT, cell)
        sets = {"domain.cell_size": cell, "bodies.cylinder.shape": shape, "time.end": 5.0 if study.long else 3.0,
                "domain.upper": [0.016, 0.016, 0.112]}
        start = study.run_on_both if cell > cells[-1] or not study.long else study.run
        frames = list(start(f"cell_{1e3 * cell:.3g}mm", sets).frames())
        top = [frame["position"][:, 2].max() for frame in (frames[0], frames[-1])]
        slumps.append(float(top[0] - top[1]))
        errors.append(abs(slumps[-1] / mises - 1.0))
        last = frames[-1]
        edges = numpy.linspace(0.0, 0.06, 21)
        volume = numpy.histogram(last["position"][:, 2], edges, weights=last["reference_volume"] * last["volume_ratio"])[0]
        outlines[cell] = numpy.sqrt(4.0 * volume / numpy.diff(edges) / math.pi)
    across = [RADIUS / cell for cell in cells]
    for n, value, error in zip(across, slumps, errors):
        print(f"slump: {n:g} cells a radius: {1e3 * value:.3f} mm, error {error:.4f}", flush=True)
    study.expect_convergence("slump, against von Mises", across, errors, 0.06, 0.3)
    study.expect("slump at the finest resolution, against von Mises", 1e3 * slumps[-1], 1e3 * mises, 0.06, "mm")
    study.expect_at_most("speed at the end, root mean square", speed(last), THRESHOLD, "m/s", note="finest resolution")
    study.remark(f"The cylinder is {HEIGHT / RADIUS:.3g} radii high; the formula takes horizontal sections to stay plane, which is "
                 f"right for slender ones only. Tresca's condition would give {1e3 * tresca:.1f} mm in place of {1e3 * mises:.1f} mm; "
                 f"the finest run gives {1e3 * slumps[-1]:.1f} mm. The floor is without friction.")

    def draw(axes):
        middles = 0.5 * (edges[1:] + edges[:-1])
        for cell, outline in outlines.items():
            axes.plot(1e3 * outline, 1e3 * middles, ".", label=f"cells of {1e3 * cell:.3g} mm")
        top = math.sqrt(3.0) * YIELD / (DENSITY * G)
        weights = numpy.linspace(top, HEIGHT, 200)  # height of the column whose weight rests on a section
        axes.plot(1e3 * RADIUS * numpy.sqrt(weights / top), 1e3 * top * numpy.log(HEIGHT / weights), "k-", label="theory")
        axes.plot([1e3 * RADIUS] * 2, [1e3 * top * math.log(HEIGHT / top), 1e3 * (HEIGHT - mises)], "k-")
        axes.set(xlabel="radius [mm]", ylabel="height [mm]")
        axes.legend()
    study.plot(draw, "The outline at the end.")
    study.finish()


if __name__ == "__main__":
    main()
