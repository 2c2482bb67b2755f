#!/usr/bin/env python3
"""The magnetic Bernoulli equation: rho g h = mu_0 (integral of M dH + M_n^2/2) + constant on the free surface of a magnetic fluid
at rest, in a field along its surface and in one across it."""

import functools
import math

import numpy

from study import Study

MU0 = 4e-7 * math.pi
GRAVITY, DENSITY = 9.81, 1290.0
SATURATION, SUSCEPTIBILITY = 28250.0, 1.0
LENGTH, DEPTH = 0.12, 0.02  # m, of the wave and of the layer at rest
K = 2.0 * math.pi / LENGTH
HEIGHT = 2e-3  # m, amplitude of the wave that the field is to hold up


def magnetisation(h):
    xi = 3.0 * SUSCEPTIBILITY * h / SATURATION
    return SATURATION * (1.0 / math.tanh(xi) - 1.0 / xi)


def slope(h):
    """dM/dH."""
    xi = 3.0 * SUSCEPTIBILITY * h / SATURATION
    return 3.0 * SUSCEPTIBILITY * (1.0 / xi**2 - 1.0 / math.sinh(xi) ** 2)


def height(along, strength):
    """The amplitude a of the surface z = a cos kx of a layer from z = -DEPTH in H_0 = `strength` e + grad psi_0, e = x (`along`) or
    z, for small psi_0 with the gradient component cos kx cosh kz along e, A/m. To first order, with the field of the layer itself:

    psi outside is psi_0 + P exp(-kz) above and psi_0 + Q exp(kz) below; inside, where the permeability is mu_x along x and mu_z
    along z, it is S exp(qz) + R exp(-qz), q = k sqrt(mu_x/mu_z), each times sin kx (along) or cos kx. At both faces tangential H
    and normal B are continuous; the surface is where Bernoulli's equation holds."""
    if along:
        inside = strength
    else:  # H + M(H) = H_0
        inside = strength
        for _ in range(60):
            inside -= (inside + magnetisation(inside) - strength) / (1.0 + slope(inside))
    m, secant, tangent = magnetisation(inside), 1.0 + magnetisation(inside) / inside, 1.0 + slope(inside)
    mu_x, mu_z = (tangent, secant) if along else (secant, tangent)
    q = K * math.sqrt(mu_x / mu_z)
    kd, e, f = K * DEPTH, math.exp(-q * DEPTH), math.exp(q * DEPTH)
    # psi_0 hat and its derivative at the surface and at the floor.
    c, s = math.cosh(kd), math.sinh(kd)
    top, top_slope, floor, floor_slope = (1.0 / K, 0.0, c / K, -s) if along else (0.0, 1.0, -s / K, c)
    # Unknown: P, Q exp(-kd), S, R, a.
    jump = 0.0 if along else m  # of psi at the surface over a: psi outside + jump a = psi inside
    flux = m * K if along else 0.0  # of normal B over a: B_z' outside - B_z' inside = flux a
    # Bernoulli: rho g a = weight times (psi inside along, its slope across).
    weight = MU0 * m * (K if along else tangent)
    matrix = numpy.array([
        [1.0, 0.0, -1.0, -1.0, jump],
        [-K, 0.0, -mu_z * q, mu_z * q, -flux],
        [0.0, 1.0, -e, -f, 0.0],
        [0.0, K, -mu_z * q * e, mu_z * q * f, 0.0],
        [0.0, 0.0, weight * (1.0 if along else q), weight * (1.0 if along else -q), -DENSITY * GRAVITY]])
    return numpy.linalg.solve(matrix, [-top, -top_slope, -floor, -floor_slope, 0.0])[4]


def source(along, strength, amplitude):
    """The same field with z from the floor."""
    z = f"(z-{DEPTH})"
    first = f"{amplitude!r}*cos({K!r}*x)*cosh({K!r}*{z})"
    if along:
        return [f"{strength!r}+{first}", "0", f"{amplitude!r}*sin({K!r}*x)*sinh({K!r}*{z})"]
    return [f"-{amplitude!r}*sin({K!r}*x)*sinh({K!r}*{z})", "0", f"{strength!r}+{first}"]


def harmonics(particles, width):
    """Amplitudes of cos kx and cos 2kx of the depth, from the volume of the particles, m."""
    volume = particles["reference_volume"] * particles["volume_ratio"]
    return [2.0 / (LENGTH * width) * (volume @ numpy.cos(n * K * particles["position"][:, 0])) for n in (1, 2)]


def profile(particles, cell):
    """Middles of the columns of cells, m, and the surface there less that at rest, m: half the distance of particles above the
    highest of them."""
    x, z = particles["position"][:, 0], particles["position"][:, 2]
    top = numpy.zeros(round(LENGTH / cell))
    numpy.maximum.at(top, (x / cell).astype(int), z)
    return (numpy.arange(len(top)) + 0.5) * cell, top + 0.25 * cell - DEPTH


def main():
    study = Study("magnetic_bernoulli", "Magnetic Bernoulli",
                  "Bernoulli's equation of magnetic fluids for a layer with the curve of EMG 700, with the field of the layer "
                  "and of its wave, all to first order in the wave; the applied field is the one that holds up a wave of 2 mm by "
                  "it")
    levels = (10, 20) if study.long else (10,)
    curves = {}
    for along, strength in ((True, 2e4), (False, 1.5e-2 / MU0)):
        name = "along" if along else "across"
        amplitude = HEIGHT / height(along, strength)
        applied = MU0 * magnetisation(strength) * amplitude / (DENSITY * GRAVITY)
        for cells in levels:
            cell = DEPTH / cells
            width = cell
            run = study.run_on_both if along and cells == 10 else functools.partial(study.run, ranks=1)
            particles = run(f"{name}_{cells}", {
                "domain.cell_size": cell, "domain.upper": [LENGTH, width, DEPTH + 4.0 * cell],
                "bodies.layer.shape.upper": [LENGTH, width, DEPTH],
                "magnetics.sources": [{"kind": "formula", "field": source(along, strength, amplitude)}]}).checkpoint()
            first, second = harmonics(particles, width)
            study.expect(f"field {name} the surface: wave of the surface, {cells} cells deep", 1e3 * first, 1e3 * HEIGHT, 0.05,
                         "mm")
            curves[f"{name}, {cells} cells"] = profile(particles, cell)
        study.remark(f"Field {name} the surface: {strength:.4g} A/m with a wave of {amplitude:.4g} A/m; amplitude of the second "
                     f"harmonic {1e3 * second:.2f} mm." + (f" Without the field of the layer Bernoulli's equation would give a "
                                                           f"wave of {1e3 * applied:.2f} mm." if along else ""))

    def draw(axes):
        x = numpy.linspace(0.0, LENGTH, 200)
        axes.plot(1e3 * x, 1e3 * HEIGHT * numpy.cos(K * x), "k:", label="first order")
        for name, (x, h) in curves.items():
            axes.plot(1e3 * x, 1e3 * h, ".", markersize=3, label=name)
        axes.set(xlabel="x / mm", ylabel="height of the surface / mm")
        axes.legend(fontsize=7)
    study.plot(draw, "Surface of a magnetic fluid at rest in fields along and across it")
    study.finish()


if __name__ == "__main__":
    main()
