"""The output folder of a run, finished or not."""

import functools
import json
import os
import pathlib
import tomllib
from collections.abc import Iterator, Sequence
from typing import Generic, TypeVar, overload

import numpy as np

from bulkley.faults import DataError
from bulkley.history import History, read_history
from bulkley.particles import Checkpoint, Frame, ParticleFile

File = TypeVar("File", bound=ParticleFile)


class Series(Sequence[File], Generic[File]):
    """Frames or checkpoints in the order of their numbers. A file is opened on first access."""

    def __init__(self, files: list[File]):
        self._files = files

    @overload
    def __getitem__(self, index: int) -> File: ...
    @overload
    def __getitem__(self, index: slice) -> "Series[File]": ...
    def __getitem__(self, index):
        return Series(self._files[index]) if isinstance(index, slice) else self._files[index]

    def __len__(self) -> int:
        return len(self._files)

    def __iter__(self) -> Iterator[File]:
        return iter(self._files)

    @property
    def times(self) -> np.ndarray:
        """(number of files,), s"""
        return np.array([file.time for file in self._files])

    def nearest(self, time: float) -> File:
        """The one whose time is nearest to `time`, s. Raises DataError where there is none."""
        if not self._files:
            raise DataError("there are no files to choose from")
        return self._files[int(np.argmin(np.abs(self.times - time)))]


class Run:
    """The result of `open_run`. Everything except the scene is read again on each access, so that a running simulation can
    be watched."""

    def __init__(self, folder: str | os.PathLike):
        self.folder = pathlib.Path(folder)
        path = self.folder / "scene.toml"
        if not path.is_file():
            raise DataError(f"'{self.folder}' is not the folder of a run: it has no scene.toml")
        try:
            self.scene: dict = tomllib.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise DataError(f"cannot read '{path}': {error}") from None

    def __repr__(self) -> str:
        return f"<Run '{self.folder}'>"

    @property
    def status(self) -> dict:
        """status.json: state ("running", "stopped", "failed", "finished"), step, time, checkpoint, reason."""
        path = self.folder / "status.json"
        try:
            return json.loads(path.read_text(encoding="utf-8"))
        except (OSError, ValueError) as error:
            raise DataError(f"cannot read '{path}': {error}") from None

    @property
    def history(self) -> History:
        """history.csv as it is now."""
        return read_history(self.folder / "history.csv")

    @property
    def cell_size(self) -> float:
        """Width of the grid's cells, m."""
        return float(self.scene["domain"]["cell_size"])

    @property
    def floor(self) -> float:
        """z of the lowest plane of the domain, m."""
        return float(self.scene["domain"]["lower"][2])

    @property
    def gravity(self) -> float:
        """Downwards, m/s^2."""
        return -float(self.scene["gravity"][2])

    @property
    def frames(self) -> Series[Frame]:
        """Those that are there now."""
        return Series([Frame(path, self.scene) for path in self._numbered("frame_")])

    @property
    def checkpoints(self) -> Series[Checkpoint]:
        """Those that are there now, the newest last."""
        return Series([Checkpoint(path) for path in self._numbered("checkpoint_")])

    def plot(self, columns: str | Sequence[str] | None = None):
        """Columns of the history over time, as matplotlib axes; by default all that `bulkley report` draws, as a figure.
        Raises DataError."""
        from bulkley import plot
        return plot.plot_sheets(self.folder) if columns is None else plot.plot_history(self.history, columns)

    def movie(self, path: str | os.PathLike | None = None, **settings) -> pathlib.Path:
        """A film of the frames, movie.gif in the folder by default; its path. `settings`: as of `bulkley.movie.movie`."""
        from bulkley.movie import movie
        return movie(self, self.folder / "movie.gif" if path is None else path, **settings)

    def view(self, **settings):
        """The frames in space, to be turned with the pointer. `settings`: as of `bulkley.view`."""
        from bulkley.viewing import view
        return view(self.frames, **settings)

    def _numbered(self, prefix: str) -> list[pathlib.Path]:
        found = [path for path in self.folder.glob(f"{prefix}*.h5") if path.stem[len(prefix):].isdigit()]
        return sorted(found, key=lambda path: int(path.stem[len(prefix):]))


class EndedRun(Run):
    """A run that is not watched: its history is read once."""

    @functools.cached_property
    def history(self) -> History:
        """history.csv as it was at the first look."""
        return super().history

    @functools.cached_property
    def frames(self) -> Series[Frame]:
        """Those that were there at the first look. Raises DataError where there are none."""
        found = super().frames
        if not found:
            raise DataError(f"'{self.folder}' has no frames: set output.frame_interval")
        return found


def open_run(folder: str | os.PathLike) -> Run:
    """The run whose output folder this is. Raises DataError if it is none."""
    return Run(folder)
