#!/usr/bin/env python3
"""Squeeze flow of a Bingham fluid between two discs, nearly plastic: the force on the disc against finite elements and lubrication theory."""

import math

import numpy

from study import Study

RADIUS, HALF_GAP, APPROACH = 0.05, 0.01, 0.025  # m, m, m/s: half of the gap at the end of a run, and how fast it closes
YIELD, VISCOSITY = 1000.0, 0.4  # Pa, Pa s
# Force over tau_y pi R^2 beyond that of lubrication theory: finite elements with a rim free of stress, R/h from 2.5 to 10, where
# tau_y h / (K V) is 1000. They lie at 1.29, 1.24 and 1.20 for 2.5, 5 and 10.
EXCESS = 1.29


def lubrication(half_gap):
    """N, of a Bingham fluid: the pressure's slope G(r) from the flux V r / 2 through a slot with walls at rest."""
    total, rings = 0.0, 400
    for ring in range(rings):
        r = RADIUS * (ring + 0.5) / rings
        flux = APPROACH * r  # of the whole gap: its speed of approach is twice that of a disc, and half of that times r goes out
        low, high = YIELD / half_gap, YIELD / half_gap + 1e3 * VISCOSITY * flux / half_gap**3
        for _ in range(80):
            slope = 0.5 * (low + high)
            ratio = YIELD / (slope * half_gap)
            out = 2.0 * slope * half_gap**3 / (3.0 * VISCOSITY) * (1.0 - 1.5 * ratio + 0.5 * ratio**3)
            low, high = (slope, high) if out < flux else (low, slope)
        total += math.pi * r**2 * slope * RADIUS / rings
    return total


def mean_force(study, cells):
    """Of the last cell of the disc's way, N, and what theory has in the same mean: a disc takes in one layer of nodes after
    another, and its force is a staircase."""
    size = HALF_GAP / cells
    start = HALF_GAP + 1.25 * size
    side, top = RADIUS + 8.0 * size, HALF_GAP + 6.0 * size
    sets = {"domain.cell_size": size, "domain.upper": [math.ceil(side / size) * size] * 2 + [top], "time.end": 1.25 * size / APPROACH,
            "bodies.paste.shape.parts.0.upper": [RADIUS, RADIUS, start], "colliders.disc.shape.start": [0.0, 0.0, start],
            "colliders.disc.shape.end": [0.0, 0.0, start + 3.0 * size]}
    history = study.run(f"cells_{cells}", sets, ranks=1, limit=3600).history()
    time = history["time_s"]
    late = time > 0.25 * size / APPROACH
    steps = numpy.diff(time, prepend=0.0)
    force = float(numpy.average(4.0 * history["discforce_z_N"][late], weights=steps[late]))
    gaps = start - APPROACH * numpy.linspace(0.25, 1.25, 21) * size / APPROACH
    lubricated = float(numpy.mean([lubrication(gap) for gap in gaps]))
    return force, lubricated


def main():
    study = Study("squeeze", "Squeeze flow",
                  "lubrication theory of a Bingham fluid with `1.29 tau_y pi R^2` added for rim and extension, as finite elements have "
                  "it at `R/h = 2.5`, `tau_y h/(K V) = 1000`")
    levels = (4, 8, 16) if study.long else (6,)
    errors, forces = [], []
    for cells in levels:
        force, lubricated = mean_force(study, cells)
        errors.append(abs(force / (lubricated + EXCESS * YIELD * math.pi * RADIUS**2) - 1.0))
        forces.append((force - lubricated) / (YIELD * math.pi * RADIUS**2))
    if study.long:
        study.expect_convergence("mean force on the disc", levels, errors, 0.05, 0.8, note="cells over half of the gap")
    else:
        study.expect_at_most("mean force on the disc, 6 cells over half of the gap", errors[0], 0.1)
    study.remark(f"Beyond lubrication theory the runs have {', '.join(f'{force:.2f}' for force in forces)} tau_y pi R^2: the disc "
                 "holds nodes up to 3/4 of a cell in front of it, and the layer that slides along it is a cell wide.")
    study.finish()


if __name__ == "__main__":
    main()
