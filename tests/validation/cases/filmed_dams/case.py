#!/usr/bin/env python3
"""Boxes of sauce with measured flow curves, let go and filmed."""

import pathlib
import sys
from dataclasses import replace

import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2]))
import films  # noqa: E402
from comparison import OF_PARTICLES, TRANSFERS, TRUE_MODULUS, VOIDS_OPEN, Case, is_imex, main, schemes_of  # noqa: E402

# Least squares of the relative error to the measured flow curves at 23 C over 1 to 100 1/s, the same range for all fluids:
# yield stress, Pa; consistency, Pa s^n; flow index.
FLOW = {"chuno_sauce": (1.19, 1.53, 0.554), "okonomiyaki_sauce": (7.05, 6.28, 0.496)}
# The same fit over 1 to 1000 1/s, all of the rheometer's but its lowest decade, for a study: of chuno sauce the law above has 1 % too little
# stress at 100 1/s, 7 % at 251 and 21 % at 1000, of okonomiyaki sauce 0.1, 0.7 and 3.5 %.
WIDE_FLOW = {"chuno_sauce": (1.66, 1.16, 0.620), "okonomiyaki_sauce": (7.34, 6.04, 0.504)}
FITTED_TO = 100.0  # 1/s, the largest rate of the fit that the gates are for
BOXES = ("chuno_sauce_H20_W30", "chuno_sauce_H40_W21", "okonomiyaki_sauce_H20_W29", "okonomiyaki_sauce_H38_W42",
         "okonomiyaki_sauce_H46_W63")
STUDIED = BOXES[0]  # the box of the study of cells
STIFFER = 4.0  # times the bulk modulus, of the study of stiffness
COARSE, FINE = 0.002, 0.001  # m, cells; the gates are for the fine ones
FINEST = (0.0008, 0.000625)  # m, cells of the studies
SHORT_IMEX = 0.0016  # m, cells of the short version with the implicit pressure
LIMITS = (1.0, 0.5, 0.25)  # factors on all limits of the time step, of the study of the implicit pressure
SHORT_BOXES = (STUDIED, "okonomiyaki_sauce_H20_W29")
# Gates, fixed before the runs were made. Cells of 2 mm leave a sheet of two cells, which is slow: theirs are wider.
FRAMES_3_TO_8, SHIFTED, LAST, MEAN = 0.15, 0.10, 0.10, 0.06
# Behind a gate, without any shift of time: of frames 3 to 8, and of the mean of frame 8. Fixed after runs of two boxes on 2 mm.
BEHIND_GATE, BEHIND_GATE_MEAN = 0.10, 0.04
SHORT = 0.30
OF_PARTICLES_SAID = ' with `transfer.dilation = "particle"`, where a sheet of two or three cells locks'


def flow_of(box, flows=FLOW):
    return flows[box.rsplit("_", 2)[0]]


def explicit_plan(box, cell, stiffness=1.0, transfer="", gate=False):
    """The run of a box with the softened fluid; with `gate`, behind the gate that the films have."""
    film = films.Film(box)
    plan = films.plan(film, flow_of(box), cell, stiffness, transfer)
    return films.behind_gate(plan, film) if gate else plan


def wide_plan(box, cell, transfer=""):
    """The explicit run behind a gate with the flow curve fitted over more rates. Its frames tell at which rates the law dissipates."""
    film = films.Film(box)
    plan = films.behind_gate(films.plan(film, flow_of(box, WIDE_FLOW), cell, 1.0, transfer), film)
    return replace(plan, key=f"{plan.key}, fit to 1000 1/s", sets={**plan.sets, "output.fields": list(films.RATES)})


def imex_plan(box, cell, limits=1.0, transfer="", gate=False):
    """The run of a box with the implicit pressure; with `gate`, behind the gate that the films have."""
    film = films.Film(box)
    plan = films.plan(film, flow_of(box), cell, transfer=transfer, key=f"{box}, {1e3 * cell:g} mm")
    return (films.behind_gate(plan, film) if gate else plan).imex("sauce", limits)


class FilmedDams(Case):
    name = "filmed_dams"
    title = "Filmed dam breaks of sauces"
    source = ("Hamamichi, Nagasawa, Okada, Seto, Yue 2023, ACM Trans. Graph. 42(6) 193, doi 10.1145/3618310; the fronts are "
              "measured "
              "on the silhouettes of github AGU-Graphics/ViRheometry (commit 897cb8e) and, for H46 W63, on the colour "
              "frames of "
              "billbearhunter/new_ViRheometry (commit 3c0cc92); flow curves from the rheometer files of the latter (commit "
              "f88fd12)")
    missing = ("Surface tension (capillary length 2.5 mm, fronts 3 mm thick), thixotropy, wall slip and, but for the runs behind a "
               "gate (above), the gate, which is pulled up by hand at 1 to 3 m/s, leaves the floor 15 to 30 ms before the films' stated "
               "time 0, and takes sauce along: without it the simulation lets the fluid go at once and is expected to end a few per cent "
               "long in tall boxes")

    def plans(self, long):
        if not long:
            return [explicit_plan(box, COARSE) for box in SHORT_BOXES]
        cells = [explicit_plan(box, cell, 1.0, transfer) for cell in (COARSE, FINE, *FINEST) for box in BOXES for transfer in TRANSFERS]
        gated = [explicit_plan(box, cell, 1.0, transfer, gate=True) for cell in (COARSE, FINE, *FINEST) for box in BOXES for transfer in TRANSFERS]
        wide = [wide_plan(box, cell, transfer) for cell in (FINE, FINEST[-1]) for box in BOXES for transfer in TRANSFERS]
        stiffer = [explicit_plan(box, FINE, STIFFER, transfer) for box in BOXES for transfer in TRANSFERS]
        return cells + gated + wide + stiffer

    def imex_plans(self, long):
        if not long:
            return [imex_plan(box, SHORT_IMEX) for box in SHORT_BOXES]
        cells = [imex_plan(box, cell, 1.0, transfer) for cell in (COARSE, FINE, *FINEST) for box in BOXES for transfer in TRANSFERS]
        gated = [imex_plan(box, cell, 1.0, transfer, gate=True) for cell in (COARSE, FINE, *FINEST) for box in BOXES for transfer in TRANSFERS]
        limits = [imex_plan(STUDIED, COARSE, limits, transfer) for limits in LIMITS[1:] for transfer in TRANSFERS]
        return cells + gated + limits

    def measure(self, run, plan):
        found = films.front(run, films.Film(plan.facts["film"]), plan.facts["cell"], plan.facts.get("start", 0.0))
        if "gate" in plan.facts:
            particles = run.history()["particles"]
            found["carried_away"] = 1.0 - particles[-1] / particles[0]  # by the gate, out of the domain
        if "output.fields" in plan.sets:
            found["dissipated_beyond_fit"] = films.dissipated_above(run, plan.facts["flow"], FITTED_TO)
        return found

    def judge(self, records, sheet):
        if sheet.short:
            for record in records.values():
                film = films.Film(record["film"])
                worst, last = films.errors(film, record)
                where = f"{film.title}{', imex' if is_imex(record) else ''}, cells of {1e3 * record['cell']:g} mm"
                # The implicit pressure does not lock thin sheets: the gates of fine cells hold on coarser ones.
                sheet.gate(f"{where}: reach in frames 3 to 8", worst, FRAMES_3_TO_8 if is_imex(record) else SHORT)
                sheet.gate(f"{where}: reach in frame 8", last, LAST if is_imex(record) else SHORT)
            return
        schemes = schemes_of(records)
        sheet.say("Gates are for the program's default transfer with cells of 1 mm, the same for the explicit step and for the "
                  "implicit pressure (`imex`). No parameter is adjusted: yield stress, consistency "
                  "and index are the rheometer's, fitted over 1 to 100 1/s for every fluid. Reach is that of the shadow "
                  "that a lamp in "
                  "the camera's eye would throw on the floor, for the film and for the particles. `t0` is the one shift of "
                  "time (-10 to 30 ms) that brings the run nearest to the film. `voids open`: runs with `transfer.close_voids = false`, as all were "
                  "before 1 December 2026, in which fluids leave empty what fronts do on floors ([figures](theory.md#voids-at-floors)). With the "
                  "default, which fills it, the fifth box behind a gate on 1 mm is of an older program, the fourth and fifth have not been run on 1 mm with `imex`, "
                  "none with both a gate and `imex` on 1 mm, with a gate below 1 mm, or with the law fitted to 1000 1/s; APIC has been run on 2 mm, at once. Explicit runs before commit bf6c055 filled the less the stiffer the fluid: "
                  "frame 8 of the tall box of chuno sauce came 0.02 to 0.03 farther on 1 and 2 mm. "
                  "Runs of commit 876382747c and earlier took nodes behind the floor for empty and closed more than there is: frame 8 of ten runs on 2 mm and of two on 1 mm is 0.002 to 0.011 "
                  "farther since ([theory](theory.md#voids-at-floors)). "
                  "Runs of commit 48accef28b and earlier ones sheared sauces on the floor in whole cells (`transfer.thin_layers = false`): with thin shear layers frame 8 of "
                  "nine runs on 2 mm differs by at most 0.001 ([decision 014](decisions/014-thin-shear-layers.md)).")
        for scheme in schemes:
            self.scheme(records, scheme, sheet, scheme == schemes[0])
        self.pictures(records, [scheme for scheme in schemes if OF_PARTICLES not in scheme], sheet)
        self.studies(records, schemes, sheet)
        self.moduli(records, schemes, sheet)
        for scheme in schemes:
            self.scheme(records, scheme, sheet, scheme == schemes[0], imex=True)
        self.imex_cells(records, schemes[0], sheet)
        self.imex_picture(records, schemes[0], sheet)
        self.limits(records, schemes, sheet)
        self.gates(records, schemes, sheet)
        self.sideways(records, schemes[0], sheet)
        self.rates(records, schemes, sheet)

    def of(self, records, box, cell, scheme, stiffness=1.0, gate=False):
        return records.get(f"{explicit_plan(box, cell, stiffness, gate=gate).key}, {scheme}")

    def of_imex(self, records, box, cell, scheme, limits=1.0, gate=False):
        return records.get(f"{imex_plan(box, cell, limits, gate=gate).key}, {scheme}")

    def scheme(self, records, scheme, sheet, gated, imex=False):
        """The table of one transfer with one integrator, and its gates if the transfer is the default."""
        rows, finals = [], {}
        for box in BOXES:
            film = films.Film(box)
            for cell in (COARSE, FINE, *FINEST):
                record = (self.of_imex if imex else self.of)(records, box, cell, scheme)
                if record is None:
                    continue
                shift = films.best_shift(film, record)
                (worst, last), (worst_shifted, last_shifted) = films.errors(film, record), films.errors(film, record, shift)
                sigmas = last * film.reach[film.judged][-1] / film.sigma[film.judged][-1]
                rows.append([film.title, f"{1e3 * cell:g} mm", f"{worst:.3f}", f"{last:+.3f}", f"{sigmas:+.1f}",
                             f"{1e3 * shift:+.0f} ms", f"{worst_shifted:.3f}", f"{last_shifted:+.3f}",
                             f"{record['particles']}", f"{record['steps']}", record["date"].split()[0], record["commit"]])
                finals.setdefault(cell, []).append(last)
                if cell == FINE and gated:
                    where = f"{film.title}{', imex' if imex else ''}"
                    sheet.gate(f"{where}: reach in frames 3 to 8, instant release", worst, FRAMES_3_TO_8)
                    sheet.gate(f"{where}: reach in frames 3 to 8, with one shift of time", worst_shifted, SHIFTED,
                               note=f"t0 = {1e3 * shift:+.0f} ms")
                    sheet.gate(f"{where}: reach in frame 8", last, LAST)
        if not rows:
            return
        means = [f"{numpy.mean(errors):+.3f} (cells of {1e3 * cell:g} mm, {len(errors)} boxes)"
                 for cell, errors in finals.items() if len(errors) > 1]
        if FINE in finals and gated:
            sheet.gate(f"mean signed error of frame 8, {len(finals[FINE])} boxes{', imex' if imex else ''}",
                       float(numpy.mean(finals[FINE])), MEAN)
        sheet.say((f"Implicit pressure (`imex`) with the bulk modulus of water, {TRUE_MODULUS / 1e9:g} GPa, and the shear modulus of the "
                   f"softened fluid; transfer `{scheme.removesuffix(VOIDS_OPEN)}`" if imex else
                   f"Transfer `{scheme.removesuffix(OF_PARTICLES).removesuffix(VOIDS_OPEN)}`" + OF_PARTICLES_SAID * (OF_PARTICLES in scheme))
                  + " with `transfer.close_voids = false`" * (VOIDS_OPEN in scheme)
                  + (" (the program's default)" if gated else "") + ", errors over the film's reach in frame 8"
                  + (f"; mean of frame 8 {', '.join(means)}" if means else "") + ":")
        sheet.table(["film", "cells", "worst of frames 3 to 8", "frame 8", "the same in sigma", "t0", "worst with t0",
                     "frame 8 with t0",
                     "particles", "steps", "date", "commit"], rows)

    def pictures(self, records, schemes, sheet):
        def draw(axes):
            axes = axes.ravel()
            for axis, box in zip(axes, BOXES):
                curves = []
                for number, scheme in enumerate(schemes):
                    for cell, style in ((FINE, "-"), (COARSE, "--")):
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
        cells = (COARSE, FINE, *FINEST)
        explicit = ((COARSE, 1.0), (FINE, 1.0), (FINE, STIFFER), *((cell, 1.0) for cell in FINEST))
        for scheme in schemes:
            runs = [self.of(records, STUDIED, cell, scheme, stiffness) for cell, stiffness in explicit]
            runs += [self.of_imex(records, STUDIED, cell, scheme) for cell in cells]
            for record in filter(None, runs):
                reach = 100 * films.simulated(film, record)
                rows.append([scheme, f"{1e3 * record['cell']:g} mm", f"{record['bulk_modulus']:g} Pa{', imex' if is_imex(record) else ''}",
                             *(f"{value:.2f}" for value in reach),
                             f"{100 * films.errors(film, record)[1]:+.1f} %", f"{record['seconds']} s"])
        sheet.say(f"Cells and stiffness, {film.title}, reach in cm at frames 1 to 8 (wall times are of one core that other "
                  f"work shared):")
        sheet.table(["transfer", "cells", "bulk modulus", *map(str, range(1, 9)), "frame 8", "wall time"],
                    [["film", "", "", *(f"{100 * value:.2f}" for value in film.reach), "", ""], *rows])

        def draw(axes):
            for number, scheme in enumerate(schemes):
                for of, style, name in ((self.of, "o-", scheme), (self.of_imex, "v--", f"{scheme}, imex")):
                    points = [(1e3 * cell, 100 * films.errors(film, record)[1]) for cell in cells
                              if (record := of(records, STUDIED, cell, scheme))]
                    if points:
                        axes.plot(*zip(*points), style, color=f"C{number}", label=name)
                stiff = self.of(records, STUDIED, FINE, scheme, STIFFER)
                if stiff:
                    axes.plot(1e3 * FINE, 100 * films.errors(film, stiff)[1], "s", mfc="none", color=f"C{number}",
                              label=f"{scheme}, four times as stiff")
            sigma = 100 * film.sigma[-1] / film.reach[-1]
            for n, color in ((2, "0.92"), (1, "0.82")):
                axes.axhspan(-n * sigma, n * sigma, color=color, lw=0, zorder=0)
            axes.set(xlabel="cells [mm]", ylabel="error of frame 8 [%]", xlim=(0, 2.2))
            axes.legend(frameon=False, fontsize="small", loc="center left", bbox_to_anchor=(1.0, 0.5))
        sheet.picture("filmed_dams_cells", f"Error of the reach in frame 8 over the cells, {film.title}.", draw, size=(7.0, 3.2))

    def moduli(self, records, schemes, sheet):
        """Stiffness, of all boxes that have a stiffer run."""
        rows = []
        for scheme in schemes:
            for box in BOXES:
                film = films.Film(box)
                soft, stiff, true = (self.of(records, box, FINE, scheme), self.of(records, box, FINE, scheme, STIFFER),
                                     self.of_imex(records, box, FINE, scheme))
                if soft and stiff:
                    rows.append([scheme, film.title, f"{soft['bulk_modulus']:g} Pa",
                                 *(f"{films.errors(film, record)[1]:+.3f}" if record else "" for record in (soft, stiff, true)),
                                 f"{soft['steps']}", f"{stiff['steps']}", stiff["date"].split()[0], stiff["commit"]])
        if rows:
            sheet.say(f"Stiffness, cells of {1e3 * FINE:g} mm, instant release: error of frame 8 with the bulk modulus of the tables above, with "
                      f"{STIFFER:g} times as much, which doubles the number of steps, and with the true one (`imex`):")
            sheet.table(["transfer", "film", "bulk modulus", "frame 8", f"{STIFFER:g} times as stiff", "true modulus, imex", "steps",
                         f"{STIFFER:g} times as stiff", "date", "commit"], rows)

    def imex_cells(self, records, scheme, sheet):
        """How far frame 8 moves from coarse to fine cells, over the boxes that have all these runs on both."""
        names = {"with the implicit pressure": (self.of_imex, scheme), "with the explicit step": (self.of, scheme),
                 "where each particle keeps its own volume": (self.of, scheme + OF_PARTICLES)}
        moves = []
        for box in BOXES:
            ends = [[of(records, box, cell, name) for cell in (COARSE, FINE)] for of, name in names.values()]
            if all(map(all, ends)):
                moves.append([abs(numpy.diff([films.errors(films.Film(box), record)[1] for record in pair])[0]) for pair in ends])
        if moves:
            means = ", ".join(f"{100 * value:.1f} % {name}" for name, value in zip(names, numpy.mean(moves, axis=0)))
            sheet.say(f"From cells of 2 mm to cells of 1 mm the reach in frame 8 moves by so much of the film's, mean of {len(moves)} boxes: "
                      f"{means}, so that a sheet of two or three cells locks ([why](transfers.md#the-bulk-modulus)).")

    def imex_picture(self, records, scheme, sheet):
        """The implicit pressure beside the explicit step."""
        def draw(axes):
            axes = axes.ravel()
            for axis, box in zip(axes, BOXES):
                wanted = [(self.of_imex(records, box, FINE, scheme), "imex, 1 mm", {"ls": "-", "color": "C2"}),
                          (self.of_imex(records, box, COARSE, scheme), "imex, 2 mm", {"ls": "--", "color": "C2"}),
                          (self.of(records, box, FINE, scheme), "explicit, 1 mm", {"ls": "-", "color": "C0"}),
                          (self.of(records, box, COARSE, scheme), "explicit, 2 mm", {"ls": "--", "color": "C0"})]
                films.draw(axis, films.Film(box), [curve for curve in wanted if curve[0]])
            for axis in axes[len(BOXES):]:
                axis.axis("off")
        sheet.picture("filmed_dams_imex", f"Implicit pressure with {TRUE_MODULUS / 1e9:g} GPa, and the softened explicit runs, `{scheme}`; "
                                          "not shifted.", draw, 3, 2, (4.2, 3.2))

    def gates(self, records, schemes, sheet):
        """The runs behind a gate."""
        rows, means = [], []
        for scheme in schemes:
            for integrator, of in (("explicit", self.of), ("imex", self.of_imex)):
                behind, finals = f"behind a gate{', imex' if integrator == 'imex' else ''}", {}
                for box in BOXES:
                    film = films.Film(box)
                    for cell in (COARSE, FINE, *FINEST):
                        record = of(records, box, cell, scheme, gate=True)
                        if record is None:
                            continue
                        worst, last = films.errors(film, record)
                        at_once = of(records, box, cell, scheme)
                        rows.append([scheme, integrator, film.title, f"{1e3 * cell:g} mm",
                                     *(f"{value:.2f} ({seen:.2f})" for value, seen in
                                       zip(100 * films.simulated(film, record)[:3], 100 * film.reach)),
                                     f"{worst:.3f}", f"{last:+.3f}", f"{films.errors(film, at_once)[1]:+.3f}" if at_once else "",
                                     f"{100 * record['carried_away']:.1f} %", record["date"].split()[0], record["commit"]])
                        if scheme != schemes[0]:
                            continue
                        finals.setdefault(cell, []).append(last)
                        if cell == FINE:
                            sheet.gate(f"{film.title}, {behind}: reach in frames 3 to 8", worst, BEHIND_GATE)
                            sheet.gate(f"{film.title}, {behind}: reach in frame 8", last, BEHIND_GATE)
                if FINE in finals:
                    sheet.gate(f"mean signed error of frame 8, {len(finals[FINE])} boxes, {behind}", float(numpy.mean(finals[FINE])),
                               BEHIND_GATE_MEAN)
                means += [f"{numpy.mean(errors):+.3f} ({integrator}, cells of {1e3 * cell:g} mm, {len(errors)} boxes, none beyond "
                          f"{max(errors, key=abs):+.3f})" for cell, errors in finals.items() if len(errors) > 1]
        if not rows:
            return
        sheet.say(f"Behind a gate: a collider {1e3 * films.GATE_THICKNESS:g} mm thick to which the fluid sticks as to the other walls, pulled up "
                  f"from the floor with {films.GATE_ACCELERATION:g} m/s^2. At time 0 its lower edge is where a frame of the film shows it (0.5 cm, "
                  "H46 W63), else at half the fluid's height, which is the rule by which the films of 2023 are timed. No shift of "
                  f"time. Mean error of frame 8, {schemes[0]}: {', '.join(means)}. Reach in cm of frames 1 to 3 (the film's), then errors as above:")
        sheet.table(["transfer", "integrator", "film", "cells", "frame 1", "2", "3", "worst of frames 3 to 8", "frame 8",
                     "frame 8 without a gate", "fluid that the gate takes along", "date", "commit"], rows)

        def draw(axes):
            axes = axes.ravel()
            for axis, box in zip(axes, BOXES):
                wanted = [(self.of(records, box, FINE, scheme, gate=gate), f"{scheme}{', gate' if gate else ', at once'}",
                           {"ls": "-" if gate else "--", "color": f"C{number}"})
                          for number, scheme in enumerate(schemes) if OF_PARTICLES not in scheme for gate in (True, False)]
                # The runs behind a gate begin before the film's time 0.
                films.draw(axis, films.Film(box), [curve for curve in wanted if curve[0]])
                axis.set_xlim(left=0.0)
            for axis in axes[len(BOXES):]:
                axis.axis("off")
        sheet.picture("filmed_dams_gate", "Reach over time behind a gate and released at once, explicit, cells of 1 mm, not shifted; points: "
                                          "film, bands of 1 and 2 sigma.", draw, 3, 2, (4.2, 3.2))

    def sideways(self, records, scheme, sheet):
        """How far the fluid has gone across, round the ends of the side walls."""
        rows = []
        for box in BOXES:
            film = films.Film(box)
            measured = 1e3 * film.near_edge[film.judged][-1]
            runs = [of(records, box, FINE, scheme, gate=gate) for of, gate in ((self.of, False), (self.of, True), (self.of_imex, False))]
            found = [1e3 * films.simulated(film, record, of="near_edge")[film.judged][-1] if record else None for record in runs]
            rows.append([film.title, f"{measured:.1f} +- {1e3 * film.sigma[film.judged][-1]:.1f}",
                         *(f"{value:.1f} ({value - measured:+.1f})" if value is not None else "" for value in found)])
        sheet.say(f"Sideways: how far the edge of the shadow that is nearest to the camera has gone in frame 8 beyond the near wall's inner face, in mm, on cells of "
                  f"{1e3 * FINE:g} mm, `{scheme}` (difference from the film in brackets). The uncertainty is the reach's, measured on the same pictures; the files state none of its own. "
                  "Not gated: no tolerance was fixed before these were looked at. The shadow's area, which the files of the films also have, is not compared:")
        sheet.table(["film", "measured", "explicit, at once", "explicit, behind a gate", "imex, at once"], rows)

    def rates(self, records, schemes, sheet):
        """What the range of the flow curve's fit does, behind the gate."""
        rows = []
        for scheme in schemes:
            for box in BOXES:
                film = films.Film(box)
                for cell in (FINE, FINEST[-1]):
                    record = records.get(f"{wide_plan(box, cell).key}, {scheme}")
                    if record is None:
                        continue
                    narrow = self.of(records, box, cell, scheme, gate=True)
                    before = [f"{value:+.3f}" for value in films.errors(film, narrow)] if narrow else ["", ""]
                    worst, last = films.errors(film, record)
                    rows.append([scheme, film.title, f"{1e3 * cell:g} mm", f"{100 * record['dissipated_beyond_fit']:.0f} %",
                                 before[0].lstrip("+"), f"{worst:.3f}", before[1], f"{last:+.3f}", record["date"].split()[0],
                                 record["commit"]])
        if not rows:
            return
        sheet.say(f"Rates beyond the fit. The rheometer goes to 1000 1/s, the fits that the gates are for to {FITTED_TO:g} 1/s, and beyond them their "
                  "law has too little stress: of chuno sauce 7 % at 251, 11 % at 398 and 16 % at 631 1/s, of okonomiyaki sauce 1 %. Explicit runs "
                  "behind the gate with the law fitted over 1 to 1000 1/s (chuno sauce "
                  f"{', '.join(f'{number:g}' for number in WIDE_FLOW['chuno_sauce'])}, within 6 % of the rheometer; okonomiyaki sauce "
                  f"{', '.join(f'{number:g}' for number in WIDE_FLOW['okonomiyaki_sauce'])}, within 2 %), and what part of the law's dissipation is beyond "
                  f"{FITTED_TO:g} 1/s in them; not gated, for no film had a say in the range of the gates' fit and none shall:")
        sheet.table(["transfer", "film", "cells", f"dissipated above {FITTED_TO:g} 1/s", "worst of frames 3 to 8, fit to 100", "fit to 1000",
                     "frame 8, fit to 100", "fit to 1000", "date", "commit"], rows)

    def limits(self, records, schemes, sheet):
        """What the length of the implicit step does, on one box."""
        film = films.Film(STUDIED)
        found = [(scheme, limits, self.of_imex(records, STUDIED, COARSE, scheme, limits)) for scheme in schemes for limits in LIMITS]
        rows = [[scheme, f"{limits:g}", f"{100 * films.simulated(film, record)[-1]:.2f}",
                 f"{100 * films.errors(film, record)[1]:+.1f} %", f"{record['steps']}", f"{record['smallest_volume_ratio']:.4f}",
                 f"{record['seconds']} s", record["date"].split()[0], record["commit"]]
                for scheme, limits, record in found if record]
        sheet.say(f"Length of the implicit step, {film.title}, cells of 2 mm; all limits of the time step times the factor. The film's "
                  f"reach in frame 8 is {100 * film.reach[-1]:.2f} cm:")
        sheet.table(["transfer", "factor", "reach in frame 8 [cm]", "frame 8", "steps", "smallest volume ratio", "wall time", "date",
                     "commit"], rows)


CASE = FilmedDams()

if __name__ == "__main__":
    main(CASE)
