#!/usr/bin/env python3
"""Steady flow of Herschel-Bulkley films down an incline: speeds, flow rate and depth of the plug over resolutions."""

import math

from steady_shear import Flow, channel_sets, profile_error, unsteadiness, yielding_from
from study import Study

WEIGHT, DENSITY = 9810.0, 100.0  # of a fluid of 1000 kg/m^3, N/m^3; and the density of the run
# By name: angle, fluid with the thickness, end of the run.
FILMS = {
    "30 degrees, n = 1": (30.0, Flow(10.0, 5.0, 1.0, WEIGHT * math.sin(math.radians(30.0)), 0.01), 0.05),
    "20 degrees, n = 0.5": (20.0, Flow(20.0, 10.0, 0.5, WEIGHT * math.sin(math.radians(20.0)), 0.02), 0.12),
}


def run(study, name, cells):
    angle, flow, end = FILMS[name]
    box = channel_sets(flow.half, cells, (0.0, 1.25))
    upper = [*box["domain.upper"][:2], flow.half]
    return study.run_on_both(f"angle{angle:g}_{cells}", {
        **box, **flow.fluid_sets(bulk=2.0 * cells), "bodies.0.shape.lower": [0.0, 0.0, 0.0], "bodies.0.shape.upper": upper,
        "materials.fluid.density": DENSITY,
        "gravity": [WEIGHT / DENSITY * math.sin(math.radians(angle)), 0.0,
                    -WEIGHT / DENSITY * math.cos(math.radians(angle))], "time.end": end})


def brink(study):
    """Films whose stress at the floor is just above and just below the yield stress: what shears is thinner than a cell."""
    cells, yield_stress, thickness, slope = 8, 10.0, 0.01, math.tan(math.radians(30.0))
    flows = {word: Flow(yield_stress, 0.05, 1.0, part * yield_stress / thickness, thickness) for word, part in (("above", 1.03), ("below", 0.98))}
    truth = flows["above"].plane_mean
    for integrator, bulk in (("imex", 2.2e9), ("explicit", 8000.0)):
        speeds = []
        for word, flow in flows.items():
            result = study.run(f"just_{word}_{integrator}", {
                **channel_sets(thickness, cells, (0.0, 1.25)), **flow.fluid_sets(), "materials.fluid.bulk_modulus": bulk,
                "bodies.0.shape.lower": [0.0, 0.0, 0.0], "bodies.0.shape.upper": [thickness / cells, thickness / cells, thickness],
                "materials.fluid.density": DENSITY, "gravity": [flow.slope / DENSITY, 0.0, -flow.slope / DENSITY / slope],
                "time.integrator": integrator, "time.end": 0.6})
            history = result.history()
            late = history["time_s"] >= 0.4
            speeds.append(history["momentum_x_kg_ms"][late].mean() / history["mass_kg"][-1])
        study.expect(f"mean speed where 0.23 cells of 8 are sheared, {integrator}", speeds[0], truth, 0.4, "m/s",
                     note="stress at the floor 3 % above the yield stress; with transfer.thin_layers = false nothing flows")
        study.expect_at_most(f"mean speed 2 % below the yield stress over that 3 % above it, {integrator}", abs(speeds[1] / truth), 0.05)


def main():
    study = Study("film", "Film on an incline",
                  "`u = u_s [1 - (1 - z/h_s)^(1+1/n)]` below `h_s = H - yield stress / (density g sin)`, `u_s` above")
    levels = (8, 16, 32) if study.long else (8, 16)
    for name, (_, flow, _) in FILMS.items():
        errors, rates = [], []
        for cells in levels:
            result = run(study, name, cells)
            particles = result.checkpoint()
            depth, speed = flow.half - particles["position"][:, 2], particles["velocity"][:, 0]
            errors.append(profile_error(speed, flow.speed(depth.clip(0.0))))
            rates.append(abs(speed.mean() / flow.plane_mean - 1.0))
            if cells == 16:
                surface = depth < flow.half / cells
                study.expect(f"{name}: speed at the surface", speed[surface].mean(), flow.largest, 0.03, "m/s",
                             note="16 cells per thickness; mean over the cells at the surface")
                study.expect(f"{name}: depth of the plug", yielding_from(depth, particles), flow.plug, flow.half / cells, "m",
                             relative=False, note="the highest particle that yields; tolerance one cell")
                study.expect_at_most(f"{name}: change of the mean speed over the last tenth of the run", unsteadiness(result),
                                     1e-3)
        study.expect_convergence(f"{name}: profile, L2 norm", levels, errors, 0.03, 1.0, note="relative to the profile's norm")
        study.expect_convergence(f"{name}: flow rate", levels, rates, 0.03, 1.0)
    if not study.imex:  # it has both integrators
        brink(study)
    study.finish()


if __name__ == "__main__":
    main()
