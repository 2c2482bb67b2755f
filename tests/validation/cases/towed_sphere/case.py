#!/usr/bin/env python3
"""A sphere is towed slowly through a yield-stress fluid: the plateau of its drag."""

import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
from comparison import TRANSFERS, Case, Plan, integrator_of, is_imex, main, schemes_of  # noqa: E402

R, TAU, K, N = 0.01, 50.0, 5.0, 0.5
BERIS, ANSLEY = 43.94, 34.5     # plateau of F/(R^2 tau_y) at vanishing speed: computed; correlation of experiments
MIDDLE, GATE = 45.0, 5.0        # accepted: 40 to 50. Fixed before the runs were made.
COARSE = 3.0                    # the gate of the short version over that of the long one


def shrunk_by(record):
    """What R + dx/2 in place of R makes of F/(R^2 tau_y)."""
    return (1.0 + 0.5 / record["cells"])**-2


class TowedSphere(Case):
    name = "towed_sphere"
    title = "Towed sphere in a yield-stress fluid"
    source = ("Beris et al. 1985: at vanishing speed `F = 43.94 R^2 tau_y` (from `2 pi R^2 tau_y/F < 0.143`), computed; the "
              "correlation "
              "of experiments in wide use (Ansley, Smith; Darby, Chhabra) has 34.5: they are 27 % apart")
    missing = ("Roughness and slip of real spheres, on which experiments depend. The viscous part of the drag is not zero "
               "at this speed: "
               "`K (V/R)^n/tau_y` is 4.5 % in the long version. The collider acts up to half a cell early, so the effective "
               "radius is "
               "larger on coarse cells. With the softened explicit fluid (20 kPa) the suction behind the sphere, ten times the yield stress, "
               "opens a cavity there after three to four cells of way, and the drag falls by a sixth; the real bulk modulus leaves no room for "
               "one in a full box, and the drag stands still")

    def plans(self, long):
        def plan(cells, speed, travel, transfer=""):
            sets = {"domain.cell_size": R / cells, "colliders.sphere.velocity": [0.0, 0.0, speed],
                    "time.end": travel * R / speed}
            return Plan(f"{cells} cells, {1e3 * speed:g} mm per s", sets, {"cells": cells, "speed": speed}, transfer)
        if not long:
            return [plan(4, 0.008, 0.6)]
        return [plan(cells, 0.002, 1.0, transfer) for cells in (4, 5, 8) for transfer in TRANSFERS]

    def imex_plans(self, long):
        return [made.imex("gel") for made in self.plans(long)]

    def measure(self, run, plan):
        history = run.history()
        force = -4.0 * history["sphereforce_z_N"][1:]
        travel = history["time_s"][1:] * plan.facts["speed"] / R
        every = max(1, len(travel) // 100)
        return {"plateau": numpy.mean(force[travel > 0.8 * travel[-1]]), "travel": travel[::every], "force": force[::every]}

    def judge(self, records, sheet):
        schemes = schemes_of(records)
        finest = {integrator: max(record["cells"] for record in records.values()
                                  if record["transfer"] == schemes[0] and integrator_of(record) == integrator)
                  for integrator in map(integrator_of, records.values())}
        rows = []
        for record in sorted(records.values(), key=lambda r: (is_imex(r), schemes.index(r["transfer"]), r["cells"])):
            imex = ", imex" if is_imex(record) else ""
            found = record["plateau"] / (R**2 * TAU)
            viscous = K * (record["speed"] / R)**N / TAU
            shrunk = found * shrunk_by(record)
            rows.append([record["transfer"], integrator_of(record), record["cells"], f"{1e3 * record['speed']:g} mm/s", f"{found:.1f}",
                         f"{shrunk:.1f}",
                         f"{100 * viscous:.1f} %", record["particles"], record["steps"], record["date"].split()[0],
                         record["commit"]])
            if record["transfer"] == schemes[0] and record["cells"] == finest[integrator_of(record)]:
                sheet.gate(f"plateau of F/(R^2 tau_y) less {MIDDLE:g}, with R + dx/2, {record['cells']} cells over R{imex}",
                           shrunk - MIDDLE,
                           GATE * (COARSE if sheet.short else 1.0))
        sheet.say(f"Plateau of F/(R^2 tau_y); Beris has {BERIS}, the correlation {ANSLEY}. A sticky collider acts "
                  "up to a cell early: in the next column, which is the gated one, R is larger by half a cell. The plateau is the mean over "
                  "the last fifth of the way. With the explicit step on 8 cells, whose plateau has the gate, that is after the drag has "
                  "fallen (below) from 54 to 45.6, with R + dx/2 from 48 to 40.4; both are within the gate. Runs with 10 cells over R "
                  "were not made.")
        sheet.table(["transfer", "integrator", "cells over R", "speed", "F/(R^2 tau_y)", "with R + dx/2", "K (V/R)^n/tau_y", "particles",
                     "steps", "date",
                     "commit"], rows)

        def draw(axes):
            axes.axhspan(40, 50, color="0.88", lw=0)
            axes.axhline(BERIS, color="k", label="Beris")
            axes.axhline(ANSLEY, color="k", ls="--", label="correlation of experiments")
            for record in records.values():
                axes.plot(record["travel"], shrunk_by(record) * numpy.array(record["force"]) / (R**2 * TAU), lw=1.2,
                          color=f"C{schemes.index(record['transfer']) + len(schemes) * is_imex(record)}",
                          ls={4: ":", 5: "--", 8: "-"}[record["cells"]],
                          label=f"{record['transfer']}{', imex' * is_imex(record)}, {record['cells']} cells over R")
            axes.set(xlabel="way over R", ylabel="F/((R + dx/2)^2 tau_y)", ylim=(0, None))
            axes.legend(frameon=False, fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
        sheet.picture(self.name, "Drag over the way, with R + dx/2; accepted: the band from 40 to 50.", draw, size=(8.0, 3.2))


CASE = TowedSphere()

if __name__ == "__main__":
    main(CASE)
