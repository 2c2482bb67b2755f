#!/usr/bin/env python3
"""Boxes of sauce with measured flow curves, let go and filmed."""

import pathlib
import sys

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import films  # noqa: E402
from comparison import TRANSFERS, Case, main, schemes_of  # noqa: E402

# Least squares of the relative error to the measured flow curves at 23 C over 1 to 100 1/s, the same range for all fluids:
# yield stress, Pa; consistency, Pa s^n; flow index.
FLOW = {"chuno_sauce": (1.19, 1.53, 0.554), "okonomiyaki_sauce": (7.05, 6.28, 0.496)}
BOXES = ("chuno_sauce_H20_W30", "chuno_sauce_H40_W21", "okonomiyaki_sauce_H20_W29", "okonomiyaki_sauce_H38_W42",
         "okonomiyaki_sauce_H46_W63")
STUDIED = BOXES[0]  # the box of the studies of cells and stiffness
FINE = 0.001        # m, cells of the gates
# Gates, fixed before the runs were made. Cells of 2 mm leave a sheet of two cells, which is slow: theirs are wider.
FRAMES_3_TO_8, SHIFTED, LAST, MEAN = 0.15, 0.10, 0.10, 0.06
SHORT = 0.30


def flow_of(box):
    return FLOW[box.rsplit("_", 2)[0]]


class FilmedDams(Case):
    name = "filmed_dams"
    title = "Filmed dam breaks of sauces"
    source = ("Hamamichi, Nagasawa, Okada, Seto, Yue 2023, ACM Trans. Graph. 42(6) 193, doi 10.1145/3618310; the fronts are "
              "measured "
              "on the silhouettes of github AGU-Graphics/ViRheometry (commit 897cb8e) and, for H46 W63, on the colour "
              "frames of "
              "billbearhunter/new_ViRheometry (commit 3c0cc92); flow curves from the rheometer files of the latter (commit "
              "f88fd12)")
    missing = ("Surface tension (capillary length 2.5 mm, fronts 3 mm thick), thixotropy, the film of fluid that stays on "
               "the walls and "
               "on the gate, wall slip, and the gate itself, which is pulled up by hand at 1 to 3 m/s and leaves the floor "
               "15 to 30 ms "
               "before the films' stated time 0: the simulation lets the fluid go at once. A simulation without them is "
               "expected "
               "to end a few per cent long in tall boxes")

    def plans(self, long):
        def plan(box, cell, stiffness=1.0, transfer=""):
            return films.plan(films.Film(box), flow_of(box), cell, stiffness, transfer)
        if not long:
            return [plan(STUDIED, 0.002), plan("okonomiyaki_sauce_H20_W29", 0.002)]
        cheap = [plan(box, cell, 1.0, transfer) for cell in (0.002, FINE) for box in BOXES for transfer in TRANSFERS]
        return cheap + [plan(STUDIED, cell, stiffness, transfer) for cell,
                        stiffness in ((FINE, 4.0), (0.0008, 1.0), (0.000625, 1.0))
                        for transfer in TRANSFERS]

    def measure(self, run, plan):
        return films.front(run, films.Film(plan.facts["film"]), plan.facts["cell"])

    def judge(self, records, sheet):
        schemes = schemes_of(records)
        if sheet.short:
            for record in records.values():
                film = films.Film(record["film"])
                worst, last = films.errors(film, record)
                sheet.gate(f"{film.title}: reach in frames 3 to 8, cells of 2 mm", worst, SHORT)
                sheet.gate(f"{film.title}: reach in frame 8, cells of 2 mm", last, SHORT)
            return
        sheet.say("Gates are for the program's default transfer with cells of 1 mm. No parameter is adjusted: yield stress, "
                  "consistency "
                  "and index are the rheometer's, fitted over 1 to 100 1/s for every fluid. Reach is that of the shadow "
                  "that a lamp in "
                  "the camera's eye would throw on the floor, for the film and for the particles. `t0` is the one shift of "
                  "time (-10 to 30 ms) that brings the run nearest to the film.")
        for scheme in schemes:
            self.scheme(records, scheme, sheet, scheme == schemes[0])
        self.pictures(records, schemes, sheet)
        self.studies(records, schemes, sheet)

    def of(self, records, box, cell, scheme, stiffness=1.0):
        return records.get(f"{films.plan(films.Film(box), flow_of(box), cell, stiffness).key}, {scheme}")

    def scheme(self, records, scheme, sheet, gated):
        """The table of one transfer, and its gates if it is the default."""
        rows, finals = [], []
        for box in BOXES:
            film = films.Film(box)
            for cell in (0.002, FINE):
                record = self.of(records, box, cell, scheme)
                if record is None:
                    continue
                shift = films.best_shift(film, record)
                (worst, last), (worst_shifted, last_shifted) = films.errors(film, record), films.errors(film, record, shift)
                sigmas = last * film.reach[film.judged][-1] / film.sigma[film.judged][-1]
                rows.append([film.title, f"{1e3 * cell:g} mm", f"{worst:.3f}", f"{last:+.3f}", f"{sigmas:+.1f}",
                             f"{1e3 * shift:+.0f} ms", f"{worst_shifted:.3f}", f"{last_shifted:+.3f}",
                             f"{record['particles']}", f"{record['steps']}", record["date"].split()[0], record["commit"]])
                if cell == FINE:
                    finals.append(last)
                    if gated:
                        sheet.gate(f"{film.title}: reach in frames 3 to 8, instant release", worst, FRAMES_3_TO_8)
                        sheet.gate(f"{film.title}: reach in frames 3 to 8, with one shift of time", worst_shifted, SHIFTED,
                                   note=f"t0 = {1e3 * shift:+.0f} ms")
                        sheet.gate(f"{film.title}: reach in frame 8", last, LAST)
        if finals and gated:
            sheet.gate(f"mean signed error of frame 8, {len(finals)} boxes", float(numpy.mean(finals)), MEAN)
        sheet.say(f"Transfer `{scheme}`" + (" (the program's default)"
                                            if gated else "") + ", errors over the film's reach in frame 8"
                  + (f"; mean of frame 8 over the {len(finals)} boxes with cells of 1 mm {numpy.mean(finals):+.3f}:" if finals else ":"))
        sheet.table(["film", "cells", "worst of frames 3 to 8", "frame 8", "the same in sigma", "t0", "worst with t0",
                     "frame 8 with t0",
                     "particles", "steps", "date", "commit"], rows)

    def pictures(self, records, schemes, sheet):
        def draw(axes):
            axes = axes.ravel()
            for axis, box in zip(axes, BOXES):
                curves = []
                for number, scheme in enumerate(schemes):
                    for cell, style in ((FINE, "-"), (0.002, "--")):
                        record = self.of(records, box, cell, scheme)
                        if record:
                            curves.append((record, f"{scheme}, {1e3 * cell:g} mm", {"ls": style, "color": f"C{number}"}))
                films.draw(axis, films.Film(box), curves)
            for axis in axes[len(BOXES):]:
                axis.axis("off")
        sheet.picture("filmed_dams", "Reach over time, instant release, not shifted; points: film, bands of 1 and 2 sigma.",
                      draw, 3, 2,
                      (4.2, 3.2))

    def studies(self, records, schemes, sheet):
        """Cells and stiffness, of one box."""
        film = films.Film(STUDIED)
        rows = []
        for scheme in schemes:
            for cell, stiffness in ((0.002, 1.0), (FINE, 1.0), (FINE, 4.0), (0.0008, 1.0), (0.000625, 1.0)):
                record = self.of(records, STUDIED, cell, scheme, stiffness)
                if record:
                    reach = 100 * films.simulated(film, record)
                    rows.append([scheme, f"{1e3 * cell:g} mm", f"{record['bulk_modulus']:g} Pa",
                                 *(f"{value:.2f}" for value in reach),
                                 f"{100 * films.errors(film, record)[1]:+.1f} %", f"{record['seconds']} s"])
        sheet.say(f"Cells and stiffness, {film.title}, reach in cm at frames 1 to 8 (wall times are of one core that other "
                  f"work shared):")
        sheet.table(["transfer", "cells", "bulk modulus", *map(str, range(1, 9)), "frame 8", "wall time"],
                    [["film", "", "", *(f"{100 * value:.2f}" for value in film.reach), "", ""], *rows])

        def draw(axes):
            for number, scheme in enumerate(schemes):
                points = [(1e3 * cell, 100 * films.errors(film, record)[1]) for cell in (0.002, FINE, 0.0008, 0.000625)
                          if (record := self.of(records, STUDIED, cell, scheme))]
                axes.plot(*zip(*points), "o-", color=f"C{number}", label=scheme)
                stiff = self.of(records, STUDIED, FINE, scheme, 4.0)
                if stiff:
                    axes.plot(1e3 * FINE, 100 * films.errors(film, stiff)[1], "s", mfc="none", color=f"C{number}",
                              label=f"{scheme}, four times as stiff")
            sigma = 100 * film.sigma[-1] / film.reach[-1]
            for n, color in ((2, "0.92"), (1, "0.82")):
                axes.axhspan(-n * sigma, n * sigma, color=color, lw=0, zorder=0)
            axes.set(xlabel="cells [mm]", ylabel="error of frame 8 [%]", xlim=(0, 2.2))
            axes.legend(frameon=False, fontsize="small")
        sheet.picture("filmed_dams_cells", f"Error of the reach in frame 8 over the cells, {film.title}.", draw)


CASE = FilmedDams()

if __name__ == "__main__":
    main(CASE)
