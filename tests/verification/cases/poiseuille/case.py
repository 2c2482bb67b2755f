#!/usr/bin/env python3
"""Plane Poiseuille flow of Herschel-Bulkley fluids: speeds, flow rate and width of the plug over resolutions."""

import numpy

from steady_shear import Flow, channel_sets, profile_error, unsteadiness, yielding_from
from study import Study

# Fluids by name: yield stress, consistency, index, driving force per volume, half gap (SI); the density, and the end of the run.
# The foam is that of the cream preset.
FLUIDS = {
    "n = 1": (Flow(10.0, 5.0, 1.0, 2000.0, 0.01), 1000.0, 0.18),
    "n = 0.5": (Flow(10.0, 5.0, 0.5, 2000.0, 0.01), 300.0, 0.1),
    "n = 2": (Flow(0.0, 2.0, 2.0, 1000.0, 0.02), 1000.0, 0.5),
    "foam, n = 0.22": (Flow(18.4175, 17.8167, 0.22, 5000.0, 0.01), 100.0, 0.05),
}


def run(study, name, cells):
    flow, density, end = FLUIDS[name]
    box = channel_sets(flow.half, cells)
    return study.run_on_both(f"n{flow.index:g}_{cells}", {
        **box, **flow.fluid_sets(200.0, 0.75), "bodies.0.shape.lower": box["domain.lower"], "bodies.0.shape.upper": box["domain.upper"],
        "materials.fluid.density": density, "gravity": [flow.slope / density, 0.0, 0.0], "time.end": end})


def main():
    study = Study("poiseuille", "Plane Poiseuille flow",
                  "`u = n/(n+1) (G/K)^(1/n) [(a - y0)^(1+1/n) - max(|y| - y0, 0)^(1+1/n)]`, `y0 = yield stress / G`")
    levels = (8, 16, 32) if study.long else (8, 16)
    profiles = {}
    for name, (flow, _, _) in FLUIDS.items():
        errors, rates = [], []
        for cells in levels:
            result = run(study, name, cells)
            particles = result.checkpoint()
            y, speed = particles["position"][:, 2], particles["velocity"][:, 0]
            errors.append(profile_error(speed, flow.speed(y)))
            rates.append(abs(speed.mean() / flow.plane_mean - 1.0))
            if cells == 16:
                middle = numpy.abs(y) < 0.5 * flow.half / cells
                study.expect(f"{name}: speed in the middle", speed[middle].mean(), flow.largest, 0.03, "m/s",
                             note="16 cells per half gap; mean over the cells next to the middle")
                if flow.plug > 0.0:
                    study.expect(f"{name}: half-width of the plug", yielding_from(y, particles), flow.plug,
                                 flow.half / cells, "m", relative=False,
                                 note="the nearest particle to the middle that yields; tolerance one cell")
                study.expect_at_most(f"{name}: change of the mean speed over the last tenth of the run", unsteadiness(result),
                                     1e-3)
        study.expect_convergence(f"{name}: profile, L2 norm", levels, errors, 0.03, 1.0, note="relative to the profile's norm")
        study.expect_convergence(f"{name}: flow rate", levels, rates, 0.03, 1.0)
        order = numpy.argsort(y)
        profiles[name] = (y[order] / flow.half, speed[order] / flow.largest, flow.speed(y[order]) / flow.largest)

    def draw(axes):
        for name, (y, speed, truth) in profiles.items():
            line, = axes.plot(truth, y, linewidth=1, label=name)
            axes.plot(speed[::3], y[::3], ".", markersize=3, color=line.get_color())
        axes.set_xlabel("u / largest u")
        axes.set_ylabel("y / a")
        axes.legend()
    study.plot(draw, f"Speeds of particles (dots) on the analytic profiles (lines), {levels[-1]} cells per half gap")
    study.finish()


if __name__ == "__main__":
    main()
