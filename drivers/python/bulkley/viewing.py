"""Particles in space in a notebook: by k3d, to be turned with the pointer, or as pictures by matplotlib."""

from collections.abc import Sequence

import numpy as np

from bulkley.faults import DataError
from bulkley.movie import colour_range
from bulkley.particles import ParticleFile
from bulkley.values import label_of, shown_field, values_of

PAINTERS = ("k3d", "matplotlib")
PICTURES = 4  # of a run's frames, evenly chosen


def view(files: ParticleFile | Sequence[ParticleFile], *, field: str | None = None, component: str | int | None = None,
         by: str | None = None):
    """Frames or checkpoints, one or several in order of time. `field`, `component`: the colours, by default the speed; `by`:
    "k3d", the default where it is installed: a k3d.Plot, with a clock for several times; or "matplotlib": a figure, of at
    most four times. Raises DataError."""
    files = [files] if isinstance(files, ParticleFile) else list(files)
    if not files:
        raise DataError("there are no frames to view: set output.frame_interval")
    if by not in (None, *PAINTERS):
        raise DataError(f"'by' is {by!r} and must be 'k3d' or 'matplotlib'")
    field, component = shown_field(files[0], field, component)
    try:
        import k3d
    except ImportError:
        if by == "k3d":
            raise DataError("this view needs k3d, which is not installed; by='matplotlib' does not") from None
        k3d = None
    if k3d is None or by == "matplotlib":
        return pictures(files, field, component)
    return turned(k3d, files, field, component)


def pictures(files: list[ParticleFile], field: str, component):
    from bulkley.plot import new_axes, plot_particles, shown_once
    n = min(PICTURES, len(files))
    chosen = [files[round(k * (len(files) - 1) / max(n - 1, 1))] for k in range(n)]
    axes = new_axes(None, (1, n), figsize=(4.0 * n + 1.0, 3.6), subplot_kw={"projection": "3d"}, squeeze=False)
    ranges = [colour_range(values_of(file, field, component)) for file in chosen]
    for file, place in zip(chosen, axes.flat):
        plot_particles(file, field, component, place, vmin=min(r[0] for r in ranges), vmax=max(r[1] for r in ranges))
    return shown_once(axes.flat[0].figure)


def turned(k3d, files: list[ParticleFile], field: str, component):
    """A k3d.Plot: spheres as large as the distance between particles, colours by the field."""
    values = {f"{file.time:.6g}": values_of(file, field, component).astype(np.float32) for file in files}
    places = {f"{file.time:.6g}": file.positions.astype(np.float32) for file in files}
    ranges = [colour_range(array) for array in values.values()]
    low, high = min(r[0] for r in ranges), max(r[1] for r in ranges)
    if len(files) == 1:
        values, places = next(iter(values.values())), next(iter(places.values()))
    points = k3d.points(places, point_size=0.5 * float(files[0].scene["domain"]["cell_size"]), shader="3d", attribute=values,
                        color_map=k3d.matplotlib_color_maps.Viridis, color_range=[low, high if high > low else low + 1.0],
                        name=label_of(files[0], field, component))
    plot = k3d.plot(name=field)
    plot += points
    return plot
