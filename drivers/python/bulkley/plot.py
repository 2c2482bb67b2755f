"""Pictures of maps, slices, profiles and history, with matplotlib. Each function draws into `axes` (default: new ones) and
returns them; saving and showing are the caller's."""

import itertools
import math
import os
from collections.abc import Sequence

import numpy as np

from bulkley.faults import DataError
from bulkley.history import History
from bulkley.maps import Map, Profile, axis_number, slab
from bulkley.particles import ParticleFile
from bulkley.progress import is_notebook
from bulkley.report_curves import history_plots
from bulkley.values import label_of, shown_field, values_of

MOST_DOTS = 20000


def new_axes(axes, shape=(1, 1), **settings):
    """`axes`, or new ones: of a figure of their own, (rows, columns) of them if that is given."""
    if axes is not None:
        return axes
    try:
        from matplotlib import pyplot
    except ImportError:
        raise DataError("pictures need matplotlib, which is not installed") from None
    return pyplot.subplots(*shape, layout="constrained", **settings)[1]


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


def plot_sheets(folder: str | os.PathLike, columns: int = 3):
    """All curves of a run's history.csv as `bulkley report` draws them, one axes a quantity, in so many columns: a figure.
    Raises DataError where there is no row yet."""
    plots = [plot for plot in history_plots(folder, math.nan, []).plots if any(len(curve.x) for curve in plot.curves)]
    if not plots:
        raise DataError(f"'{folder}' has no history.csv with rows")
    rows = -(-len(plots) // columns)
    axes = new_axes(None, (rows, columns), figsize=(4.2 * columns, 2.8 * rows))
    for plot, place in itertools.zip_longest(plots, axes.flat):
        if plot is None:
            place.set_axis_off()
            continue
        for curve in plot.curves:
            place.plot(curve.x, curve.y, "." if plot.dots else "-", label=curve.name)
        if plot.may_be_log and all((curve.y > 0.0).all() for curve in plot.curves):
            place.set_yscale("log")
        place.set_title(f"{plot.title} {plot.unit}".strip(), fontsize="small", wrap=True)
        place.set_xlabel("time [s]")
        if len(plot.curves) > 1:
            place.legend(fontsize="x-small")
    return shown_once(axes.flat[0].figure)


def shown_once(figure):
    """A figure that a cell of a notebook returns is shown as its value; pyplot must not show it as well."""
    if is_notebook():
        from matplotlib import pyplot
        pyplot.close(figure)
    return figure


def plot_particles(file: ParticleFile, field: str | None = None, component: str | int | None = None, axes=None, **settings):
    """All particles in space as dots, in a 3-D axes as large as the domain; of more than 20 000 about so many. `settings` go
    to matplotlib's scatter."""
    axes = new_axes(axes, subplot_kw={"projection": "3d"})
    field, component = shown_field(file, field, component)
    chosen = thinned(file, MOST_DOTS)
    drawn = axes.scatter(*file.positions[chosen].T, c=values_of(file, field, component)[chosen],
                         **{"s": 3, "linewidths": 0, "depthshade": False, **settings})
    axes.figure.colorbar(drawn, ax=axes, label=label_of(file, field, component), shrink=0.7, pad=0.14)
    domain = file.scene["domain"]
    axes.set(xlim=(domain["lower"][0], domain["upper"][0]), ylim=(domain["lower"][1], domain["upper"][1]),
             zlim=(domain["lower"][2], domain["upper"][2]), xlabel="x [m]", ylabel="y [m]", zlabel="z [m]",
             title=f"t = {file.time:.4g} s")
    axes.set_box_aspect(np.subtract(domain["upper"], domain["lower"]))
    return axes


def thinned(file: ParticleFile, most: int) -> np.ndarray:
    """(n,) bool: about `most` of the particles, or all; by their ids, where the file has them, the same at all times."""
    every = -(-file.n_particles // most)
    if every <= 1:
        return np.ones(file.n_particles, dtype=bool)
    return file.select(every=every) if "id" in file else np.arange(file.n_particles) % every == 0


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
