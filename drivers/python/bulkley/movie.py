"""Films of a run: by ParaView with the script that draws Bulkley's pictures, or by matplotlib."""

import os
import pathlib
import shutil
import subprocess
from typing import TYPE_CHECKING

import numpy as np

from bulkley.faults import DataError
from bulkley.places import find_shared
from bulkley.values import shown_field, values_of

if TYPE_CHECKING:
    from bulkley.run_folder import Run

KINDS = (".gif", ".mp4", ".webp")
PAINTERS = ("paraview", "matplotlib")


def movie(run: "Run", path: str | os.PathLike, *, field: str | None = None, component: str | int | None = None,
          rate: float = 20.0, by: str | None = None, look: str | os.PathLike | None = None,
          largest: float = 2000.0) -> pathlib.Path:
    """Writes a film of all frames to `path`, .gif, .webp or (with ffmpeg) .mp4; returns it.

    `field`, `component`: the colours, by default the speed; `rate`: frames a second; `by`: "paraview", the default where
    pvpython is, or "matplotlib", particles as dots; `look`: a file for ParaView (docs/rendering.md); `largest`: kilobytes that ParaView's
    .gif or .webp may have, and is drawn smaller to have. Raises DataError in one sentence.
    """
    path = pathlib.Path(path)
    if path.suffix.lower() not in KINDS:
        raise DataError(f"a film's name ends in {', '.join(KINDS[:-1])} or {KINDS[-1]}, and '{path}' does not")
    if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        raise DataError(f"'{path}' needs ffmpeg, which is not installed; a film that ends in .gif does not")
    if not 0.0 < rate <= 50.0:
        raise DataError(f"'rate' is {rate!r} and must be above 0 and at most 50 frames a second")
    if not largest >= 1.0:
        raise DataError(f"'largest' is {largest!r} and must be at least 1 kilobyte")
    if not run.frames:
        raise DataError(f"'{run.folder}' has no frames: set output.frame_interval")
    painter = painter_of(by, look)
    path.parent.mkdir(parents=True, exist_ok=True)
    if painter == "paraview":
        options = {"--field": field, "--component": component, "--look": look}
        render(run.folder, path, [word for name, value in options.items() if value is not None for word in (name, str(value))]
               + ["--rate", f"{rate:g}", "--largest", f"{largest:g}"])
    else:
        animate(run, path, field, component, rate)
    return path


def painter_of(by: str | None, look) -> str:
    """Who draws. Raises DataError where nobody can."""
    if by not in (None, *PAINTERS):
        raise DataError(f"'by' is {by!r} and must be 'paraview' or 'matplotlib'")
    has_paraview = shutil.which("pvpython") is not None and find_shared("paraview", "render.py") is not None
    if by == "paraview" and not has_paraview:
        raise DataError("a film by ParaView needs pvpython on the PATH, and Bulkley's render.py, found by BULKLEY_SHARE")
    painter = by or ("paraview" if has_paraview else "matplotlib")
    if painter == "matplotlib":
        if look is not None:
            raise DataError("'look' is for ParaView, and this film is drawn by matplotlib")
        try:
            import matplotlib  # noqa: F401
        except ImportError:
            raise DataError("a film needs ParaView (pvpython) or matplotlib, and neither is installed") from None
    return painter


def render(folder: pathlib.Path, path: pathlib.Path, options: list[str]) -> None:
    """By drivers/paraview/render.py. Raises DataError with its last line."""
    script = find_shared("paraview", "render.py")
    command = ["pvpython", str(script), "--run", str(folder), "--animation", str(path), *options]
    outcome = subprocess.run(command, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                             errors="replace", check=False)
    if outcome.returncode != 0 or not path.is_file():
        said = [line for line in outcome.stdout.splitlines() if line.strip()]
        raise DataError(
            f"ParaView did not draw '{path}': {said[-1].removeprefix('render.py: ') if said else 'it said nothing'}")


def animate(run: "Run", path: pathlib.Path, field: str | None, component: str | int | None, rate: float) -> None:
    """By matplotlib: dots in the domain, with the same colours for all times."""
    from matplotlib.animation import FFMpegWriter, PillowWriter
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    from bulkley.plot import plot_particles
    field, component = shown_field(run.frames[0], field, component)
    ranges = [colour_range(values_of(frame, field, component)) for frame in run.frames]
    low, high = min(r[0] for r in ranges), max(r[1] for r in ranges)
    figure = Figure(figsize=(7.2, 4.8), dpi=100)
    FigureCanvasAgg(figure)
    writer = (FFMpegWriter if path.suffix.lower() == ".mp4" else PillowWriter)(fps=rate)
    with writer.saving(figure, str(path), dpi=100):
        for frame in run.frames:
            figure.clear()
            plot_particles(frame, field, component, figure.add_subplot(projection="3d"), vmin=low, vmax=high)
            writer.grab_frame()


def colour_range(values: np.ndarray) -> tuple[float, float]:
    """From the 1st to the 99th percentile, as ParaView's pictures; (0, 1) where there is no particle."""
    return tuple(float(end) for end in np.percentile(values, (1, 99))) if len(values) else (0.0, 1.0)
