#!/usr/bin/env python3
"""A steady jet runs into the corner of two slip faces: what gauges up the wall measure, against free streamlines."""

import math

import numpy

from study import Study

DEPTH, SPEED, DENSITY, HEIGHT = 0.08, 4.0, 1000.0, 0.6
PATCH, PATCHES, NEAR = 0.04, 15, 7  # m; number of gauges, and of those within 3.5 depths
BEGIN = 0.15                        # s, 7.5 depths/speed; the flow up the wall has left the domain


def patch_means():
    """Pressure over density speed^2/2 on each patch: with q the speed along the wall over that of the jet,
    y = (4 d/pi) (atan q + artanh q), p = 1 - q^2."""
    q = numpy.concatenate([numpy.linspace(0.0, 0.99, 4000), 1.0 - numpy.logspace(-2, -12, 4000)])
    y, p = 4.0 * DEPTH / math.pi * (numpy.arctan(q) + numpy.arctanh(q)), 1.0 - q**2
    force = numpy.concatenate([[0.0], numpy.cumsum(0.5 * (p[1:] + p[:-1]) * numpy.diff(y))])
    return numpy.diff(numpy.interp(PATCH * numpy.arange(PATCHES + 1), y, force)) / PATCH


def scene_with_gauges(study):
    text = study.scene.read_text()
    for n in range(PATCHES):
        text += (f'\n[[output.gauge]]\nname = "g{n}"\nface = "x_upper"\nlower = [0.9, -1.0, {PATCH * n if n else -1.0:.2f}]\n'
                 f"upper = [1.1, 1.0, {PATCH * (n + 1):.2f}]\n")
    path = study.work / "gauges.toml"
    path.write_text(text)
    return path


def pressures(history):
    time = history["time_s"]
    steps, late = numpy.diff(time), time[1:] > BEGIN
    return numpy.array([numpy.average(history[f"g{n}pressure_Pa"][1:][late], weights=steps[late]) for n in range(PATCHES)]
                       ) / (0.5 * DENSITY * SPEED**2)


def main():
    study = Study("jet_on_wall", "Jet on a wall",
                  "Free streamlines, half of a plane jet on a plate: `y = (4 d/pi) (atan q + artanh q)`, "
                  "`p = (1 - q^2) density U^2/2`; force `density U^2 d`")
    scene, truth = scene_with_gauges(study), patch_means()
    found = {}
    for cells in (4, 8, 16) if study.long else (4,):
        size = DEPTH / cells
        run = study.run if found else study.run_on_both
        found[cells] = pressures(run(f"cells_{cells}", {
            "domain.cell_size": size, "domain.upper": [1.0, size, HEIGHT],
            "bodies.0.shape.upper": [0.98, size, DEPTH],
            "inflows.0.section.width": size, "inflows.0.position": [0.48, 0.5 * size, 0.5 * DEPTH]}, scene=scene).history())
        error = numpy.linalg.norm((found[cells] - truth)[:NEAR]) / numpy.linalg.norm(truth[:NEAR])
        study.expect_at_most(f"pressure on the wall, L2 norm to 3.5 depths, {cells} cells", error, 0.1)
        study.expect(f"force on the wall over density U^2 d, {cells} cells", found[cells].sum() * PATCH / (2.0 * DEPTH), 1.0, 0.03)
    study.remark("Mean over 7.5 to 20 d/U after the start. The jet comes from a nozzle and is steady; what it leaves in the corner is nearly free "
                 "of friction, and the force swings about its mean.")

    def draw(axes):
        y = (numpy.arange(PATCHES) + 0.5) * PATCH / DEPTH
        axes.plot(y, truth, "k-", label="free streamlines")
        for cells, mean in found.items():
            axes.plot(y, mean, "o", ms=4, label=f"{cells} cells over the depth")
        axes.set(xlabel="height / d", ylabel="p / (density U^2/2)", xlim=(0, 5))
        axes.legend(frameon=False)
    study.plot(draw, "Mean pressure on patches of half a depth up the wall.")
    study.finish()


if __name__ == "__main__":
    main()
