#!/usr/bin/env python3
"""A nozzle in the middle of a full pipe: a diameter in front of it the flow is that of Herschel-Bulkley fluids in pipes, at the flow rate
of the nozzle."""

import numpy

from steady_shear import Flow, profile_error
from study import Study

RADIUS, FORCE = 0.01, 8000.0  # m; N/m^3, the loss of pressure along the pipe
FLUIDS = {"n = 1": Flow(10.0, 2.0, 1.0, 0.5 * FORCE, RADIUS), "n = 0.5": Flow(10.0, 4.0, 0.5, 0.5 * FORCE, RADIUS)}
CENTER = (0.31, 0.17)  # of the pipe, in cells from a node
BEHIND, LENGTH = 5, 4.5  # cells behind the exit; radii from there to the end


def mean_speed(flow):
    n = 100000
    r = (numpy.arange(n) + 0.5) * RADIUS / n
    return float((flow.speed(r) * r).sum() / r.sum())


def run(study, flow, cells):
    size = RADIUS / cells
    side, center = (cells + 3) * size, [n * size for n in CENTER]
    start, end = [BEHIND * size, *center], [(BEHIND + numpy.ceil(LENGTH * cells)) * size, *center]
    wall = "colliders.0.shape.parts.0"
    sets = {key.replace("fluid", "paste"): value for key, value in flow.fluid_sets(bulk=30.0).items()}
    return study.run_on_both(f"n{flow.index:g}_{cells}", {
        "domain.lower": [0.0, -side, -side], "domain.upper": [end[0], side, side], "domain.cell_size": size,
        "bodies.0.shape.start": start, "bodies.0.shape.end": end, "inflows.0.position": start,
        "inflows.0.speed": f"{mean_speed(flow)!r} * min(1, t / 0.02)", f"{wall}.start": [-1.0, *center], f"{wall}.end": [1.0, *center], **sets})


def main():
    study = Study("nozzle_in_pipe", "Nozzle in a full pipe",
                  "`u = n/(n+1) (G/2K)^(1/n) [(R - r0)^(1+1/n) - max(r - r0, 0)^(1+1/n)]`, `r0 = 2 yield stress / G`, G that of the flow rate")
    levels = (8, 12, 16) if study.long else (6, 9)
    for name, flow in FLUIDS.items():
        if name != "n = 1" and not study.long:
            continue
        errors, rates = [], []
        for cells in levels:
            particles = run(study, flow, cells).checkpoint()
            size = RADIUS / cells
            place = particles["position"] - numpy.array([BEHIND * size, *(n * size for n in CENTER)])
            near = numpy.abs(place[:, 0] - 2.0 * RADIUS) < 0.25 * RADIUS
            r, speed = numpy.hypot(place[near, 1], place[near, 2]), particles["velocity"][near, 0]
            truth = flow.speed(r.clip(0.0, RADIUS))
            errors.append(profile_error(speed, truth))
            rates.append(abs(speed.mean() / truth.mean() - 1.0))
        study.expect_convergence(f"{name}: profile a diameter in front of the exit, L2 norm", levels, errors, GATES[study.long], 0.8,
                                 note="relative to the profile's norm")
        study.expect_convergence(f"{name}: flow rate there", levels, rates, 0.02, 0.0)
    study.finish()


# The wall of a collider is of first order, so the short version, with cells twice as large, may miss twice as much.
GATES = {True: 0.03, False: 0.06}

if __name__ == "__main__":
    main()
