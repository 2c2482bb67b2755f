"""What measuring needs of a run, read with the package in drivers/python; and pieces of a cloud."""

import itertools
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent / "python"))
from bulkley import DataError as MissingData, open_run  # noqa: E402, F401


class Run:
    """The folder of a run that has ended: its history is read once."""

    def __init__(self, folder):
        self._run = open_run(folder)
        self.folder, self.scene = self._run.folder, self._run.scene
        self.cell_size = self.scene["domain"]["cell_size"]
        self.floor = self.scene["domain"]["lower"][2]
        self.gravity = -self.scene["gravity"][2]  # downwards
        self._history = None

    @property
    def history(self):
        """Columns of history.csv by name without unit."""
        if self._history is None:
            self._history = self._run.history
        return self._history

    def frames(self):
        """All frames in the order of time."""
        frames = self._run.frames
        if not frames:
            raise MissingData(f"'{self.folder}' has no frames: set output.frame_interval")
        return list(frames)


def mass_share(frame):
    """Fraction of the total mass of each particle; equal ones if frames have no masses, which is right for one material."""
    mass = frame["mass"].astype(float) if "mass" in frame else np.ones(len(frame.positions))
    return mass / mass.sum()


def nearest(frames, times):
    """The frame nearest to each time, none twice."""
    chosen = {min(range(len(frames)), key=lambda n, t=time: abs(frames[n].time - t)) for time in times}
    return [frames[n] for n in sorted(chosen)]


def cells_of(position, size):
    """Indices of the cells that points lie in."""
    return np.floor(position / size).astype(np.int64)


def cell_keys(cells):
    """One number for each cell, and the strides: numbers of neighbouring cells differ by the same offsets everywhere."""
    span = cells.max(axis=0) - cells.min(axis=0) + 3
    strides = np.array([span[1] * span[2], span[2], 1])
    return (cells - cells.min(axis=0) + 1) @ strides, strides


def pieces(position, size):
    """Number of the piece that each point belongs to, 0 the piece with most points. Points are of one piece where their
    cells of width `size` touch, if only at a corner."""
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


def touching(cells, strides):
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


def bodies_of(frames, size):
    """The particles' ids of each piece of the first frame, largest first: of balls that start apart, one array each."""
    label = pieces(frames[0].positions, size)
    ids = frames[0].ids
    return [np.sort(ids[label == n]) for n in range(label.max() + 1)]


def markdown(header, rows):
    """A table."""
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])
