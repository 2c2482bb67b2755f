#!/usr/bin/env python3
"""Where sticky and slip walls act: profiles of flow and displacement, extrapolated to zero, against the stated position."""

import math

import numpy

from study import Study

# Position of the plane of a collider between two nodes, in cells. The error depends on it, so the largest counts.
OFFSETS = (0.1, 0.3, 0.6, 0.9)
GAP = 0.01  # half of it, m
HEIGHT, G, DENSITY, BULK, SHEAR = 0.5, 0.5, 1000.0, 1e5, 1e4
MODULUS = BULK + 4.0 / 3.0 * SHEAR


def scene_with(study, file, contact):
    """The scene with a collider below the fluid or column, whose height is still to be set."""
    text = study.scene.with_name(file).read_text()
    text += f'\n[[colliders]]\nname = "wall"\ncontact = "{contact}"\n'
    text += 'shape = { type = "plane", point = [0.0, 0.0, 0.0], normal = [0.0, 0.0, 1.0] }\n'
    path = study.work / f"collider_{file}"
    path.write_text(text)
    return path


def sticky_position(study, cells, offset):
    """Distance, in half gaps, from the stated position of the lower wall to where the parabola is zero."""
    size = GAP / cells
    wall = 0.0 if offset is None else (1.0 + offset) * size
    sets = {"domain.upper": [size, size, 2.0 * GAP], "domain.cell_size": size,
            "bodies.0.shape.lower": [0.0, 0.0, wall], "bodies.0.shape.upper": [size, size, 2.0 * GAP]}
    scene = study.scene.with_name("shear.toml")
    if offset is not None:
        scene = scene_with(study, "shear.toml", "sticky")
        sets["colliders.0.shape.point"] = [0.0, 0.0, wall]
    particles = run(study, f"sticky_{cells}_{offset}", sets, offset, scene)
    z, speed = particles["position"][:, 2], particles["velocity"][:, 0]
    middle = (z > wall + 0.5 * GAP) & (z < 1.5 * GAP)
    parabola = numpy.polyfit(z[middle] - wall, speed[middle], 2)
    return float(numpy.roots(parabola).real.min()) / GAP


def slip_position(study, cells, offset):
    """Distance, in heights, from the stated position of the wall to where the displacement of the column is zero."""
    size = HEIGHT / cells
    wall = 0.0 if offset is None else (1.0 + offset) * size
    sets = {"domain.upper": [size, size, HEIGHT + 4.0 * size], "domain.cell_size": size,
            "bodies.0.shape.lower": [0.0, 0.0, wall], "bodies.0.shape.upper": [size, size, wall + HEIGHT],
            "output.history_interval": 100}
    scene = study.scene
    if offset is not None:
        scene = scene_with(study, "scene.toml", "slip")
        sets["colliders.0.shape.point"] = [0.0, 0.0, wall]
    label = f"slip_{cells}_{offset}"
    start = study.run(f"{label}_start", {**sets, "time.end": 1e-9}, 1, scene=scene).checkpoint()["position"][:, 2]
    sets["time.end"] = 8.0 * cells * HEIGHT * math.sqrt(DENSITY / MODULUS)
    end = run(study, label, sets, offset, scene)["position"][:, 2]
    # Small strain: displacement -(density g / M) (H x - x^2 / 2) plus a sinking of the whole column; the strain at the wall
    # turns the latter into a distance.
    x = start - wall
    column = x.max() + 0.5 * numpy.diff(numpy.unique(numpy.round(x / size, 6)))[-1] * size
    middle = (x > 0.25 * HEIGHT) & (x < 0.75 * HEIGHT)
    parabola = numpy.polyfit(x[middle], (end - start)[middle], 2)
    return float(numpy.polyval(parabola, 0.0) / numpy.polyval(numpy.polyder(parabola), 0.0)) / column


def run(study, label, sets, offset, scene):
    """On both numbers of ranks where the wall is a face; colliders need no such check at every offset."""
    if offset is None or offset == OFFSETS[0]:
        return study.run_on_both(label, sets, scene=scene).checkpoint()
    return study.run(label, sets, 1, scene=scene).checkpoint()


def main():
    study = Study("wall_position", "Position of walls",
                  "The stated position; the profile's parabola extrapolated to zero from the middle half")
    levels = (4, 8, 16, 32) if study.long else (4, 8, 16)
    errors = [abs(sticky_position(study, cells, None)) for cells in levels]
    study.expect_convergence("sticky face", levels, errors, 0.01, 1.0, note="relative to the half gap")
    for cells in levels[:2]:
        study.expect_at_most(f"slip face, {cells} cells", cells * abs(slip_position(study, cells, None)), 0.02, "cells",
                             note="a plane of symmetry on any grid; up to the terms of small strain")
    levels = levels[1:]
    for contact, position, length in (("sticky", sticky_position, "half gap"), ("slip", slip_position, "height")):
        errors = [max(abs(position(study, cells, offset)) for offset in OFFSETS) for cells in levels]
        study.expect_convergence(f"{contact} collider, off the nodes", levels, errors, 1.0 / levels[-1], 0.8,
                                 note=f"relative to the {length}; the largest of {len(OFFSETS)} offsets; tolerance one cell")
    study.finish()


if __name__ == "__main__":
    main()
