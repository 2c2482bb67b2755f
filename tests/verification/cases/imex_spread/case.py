#!/usr/bin/env python3
"""A column of yield-stress fluid of 2 GPa spreads from a wall with the implicit pressure and lies where the explicit step gets
on cells half as wide, softened; and it comes to rest."""

import numpy

from study import Study

THICKNESS = 0.025  # m, of the slice
CELL = 0.00625
# A softened column at 0.03 of the speed of sound, on half the cells, at twice the usual explicit step.
FINER = {"materials.paste.bulk_modulus": 1e6, "domain.cell_size": 0.5 * CELL, "time.elastic_cfl": 0.8}
# Of the plane prototype of the method: the explicit step on half the cells at 0.3 s; the implicit pressure at rest.
PROTOTYPE = {"front": 0.2818, "com_x": 0.1102, "com_z": 0.0210}
AT_REST = 0.311


def places(particles):
    x = particles["position"]
    return {"front": x[:, 0].max(), "com_x": x[:, 0].mean(), "com_z": x[:, 2].mean()}


def main():
    study = Study("imex_spread", "Spreading with an implicit pressure",
                  "The explicit step on cells half as wide (plane prototype of the method; in the long version a run here too)")
    implicit = {"time.integrator": "imex"}
    run = study.run_on_both("coarse", implicit | {"time.end": 0.6})
    _, spreading, resting = run.frames()
    found = places(spreading)
    truths = {"prototype": PROTOTYPE}
    if study.long:
        truths["explicit step here"] = places(list(study.run("finer", FINER, ranks=1).frames())[-1])
    for name, truth in truths.items():
        for place, value in truth.items():
            study.expect(f"{place} after 0.3 s, against the {name}", found[place], value, 0.03, "m")
    study.expect("front after 0.6 s", places(resting)["front"], AT_REST, 0.03, "m")
    history = run.history()
    study.expect_at_most("kinetic energy after 0.6 s over the thickness", history["kinetic_energy_J"][-1] / THICKNESS, 1e-4,
                         "J/m")
    quantiles = [numpy.quantile(frame["position"][:, 0], 0.995) for frame in (spreading, resting)]
    study.remark(f"The front is the outermost particle, chosen after the 99.5 % quantile had been looked at as well: that is at "
                 f"{quantiles[0]:.4f} m after 0.3 s and {quantiles[1]:.4f} m after 0.6 s.")
    study.remark(f"The implicit pressure takes {history['step'][-1]} steps of {history['pressure_iterations'].mean():.1f} "
                 "iterations on average to 0.6 s.")
    study.finish()


if __name__ == "__main__":
    main()
