#!/usr/bin/env python3
"""A bar in uniaxial strain swings in its first mode: period, amplitude, and the energy that each transfer loses."""

import math

import numpy

from study import Study, scheme_name

LENGTH, SPEED, VELOCITY, PERIODS = 25.0, 10.0, 0.1, 3
PERIOD = 4.0 * LENGTH / SPEED
AMPLITUDE = VELOCITY * 2.0 / math.pi  # of the centre of mass: v0 / (beta L)


def curves(run):
    history = run.history()
    velocity = history["momentum_x_kg_ms"] / history["mass_kg"]
    energy = history["kinetic_energy_J"] + history["elastic_energy_J"]
    return history["time_s"], velocity, energy


def period_of(time, velocity):
    """From the first to the last zero of the velocity, which are half a period apart."""
    before = numpy.nonzero(numpy.diff(numpy.sign(velocity)))[0]
    zeros = time[before] - velocity[before] * numpy.diff(time)[before] / numpy.diff(velocity)[before]
    return 2.0 * (zeros[-1] - zeros[0]) / (len(zeros) - 1)


def resolution(n, scheme):
    """`n` cells along the bar, four across it."""
    cell = LENGTH / n
    return {"domain.cell_size": cell, "domain.upper": [LENGTH + 4 * cell, cell, cell], "transfer.scheme": scheme,
            "bodies.bar.shape.upper": [LENGTH, cell, cell], "time.dt": 0.3 * cell / SPEED,
            "time.end": PERIODS * PERIOD}


def main():
    study = Study("axial_bar", "Axial vibration of a bar", "Linear elasticity: `v = v0 sin(pi x / 2L) cos(omega t)`, period "
                  "`4 L / c`")
    cells = (10, 20, 40, 80) if study.long else (10, 20, 40)
    losses, longer, drawn = [], {}, {}
    for scheme in ("moment_flip", "apic", "flip", "pic") if study.long else ("moment_flip", "apic", "pic"):
        errors, signed, energy_losses = [], [], []
        for n in cells if scheme != "pic" else cells[-2:]:
            run = study.run_on_both if n == cells[0] and scheme != "pic" else study.run
            time, velocity, energy = curves(run(f"{scheme}_{n}", resolution(n, scheme)))
            signed.append(period_of(time, velocity) / PERIOD - 1.0)
            errors.append(abs(signed[-1]))
            energy_losses.append(1.0 - (energy[-1] / energy[0]) ** (1.0 / PERIODS))
            drawn[scheme] = time, velocity
        losses.append(f"{scheme_name(scheme)} {', '.join(f'{100 * loss:.2g} %' for loss in energy_losses)}")
        if scheme == "pic":  # damped too much to have a period worth a gate
            continue
        longer[scheme] = signed[-1] * cells[-1]
        study.expect_convergence(f"period, {scheme_name(scheme)}", cells, errors, 0.002, 1.5)
        study.expect(f"velocity of the centre of mass at the start, {scheme_name(scheme)}", drawn[scheme][1][0], AMPLITUDE, 1e-3,
                     "m/s")
    study.remark(f"Energy lost per period with {', '.join(map(str, cells))} cells along the bar (PIC: the two finest): "
                 f"{'; '.join(losses)}.")
    # The same bar between two walls tells which end is to blame.
    n = cells[-1]
    time, velocity, _ = curves(study.run("two_walls", resolution(n, "apic") | {
        "domain.upper": [LENGTH, LENGTH / n, LENGTH / n], "boundaries.x_upper": "slip",
        "bodies.bar.velocity_field": ["0.1*sin(pi*x/25)", "0", "0"], "time.end": 0.5 * PERIODS * PERIOD}))
    between_walls = n * (period_of(time, velocity) / (0.5 * PERIOD) - 1.0)
    study.remark("The bar swings as if it were longer by "
                 f"{', '.join(f'{part:.3f} ({scheme_name(scheme)})' for scheme, part in longer.items())} of a cell on the finest grid; "
                 f"between two walls by {between_walls:.3f} (APIC): walls and free ends act where they are.")

    def draw(axes):
        for scheme, (time, velocity) in drawn.items():
            axes.plot(time, velocity, label=scheme_name(scheme))
        axes.plot(time, AMPLITUDE * numpy.cos(2.0 * math.pi * time / PERIOD), "k:", label="analytic")
        axes.set(xlabel="time (s)", ylabel="velocity of the centre of mass (m/s)")
        axes.legend(ncols=4, fontsize="small")
    study.plot(draw, f"The bar with {cells[-1]} cells along its length.")
    study.finish()


if __name__ == "__main__":
    main()
