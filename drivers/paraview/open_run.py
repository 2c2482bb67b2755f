#!/usr/bin/env pvpython
"""Opens a run in ParaView's window as render.py would draw it: particles and colliders with colours by name, and time.

    BULKLEY_RUN=DIR paraview --script=drivers/paraview/open_run.py
    pvpython drivers/paraview/open_run.py --run DIR [--look FILE.toml] --state FILE.pvsm

The second form writes a state file for File > Load State, with the run's path in full. From here on everything is ParaView's
own: particles are Point Gaussians of the XDMF readers, and light and shadows are not render.py's.
"""

import argparse
import os
import pathlib
import sys


def folder_of_this_script():
    """ParaView's window runs a script as text without a path: then its command line contains the path."""
    if "__file__" in globals():
        return pathlib.Path(__file__).resolve().parent
    words = pathlib.Path("/proc/self/cmdline").read_text().split("\0")
    named = [word.removeprefix("--script=") for word in words if word.startswith("--script=")]
    return pathlib.Path(named[0]).resolve().parent


sys.dont_write_bytecode = True  # the folder may be read-only
sys.path.insert(0, str(folder_of_this_script()))

from rendering.display import leave, restart_under_xvfb  # noqa: E402
from rendering.faults import fail  # noqa: E402
from rendering.look import DIRECTIONS, SPHERE_SHADER, Look, rgb  # noqa: E402
from rendering.run_data import Series  # noqa: E402


simple = None  # paraview.simple, once there is a display


def color_by_names(display, view, field, names, colors):
    """A legend of names for the integers 0, 1, ... of a field."""
    simple.ColorBy(display, field)
    table = simple.GetColorTransferFunction(field[1])
    table.InterpretValuesAsCategories = 1
    table.Annotations = [text for i, name in enumerate(names) for text in (str(i), name)]
    table.IndexedColors = [channel for color in colors for channel in color]
    display.LookupTable = table
    legend = simple.GetScalarBar(table, view)
    legend.Title, legend.ComponentTitle = field[1], ""
    legend.TitleColor = legend.LabelColor = rgb("#26262e")
    display.SetScalarBarVisibility(view, True)


def show_particles(view, series, look):
    reader = simple.Xdmf3ReaderS(registrationName="frames.xdmf", FileName=[str(series.path.resolve())])
    display = simple.Show(reader, view)
    display.SetRepresentationType("Point Gaussian")
    display.ShaderPreset = "Custom"
    display.CustomShader = SPHERE_SHADER
    largest = series.largest_reference_volume(-1)
    if largest > 0.0:
        display.GaussianRadius = 0.5 * look["particles.radius"] * float(largest) ** (1.0 / 3.0)
    names, palette = series.materials(), look["materials.palette"]
    if "material" in series.fields and names:
        colors = [rgb(look["materials.colors"].get(name, palette[i % len(palette)])) for i, name in enumerate(names)]
        color_by_names(display, view, ("POINTS", "material"), names, colors)
    return reader


def show_colliders(view, series, look):
    if not series.colliders:
        return
    reader = simple.Xdmf3ReaderS(registrationName="colliders.xdmf", FileName=[str(series.colliders.resolve())])
    display = simple.Show(reader, view)
    names = series.collider_names()
    colors = [rgb(look["colliders.colors"].get(name, look["colliders.color"])) for name in names]
    color_by_names(display, view, ("CELLS", "collider"), names, colors)
    display.Opacity = look["colliders.opacity"]


def open_run(run, look):
    series = Series(run)
    view = simple.GetActiveViewOrCreate("RenderView")
    view.UseColorPaletteForBackground = 0
    view.Background = rgb(look["picture.background"][0])
    show_particles(view, series, look)
    show_colliders(view, series, look)
    simple.GetAnimationScene().UpdateAnimationUsingDataTimeSteps()
    direction = DIRECTIONS["corner"] if isinstance(look["camera.direction"], str) else look["camera.direction"]
    view.CameraFocalPoint, view.CameraPosition, view.CameraViewUp = [0, 0, 0], list(direction), [0, 0, 1]
    simple.ResetCamera(view)


def main():
    parser = argparse.ArgumentParser(prog="open_run.py", description="Opens a run in ParaView.")
    parser.add_argument("--run", type=pathlib.Path, default=os.environ.get("BULKLEY_RUN"), help="output folder of the run")
    parser.add_argument("--look", type=pathlib.Path, default=os.environ.get("BULKLEY_LOOK"), help="TOML file with colours")
    parser.add_argument("--state", type=pathlib.Path, help="state file to write, ending in .pvsm")
    options = parser.parse_args([] if os.environ.get("BULKLEY_RUN") else None)
    if options.run is None:
        fail("--run, or the environment variable BULKLEY_RUN, is needed")
    restart_under_xvfb((640, 480))
    global simple
    from paraview import simple
    look = Look()
    if options.look:
        look.read(pathlib.Path(options.look))
    open_run(pathlib.Path(options.run), look)
    if options.state:
        simple.SaveState(str(options.state))
        leave(0)


main()
