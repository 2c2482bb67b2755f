"""history.csv as arrays."""

import csv
import os
import pathlib
from collections.abc import Iterator, Mapping

import numpy as np

from bulkley.faults import DataError

LONGEST_ROW = 1 << 16  # bytes

class Table(Mapping[str, np.ndarray]):
    """Columns by name without unit, all of one length, one value a row: float64, or text where a column holds words.

    `units`: unit of each column, "" for none; `path`: what the table was read from.
    """

    def __init__(self, columns: dict[str, np.ndarray], units: dict[str, str], path: pathlib.Path):
        self._columns, self.units, self.path = columns, units, path

    def __getitem__(self, name: str) -> np.ndarray:
        if name not in self._columns:
            raise DataError(f"'{self.path}' has no column '{name}'; it has {', '.join(self._columns)}")
        return self._columns[name]

    def __contains__(self, name: object) -> bool:
        return name in self._columns

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def to_pandas(self):
        """A pandas.DataFrame with the columns' names without units. Needs pandas."""
        try:
            import pandas
        except ImportError:
            raise DataError("to_pandas needs pandas, which is not installed") from None
        return pandas.DataFrame(dict(self._columns))


class History(Table):
    """The table of a run over its steps."""


def last_row(path: str | os.PathLike) -> tuple[dict[str, float | str], dict[str, str]]:
    """The last whole row of a history.csv, and the units, both by the columns' names without units; empty where there is no
    row yet. However long the table is, only its two ends are read. Raises DataError."""
    try:
        with open(path, "rb") as stream:
            header = stream.readline()
            stream.seek(max(len(header), stream.seek(0, os.SEEK_END) - LONGEST_ROW))
            end = stream.read()
    except OSError as error:
        raise DataError(f"cannot read '{path}': {error.strerror}") from None
    rows = end[:end.rfind(b"\n") + 1].decode("utf-8", errors="replace").splitlines()
    names, units = names_and_units(next(csv.reader([header.decode("utf-8", errors="replace").strip()]), []))
    row = next(csv.reader(rows[-1:]), [])
    return ({name: number_or_text(cell) for name, cell in zip(names, row)}, units) if len(row) == len(names) else ({}, {})


def names_and_units(header: list[str]) -> tuple[list[str], dict[str, str]]:
    names = [name.split(" [")[0] for name in header]
    return names, {name: full[len(name) + 2:-1] if full.endswith("]") else "" for name, full in zip(names, header)}


def number_or_text(cell: str) -> float | str:
    try:
        return float(cell)
    except ValueError:
        return cell


def read_history(path: str | os.PathLike) -> History:
    """Reads a history.csv. A last row that is still being written is left out. Raises DataError."""
    path = pathlib.Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError:
        raise DataError(f"there is no '{path}'") from None
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"cannot read '{path}': {error}") from None
    rows = list(csv.reader(text[:text.rfind("\n") + 1].splitlines()))
    if not rows:
        raise DataError(f"'{path}' has no header yet")
    header, body = rows[0], rows[1:]
    for number, row in enumerate(body, 2):
        if len(row) != len(header):
            raise DataError(f"'{path}', line {number}: {len(row)} values for {len(header)} columns")
    names, units = names_and_units(header)
    values = zip(*body) if body else [[] for _ in header]
    return History({name: as_array(column) for name, column in zip(names, values)}, units, path)


def as_array(texts) -> np.ndarray:
    try:
        return np.array(texts, dtype=float)
    except ValueError:
        return np.array(texts, dtype=str)
