#!/usr/bin/env python3
"""A soft ball bounces off a plane without friction, as Hertz has it."""

import math
import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
from comparison import TRANSFERS, Case, Plan, main, measured, schemes_of  # noqa: E402

RADIUS, DENSITY, YOUNG, POISSON = 0.025, 1000.0, 5e4, 0.45
SHARE = 0.02  # of the largest force: below, there is no contact
TIME, FORCE, DEPTH, RESTITUTION = 0.03, 0.05, 0.05, 0.05  # gates, fixed beforehand; the last is 1 - restitution
JUDGED = (0.2,)   # m/s; slower impacts are less than a cell deep with the cells of the gates, faster ones too deep for Hertz
FINE = 32         # cells over the radius, of the gates
FINEST = 48       # of one run, to see where finer cells lead
COARSE = 3.0      # the gates of the short version, 16 cells over the radius, over those of the long one


def hertz_window():
    """Time in d/V during which Hertz's force is above SHARE of its peak, and how far the ball travels in it, in d."""
    low = SHARE**(2.0 / 3.0)
    angle = numpy.linspace(math.asin(low**1.25), math.pi / 2, 20001)  # x^(5/4) = sin: no singularity at the end
    slope = 0.8 * numpy.sin(angle)**-0.2
    return 2.0 * float(numpy.sum(0.5 * (slope[1:] + slope[:-1]) * numpy.diff(angle))), 1.0 - low


def finite_size(width):
    """c of `(F/k)^(2/3) + c F/(E R)`, by which the centre of mass of an elastic sphere of radius R approaches the pole at which a plane presses,
    k = 4/3 E* R^(1/2): the first term is Hertz's, for a half-space. Linear elasticity of the whole sphere, held by its own inertia, under Hertz's
    pressure on a circle of radius `width` R, in spherical harmonics (Lur'e 1964); E = R = 1. With POISSON c hardly depends on `width`."""
    nu = POISSON
    points, weights = numpy.polynomial.legendre.leggauss(800)
    angle = 0.25 * math.pi * (points + 1.0)  # from the middle of the circle to its edge, where the slope of the pressure is infinite
    sine = width * numpy.sin(angle)
    cosine = numpy.sqrt(1.0 - sine**2)
    pressed = 0.25 * math.pi * weights * numpy.cos(angle) * width * numpy.cos(angle) / cosine * sine  # p sin(theta) d(theta)
    previous, current, approach = numpy.zeros_like(cosine), numpy.ones_like(cosine), 0.0
    for n in range(4000):  # no more than the points resolve
        pressure = 0.5 * (2 * n + 1) * pressed @ current
        if n == 1:  # against inertia: a pressure that grows linearly through the sphere
            approach += 0.6 * (1.0 - 2.0 * nu) * pressure
        else:
            held = n * (n * n + 2 * n - 1 + 2 * nu) / (n - 1) if n else 0.0
            approach += pressure * (1 + nu) * (held - (n + 1) * (n - 2 + 4 * nu)) / (2 * (n * n + n + 1 + nu * (2 * n + 1)))
        previous, current = current, ((2 * n + 1) * cosine * current - n * previous) / (n + 1)
    return (approach - 0.5 * math.pi * width * (1.0 - nu**2)) / (2.0 * math.pi * pressed @ cosine)


def loading(speed, c):
    """Time, s, force, N, and approach, m, from the first touch to the largest force, if the centre of mass approaches as `finite_size` says."""
    mass, stiffness = DENSITY * 4.0 / 3.0 * math.pi * RADIUS**3, 4.0 / 3.0 * YOUNG / (1.0 - POISSON**2) * math.sqrt(RADIUS)
    depth = (1.25 * mass * speed**2 / stiffness)**0.4
    force = numpy.linspace(0.0, 2.0 * stiffness * depth**1.5, 400001)
    approach = (force / stiffness)**(2.0 / 3.0) + c * force / (YOUNG * RADIUS)
    step = numpy.diff(approach)
    work = numpy.concatenate([[0.0], numpy.cumsum(0.5 * (force[1:] + force[:-1]) * step)])
    last = int(numpy.searchsorted(work, 0.5 * mass * speed**2)) - 1  # here it all but rests
    slowing = numpy.sqrt(speed**2 - 2.0 * work[:last] / mass)
    time = numpy.concatenate([[0.0], numpy.cumsum(2.0 * step[:last - 1] / (slowing[1:] + slowing[:-1])), [0.0]])
    time[-1] = time[-2] + slowing[-1] * mass / force[last]
    return time, force[:last + 1], approach[:last + 1]


def impact(speed, c):
    """Largest force, N, contact time, s, and travel, m, both while the force is above SHARE of that, by `loading`."""
    time, force, approach = loading(speed, c)
    first = int(numpy.searchsorted(force, SHARE * force[-1]))
    return force[-1], 2.0 * (time[-1] - time[first]), approach[-1] - approach[first]


class HertzBall(Case):
    name = "hertz_ball"
    title = "Impact of a soft ball"
    source = ("Hertz's theory of the impact of an elastic sphere on a rigid plane without friction, exact for small depth: "
              "`d = (15 m V^2/(16 E* sqrt R))^(2/5)`, contact time `2.94328 d/V`, force `4/3 E* sqrt(R) d^(3/2)`; R = 25 "
              "mm, "
              "1000 kg/m^3, E = 50 kPa, nu = 0.45")
    missing = ("Nothing of the physics; the ball touches up to a cell before it should. Tables of gel balls at larger "
               "speeds (Tanaka et al. "
               "2003), where Hertz ends, could not be read: not compared")

    def plans(self, long):
        def plan(cells, speed, transfer=""):
            cell, low = RADIUS / cells, 0.003125  # m, of the ball above the plane at the start
            row = {value: k for k, value in enumerate(measured("hertz_impact")[0]["speed_m_per_s"])}[speed]
            contact = measured("hertz_impact")[0]["contact_time_s"][row]
            sets = {"domain.cell_size": cell, "time.end": low / speed + 1.5 * contact,
                    "bodies.ball.velocity": [0.0, 0.0, -speed]}
            return Plan(f"{speed:g} m per s, {cells} cells", sets, {"cells": cells, "speed": speed, "row": row}, transfer)
        if not long:
            return [plan(16, 0.2)]
        return [plan(FINEST, JUDGED[0])] + [plan(cells, speed, transfer) for cells in (8, 16, FINE) for speed in (0.1, 0.2, 0.4, 0.8)
                                            for transfer in TRANSFERS]

    def measure(self, run, plan):
        history = run.history()
        time, momentum, height = history["time_s"], 4.0 * history["momentum_z_kg_ms"], history["center_of_mass_z_m"]
        force = numpy.diff(momentum) / numpy.diff(time)
        touching = numpy.flatnonzero(force > SHARE * force.max())
        first, last = touching[0], touching[-1]
        middle = 0.5 * (time[1:] + time[:-1])
        every = max(1, len(middle[first:last + 1]) // 60)
        return {"contact_time": time[last + 1] - time[first], "force": force.max(), "travel": height[first] - height.min(),
                "depth": RADIUS - height.min(), "restitution": -momentum[-1] / momentum[0],
                "mass": 4.0 * history["mass_kg"][0],
                "curve_time": middle[first:last + 1:every] - time[first], "curve_force": force[first:last + 1:every]}

    def judge(self, records, sheet):
        schemes = schemes_of(records)
        table = measured("hertz_impact")[0]
        window, travel = hertz_window()
        rows = []
        for record in sorted(records.values(), key=lambda r: (schemes.index(r["transfer"]), r["speed"], r["cells"])):
            k = record["row"]
            depth, speed = table["deepest_m"][k], record["speed"]
            errors = {"contact time": (record["contact_time"] / (window * depth / speed) - 1.0, TIME),
                      "largest force": (record["force"] / table["largest_force_N"][k] - 1.0, FORCE),
                      "depth": (record["travel"] / (travel * depth) - 1.0, DEPTH),
                      "loss of speed": (1.0 - record["restitution"], RESTITUTION)}
            rows.append([record["transfer"], f"{speed:g} m/s", record["cells"], f"{depth * record['cells'] / RADIUS:.2f}",
                         *(f"{100 * error:+.1f} %" for error, _ in errors.values()), record["particles"], record["steps"],
                         record["date"].split()[0], record["commit"]])
            if record["transfer"] == schemes[0] and speed in JUDGED and (sheet.short or record["cells"] == FINE):
                for quantity, (error, tolerance) in errors.items():
                    sheet.gate(f"{quantity}, {speed:g} m/s, {record['cells']} cells over the radius", error,
                               tolerance * (COARSE if sheet.short else 1.0))
        sheet.say(f"Contact is where the force is above {100 * SHARE:g} % of its peak, in the simulation as in the theory; "
                  f"depth is how far "
                  "the centre of mass travels from there. The force is the change of the momentum.")
        sheet.table(["transfer", "speed", "cells over R", "depth in cells", "contact time", "force", "depth",
                     "loss of speed", "particles",
                     "steps", "date", "commit"], rows)

        if not sheet.short:
            self.beyond(records, schemes[0], sheet)

        def draw(axes):
            for axis, speed in zip(axes, (0.1, 0.2)):
                k = list(table["speed_m_per_s"]).index(speed)
                depth = table["deepest_m"][k]
                for c, style in ((0.0, {"lw": 2.5, "color": "0.5", "label": "Hertz"}),
                                 (finite_size(math.sqrt(depth / RADIUS)), {"lw": 1.5, "color": "0.7", "label": "a ball of finite size"})):
                    time, force, _ = loading(speed, c)
                    every = slice(None, None, 500)
                    axis.plot(1e3 * numpy.concatenate([time[every], 2 * time[-1] - time[every][::-1]]),
                              numpy.concatenate([force[every], force[every][::-1]]), **style)
                for record in records.values():
                    if record["speed"] == speed:
                        axis.plot(1e3 * numpy.array(record["curve_time"]), record["curve_force"], lw=1.2,
                                  color=f"C{schemes.index(record['transfer'])}",
                                  ls={8: ":", 16: "--"}.get(record["cells"], "-"),
                                  label=f"{record['transfer']}, {record['cells']} cells over R")
                axis.set(xlabel="time [ms]", ylabel="force [N]", title=f"{speed:g} m/s")
                axis.legend(frameon=False, fontsize="small", loc="lower center")
        sheet.picture(self.name, "Force of the plane on the ball; the times begin with the contact.", draw, 2)

    def beyond(self, records, scheme, sheet):
        """What Hertz's theory leaves out, beside the runs on the two finest cells."""
        table = measured("hertz_impact")[0]
        rows = []
        for speed in sorted({record["speed"] for record in records.values()}):
            k = list(table["speed_m_per_s"]).index(speed)
            depth = table["deepest_m"][k]
            c = finite_size(math.sqrt(depth / RADIUS))
            with_it, without = impact(speed, c), impact(speed, 0.0)
            coarse, fine = sorted((r for r in records.values() if r["transfer"] == scheme and r["speed"] == speed), key=lambda r: r["cells"])[-2:]
            ahead = coarse["cells"] / (fine["cells"] - coarse["cells"])
            found = [fine[name] for name in ("force", "contact_time", "travel")]
            line = [(1.0 + ahead) * fine[name] - ahead * coarse[name] for name in ("force", "contact_time", "travel")]
            rows.append([f"{speed:g} m/s", f"{depth / RADIUS:.2f}", f"{c:.2f}", *(f"{100 * (a / b - 1):+.1f} %" for a, b in zip(with_it, without)),
                           fine["cells"], *(f"{100 * (a / b - 1):+.1f} %" for a, b in zip([*found, *line], [*without, *without]))])
        sheet.say("Hertz's theory takes the ball for a half-space. But it is round and held by its own inertia: by linear elasticity its centre of "
                  "mass approaches the plane by `(F/k)^(2/3) + c F/(E R)`, `k = 4/3 E* sqrt(R)`, where Hertz has the first term alone (`finite_size` in "
                  "`case.py` computes c). What that adds falls with the root of the depth only, and is 9 % of the force at d/R = 0.03 still: "
                  "all impacts here are too deep for Hertz by more than the gates, which were fixed before this was known and stay. The runs approach that theory "
                  "with finer cells, the shallow ones most; in deep ones strains are no longer small. Against Hertz, the last three columns on a straight line "
                  "through the two finest cells, to cells of no size:")
        sheet.table(["speed", "d/R", "c", "theory: force", "contact time", "depth", "cells over R", "run: force", "contact time", "depth",
                     "no cells: force", "contact time", "depth"], rows)


CASE = HertzBall()

if __name__ == "__main__":
    main(CASE)
