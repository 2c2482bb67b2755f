#!/usr/bin/env python3
"""The speed of a pressure pulse and of a shear pulse, from how far each has run when the run ends."""

import math

import numpy

from study import Study, scheme_name

BULK, SHEAR, DENSITY = 1.2e5, 6e4, 1000.0
SPEEDS = {"P": math.sqrt((BULK + 4.0 / 3.0 * SHEAR) / DENSITY), "S": math.sqrt(SHEAR / DENSITY)}
DISTANCE, CENTER, PULSE = 2.0, 4.0, "abs(x - 4) < 0.5 ? 0.0005*(1 + cos(2*pi*(x - 4))) : 0"  # one wavelength is 1 m


def shift_of(position, velocity):
    """How far the pulse that runs to the right has come: where the exact shape correlates best with the velocity."""
    def correlation(shift):
        u = position - CENTER - shift
        shape = numpy.where(numpy.abs(u) < 0.5, 1.0 + numpy.cos(2.0 * math.pi * u), 0.0)
        return float(shape @ velocity)
    shifts = numpy.linspace(0.7 * DISTANCE, 1.3 * DISTANCE, 241)
    values = numpy.array([correlation(shift) for shift in shifts])
    best = min(max(int(values.argmax()), 1), len(shifts) - 2)
    left, middle, right = values[best - 1:best + 2]
    return shifts[best] + 0.5 * (left - right) / (left - 2.0 * middle + right) * (shifts[1] - shifts[0])


def main():
    study = Study("elastic_waves", "Elastic waves", "`c_P = sqrt((kappa + 4/3 mu) / rho)`, `c_S = sqrt(mu / rho)`")
    cells = (10, 20, 40) if study.long else (10, 20)
    for wave, axis in (("P", 0), ("S", 1)):
        speed = SPEEDS[wave]
        for scheme in ("moment_flip", "apic", "flip") if study.long else ("moment_flip", "apic"):
            errors, heights = [], []
            for n in cells:
                cell = 1.0 / n
                field = ["0", "0", "0"]
                field[axis] = PULSE
                step = 0.3 * cell / SPEEDS["P"]
                sets = {"domain.cell_size": cell, "domain.upper": [8.0, cell, cell], "transfer.scheme": scheme,
                        "bodies.bar.shape.upper": [8.0, cell, cell], "bodies.bar.velocity_field": field,
                        "time.end": DISTANCE / speed, "time.dt": step}
                run = study.run_on_both if n == cells[0] and scheme == "moment_flip" else study.run
                end = run(f"{wave}_{scheme}_{n}", sets).checkpoint()
                measured = shift_of(end["position"][:, 0], end["velocity"][:, axis]) / end["time"]
                errors.append(abs(measured / speed - 1.0))
                heights.append(end["velocity"][:, axis].max() / 0.0005)
                if n == 20:
                    study.expect(f"speed of the {wave} pulse, 20 cells per wavelength, {scheme_name(scheme)}", measured, speed, 0.03,
                                 "m/s")
            study.expect_convergence(f"speed of the {wave} pulse, {scheme_name(scheme)}", cells, errors, 0.03, 1.0)
            study.remark(f"After two wavelengths the {wave} pulse has {', '.join(f'{100 * h:.0f} %' for h in heights)} of its "
                         f"height with {', '.join(map(str, cells))} cells per wavelength ({scheme_name(scheme)}).")
    study.finish()


if __name__ == "__main__":
    main()
