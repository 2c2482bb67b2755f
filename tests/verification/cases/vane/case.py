#!/usr/bin/env python3
"""A vane rheometer: torques of a sweep of speeds, converted as if the vane were the cylinder that it cuts, give back the flow curve."""

import math

import numpy

from study import Study

RADIUS = 0.02  # m
YIELD, CONSISTENCY, INDEX = 20.0, 10.0, 0.3
STRESSES = (30.0, 36.0, 43.0, 50.0)  # Pa, that a cylinder would have at the speeds of the sweep
WAY = 0.05  # rad, the least that a run turns


def flow_curve(rate):
    return YIELD + CONSISTENCY * rate**INDEX


def speed_of_cylinder(stress):
    """rad/s: half the integral of rate/stress from the yield stress to that at the cylinder, by the midpoint rule."""
    edges = numpy.linspace(YIELD, stress, 20001)
    middle = 0.5 * (edges[1:] + edges[:-1])
    return 0.5 * float(numpy.sum(((middle - YIELD) / CONSISTENCY) ** (1.0 / INDEX) / middle * numpy.diff(edges)))


def stress_of_vane(study, spin, cells):
    """Pa: the mean torque of the second half of a run, over 2 pi R^2 times the height of the slice."""
    size = RADIUS / cells
    side, height = 2 * cells * size, size
    end = max(0.3, WAY / spin) if study.long else 0.08
    sets = {"domain.cell_size": size, "domain.lower": [-side, -side, 0.0], "domain.upper": [side, side, height], "time.end": end,
            "bodies.0.shape.parts.0.lower": [-side, -side, 0.0], "bodies.0.shape.parts.0.upper": [side, side, height],
            "colliders.vane.angular_velocity": [0.0, 0.0, spin]}
    history = study.run(f"cells_{cells}_spin_{spin:.4f}", sets, ranks=1, limit=3000).history()
    late = history["time_s"] > 0.5 * history["time_s"][-1]
    return -history["vanetorque_z_N_m"][late].mean() / (2.0 * math.pi * RADIUS**2 * height)


def convert(spins, stresses):
    """Rates at the vane, 1/s: 2 Omega dlnOmega/dlnT, which is exact where the outer part of the vessel rests. The slope is that of
    the parabola of ln Omega through the points."""
    x, y = numpy.log(stresses), numpy.log(spins)
    slope = numpy.polyval(numpy.polyder(numpy.polyfit(x, y, 2)), x)
    return 2.0 * numpy.asarray(spins) * slope


def main():
    study = Study("vane", "Vane rheometer",
                  "the law's own flow curve, `tau = tau_y + K rate^n`, at `rate = 2 Omega dlnOmega/dlnT`, `tau = T / (2 pi R^2 L)`")
    if not study.long:
        stress = STRESSES[-1]
        study.expect("torque over that of a cylinder, 17 cells over the radius",
                     stress_of_vane(study, speed_of_cylinder(stress), 17) / stress, 1.0, 0.05)
        study.finish()
        return
    cells = 20
    spins = [speed_of_cylinder(stress) for stress in STRESSES]
    found = numpy.array([stress_of_vane(study, spin, cells) for spin in spins])
    rates = convert(spins, found)
    for spin, rate, stress in zip(spins, rates, found):
        study.expect(f"stress at {rate:.3g} 1/s, {cells} cells over the radius", stress, flow_curve(rate), 0.05, "Pa",
                     note=f"the vane turns at {spin:.4g} rad/s")
    fine = stress_of_vane(study, spins[-1], 28)
    study.expect("torque of the fastest run, 28 cells over the radius against 20", found[-1], fine, 0.02, "Pa")
    study.remark(f"As a cylinder the vane would have {', '.join(f'{stress:g}' for stress in STRESSES)} Pa; it has "
                 f"{', '.join(f'{stress:.2f}' for stress in found)} Pa. Fewer blades are weaker, the more so the less the paste thins, "
                 "for it bulges in between their tips. Six in the same paste: 30.11, 35.56, 41.90 and 47.60 Pa, which makes the "
                 "curve 0.5, 2.9, 4.6 and 6.0 % low; four in a paste with n = 0.5: 33.75 and 53.0 Pa in place of 36 and 60. Of the "
                 "torque in a Newtonian fluid N blades have 1 - 1/N (Sherwood, Meeten 1991).")
    curve = numpy.geomspace(0.5 * rates[0], 2.0 * rates[-1], 100)
    def draw(axes):
        axes.loglog(curve, flow_curve(curve), label="flow curve of the paste")
        axes.loglog(rates, found, "o", label=f"vane, {cells} cells over its radius")
        axes.set(xlabel="rate, 1/s", ylabel="shear stress, Pa")
        axes.legend()
    study.plot(draw, "The flow curve that a sweep of speeds gives, and that of the material.")
    study.finish()


if __name__ == "__main__":
    main()
