"""Pictures of maps, slices, profiles and history, with matplotlib. Each function draws into `axes` (default: new ones) and
returns them; saving and showing are the caller's."""

from collections.abc import Sequence

import numpy as np

from bulkley.faults import DataError
from bulkley.history import History
from bulkley.maps import Map, Profile, axis_number, slab
from bulkley.particles import ParticleFile
from bulkley.values import label_of, values_of


def new_axes(axes):
    if axes is not None:
        return axes
    try:
        from matplotlib import pyplot
    except ImportError:
        raise DataError("pictures need matplotlib, which is not installed") from None
    return pyplot.subplots(layout="constrained")[1]


def plot_history(history: History, columns: str | Sequence[str], axes=None):
    """Columns over time. Those of one picture should have one unit."""
    columns = [columns] if isinstance(columns, str) else list(columns)
    axes = new_axes(axes)
    for name in columns:
        axes.plot(history["time"], history[name], label=name.replace("_", " "))
    units = sorted({history.units[name] for name in columns} - {""})
    axes.set_xlabel("time [s]")
    name = columns[0].replace("_", " ") if len(columns) == 1 else ""
    axes.set_ylabel(name + (f" [{', '.join(units)}]" if units else ""))
    if len(columns) > 1:
        axes.legend()
    return axes


def plot_map(found: Map, axes=None, **settings):
    """A map in its plane, with a colour bar. `settings` go to matplotlib's pcolormesh."""
    axes = new_axes(axes)
    drawn = axes.pcolormesh(found.columns, found.rows, np.ma.masked_invalid(found.values), **settings)
    axes.figure.colorbar(drawn, ax=axes, label=found.label)
    decorate(axes, found.axes, found.time)
    return axes


def plot_slice(file: ParticleFile, field: str, axis: str = "y", at: float | None = None, thickness: float | None = None,
               component: str | int | None = None, axes=None, **settings):
    """The particles of a thin slab as dots. `at`: m (default: the middle of the particles); `thickness`: m (default: the
    scene's cell_size). `settings` go to matplotlib's scatter."""
    axes = new_axes(axes)
    position = file.positions
    normal = axis_number(axis)
    if at is None:
        at = 0.5 * (position[:, normal].min() + position[:, normal].max())
    chosen = slab(file, axis, at, float(file.scene["domain"]["cell_size"]) if thickness is None else thickness)
    plane = "xyz".replace(axis, "")
    across, up = (axis_number(name) for name in plane)
    drawn = axes.scatter(position[chosen, across], position[chosen, up], c=values_of(file, field, component)[chosen],
                         **{"s": 6, "linewidths": 0, **settings})
    axes.figure.colorbar(drawn, ax=axes, label=label_of(file, field, component))
    decorate(axes, plane, file.time)
    return axes


def plot_profile(found: Profile, axes=None, **settings):
    """A profile over the distance along its line. `settings` go to matplotlib's plot."""
    axes = new_axes(axes)
    axes.plot(found.distance, found.values, **settings)
    axes.set_xlabel("distance [m]")
    axes.set_ylabel(found.label)
    return axes


def decorate(axes, plane: str, time: float) -> None:
    axes.set_aspect("equal")
    axes.set_xlabel(f"{plane[0]} [m]")
    axes.set_ylabel(f"{plane[1]} [m]")
    axes.set_title(f"t = {time:.4g} s")
