#!/usr/bin/env python3
"""A layer that is fed through a slot: whether particles take up the volume that they say they have."""

from study import Study

SLOT = 0.008      # m, from the middle to its edge
PUSHED = 0.06 * 1.5 * SLOT  # m^2, what the piston has pushed out at the end
LAYERS = 2        # of cells from the plate on, which are full from the slot to some cells behind the front
IMEX = {"time.integrator": "imex", "materials.gum.bulk_modulus": 2e9}
TOLERANCE = 0.2  # a tenth is tolerated, and what the flow adds to it


class Layer:
    """The layer on the plate at the end of a run with cells of `size`."""

    def __init__(self, run, size):
        particles = run.checkpoint()
        x, volume = particles["position"], particles["reference_volume"] * particles["volume_ratio"]
        self.ratio = float(volume.sum() / particles["reference_volume"].sum())
        depth = size
        above = x[:, 2] > 0.0
        self.front = float(x[above, 0].max())
        first, last = SLOT + 2.0 * size, self.front - 5.0 * size
        low = above & (x[:, 2] < LAYERS * size) & (x[:, 0] > first) & (x[:, 0] < last)
        self.fullness = float(volume[low].sum() / ((last - first) * depth * LAYERS * size))
        self.pushed = float(volume[above].sum() / depth)


def study_layer(study, label, size, name, more):
    run = study.run(label, {"domain.cell_size": size, "domain.upper": [0.08, size, 0.02],
                            "bodies.0.shape.upper": [SLOT, size, 0.0], **more})
    layer = Layer(run, size)
    what = f"{name}, cells of {1e3 * size:g} mm"
    study.expect(f"{what}: volume of the particles in the two lowest layers of cells, over that of the cells", layer.fullness, 1.0, TOLERANCE)
    study.expect(f"{what}: volume above the plate, over what was pushed out", layer.pushed / PUSHED, 1.0, 0.05)
    study.remark(f"{what[0].upper()}{what[1:]}: the front is at {1e3 * layer.front:.1f} mm, the mean volume ratio is {layer.ratio:.3f}.")


def main():
    study = Study("fed_layer", "Volume of a fed layer",
                  "Volume: cells within a layer are full, and hold no more than that. Particles that are laid down at a front crowd in the cells at "
                  "the plate, without their volume ratios' knowledge, unless it is measured")
    for size in (0.002, 0.001) if study.long else (0.002,):
        study_layer(study, f"explicit_{1e3 * size:g}", size, "explicit", {})
        study_layer(study, f"imex_{1e3 * size:g}", size, "implicit pressure", IMEX)
    study.finish()


if __name__ == "__main__":
    main()
