#!/usr/bin/env python3
"""What transfers damp: per step in APIC, per time in moment FLIP and in a blend with a damping time."""

import math

from study import Study

CELL, SOUND, WAVE_NUMBER = 0.0625, 10.0, 2.0 * math.pi  # m, m/s, 1/m: 16 cells a wave
# (T9a): the part of the wave that a passage from nodes to particles and back loses, quadratic and cubic splines.
MOMENTS = {"quadratic": (WAVE_NUMBER * CELL) ** 4 / 42.0, "cubic": 17.0 * (WAVE_NUMBER * CELL) ** 4 / 360.0}
VELOCITY = {"quadratic": (WAVE_NUMBER * CELL) ** 2 / 4.0, "cubic": (WAVE_NUMBER * CELL) ** 2 / 3.0}
DAMPING_TIME = 0.02  # s


def rate(run):
    """Decay rate of the amplitude, 1/s, over the last three quarters."""
    history = run.history()
    time, energy = history["time_s"], history["kinetic_energy_J"]
    first = len(time) // 4
    return -math.log(energy[-1] / energy[first]) / (2.0 * (time[-1] - time[first]))


def main():
    study = Study("transfer_damping", "Damping of a shear wave by the transfer",
                  "Fourier analysis of the transfers (theory.md, T9a): rates of decay (1 - kappa) / dt, or (1 - kappa) times "
                  "(1 - exp(-dt / damping_time)) / dt")
    orders = ("quadratic", "cubic") if study.long else ("quadratic",)
    for order in orders:
        automatic, apic = {}, {}
        for factor in (0.4, 0.1):
            sets = {"transfer.order": order, "time.elastic_cfl": factor}
            def alone(name, more):
                return study.run(name, sets | more, ranks=1)  # too small for more

            label = f"{order}_{factor:g}"
            step = factor * CELL / SOUND
            lost = -math.expm1(-step / DAMPING_TIME) / step  # of what the grid does not see, 1/s
            apic[factor] = rate(alone(f"apic_{label}", {"transfer.scheme": "apic"}))
            case = f"{order}, elastic_cfl {factor:g}"
            study.expect(f"rate of decay, APIC, {case}", apic[factor], MOMENTS[order] / step, 0.05, "1/s")
            given = rate(alone(f"moment_flip_{label}", {"transfer.scheme": "moment_flip",
                                                        "transfer.damping_time": DAMPING_TIME}))
            study.expect(f"rate of decay, moment FLIP with a given damping time, {case}", given, MOMENTS[order] * lost, 0.05,
                         "1/s")
            blend = rate(alone(f"blend_{label}", {"transfer.scheme": "blend", "transfer.damping_time": DAMPING_TIME,
                                                  "time.end": 0.5}))
            study.expect(f"rate of decay, blend with a damping time, {case}", blend, VELOCITY[order] * lost, 0.05, "1/s")
            run = study.run_on_both if factor == 0.4 else study.run
            automatic[factor] = rate(run(f"automatic_{label}", sets | {"transfer.scheme": "moment_flip"}))
        study.expect(f"rate of decay, moment FLIP, {order}, elastic_cfl 0.1 against 0.4", automatic[0.1], automatic[0.4], 0.05,
                     "1/s")
        study.expect_at_most(f"rate of decay over that of APIC at elastic_cfl 0.4, moment FLIP, {order}",
                             automatic[0.4] / apic[0.4], 0.02)
    study.finish()


if __name__ == "__main__":
    main()
