#!/usr/bin/env python3
"""A slice of a cylinder of cream of 2 GPa hits a floor with the implicit pressure: its volume is kept, and where it lies does
not depend on the tolerance of the pressure, nor, with a transfer that damps per time, on the step."""

import numpy

from study import Study

PROTOTYPE = {"height of the centre of mass": 0.02109, "front": 0.763}  # m, plane, at 0.1 s
TOLERANCES = (1e-2, 1e-3, 1e-6)
# The prototype limited neither the deformation in a step nor the growth of the step.
UNLIMITED = {"time.deformation_limit": 0.5, "time.dt_initial": 1.18e-3}
HALF = {"time.cfl": 0.25, "time.elastic_cfl": 0.2, "time.deformation_limit": 0.05}
MOMENT_FLIP = {"transfer.scheme": "moment_flip"}
# Damps per time, and softened to Mach 0.16: where each particle keeps its own volume, the sheet locks as the modulus grows.
EXPLICIT = MOMENT_FLIP | {"transfer.dilation": "particle", "time.integrator": "explicit", "materials.cream.bulk_modulus": 1e6, "output.history_interval": 50}
CELLS = (0.0125, 0.00625, 0.003125)  # m
HEIGHT, FRONT = PROTOTYPE


def slice_of(cell):
    """Cells of this width, and as many of them across the slice."""
    return {"domain.cell_size": cell, "domain.upper": [0.9, cell, 0.4], "bodies.ball.shape.end": [0.3, cell, 0.125]}


def places(run):
    particles = list(run.frames())[-1]
    x = particles["position"]
    return {"height of the centre of mass": x[:, 2].mean(), "front": numpy.quantile(x[:, 0], 0.995)}


def volume_error(run):
    particles = run.checkpoint()
    return numpy.sqrt(numpy.average((particles["volume_ratio"] - 1.0) ** 2, weights=particles["reference_volume"]))


def compare_with_explicit(study, coarse):
    """`coarse`: the places by scheme on the scene's own cells."""
    explicit = [places(study.run(f"explicit_{cell:g}", EXPLICIT | slice_of(cell), ranks=1)) for cell in CELLS]
    apic = [coarse["apic"], places(study.run("apic_0.00625", slice_of(CELLS[1]), ranks=1))]
    per_time = [coarse["moment_flip"]] + [places(study.run(f"moment_flip_{cell:g}", MOMENT_FLIP | slice_of(cell), ranks=1))
                                          for cell in CELLS[1:]]
    # Told, not judged: the softened fluid is another one, and its own places still move with the cells.
    for scheme, runs in (("moment_flip", per_time), ("APIC", apic)):
        for name, finest in explicit[-1].items():
            errors = ", ".join(f"{100.0 * abs(run[name] / finest - 1.0):.1f}" for run in runs)
            study.remark(f"{name[0].upper()}{name[1:]}, {scheme}, on cells of "
                         f"{', '.join(f'{1e3 * cell:g}' for cell in CELLS[:len(runs)])} mm: {errors} % from the explicit step on cells of "
                         "3.1 mm. No gate: that fluid is softened to Mach 0.16, and moves by "
                         f"{100.0 * abs(explicit[-2][name] / finest - 1.0):.1f} % itself between its last two cells.")
    for what, runs in (("explicit step with 1 MPa and moment_flip", explicit), ("implicit pressure with moment_flip", per_time),
                       ("implicit pressure with APIC", apic)):
        study.remark(f"The {what}, cells of {', '.join(f'{1e3 * cell:g}' for cell in CELLS[:len(runs)])} mm: height "
                     f"{', '.join(f'{run[HEIGHT]:.5f}' for run in runs)} m, front {', '.join(f'{run[FRONT]:.4f}' for run in runs)} m. "
                     "A cell is not small beside the sheet, and these still move.")
    half = places(study.run("apic_half", HALF, ranks=1))
    study.remark(f"With APIC half of all limits raises the centre of mass from {coarse['apic'][HEIGHT]:.5f} to {half[HEIGHT]:.5f} m: it "
                 "damps once a step. The prototype took a quarter of the steps.")


def main():
    study = Study("imex_ball", "Impact with an implicit pressure",
                  "The same impact with the tolerance 1e-6; the "
                  "plane prototype of the method, which has 12.5 mm, APIC and 112 steps: centre of mass 0.02109 m, front "
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
    unlimited = study.run("unlimited", UNLIMITED)
    for name, value in places(unlimited).items():
        study.expect(f"{name}, steps as long as the prototype's", value, PROTOTYPE[name], 0.03, "m")
    study.expect_at_most("root mean square of J - 1 at the end, steps as long as the prototype's", volume_error(unlimited), 2e-3)
    per_time = {name: places(study.run(name, MOMENT_FLIP | sets, ranks=1))
                for name, sets in (("moment_flip", {}), ("moment_flip_half", HALF))}
    for name, value in per_time["moment_flip_half"].items():
        study.expect(f"{name}, moment_flip, half of all limits against its own steps", value, per_time["moment_flip"][name], 0.03, "m")
    if study.long:
        compare_with_explicit(study, {"apic": found, "moment_flip": per_time["moment_flip"]})
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
