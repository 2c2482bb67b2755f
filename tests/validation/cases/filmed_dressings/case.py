#!/usr/bin/env python3
"""Dressings without a flow curve: fitted to the film of one box, the other is predicted."""

import datetime
import json
import pathlib
import shlex
import shutil
import subprocess
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import films  # noqa: E402
from comparison import FOLDER, TRANSFERS, Case, Plan, commit, load, machine, main, make, rounded, schemes_of  # noqa: E402
from study import toml  # noqa: E402

TOOLS = FOLDER.parents[1] / "drivers/python/bulkley"
BOXES = {"cobb_dressing": ("cobb_dressing_H20_W29", "cobb_dressing_H47_W55"),
         "island_dressing": ("island_dressing_H20_W29", "island_dressing_H36_W33")}  # fitted, predicted
AUTHORS = {"cobb_dressing": (12.9, 9.82, 0.705), "island_dressing": (2.30, 2.57,
                                                                     0.806)}  # estimates of the paper, from its first box
CELLS = (0.0016,)          # m
SHIFT, SHARED = 0.015, 0.9  # s, one sigma of the shift of time; part of the variance that is one error of the whole film
GATE, SHORT = 0.12, 0.30    # of the predicted reach in frame 8; of cells of 2 mm. Fixed before the runs were made.


class FilmedDressings(Case):
    name = "filmed_dressings"
    title = "Dressings: fitted to one box, the other predicted"
    source = ("Hamamichi et al. 2023 as above: Cobb and island dressing, of which no flow curve is measured")
    missing = ("What the sauces miss. A front determines the flow curve at the rates that the flow visits, not the three "
               "parameters. Of the "
               "authors' estimates, the numbers of the Cobb dressing are also those of another fluid in their files: one is "
               "a slip")

    def plans(self, long):
        if not long:
            return [Plan(f"{fluid}, predicted", {}, {"fluid": fluid, "cell": 0.002}) for fluid in ("island_dressing",)]  # the smaller box
        return [Plan(f"{fluid}, {1e3 * cell:g} mm", {}, {"fluid": fluid, "cell": cell}, transfer) for cell in CELLS
                for fluid in BOXES
                for transfer in TRANSFERS]

    def sets(self, film, flow, cell, plan, default):
        """Of the scene of a film's box."""
        made = films.plan(film, flow, cell, transfer=plan.transfer)
        return {**made.sets_for(default), "output.front.film.origin": [film.width, 0.0, 0.0],
                "output.front.film.eye": [float(value) for value in film.eye]}

    def execute(self, plan, program, work, arguments, default):
        fluid, cell = plan.facts["fluid"], plan.facts["cell"]
        fitted, predicted = (films.Film(box) for box in BOXES[fluid])
        record = {"key": plan.key, "transfer": plan.transfer, "default_transfer": default, **plan.facts,
                  "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M"), "commit": commit(program),
                  "machine": machine()}
        if arguments.long:
            record |= self.fit(fitted, fluid, plan, program, work, default)
            flow = record["flow"]
        else:
            shipped = load(FOLDER / "results" / f"{self.name}.json").values()
            flow = next(entry["flow"] for entry in shipped if entry["fluid"] == fluid and entry["transfer"] == plan.transfer)
        for name, film in (("fitted", fitted), ("predicted", predicted)) if arguments.long else (("predicted", predicted),):
            label = f"{fluid}_{name}"
            run = make(self.folder / "scene.toml", label, self.sets(film, flow, cell, plan, default), program, work,
                       arguments.ranks)
            print(f"{self.name}: {label} took {run.seconds:.1f} s", flush=True)
            front = films.front(run, film, cell)
            record |= {name: {"time": rounded(front["time"]), "reach": rounded(front["reach"])}}
            shutil.rmtree(run.folder)
        return record

    def fit(self, film, fluid, plan, program, work, default):
        """What fit-front finds in the film of a box."""
        cell = plan.facts["cell"]
        sets = self.sets(film, (5.0, 5.0, 0.6), cell, plan, default)
        words = [sys.executable, TOOLS, "fit-front", self.folder / "scene.toml", FOLDER / f"measured/{film.name}.csv",
                 "--material", "sauce",
                 "--column", "film.reach", "--zero", -0.25 * cell, "--shift", SHIFT, "--shared", SHARED, "--out",
                 work / f"{fluid}_fit",
                 "--program", shlex.quote(str(program.path)), "--jobs", 1]
        for key, value in sets.items():
            if key.rsplit(".", 1)[-1] not in ("yield_stress", "consistency", "flow_index", "end", "frame_interval"):
                words += ["--set", f"{key}={toml(value)}"]
        outcome = subprocess.run([str(word) for word in words], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                                 check=False)
        print(outcome.stdout, flush=True)
        if outcome.returncode != 0:
            sys.exit(f"FAILED: fit-front ended with {outcome.returncode}")
        found = json.loads((work / f"{fluid}_fit/fit.json").read_text(encoding="utf-8"))
        names = ("yield_stress", "consistency", "flow_index")
        return {"flow": [float(f"{found[name]['value']:.5g}") for name in names],
                "sigma": rounded([found[name]["sigma"] for name in names]), "shift": rounded(found["shift"]["value"]),
                "shift_sigma": rounded(found["shift"]["sigma"]), "chi2": rounded(found["chi2"]),
                "converged": found["converged"],
                "runs": found["runs"], "rates": rounded(found["flow_curve"]["shear_rate"]),
                "stress": rounded(found["flow_curve"]["stress"]), "log_sigma": rounded(found["flow_curve"]["log_sigma"]),
                "combinations": [f"{entry['combination']}: {numpy.exp(min(entry['log_sigma'], 20.0)):.2f}"
                                 for entry in found["combinations"]]}

    def judge(self, records, sheet):
        schemes = schemes_of(records)
        rows, curves = [], []
        for record in sorted(records.values(), key=lambda r: (schemes.index(r["transfer"]), r["fluid"])):
            fluid = record["fluid"]
            film = films.Film(BOXES[fluid][1])
            worst, last = films.errors(film, record["predicted"])
            if sheet.short:
                sheet.gate(f"{film.title}: predicted reach in frame 8, cells of 2 mm", last, SHORT)
                continue
            where = f"cells of {1e3 * record['cell']:g} mm"
            if record["transfer"] == schemes[0]:
                sheet.gate(f"{film.title}: predicted reach in frame 8, {where}", last, GATE)
            fitted = films.errors(films.Film(BOXES[fluid][0]), record["fitted"], record["shift"])[0]
            authors = [AUTHORS[fluid][0] + AUTHORS[fluid][1] * rate**AUTHORS[fluid][2] for rate in record["rates"]]
            values = ", ".join(f"{value:.3g} +- {sigma:.1g}" for value, sigma in zip(record["flow"], record["sigma"]))
            rows.append([fluid.replace("_", " "), record["transfer"], f"{1e3 * record['cell']:g} mm", values,
                         f"{1e3 * record['shift']:+.0f} +- {1e3 * record['shift_sigma']:.0f} ms", f"{record['chi2']:.1f}",
                         record["runs"],
                         f"{fitted:.3f}", f"{worst:.3f}", f"{last:+.3f}", record["date"].split()[0], record["commit"]])
            middle = len(record["rates"]) // 2
            curves.append([fluid.replace("_", " "), record["transfer"],
                           *(f"{record['stress'][k]:.3g} Pa +- {100 * record['log_sigma'][k]:.0f} % ({authors[k]:.3g}) at "
                             f"{record['rates'][k]:.2g} 1/s" for k in (0, middle, -1)), "; ".join(record["combinations"])])
        if sheet.short:
            return
        sheet.say("`fit-front` ([how](fit-from-video.md)) finds yield stress, consistency and index from the film of the "
                  "smaller box, with "
                  f"a shift of time of 0 +- {1e3 * SHIFT:g} ms; the film of the larger box is then predicted without a "
                  f"shift. Errors are over "
                  "the film's reach in frame 8.")
        sheet.table(["fluid", "transfer", "cells", "yield stress [Pa], consistency [Pa s^n], index", "shift",
                     "chi-square of 8 points", "runs",
                     "fitted box, worst of frames 3 to 8", "predicted box, worst of 3 to 8", "frame 8", "date", "commit"],
                    rows)
        sheet.say("The flow curve over the rates that the flow visits; in brackets: by the estimates of the film's authors. "
                  "Combinations "
                  "of the parameters, with one sigma as a factor:")
        sheet.table(["fluid", "transfer", "slow", "middle", "fast", "combinations"], curves)

        def draw(axes):
            for row, fluid in zip(axes, BOXES):
                for axis, box, part in zip(row, BOXES[fluid], ("fitted", "predicted")):
                    shown = [(record[part], f"{part}, {record['transfer']}",
                              {"color": f"C{schemes.index(record['transfer'])}"})
                             for record in records.values() if record["fluid"] == fluid]
                    films.draw(axis, films.Film(box), shown)
                for record in records.values():
                    if record["fluid"] == fluid:
                        rates, stress, error = (numpy.array(record[name]) for name in ("rates", "stress", "log_sigma"))
                        for n in (2, 1):
                            row[2].fill_between(rates, stress * numpy.exp(-n * error), stress * numpy.exp(n * error),
                                                alpha=0.2, lw=0,
                                                color=f"C{schemes.index(record['transfer'])}")
                        row[2].loglog(rates, stress, color=f"C{schemes.index(record['transfer'])}",
                                      label=f"fit, {record['transfer']}")
                        row[2].loglog(rates, AUTHORS[fluid][0] + AUTHORS[fluid][1] * rates**AUTHORS[fluid][2], "k--", lw=0.8)
                row[2].set(xlabel="shear rate [1/s]", ylabel="stress [Pa]", title="flow curve; dashed: authors")
                row[2].legend(frameon=False, fontsize="small")
        sheet.picture(self.name, "The box that was fitted, the box that was predicted, and the flow curve with bands of 1 "
                                 "and 2 sigma. The runs "
                      "are not shifted.", draw, 3, 2, (4.2, 3.2))


CASE = FilmedDressings()

if __name__ == "__main__":
    main(CASE)
