#!/usr/bin/env python3
"""A stiff elastic ball is let go in a field with a gradient: how it moves, and what becomes of the magnetic energy."""

import math

import numpy

from study import Study

MU0 = 4e-7 * math.pi
STRENGTH, GRADIENT = 1e5, 1e6  # A/m at z = 0, A/m^2
DENSITY, START, END = 1000.0, -0.005, 0.015  # kg/m^3; m; s
FACTOR = 0.75  # 3 chi/(3 + chi)


class Flight:
    """The rows of the history at whose times the field was solved for; works and energies over the magnetic energy given up."""

    def __init__(self, run):
        rows = run.history()
        solved = numpy.flatnonzero(numpy.diff(rows["magnetic_solves"], prepend=0))
        at = numpy.searchsorted(rows["time_s"], rows["magnetic_field_time_s"][solved] - 1e-12)
        magnetic = rows["magnetic_energy_J"][solved]
        self.time = rows["time_s"][at]
        self.work = magnetic[0] - magnetic[-1]
        self.field_work = rows["magnetic_field_work_J"][at][-1] / self.work
        total = rows["kinetic_energy_J"][at] + rows["elastic_energy_J"][at] + magnetic
        self.drift = (total - total[0]) / self.work
        self.moved = rows["center_of_mass_z_m"][-1] - rows["center_of_mass_z_m"][0]
        start = rows["center_of_mass_z_m"][0]
        rate = GRADIENT * math.sqrt(MU0 * FACTOR / DENSITY)
        self.exact = (start + STRENGTH / GRADIENT) * (math.cosh(rate * rows["time_s"][-1]) - 1.0)
        pull = MU0 * FACTOR * (STRENGTH + GRADIENT * start) * GRADIENT / DENSITY  # m/s^2
        self.acceleration = rows["momentum_z_kg_ms"][1] / rows["mass_kg"][1] / rows["time_s"][1] / pull
        self.n_solves = len(solved)


def main():
    study = Study("magnetic_release", "Ball let go in a magnetic gradient",
                  "The motion of a rigid ball with the moment of a ball; the magnetic energy that it gives up")

    def fly(label, both=False, **sets):
        sets = {"time.dt": sets.get("dt", 2e-5), "magnetics.resolve_distance": sets.get("distance", 0.25)} | sets.get("more", {})
        return Flight(study.run_on_both(label, sets) if both else study.run(label, sets, ranks=1))

    plain = fly("plain", both=True)
    study.expect("acceleration of the first step", plain.acceleration, 1.0, 0.01, "of the exact one")
    study.expect("way in 15 ms", 1e3 * plain.moved, 1e3 * plain.exact, 0.01, "mm")
    study.expect_at_most("drift of kinetic, elastic and magnetic energy", abs(plain.drift).max(), 0.01,
                         note="over the magnetic energy given up; what the transfer damps counts")
    study.expect("work of the magnetic forces", plain.field_work, 1.0, 0.005, "of the magnetic energy given up",
                 note=f"with forces that particles keep for a quarter of a cell, {plain.n_solves} solutions")

    distances = (0.5, 0.25, 0.125)
    lags = [1.0 - (plain if d == 0.25 else fly(f"distance_{d:g}", distance=d)).field_work for d in distances]
    study.expect_convergence("work of forces that particles keep", [1.0 / d for d in distances], [abs(lag) for lag in lags], 0.005,
                             0.8, note="over the solutions in the time in which the fastest particle crosses a cell; less the "
                                       "magnetic energy given up, over that")

    steps = (2e-5, 1e-5, 5e-6) if study.long else (2e-5, 1e-5)
    flights = [fly(f"step_{dt:g}", dt=dt, distance=1e-9) for dt in steps]
    study.expect_convergence("work of the magnetic forces, field solved for in every step", [END / dt for dt in steps],
                             [abs(f.field_work - 1.0) for f in flights], 5e-4, 0.9,
                             note="over the number of steps; likewise. No error of the cells is in it: forces are the derivative "
                                  "of the magnetic energy of the grid")
    study.remark("Drift of kinetic, elastic and magnetic energy with the field solved for in every step: " + ", ".join(
        f"{100 * f.drift[-1]:.2f} % with {END / dt:.0f} steps" for dt, f in zip(steps, flights)) +
        ", nearly all of it what the transfer damps of the ball's oscillations.")

    if study.long:
        cell = 0.00125
        fine = fly("fine", dt=1e-5, more={"domain.cell_size": cell})
        study.expect("acceleration of the first step, 16 cells across", fine.acceleration, 1.0, 0.01, "of the exact one")
        study.expect("way in 15 ms, 16 cells across", 1e3 * fine.moved, 1e3 * fine.exact, 0.01, "mm")
        study.expect_at_most("drift of kinetic, elastic and magnetic energy, 16 cells across", abs(fine.drift).max(), 0.01,
                             note="over the magnetic energy given up")

    def draw(axes):
        axes.plot(1e3 * plain.time, 100 * plain.drift, "o-", label="solved for every quarter of a cell")
        for dt, f in zip(steps, flights):
            axes.plot(1e3 * f.time, 100 * f.drift, label=f"in every step of {1e6 * dt:.0f} us")
        axes.set(xlabel="time / ms", ylabel="drift of the energy / % of the magnetic work")
        axes.legend(fontsize=7)
    study.plot(draw, "Kinetic, elastic and magnetic energy of a ball let go, less those at the start")
    study.finish()


if __name__ == "__main__":
    main()
