#!/usr/bin/env python3
"""Displacements along the axes: a manufactured solution without shear, by a body force found from each node's place."""

import math

import numpy

from study import Study, scheme_name

DENSITY, YOUNG, POISSON = 1000.0, 1e4, 0.3
SHEAR, BULK = YOUNG / (2.0 * (1.0 + POISSON)), YOUNG / (3.0 * (1.0 - 2.0 * POISSON))
WAVE_SPEED = math.sqrt((BULK + 4.0 / 3.0 * SHEAR) / DENSITY)
AMPLITUDE = 0.05  # m; the strain is 2 pi times as much
OMEGA = math.pi * WAVE_SPEED  # 1/s
PERIOD = 2.0 * math.pi / OMEGA
SIGNS = (1.0, -1.0, 1.0)  # of the displacement along x, y, z: phases of 0 and pi
FRAMES = 8


def body_force(n_axes):
    """Per mass. The place X that a node's x belongs to comes from Newton's iteration, whose error squares at each step."""
    axes = "xyz"[:n_axes]
    begin = f"s = {AMPLITUDE!r}*sin({OMEGA!r}*t), p = 2*pi, "
    for axis, sign in zip(axes, SIGNS):
        begin += f"s{axis} = {sign!r}*s, X{axis} = {axis}, "
        begin += 4 * f"X{axis} = X{axis} - (X{axis} + s{axis}*sin(p*X{axis}) - {axis})/(1 + p*s{axis}*cos(p*X{axis})), "
        begin += f"F{axis} = 1 + p*s{axis}*cos(p*X{axis}), "
    begin += "J = " + "*".join(f"F{axis}" for axis in axes) + ", "
    begin += "trace = " + "+".join(f"F{axis}^2" for axis in axes) + f" + {3 - n_axes}, "
    forces = []
    for axis in axes:
        modulus = (f"{0.5 * BULK!r}*(J^2 + 1) + {SHEAR!r}*J^(-2/3)*(2/9*F{axis}^2 + 5/9*(trace - F{axis}^2))")
        forces.append(begin + f"-{OMEGA!r}^2*s{axis}*sin(p*X{axis}) + ({modulus})/F{axis}^2*p^2*s{axis}*sin(p*X{axis})"
                              f"/{DENSITY!r}")
    return forces + ["0"] * (3 - n_axes)


def start_velocity(n_axes, step):
    """At half a step before the start: symplectic Euler is the leapfrog method with velocities between the steps."""
    rate = AMPLITUDE * OMEGA * math.cos(0.5 * OMEGA * step)
    return [f"{sign * rate!r}*sin(2*pi*{axis})" for axis, sign in zip("xyz"[:n_axes], SIGNS)] + ["0"] * (3 - n_axes)


def displacement(start, time, n_axes):
    result = AMPLITUDE * math.sin(OMEGA * time) * numpy.array(SIGNS) * numpy.sin(2.0 * math.pi * start)
    result[:, n_axes:] = 0.0
    return result


def largest_error(run, n_axes):
    """The largest over the frames of the root mean square error of position, over the amplitude."""
    first, largest = None, 0.0
    for frame in run.frames():
        first = frame if first is None else first
        error = frame["position"] - first["position"] - displacement(first["position"], frame["time"], n_axes)
        error[:, n_axes:] = 0.0
        error -= numpy.rint(error)  # the box is periodic
        largest = max(largest, math.sqrt((error**2).sum(axis=1).mean()) / AMPLITUDE)
    return largest


def resolution(n, n_axes, scheme, per_cell=8):
    step = PERIOD / (FRAMES * math.ceil(PERIOD / (FRAMES * 0.25 / n / WAVE_SPEED)))
    upper = [1.0, 1.0, 1.0 if n_axes == 3 else 4.0 / n]
    return {"domain.cell_size": 1.0 / n, "domain.upper": upper, "bodies.all.shape.upper": upper, "time.dt": step,
            "time.end": PERIOD, "output.frame_interval": PERIOD / FRAMES, "transfer.scheme": scheme,
            "bodies.all.velocity_field": start_velocity(n_axes, step), "acceleration_field": body_force(n_axes),
            "bodies.all.particles_per_cell": per_cell}


def main():
    study = Study("axis_aligned", "Axis-aligned displacement", "Manufactured solution after Wallstedt and Guilkey (2008)")
    drawn = {}
    plane, space = ((8, 16, 32, 64), (8, 16, 32)) if study.long else ((8, 16, 32), (8, 16))
    for n_axes, cells, scheme in ((2, plane, "moment_flip"), (2, plane[1:], "apic"), (3, space, "moment_flip")):
        errors = []
        for n in cells:
            run = study.run_on_both if n == cells[0] and scheme == "moment_flip" else study.run
            errors.append(largest_error(run(f"{scheme}_{n_axes}_{n}", resolution(n, n_axes, scheme)), n_axes))
        drawn[f"{scheme_name(scheme)}, {n_axes} axes"] = cells, errors
        study.expect_convergence(f"position, root mean square, largest of {FRAMES} times, {scheme_name(scheme)} along {n_axes} axes",
                                 cells, errors, 0.05, 1.5, note="of the amplitude")

    if study.long:
        finest = plane[-2:]
        errors = [largest_error(study.run(f"dense_{n}", resolution(n, 2, "moment_flip", 27)), 2) for n in finest]
        drawn["moment FLIP, 2 axes, 27 particles per cell"] = finest, errors
        study.expect_convergence("the same along 2 axes with 27 particles per cell, moment FLIP", finest, errors, 0.01, 1.8,
                                 note="of the amplitude")
        study.remark("With 8 particles per cell the order falls on the finest grid, because the sums over particles integrate the "
                     "stress less exactly where the cells have been stretched; 27 particles per cell restore it. Halving the "
                     "time step does not.")

    def draw(axes):
        for label, (n, errors) in drawn.items():
            axes.loglog(n, errors, "o-", label=label)
        axes.loglog(plane, [drawn["moment FLIP, 2 axes"][1][0] * (plane[0] / n) ** 2 for n in plane], "k:", label="second order")
        axes.set(xlabel="cells per wavelength", ylabel="error of position over amplitude")
        axes.legend(fontsize="small")
    study.plot(draw, "Convergence of the position.")
    study.finish()


if __name__ == "__main__":
    main()
