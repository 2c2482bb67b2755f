#!/usr/bin/env python3
"""A slice of a cylinder of cream of 2 GPa hits a floor with the implicit pressure: its volume is kept, and where it lies does
not depend on the tolerance of the pressure."""

import numpy

from study import Study

HEIGHT = "height of the centre of mass"
PROTOTYPE = {HEIGHT: 0.02109, "front": 0.763}  # m, plane, at 0.1 s
TOLERANCES = (1e-2, 1e-3, 1e-6)
# The prototype limited neither the deformation in a step nor the growth of the step.
UNLIMITED = {"time.deformation_limit": 0.5, "time.dt_initial": 1.18e-3}
MOMENT_FLIP = {"transfer.scheme": "moment_flip"}
HALF_STEPS = {"time.elastic_cfl": 0.2, "time.cfl": 0.25, "time.deformation_limit": 0.05}
FINE = {"domain.cell_size": 0.00625, "domain.upper": [0.9, 0.025, 0.4], "bodies.ball.shape.end": [0.3, 0.025, 0.125]}


def places(run):
    particles = list(run.frames())[-1]
    x = particles["position"]
    return {HEIGHT: x[:, 2].mean(), "front": numpy.quantile(x[:, 0], 0.995)}


def volume_error(run):
    particles = run.checkpoint()
    return numpy.sqrt(numpy.average((particles["volume_ratio"] - 1.0) ** 2, weights=particles["reference_volume"]))


def main():
    study = Study("imex_ball", "Impact with an implicit pressure",
                  "The same impact with the tolerance 1e-6; the plane prototype of the method: centre of mass 0.02109 m, front "
                  "0.763 m; volume")
    runs = {tolerance: study.run_on_both(f"tolerance_{tolerance:g}", {"time.pressure.tolerance": tolerance})
            for tolerance in TOLERANCES}
    tight = places(runs[1e-6])
    for tolerance in (1e-2, 1e-3):
        found = places(runs[tolerance])
        for name, value in found.items():
            study.expect(f"{name}, tolerance {tolerance:g}, against 1e-6", value, tight[name], 0.03, "m")
    found = places(runs[1e-3])
    history = runs[1e-3].history()
    study.expect_at_most("root mean square of J - 1 of the cells, largest of the run", numpy.nanmax(history["volume_error"]),
                         1e-3)
    study.expect("front, the program's own steps", found["front"], PROTOTYPE["front"], 0.03, "m")
    flips = places(study.run("moment_flip", MOMENT_FLIP))
    halves = places(study.run("moment_flip_half_steps", MOMENT_FLIP | HALF_STEPS))
    for name, value in flips.items():
        study.expect(f"{name}, moment FLIP, against steps half as long", value, halves[name], 0.03, "m")
    if study.long:
        halves = places(study.run("half_steps", HALF_STEPS))
        study.remark(f"With APIC the height of the centre of mass is {found[HEIGHT]:.4f} m with the program's own steps and "
                     f"{halves[HEIGHT]:.4f} m with half of them, because APIC damps with every step; that of the prototype, of fewer "
                     f"steps, is not reached. With moment FLIP it is {flips[HEIGHT]:.4f} m. Neither is the limit of fine cells.")
        for scheme, overrides in (("APIC", {}), ("moment FLIP", MOMENT_FLIP)):
            fine = places(study.run(f"fine_{scheme.split()[0]}", FINE | overrides))
            study.remark(f"On cells of 6.2 mm, {scheme}: height {fine[HEIGHT]:.4f} m, front {fine['front']:.4f} m.")
    unlimited = study.run("unlimited", UNLIMITED)
    for name, value in places(unlimited).items():
        study.expect(f"{name}, steps as long as the prototype's", value, PROTOTYPE[name], 0.03, "m")
    study.expect_at_most("root mean square of J - 1 at the end, steps as long as the prototype's", volume_error(unlimited), 2e-3)
    study.remark("The prototype's floor, walls and limits are not stated. Floors that stick, slip and separate, two domains and "
                 "three limits of the deformation were tried; this floor, no wall near by and the limit 0.5 came closest. The rows "
                 "with its steps therefore say that the prototype can be met, not that it was predicted.")
    study.remark(f"The program's own steps are {history['step'][-1]} instead of {unlimited.history()['step'][-1]}. With the longer "
                 f"ones the root mean square of J - 1 reaches {numpy.nanmax(unlimited.history()['volume_error']):.1e} during the "
                 "impact.")
    means = [f"{run.history()['pressure_iterations'].mean():.1f}" for run in runs.values()]
    study.remark(f"With tolerances 1e-2, 1e-3 and 1e-6 a step takes {', '.join(means)} iterations on average.")
    study.finish()


if __name__ == "__main__":
    main()
