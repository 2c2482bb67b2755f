#!/usr/bin/env pvpython
"""Renders the frames of a run: pictures, strips of pictures, animations.

    pvpython drivers/paraview/render.py --run DIR --output PNG_OR_FOLDER [--look FILE.toml] [--frame last|all|N,N,...] ...
    pvpython drivers/paraview/render.py --run DIR --strip FILE.png [--frame N,N,...] ...
    pvpython drivers/paraview/render.py --run DIR --animation FILE.mp4|FILE.gif|FILE.webp ...

Works under pvpython and pvbatch, with or without a display: without one it starts itself again under Xvfb, because
Debian's ParaView can only draw through an X server. Exit code 2: the command line or the look file is wrong, or something is
missing. All looks: looks/default.toml; examples: docs/rendering.md.
"""

import argparse
import os
import pathlib
import sys
import tempfile

sys.dont_write_bytecode = True  # the folder may be read-only
sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))

from rendering import sequence  # noqa: E402
from rendering.display import leave, restart_under_xvfb  # noqa: E402
from rendering.faults import fail  # noqa: E402
from rendering.look import Look  # noqa: E402
from rendering.run_data import Reader, Series  # noqa: E402

STRIP_FRAMES = 6
# Options that set a key of the look.
SHORTHANDS = {"field": "particles.field", "colormap": "particles.colormap", "zoom": "camera.zoom"}


def parse_arguments():
    parser = argparse.ArgumentParser(prog="render.py", description="Renders the frames of a run.")
    parser.add_argument("--run", required=True, type=pathlib.Path, help="output folder of the run")
    parser.add_argument("--output", type=pathlib.Path, help="file ending in .png for one frame, else a folder")
    parser.add_argument("--strip", type=pathlib.Path, help="PNG below 300 kB with several frames side by side")
    parser.add_argument("--animation", type=pathlib.Path, help="file ending in .mp4, .gif or .webp")
    parser.add_argument("--rate", type=float, default=20.0, help="frames a second of an animation")
    parser.add_argument("--largest", type=float, default=2000.0, metavar="KB",
                        help="kilobytes of a GIF or WebP, which is drawn smaller until it has no more; default: 2000")
    parser.add_argument("--frame", help="last, all, or numbers from 0 in frames.xdmf such as 0,5,10; default: last; "
                                        f"all for an animation, {STRIP_FRAMES} evenly chosen for a strip")
    parser.add_argument("--look", type=pathlib.Path, help="TOML file; see looks/default.toml for every key")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="a key of the look, overrides its file")
    parser.add_argument("--field", help="field to colour by, or material")
    parser.add_argument("--component", help="magnitude, or the number of a component from 0")
    parser.add_argument("--range", help="LOW,HIGH of the colours; default: from the 1st to the 99th percentile")
    parser.add_argument("--colormap", help="name of a ParaView preset")
    parser.add_argument("--surface", action="store_true", help="a smooth surface instead of spheres")
    parser.add_argument("--size", help="width x height in pixels")
    parser.add_argument("--camera", help="corner, front, side, top, or a direction X,Y,Z from the middle towards the camera")
    parser.add_argument("--zoom", help="larger: closer")
    parser.add_argument("--no-floor", action="store_true", help="leave out the floor")
    options = parser.parse_args()
    if not (options.output or options.strip or options.animation):
        fail("one of --output, --strip and --animation is needed")
    if not 0.0 < options.rate <= 50.0:
        fail(f"--rate is {options.rate} and must be above 0 and at most 50")
    if not options.largest >= 1.0:
        fail(f"--largest is {options.largest} and must be at least 1")
    return options


def look_of(options):
    look = Look()
    if options.strip and not options.output:
        look.values["picture.size"], look.values["picture.text_scale"] = [720, 480], 1.6
        look.values["picture.title"] = look.values["picture.legend"] = False
    if options.look:
        look.read(options.look)
    for option, key in SHORTHANDS.items():
        value = getattr(options, option)
        if value is not None:
            look.put(key, number(value) if option == "zoom" else value, f"--{option}: ")
    if options.component is not None:
        look.put("particles.component", number(options.component), "--component: ")
    if options.size is not None:
        look.put("picture.size", [number(part) for part in options.size.split("x")], "--size: ")
    if options.range is not None:
        look.put("particles.range", [number(part) for part in options.range.split(",")], "--range: ")
    if options.camera is not None:
        parts = options.camera.split(",")
        look.put("camera.direction", options.camera if len(parts) == 1 else [number(part) for part in parts], "--camera: ")
    if options.surface:
        look.put("particles.representation", "surface", "--surface: ")
    if options.no_floor:
        look.put("floor.show", False, "--no-floor: ")
    for assignment in options.set:
        look.set_text(assignment)
    look.check_together()
    return look


def number(text):
    """A number if possible; otherwise the text, which the look refuses."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            pass
    return text


def chosen_frames(options, n_frames):
    frame = options.frame
    if frame is None:
        if options.strip:
            n = min(STRIP_FRAMES, n_frames)
            return [round(i * (n_frames - 1) / max(n - 1, 1)) for i in range(n)]
        frame = "all" if options.animation else "last"
    if frame == "all":
        return list(range(n_frames))
    if frame == "last":
        return [n_frames - 1]
    parts = frame.split(",")
    if not all(part.isdigit() and int(part) < n_frames for part in parts):
        fail(f"--frame is '{frame}' and must be last, all, or numbers from 0 to {n_frames - 1}")
    return [int(part) for part in parts]


def output_paths(options, series, chosen, scratch):
    output = options.output
    if output is None:
        return [scratch / f"{n:06}.png" for n in range(len(chosen))]
    if output.suffix.lower() == ".png":
        if len(chosen) != 1:
            fail(f"--output is the file '{output}', but there are {len(chosen)} frames: give a folder")
        output.parent.mkdir(parents=True, exist_ok=True)
        return [output]
    output.mkdir(parents=True, exist_ok=True)
    return [output / series.files[number].with_suffix(".png").name for number in chosen]


def render(options, look, series, chosen, paths):
    from paraview import simple
    from rendering.stage import Stage

    simple._DisableFirstRenderCameraReset()
    stage = Stage(simple, look, series, Reader(simple, series, look), chosen)
    for n, (number, path) in enumerate(zip(chosen, paths)):
        stage.draw(number)
        stage.show_legend(options.strip is None or options.output is not None or n == 0)  # a strip has it once
        path.unlink(missing_ok=True)  # so that an old picture is never taken for a new one
        simple.SaveScreenshot(str(path), stage.view, ImageResolution=list(look["picture.size"]))
        if not path.is_file():
            fail(f"ParaView did not write '{path}'")
        if options.output:
            print(path, flush=True)


def main():
    options = parse_arguments()
    look = look_of(options)
    if options.strip:
        sequence.check_strip(options.strip)
    if options.animation:
        sequence.check_animation(options.animation)
    series = Series(options.run)
    chosen = chosen_frames(options, len(series.times))
    field = look["particles.field"]
    if field not in ("auto", "material", *series.fields):
        fail(f"--field is '{field}', and the frames hold {', '.join(series.fields) or 'no fields'}")
    restart_under_xvfb(look["picture.size"])
    with tempfile.TemporaryDirectory(prefix="bulkley_render_") as scratch:
        paths = output_paths(options, series, chosen, pathlib.Path(scratch))
        render(options, look, series, chosen, paths)
        if options.strip:
            sequence.write_strip(paths, options.strip)
            print(options.strip)
        if options.animation:
            sequence.write_animation(paths, options.animation, options.rate, pathlib.Path(scratch),
                                     1000.0 * options.largest)
            print(options.animation)
    return 0


if __name__ == "__main__":
    leave(main())
