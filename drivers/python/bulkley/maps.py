"""Averages over particles: in a plane, and along a line."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from bulkley.particles import ParticleFile
from bulkley.values import label_of, values_of

AXES = "xyz"


@dataclass(frozen=True)
class Map:
    """A field averaged over the cells of a plane.

    `values`: (rows, columns), NaN where no particle is; `counts`: particles in each; `columns`, `rows`: edges of the cells
    along the first and second of `axes`, m; `label`: name and unit; `time`: s.
    """

    values: np.ndarray
    counts: np.ndarray
    columns: np.ndarray
    rows: np.ndarray
    axes: str
    label: str
    time: float


@dataclass(frozen=True)
class Profile:
    """A field along a line. `distance`: (n,), middles of the intervals from the start, m; `values`: (n,), NaN where no
    particle is; `counts`: (n,); `label`: name and unit; `time`: s."""

    distance: np.ndarray
    values: np.ndarray
    counts: np.ndarray
    label: str
    time: float


def slab(file: ParticleFile, axis: str, at: float, thickness: float) -> np.ndarray:
    """(n,) bool: particles of the thin slice `thickness` (m) about the plane `axis` ("x", "y", "z") = `at` (m)."""
    coordinate = file.positions[:, axis_number(axis)]
    return (coordinate >= at - 0.5 * thickness) & (coordinate < at + 0.5 * thickness)


def binned(file: ParticleFile, field: str, axes: str = "xz", cell: float | None = None, component: str | int | None = None,
           chosen: np.ndarray | None = None, weights: str | None = None,
           bounds: Sequence[Sequence[float]] | None = None) -> Map:
    """Mean of a field over the particles in each square cell of the plane of `axes`, seen along the third axis.

    `cell`: width, m (default: the scene's cell_size); `chosen`: (n,) bool, as `slab` or `select` give; `weights`: a field
    such as "mass" (default: equal weights); `bounds`: ((lower, upper), (lower, upper)) along `axes`, m
    (default: around the chosen particles).
    """
    first, second = (axis_number(axis) for axis in axes)
    if first == second:
        raise ValueError(f"axes is '{axes}' and must be two of x, y, z")
    cell = float(file.scene["domain"]["cell_size"]) if cell is None else cell
    chosen = np.ones(file.n_particles, dtype=bool) if chosen is None else chosen
    points = file.positions[chosen][:, [first, second]]
    values, weight = values_of(file, field, component)[chosen], weight_of(file, weights)[chosen]
    if bounds is None:
        bounds = [(0.0, cell)] * 2 if len(points) == 0 else [
            (np.floor(low / cell) * cell, (np.floor(high / cell) + 1) * cell)
            for low, high in zip(points.min(axis=0), points.max(axis=0))]
    edges = [lower + cell * np.arange(max(1, round((upper - lower) / cell)) + 1) for lower, upper in bounds]
    column, row = (np.searchsorted(edge, points[:, n], side="right") - 1 for n, edge in enumerate(edges))
    shape = (len(edges[1]) - 1, len(edges[0]) - 1)
    inside = (column >= 0) & (column < shape[1]) & (row >= 0) & (row < shape[0])
    place = (row * shape[1] + column)[inside]
    mean, counts = means(place, values[inside], weight[inside], shape[0] * shape[1])
    label = label_of(file, field, component)
    return Map(mean.reshape(shape), counts.reshape(shape), edges[0], edges[1], axes, label, file.time)


def profile(file: ParticleFile, field: str, start: Sequence[float], end: Sequence[float], radius: float, n: int = 50,
            component: str | int | None = None, weights: str | None = None) -> Profile:
    """Mean of a field over `n` equal intervals of the line from `start` to `end` (m), over the particles that are nearer to
    it than `radius` (m)."""
    start, along = np.asarray(start, dtype=float), np.subtract(end, start)
    length = float(np.linalg.norm(along))
    if not length > 0.0:
        raise ValueError("start and end of a profile must differ")
    offset = file.positions - start
    distance = offset @ (along / length)
    aside = np.linalg.norm(offset - np.outer(distance, along / length), axis=1)
    near = (aside < radius) & (distance >= 0.0) & (distance < length)
    place = np.minimum((distance[near] / length * n).astype(int), n - 1)
    mean, counts = means(place, values_of(file, field, component)[near], weight_of(file, weights)[near], n)
    return Profile((np.arange(n) + 0.5) * length / n, mean, counts, label_of(file, field, component), file.time)


def means(place: np.ndarray, values: np.ndarray, weights: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Weighted mean of the values at each place (n,), NaN where there are none, and how many there are."""
    counts, total = np.bincount(place, minlength=n), np.bincount(place, weights=weights, minlength=n)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.bincount(place, weights=weights * values, minlength=n) / total, counts


def weight_of(file: ParticleFile, field: str | None) -> np.ndarray:
    return np.ones(file.n_particles) if field is None else values_of(file, field)


def axis_number(axis: str) -> int:
    if len(axis) != 1 or axis not in AXES:
        raise ValueError(f"'{axis}' is no axis: x, y or z")
    return AXES.index(axis)
