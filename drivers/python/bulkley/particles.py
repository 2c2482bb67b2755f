"""Frames and checkpoints: the particles of a run at one time."""

import functools
import os
import pathlib
import tomllib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from bulkley.faults import DataError

if TYPE_CHECKING:
    import h5py

Region = Sequence[Sequence[float | None]]
"""((x0, x1), (y0, y1), (z0, z1)) in m; None leaves an end open. A point is inside where lower <= coordinate < upper."""

PLACES_PER_CELL = 64  # ids that seeding sets aside for each cell and body
KINDS = {"bulkley frame", "bulkley checkpoint"}


def is_chosen(ids: np.ndarray, every: int) -> np.ndarray:
    """Which of `ids` (n,) are of the one in `every` that is kept; the same choice as `bulkley convert --every`."""
    with np.errstate(over="ignore"):
        x = np.asarray(ids).astype(np.uint64) + np.uint64(0x9E3779B97F4A7C15)
        x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
        x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    return (x ^ (x >> np.uint64(31))) % np.uint64(every) == 0


@dataclass(frozen=True)
class Grid:
    """Nodes of the grid. `fields`: (nz, ny, nx) or (nz, ny, nx, 3); `x`, `y`, `z`: coordinates of the nodes, m."""

    x: np.ndarray
    y: np.ndarray
    z: np.ndarray
    fields: dict[str, np.ndarray]
    units: dict[str, str]


class ParticleFile:
    """A frame or checkpoint. Arrays are read on access; `with` keeps the file open between them.

    Rows are particles. Their order has no meaning and may differ between files: `ids` identify them.
    """

    def __init__(self, path: str | os.PathLike, scene: dict | None = None):
        """`scene`: of the run, if available; otherwise it is read when a body is requested."""
        self.path = pathlib.Path(path)
        self._scene = scene
        self._open: "h5py.File | None" = None

    # --- the file ---------------------------------------------------------------------------------------------------------

    def __enter__(self):
        self._open = self._opened()
        return self

    def __exit__(self, *_):
        self.close()

    def close(self) -> None:
        if self._open is not None:
            self._open.close()
            self._open = None

    def __repr__(self) -> str:
        return f"<{type(self).__name__} '{self.path}'>"

    def _opened(self) -> "h5py.File":
        if not self.path.is_file():
            raise DataError(f"there is no file '{self.path}'")
        try:
            import h5py
        except ImportError:
            raise DataError("frames and checkpoints need h5py, which is not installed") from None
        try:
            try:  # runs write under other names and rename: nothing is to be locked out, and some file systems cannot
                file = h5py.File(self.path, "r", locking=False)
            except OSError:  # among others: this process has it open with a lock
                file = h5py.File(self.path, "r")
        except OSError as error:
            raise DataError(f"cannot read '{self.path}': {error}") from None
        if text_of(file.attrs.get("format", "")) not in KINDS:
            file.close()
            raise DataError(f"'{self.path}' is neither a frame nor a checkpoint")
        return file

    def _read(self, work):
        """`work(file)`, with the file that is open, or one opened for this."""
        if self._open is not None:
            return self._guarded(work, self._open)
        with self._opened() as file:
            return self._guarded(work, file)

    def _guarded(self, work, file):
        try:
            return work(file)
        except (OSError, KeyError, RuntimeError) as error:
            raise DataError(f"cannot read '{self.path}': {error}") from None

    # --- the header -------------------------------------------------------------------------------------------------------

    @functools.cached_property
    def attributes(self) -> dict:
        """Attributes of the file's root; text as str."""
        found = self._read(lambda file: {name: text_of(value) for name, value in file.attrs.items()})
        return found

    @functools.cached_property
    def _arrays(self) -> dict[str, str]:
        return self._read(lambda file: {name: text_of(array.attrs.get("unit", "")) for name, array in
                                        file["particles"].items() if name != "connectivity"})

    @property
    def time(self) -> float:
        """s"""
        return float(self.attributes["time"])

    @property
    def step(self) -> int:
        return int(self.attributes["step"])

    @property
    def n_particles(self) -> int:
        return int(self.attributes["n_particles"])

    @property
    def materials(self) -> list[str]:
        """Names, in the order of the numbers that the field "material" holds."""
        names = self.attributes.get("materials", "")
        return names.split("\n") if names else []

    @property
    def fields(self) -> list[str]:
        """Names of the particles' arrays."""
        return list(self._arrays)

    @property
    def units(self) -> dict[str, str]:
        """Unit of each field, "1" for none."""
        return dict(self._arrays)

    @property
    def scene(self) -> dict:
        """The run's scene: of this file, or of the scene.toml in its folder. Raises DataError where there is none."""
        if self._scene is None:
            text = self._scene_text()
            try:
                self._scene = tomllib.loads(text)
            except tomllib.TOMLDecodeError as error:
                raise DataError(f"the scene of '{self.path}' is damaged: {error}") from None
        return self._scene

    def _scene_text(self) -> str:
        beside = self.path.with_name("scene.toml")
        if not beside.is_file():
            raise DataError(f"there is no '{beside}', which says what scene '{self.path.name}' belongs to")
        return beside.read_text(encoding="utf-8")

    # --- the particles ----------------------------------------------------------------------------------------------------

    def __contains__(self, name: str) -> bool:
        return name in self._arrays

    def __getitem__(self, name: str) -> np.ndarray:
        """A field as it is in the file: (n,), vectors (n, 3), tensors (n, 3, 3); symmetric tensors of checkpoints are
        (n, 6), xx yy zz xy yz xz. Raises DataError."""
        if name not in self._arrays:
            raise DataError(f"'{self.path}' has no field /particles/{name}: add it to output.fields; it has "
                            f"{', '.join(self._arrays)}")
        return self._read(lambda file: file["particles"][name][...])

    @property
    def positions(self) -> np.ndarray:
        """(n, 3), m, float64"""
        return self["position"].astype(float)

    @property
    def ids(self) -> np.ndarray:
        """(n,), int64"""
        return self["id"]

    def rows_of(self, ids: np.ndarray) -> np.ndarray:
        """Row of each of `ids` in this file, -1 for those it does not have: to follow particles from file to file."""
        own = self.ids
        order = np.argsort(own)
        if len(own) == 0:
            return np.full(len(ids), -1)
        found = order[np.minimum(np.searchsorted(own, ids, sorter=order), len(own) - 1)]
        return np.where(own[found] == ids, found, -1)

    def bodies(self) -> np.ndarray:
        """(n,): number of the body in the scene that each particle was seeded for. Needs ids, and the scene."""
        domain = self.scene["domain"]
        sides = np.subtract(domain["upper"], domain["lower"]) / domain["cell_size"]
        return self.ids // (PLACES_PER_CELL * int(np.prod(np.rint(sides).astype(np.int64))))

    def select(self, region: Region | None = None, every: int = 1, material: str | int | None = None,
               body: str | int | None = None) -> np.ndarray:
        """(n,) bool: particles in `region`, of a material and of a body (by name or number), about one in `every` by id."""
        chosen = np.ones(self.n_particles, dtype=bool)
        if region is not None:
            chosen &= self._inside(region)
        if every != 1:
            if every < 1:
                raise ValueError(f"every is {every} and must be at least 1")
            chosen &= is_chosen(self.ids, every)
        if material is not None:
            chosen &= self["material"] == self._number(material, self.materials, "material")
        if body is not None:
            names = [entry.get("name", "") for entry in self.scene.get("bodies", [])]
            chosen &= self.bodies() == self._number(body, names, "body")
        return chosen

    def _inside(self, region: Region) -> np.ndarray:
        position = self.positions
        inside = np.ones(len(position), dtype=bool)
        for axis, (lower, upper) in enumerate(region):
            if lower is not None:
                inside &= position[:, axis] >= lower
            if upper is not None:
                inside &= position[:, axis] < upper
        return inside

    def _number(self, wanted: str | int, names: list[str], what: str) -> int:
        if isinstance(wanted, str):
            if wanted not in names:
                raise DataError(f"'{self.path}' has no {what} '{wanted}'; it has {', '.join(names)}")
            return names.index(wanted)
        if not 0 <= wanted < len(names):
            raise DataError(f"'{self.path}' has no {what} {wanted}; it has {len(names)}")
        return wanted

    def to_pandas(self, fields: Iterable[str] | None = None, **selection):
        """A pandas.DataFrame, one row a particle, components as velocity_x or cauchy_stress_xy. `selection`: as for select.
        Needs pandas."""
        try:
            import pandas
        except ImportError:
            raise DataError("to_pandas needs pandas, which is not installed") from None
        return pandas.DataFrame(self.columns(fields, **selection))

    def columns(self, fields: Iterable[str] | None = None, **selection) -> dict[str, np.ndarray]:
        """One array (m,) a component: position_x, velocity_y, cauchy_stress_xy, .... `selection`: as for select."""
        chosen = self.select(**selection)
        columns: dict[str, np.ndarray] = {}
        for name in self.fields if fields is None else fields:
            values = self[name][chosen].reshape(int(chosen.sum()), -1)
            for component, suffix in enumerate(suffixes(values.shape[1])):
                columns[name + suffix] = values[:, component]
        return columns


class Frame(ParticleFile):
    """The fields of a run at one time; float32 unless the scene sets another precision."""

    @property
    def index(self) -> int:
        """Number of the frame."""
        return int(self.attributes["index"])

    @property
    def colliders(self) -> list[str]:
        """Names of the colliders whose surfaces the frame has, in the order of their numbers."""
        names = self._read(lambda file: text_of(file["colliders"].attrs.get("names", "")) if "colliders" in file else "")
        return names.split("\n") if names else []

    def grid(self) -> Grid:
        """The nodes. Raises DataError where the frame has none (output.grid)."""
        def read(file):
            if "grid" not in file:
                raise DataError(f"'{self.path}' has no grid: set output.grid")
            group = file["grid"]
            fields = {name: array[...] for name, array in group.items()}
            units = {name: text_of(array.attrs.get("unit", "")) for name, array in group.items()}
            nz, ny, nx = next(iter(fields.values())).shape[:3]
            axes = [group.attrs["origin"][axis] + group.attrs["cell_size"] * np.arange(n)
                    for axis, n in enumerate((nx, ny, nz))]
            return Grid(*axes, fields, units)
        return self._read(read)


class Checkpoint(ParticleFile):
    """The state that a run continues from; float64."""

    def _scene_text(self) -> str:
        parts = [self.attributes["scene"]]
        while (name := f"scene_{len(parts) + 1}") in self.attributes:
            parts.append(self.attributes[name])
        return "".join(parts)


def open_file(path: str | os.PathLike) -> Frame | Checkpoint:
    """A frame or checkpoint by its file's name. Raises DataError."""
    file = ParticleFile(path)
    return (Checkpoint if file.attributes["format"] == "bulkley checkpoint" else Frame)(path)


def suffixes(n_components: int) -> list[str]:
    """What the names of a field's components end in."""
    axes = "xyz"
    known = {1: [""], 3: [f"_{a}" for a in axes], 6: ["_xx", "_yy", "_zz", "_xy", "_yz", "_xz"],
             9: [f"_{a}{b}" for a in axes for b in axes]}
    return known.get(n_components) or [f"_{n}" for n in range(n_components)]


def text_of(value):
    """Text as str; anything else as it is."""
    return value.decode("utf-8") if isinstance(value, bytes) else value
