"""Pieces of a cloud of particles, and what else measuring needs of frames."""

import itertools
from collections.abc import Sequence

import numpy as np

from bulkley.particles import ParticleFile


def mass_share(frame: ParticleFile) -> np.ndarray:
    """(n,): share of each particle in the whole mass; equal ones where frames hold no masses, as is right for one material."""
    mass = frame["mass"].astype(float) if "mass" in frame else np.ones(len(frame.positions))
    return mass / mass.sum()


def nearest(frames: Sequence[ParticleFile], times: Sequence[float]) -> list[ParticleFile]:
    """The frame nearest to each time (s), none twice."""
    chosen = {min(range(len(frames)), key=lambda n, t=time: abs(frames[n].time - t)) for time in times}
    return [frames[n] for n in sorted(chosen)]


def cells_of(position: np.ndarray, size: float) -> np.ndarray:
    """(n, axes), int64: indices of the cells of width `size` (m) that the points (n, axes) lie in."""
    return np.floor(position / size).astype(np.int64)


def cell_keys(cells: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,), (3,): one number for each of the cells (n, 3), and the strides: numbers of neighbouring cells differ by the same
    offsets everywhere."""
    span = cells.max(axis=0) - cells.min(axis=0) + 3
    strides = np.array([span[1] * span[2], span[2], 1])
    return (cells - cells.min(axis=0) + 1) @ strides, strides


def pieces(position: np.ndarray, size: float) -> np.ndarray:
    """(n,): number of the piece that each of the points (n, 3) belongs to, 0 the piece with most points. Points are of one
    piece where their cells of width `size` (m) touch, if only at a corner."""
    keys, strides = cell_keys(cells_of(position, size))
    cells, cell_of_point = np.unique(keys, return_inverse=True)
    first, second = touching(cells, strides)
    root = np.arange(len(cells))
    while True:
        a, b = root[first], root[second]
        if np.array_equal(a, b):
            break
        np.minimum.at(root, a, b)
        np.minimum.at(root, b, a)
        while not np.array_equal(root, root[root]):
            root = root[root]
    _, label, count = np.unique(root[cell_of_point], return_inverse=True, return_counts=True)
    rank = np.empty(len(count), dtype=np.int64)
    rank[np.argsort(-count, kind="stable")] = np.arange(len(count))
    return rank[label]


def touching(cells: np.ndarray, strides: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Pairs of indices into the sorted keys `cells` of cells that touch."""
    pairs = []
    for step in itertools.product((-1, 0, 1), repeat=3):
        if step <= (0, 0, 0):  # each pair once
            continue
        wanted = cells + np.dot(step, strides)
        place = np.minimum(np.searchsorted(cells, wanted), len(cells) - 1)
        found = np.flatnonzero(cells[place] == wanted)
        pairs.append((found, place[found]))
    return np.concatenate([p[0] for p in pairs]), np.concatenate([p[1] for p in pairs])


def bodies_of(frames: Sequence[ParticleFile], size: float) -> list[np.ndarray]:
    """The particles' ids of each piece of the first frame, largest first: of balls that start apart, one array each. `size`:
    width of a cell, m."""
    label = pieces(frames[0].positions, size)
    ids = frames[0].ids
    return [np.sort(ids[label == n]) for n in range(label.max() + 1)]
