#!/usr/bin/env python3
"""A soft ball bounces off a plane without friction, as Hertz has it."""

import math
import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
from comparison import TRANSFERS, Case, Plan, main, measured, schemes_of  # noqa: E402

RADIUS = 0.025
SHARE = 0.02  # of the largest force: below, there is no contact
TIME, FORCE, DEPTH, RESTITUTION = 0.03, 0.05, 0.05, 0.05  # gates, fixed beforehand; the last is 1 - restitution
JUDGED = (0.2,)   # m/s; slower impacts are less than a cell deep with the cells of the gates, faster ones too deep for Hertz
FINE = 32         # cells over the radius, of the gates
COARSE = 3.0      # the gates of the short version, 16 cells over the radius, over those of the long one


def hertz_window():
    """Time in d/V during which Hertz's force is above SHARE of its peak, and how far the ball travels in it, in d."""
    low = SHARE**(2.0 / 3.0)
    angle = numpy.linspace(math.asin(low**1.25), math.pi / 2, 20001)  # x^(5/4) = sin: no singularity at the end
    slope = 0.8 * numpy.sin(angle)**-0.2
    return 2.0 * float(numpy.sum(0.5 * (slope[1:] + slope[:-1]) * numpy.diff(angle))), 1.0 - low


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
        return [plan(cells, speed, transfer) for cells in (8, 16, FINE) for speed in (0.1, 0.2, 0.4, 0.8)
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
        finest = max(record["cells"] for record in records.values() if record["transfer"] == schemes[0])
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
            if record["transfer"] == schemes[0] and speed in JUDGED and (sheet.short or record["cells"] == finest):
                for quantity, (error, tolerance) in errors.items():
                    sheet.gate(f"{quantity}, {speed:g} m/s, {record['cells']} cells over the radius", error,
                               tolerance * (COARSE if sheet.short else 1.0))
        sheet.say(f"Contact is where the force is above {100 * SHARE:g} % of its peak, in the simulation as in the theory; "
                  f"depth is how far "
                  "the centre of mass travels from there. The force is the change of the momentum. "
                  "Hertz's theory is exact for small depth: d/R is 0.05 at 0.1 m/s, 0.09 at 0.2 m/s, 0.16 and 0.28 at the faster ones.")
        sheet.table(["transfer", "speed", "cells over R", "depth in cells", "contact time", "force", "depth",
                     "loss of speed", "particles",
                     "steps", "date", "commit"], rows)

        def draw(axes):
            for axis, speed in zip(axes, (0.2, 0.4)):
                k = list(table["speed_m_per_s"]).index(speed)
                depth, peak = table["deepest_m"][k], table["largest_force_N"][k]
                x = numpy.sin(numpy.linspace(0.0, math.pi / 2, 400))**0.8
                angle = numpy.linspace(0.0, math.pi / 2, 400)
                slope = 0.8 * numpy.sin(0.5 * (angle[1:] + angle[:-1]))**-0.2
                passed = numpy.concatenate([[0.0], numpy.cumsum(slope * numpy.diff(angle))]) * depth / speed
                axis.plot(1e3 * numpy.concatenate([passed, 2 * passed[-1] - passed[::-1]]),
                          numpy.concatenate([x, x[::-1]])**1.5 * peak,
                          "k-", lw=2.5, alpha=0.5, label="Hertz")
                for record in records.values():
                    if record["speed"] == speed:
                        axis.plot(1e3 * numpy.array(record["curve_time"]), record["curve_force"], lw=1.2,
                                  color=f"C{schemes.index(record['transfer'])}",
                                  ls={8: ":", 16: "--", 32: "-"}[record["cells"]],
                                  label=f"{record['transfer']}, {record['cells']} cells over R")
                axis.set(xlabel="time [ms]", ylabel="force [N]", title=f"{speed:g} m/s")
                axis.legend(frameon=False, fontsize="small")
        sheet.picture(self.name, "Force of the plane on the ball; the times begin with the contact.", draw, 2)


CASE = HertzBall()

if __name__ == "__main__":
    main(CASE)
