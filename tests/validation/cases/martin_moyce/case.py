#!/usr/bin/env python3
"""A column of water collapses on a dry plane: front and height over time."""

import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
from comparison import TRANSFERS, Case, Plan, frames, integrator_of, is_imex, main, measured, schemes_of  # noqa: E402

A, G = 0.05715, 9.81                     # m, width of the column; m/s^2
SHIFTS = numpy.arange(0.0, 0.3501, 0.01)  # of T, allowed: the simulation leads
CELLS, FINE = (16, 32), 32               # over the width; of the gates
SLOPE, FRONT, HEIGHT = 0.05, 0.10, 0.02  # gates: of the slope, in Z after the shift, in H; fixed before the runs were made
COARSE = 2.0                             # the gates of the short version, of 16 cells, over those of the long one


class MartinMoyce(Case):
    name = "martin_moyce"
    title = "Collapse of a water column"
    source = ("Martin, Moyce 1952, Phil. Trans. R. Soc. A 244, 312, doi 10.1098/rsta.1952.0006: their tables 2 and 6 as "
              "printed in the "
              "codes Ocellaris and Lethe, which agree to 0.01")
    missing = ("The diaphragm of waxed paper, which does not vanish at once, and the friction of the floor on a thin tip "
               "(walls and floor "
               "slip): simulations lead the measured front by a nearly constant time, 0.15 to 0.3 in T in what others "
               "published; "
               "surface tension")

    def plans(self, long):
        def plan(cells, floor="slip", transfer=""):
            cell = A / cells
            sets = {"domain.cell_size": cell, "domain.upper": [8 * A, cell, 2.25 * A],
                    "bodies.column.shape.upper": [A, cell, 2 * A], "boundaries.z_lower": floor}
            return Plan(f"{cells} cells, {floor} floor", sets, {"cells": cells, "floor": floor}, transfer)
        if not long:
            return [plan(CELLS[0])]
        wanted = [(cells, "slip") for cells in (*CELLS, 64)] + [(FINE, "sticky")]
        return [plan(*entry, transfer) for entry in wanted for transfer in TRANSFERS]

    def imex_plans(self, long):
        return [made.imex("water") for made in self.plans(long)]

    def measure(self, run, plan):
        half = 0.25 * A / plan.facts["cells"]
        history = run.history()
        times = numpy.arange(0.0, 0.2401, 0.002)
        front = numpy.interp(times, history["time_s"], history["upper_x_m"]) + half
        heights = [(time, points[points[:, 0] < 8 * half, 2].max() + half) for time, points in frames(run)]
        return {"time": times, "front": front, "height_time": [time for time, _ in heights],
                "height": [height for _, height in heights]}

    @staticmethod
    def front(record, scaled):
        return numpy.interp(scaled * (A / (2 * G))**0.5, record["time"], record["front"]) / A

    @staticmethod
    def height(record, scaled):
        return numpy.interp(scaled * (A / G)**0.5, record["height_time"], record["height"]) / (2 * A)

    def facts(self, record):
        """Slope over that measured, shift of T, largest miss of Z after it, largest miss of H."""
        points, columns = measured("martin_moyce_front")[0], measured("martin_moyce_height")[0]
        late = points["T"] > 1.42
        slope = numpy.polyfit(points["T"][late], self.front(record, points["T"][late]), 1)[0]
        truth = numpy.polyfit(points["T"][late], points["Z"][late], 1)[0]
        misses = [numpy.abs(self.front(record, points["T"] - shift) - points["Z"]).max() for shift in SHIFTS]
        best = int(numpy.argmin(misses))
        reached = columns["tau"] * (A / G)**0.5 <= record["height_time"][-1]
        height = numpy.abs(self.height(record, columns["tau"]) - columns["H"])[reached].max()
        return slope / truth - 1.0, SHIFTS[best], misses[best], height

    def on_a_sticky_floor(self, records, scheme):
        """What the default transfer does there, where no gate is set: a sentence."""
        found = [(record, self.facts(record)) for record in records.values()
                 if record["transfer"] == scheme and record["floor"] == "sticky" and record["cells"] == FINE]
        if not found:
            return ""
        within = all(abs(slope) <= SLOPE and front <= FRONT and height <= HEIGHT for _, (slope, _, front, height) in found)
        values = ", ".join(f"{100 * slope:+.1f} %, {front:.3f} and {height:.3f} {'with `imex`' if is_imex(record) else 'with the explicit step'}"
                           for record, (slope, _, front, height) in found)
        return (f" With a sticky floor, which has no gates of its own, the default transfer is {'' if within else 'not '}within all three "
                f"on {FINE} cells: {values}, against {100 * SLOPE:g} %, {FRONT:g} and {HEIGHT:g}.")

    def judge(self, records, sheet):
        schemes = schemes_of(records)
        factor = COARSE if sheet.short else 1.0
        rows = []
        for record in sorted(records.values(), key=lambda record: (schemes.index(record["transfer"]), integrator_of(record),
                                                                   record["cells"], record["floor"])):
            slope, shift, front, height = self.facts(record)
            rows.append([record["transfer"], integrator_of(record), record["cells"], record["floor"], f"{100 * slope:+.1f} %", f"{shift:.2f}",
                         f"{front:.3f}",
                         f"{height:.3f}", record["particles"], record["steps"], record.get("date", "").split()[0],
                         record["commit"]])
            if record["transfer"] == schemes[0] and record["floor"] == "slip" and (sheet.short or record["cells"] == FINE):
                where = f", {record['cells']} cells over the width{', imex' if is_imex(record) else ''}"
                sheet.gate(f"slope of the front{where}", slope, SLOPE * factor)
                sheet.gate(f"front after one shift of time, in Z{where}", front, FRONT * factor,
                           note=f"shift {shift:.2f} in T")
                sheet.gate(f"height without any shift, in H{where}", height, HEIGHT * factor)
        sheet.say("`T = t sqrt(2 g/a)`, `Z = front/a`; `tau = t sqrt(g/a)`, `H = height/(2 a)`; the measured slope of the "
                  "front over "
                  "1.43 <= T <= 3.33 is 1.319. Heights are compared to tau = 4.2. `imex` has the implicit pressure and "
                  "the bulk modulus of water, 2.2 GPa: with slip walls its column falls as the explicit one does, faster than the "
                  "measured one." + self.on_a_sticky_floor(records, schemes[0]))
        sheet.table(["transfer", "integrator", "cells over a", "floor", "slope", "shift of T", "largest miss of Z with it",
                     "largest miss of H",
                     "particles", "steps", "date", "commit"], rows)

        def draw(axes):
            points, columns = measured("martin_moyce_front")[0], measured("martin_moyce_height")[0]
            for axis, x, y, x_label, y_label, sigma in ((axes[0], points["T"], points["Z"], "T", "Z", 0.025 * points["Z"]),
                                                        (axes[1], columns["tau"], columns["H"], "tau", "H",
                                                         0.02 + 0 * columns["H"])):
                for n, color in ((2, "0.92"), (1, "0.82")):
                    axis.fill_between(x, y - n * sigma, y + n * sigma, color=color, lw=0)
                axis.plot(x, y, "ko", ms=4, label="Martin, Moyce")
                axis.set(xlabel=x_label, ylabel=y_label)
            for record in records.values():
                if record["transfer"] != schemes[0]:
                    continue  # they are in the table
                style = {"color": "C1" if is_imex(record) else "C0", "lw": 1.2,
                         "ls": {16: ":", 32: "-", 64: "--"}[record["cells"]] if record["floor"] == "slip" else "-."}
                label = f"{integrator_of(record)}, {record['cells']} cells, {record['floor']}"
                time = numpy.array(record["time"])
                axes[0].plot(time * (2 * G / A)**0.5, numpy.array(record["front"]) / A, label=label, **style)
                time = numpy.array(record["height_time"])
                axes[1].plot(time * (G / A)**0.5, numpy.array(record["height"]) / (2 * A), label=label, **style)
            axes[0].set(xlim=(0, 3.5), ylim=(1, 4.5))
            axes[1].set(xlim=(0, 4.5), ylim=(0, 1.05))
            axes[0].legend(frameon=False, fontsize="small")
        sheet.picture(self.name, "Front (left) and height at the wall (right), not shifted; bands of 1 and 2 times the "
                                 "scatter, 2.5 % of Z and 0.02 of H; " + schemes[0] + ".", draw, 2)


CASE = MartinMoyce()

if __name__ == "__main__":
    main(CASE)
