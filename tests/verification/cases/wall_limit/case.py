#!/usr/bin/env python3
"""When a printed wall falls under its own weight: the yield stress is found by bisection, with one shape, and compared with limit loads."""

import math

from slump_theory import quarter_cylinder
from study import Study

HEIGHT, DENSITY, G = 0.04, 2000.0, 9.81
RAMP, END = 0.2, 0.7  # s: gravity grows, and how long the wall is watched
# Limit heights over a_0 = tau_y / (rho g) on a rough plate, finite elements: upper bounds, 0.5 to 1 % high. Keys: width over height.
PLANE, RING = {0.5: 2.574, 0.25: 2.289}, {0.25: 2.331}
RING_RADIUS = 10.0 / 3.0  # mean radius over the width
GATE = 0.1
N_HALVINGS = 6


def slip_plane_bound(slenderness):
    """H / a_0 at the yield stress of a plane wall that slips along the best straight line: H = 2 a_0 sqrt(1 + w / (2 a_0))."""
    # With w = slenderness H: h^2 = 4 + 2 slenderness h.
    return slenderness + math.sqrt(slenderness**2 + 4.0)


def plane_wall(slenderness, cells):
    width = slenderness * HEIGHT
    cell = width / cells
    upper = [0.5 * width, cell, HEIGHT]
    return {"domain.cell_size": cell, "domain.upper": [1.5 * width, cell, math.ceil(HEIGHT / cell + 2.0) * cell],
            "bodies.wall.shape": {"type": "box", "lower": [0.0, 0.0, 0.0], "upper": upper}}


def ring(slenderness, cells):
    """A quarter of it."""
    width = slenderness * HEIGHT
    cell, radius = width / cells, RING_RADIUS * width
    side = math.ceil((radius + width) / cell) * cell
    hole = {"type": "cylinder", "start": [0.0, 0.0, -cell], "end": [0.0, 0.0, HEIGHT + cell], "radius": radius - 0.5 * width}
    shape = {"type": "difference", "parts": [quarter_cylinder(radius + 0.5 * width, HEIGHT, cell), hole]}
    return {"domain.cell_size": cell, "domain.upper": [side, side, math.ceil(HEIGHT / cell + 2.0) * cell], "boundaries.y_lower": "slip",
            "boundaries.y_upper": "sticky", "bodies.wall.shape": shape}


def falls(study, label, sets, yield_stress, width):
    """Whether the top goes on sinking, by a hundredth of the width, once gravity is complete. That strains the foot by about as much, and
    a foot that has become wider carries more: with a twentieth, some 5 % more."""
    frames = study.run(label, {**sets, "materials.paste.yield_stress": yield_stress}).frames()
    tops = [(frame["time"], float(frame["position"][:, 2].max())) for frame in frames]
    complete = next(top for time, top in tops if time > RAMP - 1e-3)
    return complete - tops[-1][1] > 0.01 * width


def limit_height(study, name, slenderness, cells, shape, truth):
    """H / a_0 between the last wall that stands and the first that falls, bisected between 0.7 and 1.3 of the truth."""
    sets, width = shape(slenderness, cells), slenderness * HEIGHT
    stands, lies = 0.7 * truth, 1.3 * truth
    for n in range(N_HALVINGS):
        middle = 0.5 * (stands + lies)
        if falls(study, f"{name}_{slenderness:g}_{cells}_{n}", sets, DENSITY * G * HEIGHT / middle, width):
            lies = middle
        else:
            stands = middle
    return 0.5 * (stands + lies)


def main():
    study = Study("wall_limit", "Wall that falls under its own weight",
                  "Limit loads of a Mises material on a rough plate, finite elements (upper bounds, 0.5 to 1 % high); rigorous bounds")
    levels = (12, 24) if study.long else (12,)
    heights = [limit_height(study, "plane", 0.5, cells, plane_wall, PLANE[0.5]) for cells in levels]
    study.expect(f"H rho g / tau_y of a long wall half as wide as high, {levels[-1]} cells across", heights[-1], PLANE[0.5], GATE)
    study.expect_at_most("what it lacks of the lower bound 2", max(0.0, 2.0 - heights[-1]), 0.0)
    study.remark("Long wall, width 0.5 H: " + ", ".join(f"{h:.3f} with {n} cells across" for n, h in zip(levels, heights))
                 + f"; bisected to {0.3 * PLANE[0.5] / 2**N_HALVINGS:.3f}. Slip along a straight line: at most {slip_plane_bound(0.5):.3f}.")
    if study.long:
        slender = limit_height(study, "plane", 0.25, 12, plane_wall, PLANE[0.25])
        round_wall = limit_height(study, "ring", 0.25, 8, ring, RING[0.25])
        study.expect("the same of a long wall a quarter as wide as high, 12 cells across", slender, PLANE[0.25], GATE)
        study.expect("the same of a ring as slender, mean radius 3.33 widths, 8 cells across", round_wall, RING[0.25], GATE)
        study.remark(f"The height sqrt(3) tau_y / (rho g) is a safe one for any wall with vertical sides, 2 tau_y / (rho g) for a long "
                     f"one. The foot that sticks to the plate carries more: a ring as slender as this falls at {round_wall:.2f}.")

        def draw(axes):
            ratios = [0.1 + 0.01 * n for n in range(45)]
            axes.plot(ratios, [slip_plane_bound(ratio) for ratio in ratios], "k-", label="slip along a line: upper bound, long wall")
            axes.plot(ratios, [2.0] * len(ratios), "k--", label="2: lower bound, long wall")
            axes.plot(ratios, [math.sqrt(3.0)] * len(ratios), "k:", label="sqrt(3): lower bound, any wall")
            axes.plot(list(PLANE), list(PLANE.values()), "o", mfc="none", label="finite elements, long wall")
            axes.plot(list(RING), list(RING.values()), "s", mfc="none", label="finite elements, ring")
            axes.plot([0.5] * len(levels) + [0.25], [*heights, slender], "x", label="here, long wall")
            axes.plot([0.25], [round_wall], "+", label="here, ring")
            axes.set(xlabel="width over height", ylabel="H rho g / tau_y", ylim=(1.6, 3.0))
            axes.legend(fontsize=7)
        study.plot(draw, "The height at which a wall falls, over a_0 = tau_y / (rho g).")
    study.finish()


if __name__ == "__main__":
    main()
