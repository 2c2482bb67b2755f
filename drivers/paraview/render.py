#!/usr/bin/env pvpython
"""Renders the frames of a run to PNG.

    pvpython drivers/paraview/render.py --run DIR --output PNG_OR_FOLDER [--field NAME] [--frame last|all|N] ...

Works under pvpython and pvbatch, with or without a display: without one it starts itself again under Xvfb, because
Debian's ParaView can only draw through an X server. Exit code 2: the command line is wrong or something is missing.
"""

import argparse
import itertools
import math
import os
import pathlib
import shutil
import subprocess
import sys
import tomllib
import xml.etree.ElementTree as ElementTree

UNDER_XVFB = "BULKLEY_RENDER_UNDER_XVFB"
# Colours of materials, in the order of the scene.
MATERIAL_COLORS = [(0.98, 0.90, 0.74), (0.80, 0.36, 0.22), (0.27, 0.51, 0.71), (0.45, 0.62, 0.35), (0.55, 0.40, 0.65)]
FLOOR_COLOR = (0.90, 0.905, 0.92)
TEXT_COLOR = (0.15, 0.15, 0.18)
# Directions from the middle of the domain to the camera.
CAMERAS = {"corner": (0.55, -1.0, 0.38), "front": (0, -1, 0), "side": (1, 0, 0), "top": (0, 0, 1)}
VIEW_ANGLE = 26.0  # degrees
WIDTH_BESIDE_LEGEND = 0.82  # part of the picture
# ParaView's own sphere shader draws edges black, and many small black edges look like dirt.
SPHERE_SHADER = """//VTK::Color::Impl
float distance2 = dot(offsetVCVSOutput.xy, offsetVCVSOutput.xy);
if (distance2 > 1.0) discard;
float shade = 0.74 + 0.26 * sqrt(1.0 - distance2);
ambientColor *= shade;
diffuseColor *= shade;
"""
PARTICLE_OVERLAP = 1.25  # radius of a drawn particle over half the distance between particles: no gaps between neighbours


def fail(sentence):
    print(f"render.py: {sentence}", file=sys.stderr)
    sys.exit(2)


def parse_arguments():
    parser = argparse.ArgumentParser(prog="render.py", description="Renders the frames of a run to PNG.")
    parser.add_argument("--run", required=True, type=pathlib.Path, help="output folder of the run")
    parser.add_argument("--output", required=True, type=pathlib.Path,
                        help="file ending in .png for one frame, else a folder")
    parser.add_argument("--field", help="field to colour by; default velocity, or else the first in the frames")
    parser.add_argument("--component", default="magnitude", help="magnitude, or the number of a component from 0")
    parser.add_argument("--frame", default="last", help="last, all, or a number from 0 in frames.xdmf")
    parser.add_argument("--size", default="1200x900", help="width x height in pixels")
    parser.add_argument("--range", help="LOW,HIGH of the colours; default: from the 1st to the 99th percentile")
    parser.add_argument("--colormap", default="Viridis (matplotlib)", help="name of a ParaView preset")
    parser.add_argument("--camera", help="corner, front, side, top, or a direction X,Y,Z from the middle of the domain; "
                                         "default: corner, or across a thin domain")
    parser.add_argument("--zoom", type=float, default=1.0, help="larger: closer")
    parser.add_argument("--no-floor", action="store_true", help="leave out the floor and the outline of the domain")
    options = parser.parse_args()
    options.size = numbers(options.size, "x", 2, "--size", int)
    if options.range:
        options.range = numbers(options.range, ",", 2, "--range", float)
    if options.camera and options.camera not in CAMERAS:
        options.camera = numbers(options.camera, ",", 3, "--camera", float)
    if options.component != "magnitude":
        options.component = numbers(options.component, ",", 1, "--component", int)[0]
    if not options.zoom > 0:
        fail(f"--zoom is {options.zoom} and must be greater than 0")
    return options


def numbers(text, separator, count, key, kind):
    try:
        values = tuple(kind(part) for part in text.split(separator))
    except ValueError:
        values = ()
    if len(values) != count or not all(math.isfinite(value) for value in values) or (key == "--size" and min(values) < 16):
        fail(f"{key} is '{text}' and must be {count} numbers separated by '{separator}' (or a word that --help lists)")
    return values


def restart_under_xvfb(size):
    """Does nothing where there is a display; else does the work in another process that has one, and ends."""
    if os.environ.get("DISPLAY"):
        return
    if UNDER_XVFB in os.environ:
        fail("Xvfb gave no display")
    for program in ("Xvfb", "pvpython"):
        if not shutil.which(program):
            fail(f"there is no display, and {program} is not installed (Debian: apt-get install xvfb paraview)")
    # The server itself chooses a free display and tells its number once it is ready.
    reading, writing = os.pipe()
    screen = f"{max(size[0], 640)}x{max(size[1], 480)}x24"
    server = subprocess.Popen(["Xvfb", "-displayfd", str(writing), "-screen", "0", screen, "-nolisten", "tcp", "-noreset"],
                              pass_fds=[writing], stderr=subprocess.DEVNULL)
    os.close(writing)
    try:
        with os.fdopen(reading) as channel:
            number = channel.readline().strip()
        if not number:
            fail("Xvfb did not start")
        environment = {**os.environ, UNDER_XVFB: "1", "DISPLAY": f":{number}"}
        environment.pop("XAUTHORITY", None)
        command = ["pvpython", os.path.abspath(__file__), *sys.argv[1:]]
        status = subprocess.run(command, env=environment).returncode
    finally:
        server.terminate()
        server.wait()
    sys.exit(status)


class Series:
    """What frames.xdmf and scene.toml say, before ParaView opens anything (a missing file would end ParaView)."""

    def __init__(self, run):
        self.run = run
        self.path = run / "frames.xdmf"
        if not self.path.is_file():
            fail(f"there is no '{self.path}': the run has written no frames")
        grids = [grid for grid in ElementTree.parse(self.path).iter("Grid") if grid.find("Time") is not None]
        self.times = [float(grid.find("Time").get("Value")) for grid in grids]
        self.files = [run / next(grid.iter("DataItem")).text.split(":")[0].strip() for grid in grids]
        self.fields = [attribute.get("Name") for attribute in grids[-1].iter("Attribute")]
        missing = [file.name for file in self.files if not file.is_file()]
        if missing:
            fail(f"'{self.path}' names {missing[0]}, which is not there")
        self.scene = {}
        if (run / "scene.toml").is_file():
            self.scene = tomllib.loads((run / "scene.toml").read_text(encoding="utf-8"))

    def domain(self):
        """(lower, upper), or None without a scene."""
        domain = self.scene.get("domain", {})
        return (domain["lower"], domain["upper"]) if "lower" in domain and "upper" in domain else None

    def chosen(self, frame):
        """Numbers of the frames asked for."""
        if frame == "all":
            return list(range(len(self.times)))
        if frame == "last":
            return [len(self.times) - 1]
        if not frame.isdigit() or int(frame) >= len(self.times):
            fail(f"--frame is '{frame}' and must be last, all, or a number from 0 to {len(self.times) - 1}")
        return [int(frame)]

    def attributes(self, number, field=None):
        """Attributes of a frame's file or of one of its fields; empty where h5py is not installed."""
        try:
            import h5py
        except ImportError:
            return {}
        with h5py.File(self.files[number], "r") as file:
            found = dict((file["particles"][field] if field else file).attrs)
        return {name: value.decode() if isinstance(value, bytes) else value for name, value in found.items()}


def output_paths(options, series, chosen):
    if options.output.suffix.lower() == ".png":
        if len(chosen) != 1:
            fail(f"--output is the file '{options.output}', but there are {len(chosen)} frames: give a folder")
        options.output.parent.mkdir(parents=True, exist_ok=True)
        return [options.output]
    options.output.mkdir(parents=True, exist_ok=True)
    return [options.output / series.files[number].with_suffix(".png").name for number in chosen]


def component_values(simple, reader, field, component):
    """The scalars that are drawn, as an array."""
    import numpy
    from paraview import servermanager
    from vtkmodules.util.numpy_support import vtk_to_numpy

    values = vtk_to_numpy(servermanager.Fetch(reader).GetPointData().GetArray(field)).astype(float)
    if values.ndim == 1:
        return values
    if component == "magnitude":
        return numpy.linalg.norm(values, axis=1)
    if not 0 <= component < values.shape[1]:
        fail(f"--component is {component}, but {field} has {values.shape[1]} components")
    return values[:, component]


def color_range(simple, reader, series, chosen, options):
    """(low, high) over all chosen frames, without the outermost hundredths."""
    import numpy

    if options.range:
        return options.range
    low, high = math.inf, -math.inf
    for number in chosen:
        reader.UpdatePipeline(series.times[number])
        values = component_values(simple, reader, options.field, options.component)
        values = values[numpy.isfinite(values)]
        if len(values):
            low, high = min(low, numpy.percentile(values, 1)), max(high, numpy.percentile(values, 99))
    if not low < high:  # one value everywhere
        low, high = (low - 0.5 * abs(low), low + 0.5 * abs(low)) if math.isfinite(low) and low != 0 else (0.0, 1.0)
    return low, high


def color_by_field(simple, display, view, series, chosen, reader, options):
    """Colours the particles and adds a legend."""
    field = options.field
    simple.ColorBy(display, ("POINTS", field))
    table = simple.GetColorTransferFunction(field)
    if options.component != "magnitude":
        table.VectorMode, table.VectorComponent = "Component", options.component
    display.LookupTable = table
    attributes = series.attributes(chosen[-1], field)
    names = series.attributes(chosen[-1]).get("materials", "").split("\n")
    if field == "material":
        names = names if names != [""] else [str(i) for i in range(len(MATERIAL_COLORS))]
        table.InterpretValuesAsCategories = 1
        table.Annotations = [text for i, name in enumerate(names) for text in (str(i), name)]
        table.IndexedColors = [c for i in range(len(names)) for c in MATERIAL_COLORS[i % len(MATERIAL_COLORS)]]
        if len(names) < 2:
            return  # a legend of one entry says nothing
    else:
        table.ApplyPreset(options.colormap, True)
        table.RescaleTransferFunction(*color_range(simple, reader, series, chosen, options))
        table.NanColor = [1.0, 0.0, 1.0]
    legend = simple.GetScalarBar(table, view)
    unit = attributes.get("unit", "1")
    title = field.replace("_", " ") + ("" if options.component == "magnitude" else f" [{options.component}]")
    legend.Title = title + (f" ({unit})" if unit != "1" else "")
    legend.ComponentTitle = ""
    legend.TitleColor = legend.LabelColor = TEXT_COLOR
    legend.TitleFontSize, legend.LabelFontSize = font_size(16, options), font_size(14, options)
    legend.HorizontalTitle = 1
    legend.WindowLocation = "Any Location"
    legend.Position = [0.885, 0.3]
    legend.ScalarBarLength = 0.4
    legend.ScalarBarThickness = font_size(14, options)
    if field != "material":
        legend.AutomaticLabelFormat = 0
        legend.LabelFormat = "%-#.3g"
        legend.RangeLabelFormat = "%-#.3g"
    display.SetScalarBarVisibility(view, True)


def font_size(size, options):
    """`size` is for a picture 900 pixels high."""
    return max(7, round(size * options.size[1] / 900))


def particle_radius(series, number, n_particles, bounds):
    volume = series.attributes(number).get("largest_reference_volume", 0.0)
    if not volume > 0.0:  # not recorded: as if the bounding box were full
        volume = math.prod(max(bounds[2 * a + 1] - bounds[2 * a], 1e-9) for a in range(3)) / max(n_particles, 1)
    return 0.5 * PARTICLE_OVERLAP * volume ** (1.0 / 3.0)


def show_domain(simple, view, lower, upper):
    size = [u - l for l, u in zip(lower, upper)]
    # A hair below, so that it does not fight with particles on it.
    z = lower[2] - 2e-3 * max(size)
    floor = simple.Plane(Origin=[lower[0], lower[1], z], Point1=[upper[0], lower[1], z], Point2=[lower[0], upper[1], z])
    display = simple.Show(floor, view)
    display.DiffuseColor = display.AmbientColor = FLOOR_COLOR
    display.Ambient, display.Diffuse, display.Specular = 0.8, 0.2, 0.0
    box = simple.Box(XLength=size[0], YLength=size[1], ZLength=size[2], Center=[0.5 * (l + u) for l, u in zip(lower, upper)])
    outline = simple.Show(box, view)
    outline.SetRepresentationType("Outline")
    outline.AmbientColor = outline.DiffuseColor = (0.65, 0.66, 0.70)
    outline.LineWidth = 1.0


def place_camera(view, lower, upper, options):
    size = [u - l for l, u in zip(lower, upper)]
    center = [0.5 * (l + u) for l, u in zip(lower, upper)]
    direction = options.camera
    if direction is None:
        thin = min(range(3), key=lambda axis: size[axis])
        direction = ("side", "front", "top")[thin] if size[thin] < 0.2 * max(size) else "corner"
    direction = CAMERAS.get(direction, direction)
    length = math.sqrt(sum(d * d for d in direction))
    if length == 0.0:
        fail("--camera 0,0,0 is no direction")
    direction = [d / length for d in direction]
    up = [0, 1, 0] if abs(direction[2]) > 0.99 else [0, 0, 1]

    # The nearest place from which every corner of the domain is in the picture.
    right = normalized(cross(up, direction))
    true_up = cross(direction, right)
    half = math.tan(math.radians(0.5 * VIEW_ANGLE))
    aspect = options.size[0] / options.size[1]
    distance = 0.0
    for corner in itertools.product(*zip(lower, upper)):
        offset = [c - m for c, m in zip(corner, center)]
        toward = dot(offset, direction)
        distance = max(distance, toward + abs(dot(offset, true_up)) / half,
                       toward + abs(dot(offset, right)) / (half * aspect * WIDTH_BESIDE_LEGEND))
    distance *= 1.06 / options.zoom
    view.CameraPosition = [m + distance * d for m, d in zip(center, direction)]
    view.CameraFocalPoint = center
    view.CameraViewUp = up
    view.CameraViewAngle = VIEW_ANGLE
    view.CameraParallelProjection = 0


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def normalized(a):
    length = math.sqrt(dot(a, a))
    return [x / length for x in a]


def make_view(simple, size, reach):
    """`reach`: largest extent of the domain."""
    view = simple.CreateView("RenderView")
    view.ViewSize = list(size)
    view.UseColorPaletteForBackground = 0
    view.BackgroundColorMode = "Gradient"
    view.Background = [0.97, 0.975, 0.985]
    view.Background2 = [1.0, 1.0, 1.0]
    view.OrientationAxesVisibility = 0
    view.UseFXAA = 1
    # Shadows in hollows and under rims, without which a heap of particles of one colour has no shape.
    view.UseAmbientOcclusion = 1
    view.UseSSAODefaultPresets = 0
    view.Radius, view.Bias, view.KernelSize, view.Blur = 0.05 * reach, 0.004 * reach, 96, 1
    return view


def add_text(simple, view, text, position, size):
    source = simple.Text(Text=text)
    display = simple.Show(source, view)
    display.WindowLocation = "Any Location"
    display.Position = position
    display.FontSize = size
    display.Color = TEXT_COLOR
    return source


def main():
    options = parse_arguments()
    series = Series(options.run)
    chosen = series.chosen(options.frame)
    if options.field is None:
        options.field = "velocity" if "velocity" in series.fields else next(iter(series.fields), None)
    if options.field not in series.fields:
        fail(f"--field is '{options.field}', and the frames hold {', '.join(series.fields) or 'no fields'}")
    restart_under_xvfb(options.size)
    paths = output_paths(options, series, chosen)

    from paraview import simple

    simple._DisableFirstRenderCameraReset()
    reader = simple.XDMFReader(FileNames=[str(series.path.resolve())])
    reader.UpdatePipeline(series.times[chosen[-1]])
    data = reader.GetDataInformation()
    lower, upper = series.domain() or (data.GetBounds()[0::2], data.GetBounds()[1::2])

    view = make_view(simple, options.size, max(u - l for l, u in zip(lower, upper)))
    display = simple.Show(reader, view)
    display.SetRepresentationType("Point Gaussian")
    display.ShaderPreset = "Custom"
    display.CustomShader = SPHERE_SHADER
    display.GaussianRadius = particle_radius(series, chosen[-1], data.GetNumberOfPoints(), data.GetBounds())
    color_by_field(simple, display, view, series, chosen, reader, options)
    if not options.no_floor:
        show_domain(simple, view, lower, upper)
    place_camera(view, lower, upper, options)
    if series.scene.get("title"):
        add_text(simple, view, series.scene["title"], [0.03, 0.93], font_size(22, options))
    clock = add_text(simple, view, "", [0.03, 0.88], font_size(18, options))

    for number, path in zip(chosen, paths):
        view.ViewTime = series.times[number]
        clock.Text = f"t = {series.times[number]:.4g} s"
        path.unlink(missing_ok=True)  # so that an old picture is never taken for a new one
        simple.SaveScreenshot(str(path), view, ImageResolution=list(options.size))
        if not path.is_file():
            fail(f"ParaView did not write '{path}'")
        print(path)
    return 0


if __name__ == "__main__":
    status = main()
    sys.stdout.flush()
    sys.stderr.flush()
    # ParaView closes its window after the X connection and then reports an error of its own making.
    os._exit(status)
