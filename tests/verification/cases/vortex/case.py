#!/usr/bin/env python3
"""The generalised vortex: a manufactured solution with large shear and rotation, by a body force that follows the time."""

import math

import numpy

from study import Study, scheme_name

DENSITY, YOUNG, POISSON = 1000.0, 1000.0, 0.3
SHEAR = YOUNG / (2.0 * (1.0 + POISSON))
WAVE_SPEED = math.sqrt(YOUNG * (1.0 - POISSON) / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON)) / DENSITY)
TURN, PERIOD = 0.1, 1.0  # rad at the middle of the ring at half the period; s


def body_force():
    """Per mass. A particle keeps its radius, so that formulas of its present place suffice."""
    begin = (f"r = max(sqrt(x*x + y*y), 1e-9), u = abs(r - 1) < 0.25 ? r - 1 : 0.25, w = {2.0 * math.pi / PERIOD!r}, "
             f"g = {0.5 * TURN!r}*(1 - cos(w*t)), g1 = {0.5 * TURN!r}*w*sin(w*t), g2 = {0.5 * TURN!r}*w*w*cos(w*t), "
             "h = 1 - 32*u^2 + 256*u^4, h1 = -64*u + 1024*u^3, h2 = abs(r - 1) < 0.25 ? -64 + 3072*u^2 : 0, "
             f"k = g*r*h1, k1 = g*(h1 + r*h2), m = {SHEAR / DENSITY!r}, "
             "radial = -r*(g1*h)^2 + m*(2/3*k*k1 + k*k/r), around = r*g2*h - m*(k1 + 2*k/r), ")
    return [begin + "(radial*x - around*y)/r", begin + "(radial*y + around*x)/r", "0"]


def start_velocity(step):
    """Half a step back from rest: symplectic Euler is the leapfrog method with velocities between the steps."""
    rate = -0.5 * step * 0.5 * TURN * (2.0 * math.pi / PERIOD) ** 2
    profile = f"u = sqrt(x*x + y*y) - 1, h = abs(u) < 0.25 ? {rate!r}*(1 - 32*u^2 + 256*u^4) : 0, "
    return [profile + "-h*y", profile + "h*x", "0"]


def turned(start, time):
    """Where the particles that began at `start` are at `time`."""
    radius = numpy.hypot(start[:, 0], start[:, 1])
    u = radius - 1.0
    profile = numpy.where(numpy.abs(u) < 0.25, 1.0 - 32.0 * u**2 + 256.0 * u**4, 0.0)
    angle = 0.5 * TURN * (1.0 - math.cos(2.0 * math.pi * time / PERIOD)) * profile
    c, s = numpy.cos(angle), numpy.sin(angle)
    return numpy.column_stack([c * start[:, 0] - s * start[:, 1], s * start[:, 0] + c * start[:, 1], start[:, 2]])


def errors_over_time(run):
    """Times, and the root mean square error of position in the ring over the largest displacement, TURN."""
    times, errors, first = [], [], None
    for frame in run.frames():
        first = frame if first is None else first
        ring = numpy.abs(numpy.hypot(first["position"][:, 0], first["position"][:, 1]) - 1.0) < 0.25
        error = frame["position"][ring] - turned(first["position"][ring], frame["time"])
        times.append(frame["time"])
        errors.append(math.sqrt((error**2).sum(axis=1).mean()) / TURN)
    return numpy.array(times), numpy.array(errors)


def resolution(n):
    """`n` cells per unit of radius."""
    cell = 1.0 / n
    step = PERIOD / (8 * math.ceil(PERIOD / (8 * 0.3 * cell / WAVE_SPEED)))
    return {"domain.cell_size": cell, "domain.upper": [1.6, 1.6, cell], "time.dt": step,
            "bodies.cylinder.shape.end": [0.0, 0.0, cell], "output.frame_interval": PERIOD / 8,
            "bodies.cylinder.velocity_field": start_velocity(step), "acceleration_field": body_force()}


def ring(n):
    """The ring without the rest of the cylinder, both surfaces free."""
    sets = resolution(n) | {"time.end": 0.5 * PERIOD}
    ends = {"type": "cylinder", "start": [0.0, 0.0, 0.0], "end": sets.pop("bodies.cylinder.shape.end")}
    return sets | {"bodies.cylinder.shape": {"type": "difference", "parts": [ends | {"radius": 1.25}, ends | {"radius": 0.75}]}}


def main():
    study = Study("vortex", "Generalised vortex", "Manufactured solution after Kamojjala et al. (2015): `angle = g(t) h(R)`")
    cells, order = ((20, 40, 80), 1.5) if study.long else ((20, 40), 1.2)
    end = PERIOD if study.long else 0.5 * PERIOD  # the largest angle is at half the period
    drawn = {}
    for scheme in ("moment_flip", "apic") if study.long else ("moment_flip",):
        errors = []
        for n in cells:
            sets = resolution(n) | {"time.end": end, "transfer.scheme": scheme}
            run = study.run_on_both if n == cells[0] and scheme == "moment_flip" else study.run
            drawn[scheme, n] = errors_over_time(run(f"{scheme}_{n}", sets))
            errors.append(drawn[scheme, n][1].max())
        study.expect_convergence(f"position, root mean square over the ring, largest until {end:g} s, {scheme_name(scheme)}", cells,
                                 errors, 0.02, order, note="of the largest displacement")

    # The solution leaves the ring's surfaces free of load, so that the ring may also stand alone.
    cells = cells[:2]
    errors = [errors_over_time(study.run(f"ring_{n}", ring(n)))[1].max() for n in cells]
    study.expect_convergence("position in the ring alone, root mean square, largest until 0.5 s, moment FLIP", cells, errors, 0.08, 0.8,
                             note="of the largest displacement")
    study.remark("With the resting material around it the ring converges towards the second order, alone with the first: its "
                 "surfaces are seeded as steps of half a cell, and the body force ends with them.")

    def draw(axes):
        for (scheme, n), (times, errors) in drawn.items():
            axes.semilogy(times[1:], errors[1:], "o-", label=f"{scheme_name(scheme)}, {n} cells per radius")
        axes.set(xlabel="time (s)", ylabel="error of position over displacement")
        axes.legend(fontsize="small")
    study.plot(draw, "Error of position over time.")
    study.finish()


if __name__ == "__main__":
    main()
