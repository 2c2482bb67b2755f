#!/usr/bin/env python3
"""Angular momentum of bodies that spin freely: kept by APIC and moment FLIP to rounding, lost by PIC, left to drift by FLIP."""

import numpy

from study import Study, scheme_name

TURN = 0.314159265358979  # s, of the disk
ELLIPSOID = {
    "domain.upper": [0.32, 0.32, 0.32],
    "bodies.body.shape": {"type": "ellipsoid", "center": [0.16, 0.16, 0.16], "radii": [0.1, 0.06, 0.05]},
    "bodies.body.angular_velocity": [8.0, 6.0, 20.0],  # about no principal axis: it tumbles
    "boundaries.z_lower": "open", "boundaries.z_upper": "open"}


def momentum(run):
    """Time, and the vector of angular momentum at each row of the history."""
    history = run.history()
    return history["time_s"], numpy.column_stack([history[f"angular_momentum_{axis}_kg_m2s"] for axis in "xyz"])


def change(vectors):
    """|L(t) - L(0)| / |L(0)|."""
    return numpy.linalg.norm(vectors - vectors[0], axis=1) / numpy.linalg.norm(vectors[0])


def main():
    study = Study("spinning_bodies", "Spinning bodies", "Conservation of angular momentum")
    turns = 10 if study.long else 1
    sizes = (0.02, 0.01)
    drawn = {}
    for scheme in ("apic", "moment_flip", "flip", "pic"):
        changes = []
        for size in sizes:
            sets = {"transfer.scheme": scheme, "domain.cell_size": size, "domain.upper": [0.32, 0.32, size],
                    "bodies.body.shape.end": [0.16, 0.16, size], "time.end": turns * TURN}
            exact = scheme in ("apic", "moment_flip")
            run = study.run_on_both if exact else study.run
            time, vectors = momentum(run(f"disk_{scheme}_{size:g}", sets))
            changes.append(change(vectors).max())
            name = scheme_name(scheme)
            drawn[f"{name}, {0.1 / size:g} cells per radius"] = time / TURN, vectors[:, 2] / vectors[0, 2]
            if exact:
                study.expect_at_most(f"change of the disk's angular momentum, {name}, {0.1 / size:g} cells per radius",
                                     changes[-1], 1e-12)
        text = " and ".join(f"{100 * c:.3g} %" for c in changes)
        if scheme == "pic":
            kept = drawn[f"PIC, {0.1 / sizes[-1]:g} cells per radius"][1][-1]
            study.expect_at_most("angular momentum that PIC keeps, which must decay", kept, 0.9)
        if not exact:
            study.remark(f"{scheme.upper()} changes the disk's angular momentum by at most {text} in {turns} turns with "
                         f"{' and '.join(f'{0.1 / size:g}' for size in sizes)} cells per radius.")
    for scheme, name in (("apic", "APIC"), ("moment_flip", "moment FLIP")):
        ellipsoid = study.run_on_both(f"ellipsoid_{scheme}", ELLIPSOID | {"time.end": turns * TURN, "transfer.scheme": scheme})
        study.expect_at_most(f"change of the tumbling ellipsoid's angular momentum, {name}",
                             change(momentum(ellipsoid)[1]).max(), 1e-12)

    def draw(axes):
        for label, (time, ratio) in drawn.items():
            axes.plot(time, ratio, label=label)
        axes.set(xlabel="turns", ylabel="L(t) / L(0)")
        axes.legend(fontsize="small")
    study.plot(draw, "Angular momentum of the disk.")
    study.finish()


if __name__ == "__main__":
    main()
