#!/usr/bin/env python3
"""An elastic column at rest under its weight: settled height, pressure at the base and the whole stress over resolutions."""

import math

import numpy

from study import Study

G = 9.81
ZZ = 2  # of the components xx yy zz xy yz xz
# By name: density, bulk modulus, shear modulus, height; and the settled height, integrated from the uniaxial law.
COLUMNS = {
    "stiff": (1000.0, 1e5, 1e4, 0.5, 0.4893600177),
    "light": (200.0, 1.09e5, 290.0, 1.0, 0.9910856805),
    "soft": (1000.0, 1e4, 1e3, 0.1, 0.09581530872),
}


# Hardly compressible, for the implicit pressure alone: it stays as high as it was.
WATER_LIKE = (1000.0, 2.2e9, 1e4, 0.5)


def run(study, name, cells):
    density, bulk, shear, height, *_ = COLUMNS.get(name, WATER_LIKE)
    size = height / cells
    wave_speed = math.sqrt(((bulk if name in COLUMNS else 0.0) + 4.0 / 3.0 * shear) / density)
    return study.run_on_both(f"{name}_{cells}", {
        "domain.upper": [4.0 * size, 4.0 * size, height + 2.0 * size], "domain.cell_size": size,
        "bodies.0.shape.upper": [4.0 * size, 4.0 * size, height], "materials.solid.density": density,
        "materials.solid.bulk_modulus": bulk, "materials.solid.shear_modulus": shear,
        "time.end": 12.0 * cells * height / wave_speed, "output.history_interval": 100})


def layers(particles):
    """Mean height and stress of each layer of particles, from below. Layers keep their order, and ids count along z first."""
    z = particles["position"][:, 2]
    order = numpy.argsort(z, kind="stable").reshape(-1, LAYER)
    stress = particles["kirchhoff_stress"][:, ZZ] / particles["volume_ratio"]
    return z[order].mean(axis=1), stress[order].mean(axis=1), numpy.ptp(z[order], axis=1).max()


LAYER = 8 * 8  # particles: two per cell along x and y


def water_like(study):
    """The stress of a column that the explicit step would need a million steps for."""
    density, _, _, height = WATER_LIKE
    particles = run(study, "water_like", 20).checkpoint()
    _, stress, _ = layers(particles)
    truth = -density * G * (height - (numpy.arange(stress.size) + 0.5) * height / stress.size)
    error = numpy.abs((stress - truth).reshape(-1, 2).mean(axis=1)) / (density * G * height)
    study.expect_at_most("kappa 2.2 GPa: stress of pairs of layers, largest error inside", error[1:-1].max(), 5e-3,
                         note="over density g H; a pressure is that of a cell, which has two layers")
    study.expect_at_most("kappa 2.2 GPa: speed left", numpy.abs(particles["velocity"]).max(), 1e-4, "m/s",
                         note="after a step that the end has cut short; the tolerance of the pressure over g dt is 3e-5 m/s")


def main():
    study = Study("hydrostatic", "Hydrostatic column",
                  "Uniaxial strain: `P(stretch) = -density g (H - X)` integrated over the column; base pressure `density g H`")
    levels = (10, 20, 40) if study.long else (10, 20)
    for name, (density, _, _, height, settled) in COLUMNS.items():
        stresses = []
        for cells in levels:
            result = run(study, name, cells)
            particles = result.checkpoint()
            z, stress, unevenness = layers(particles)
            top = z[-1] + 0.5 * (z[-1] - z[-2])
            reference = (numpy.arange(z.size) + 0.5) * height / z.size
            truth = -density * G * (height - reference)
            base = numpy.polyfit(reference[:cells // 2], stress[:cells // 2], 1)[1]
            if study.imex:  # a pressure a cell, and two layers in each: compared in pairs
                stress, truth = (values.reshape(-1, 2).mean(axis=1) for values in (stress, truth))
            stresses.append(float(numpy.sqrt(((stress - truth) ** 2).mean() / (truth**2).mean())))
            # Pressures that are constant in a cell resolve a settlement of a sixth of a cell, the light column's, less well.
            coarse = study.imex and name == "light"
            study.expect(f"{name}: settlement, {cells} cells", height - top, height - settled,
                         (1.0 / cells if coarse else 0.01), "m",
                         note="the top is half a layer above the highest layer of particles")
            if cells == levels[-1]:
                study.expect(f"{name}: settled height", top, settled, 0.01, "m", note=f"{cells} cells")
                study.expect(f"{name}: pressure at the base", -base, density * G * height,
                             0.02 if study.imex else 0.01, "Pa",
                             note="line through the lowest quarter of the layers")
                study.expect_at_most(f"{name}: unevenness of the layers", unevenness / height, 1e-6,
                                     note="range of heights in a layer over the height")
                speed = numpy.abs(particles["velocity"]).max()
                study.expect_at_most(f"{name}: speed left", speed / math.sqrt(2.0 * G * (height - settled)), 0.02,
                                     note="over that of a fall by the settlement")
        # By a tenth shorter at its base, the soft column has its particles at every place in a cell, two a cell along z no more.
        if study.imex:
            study.expect_at_most(f"{name}: stress of pairs of layers, L2 norm", max(stresses), 0.02)
            continue
        study.expect_convergence(f"{name}: stress, L2 norm", levels, stresses, 0.02, 0.6 if name == "soft" else 0.8,
                                 note="of the layers")
    study.remark("What remains of the stress error alternates from layer to layer: the sums over few particles per cell are "
                 "not even. The soft column, a tenth shorter at its base, has the most of it, and the lowest order.")
    if study.imex:
        water_like(study)
    study.finish()


if __name__ == "__main__":
    main()
