#!/usr/bin/env python3
"""A column of a very viscous fluid that sinks under its weight: implicit viscosity at many times the viscous limit of the step,
against explicit viscosity."""

import numpy

from study import Study

DX, VISCOSITY, DENSITY = 0.00625, 200.0, 1000.0
LIMIT = 0.5 * DX**2 / (6.0 * VISCOSITY / DENSITY)  # of dt, s, with the default viscous_cfl
LEVELS = (10, 30, 100)


class Column:
    """Where a run ends: mean position, reach of the foot, kinetic energy a metre of width."""

    def __init__(self, run):
        particles = run.checkpoint()
        position, velocity, volume = (particles[name] for name in ("position", "velocity", "reference_volume"))
        self.center = volume @ position[:, :2] / volume.sum()
        self.front = numpy.quantile(position[:, 0], 0.995)
        history = run.history()
        self.kinetic = history["kinetic_energy_J"][-1] / DX
        self.residual = abs(history["energy_residual_J"]).max() / abs(history["gravity_work_J"][-1])


def implicit(study, level, run):
    return Column(run(f"implicit_{level}", {
        "time.integrator": "imex", "time.viscosity": "implicit", "materials.honey.bulk_modulus": 2e9, "time.mode": "fixed",
        "time.dt": level * LIMIT}))


def main():
    study = Study("viscous_column", "Viscous column",
                  "The same column with explicit viscosity and a bulk modulus of 1e5 Pa, 6200 steps")
    truth = Column(study.run("explicit"))
    for level in LEVELS:
        found = implicit(study, level, study.run_on_both if level == LEVELS[-1] else study.run)
        name = f"{level} times the viscous limit"
        study.expect_at_most(f"{name}: centre of mass", numpy.abs(found.center - truth.center).max(), 5e-4, "m",
                             note="distance along either axis from that of the explicit run")
        study.expect(f"{name}: front", found.front, truth.front, 5e-4, "m", relative=False, note="the 99.5 % quantile of x")
        study.expect(f"{name}: kinetic energy", found.kinetic, truth.kinetic, 0.1, "J/m",
                     note="off by 32, 65 and 126 % where the pressure of the last step does not stand in front of the viscosity")
        study.expect_at_most(f"{name}: residual of the energy account", found.residual, 1e-12, note="over the work of gravity")
    study.finish()


if __name__ == "__main__":
    main()
