"""Turns a G-code file into key frames of a print head: where the nozzle is and how much has come out of it.

    python3 -m bulkley gcode FILE.gcode --filament 1.75 --out head.csv --plot head.png

The CSV file has the columns t [s], x, y, z [m] and e [m^3], the volume that has come out; everything is linear between its
rows. docs/processes.md says what is read and how the head moves. Needs numpy; matplotlib for --plot. Exit code 2: bad input.
"""

import argparse
import dataclasses
import math
import pathlib
import sys

import numpy as np

from bulkley.faults import DataError
from bulkley.gcode_motion import follow
from bulkley.gcode_reader import read_program

HEADER = "t,x,y,z,e"


@dataclasses.dataclass
class Settings:
    """Lengths in m, speeds in m/s."""
    filament: float = 1.75e-3       # diameter
    e_is_volume: bool = False
    acceleration: float = 1.0
    corner_speed: float = 0.01
    tolerance: float = 1e-4
    origin: tuple = (0.0, 0.0, 0.0)  # of the file's coordinates, in the scene

    @property
    def section(self):
        return None if self.e_is_volume else 0.25 * math.pi * self.filament**2


def convert(text, settings, name="G-code"):
    """The reader and the motion of a program. Raises DataError."""
    reader = read_program(text, settings.section, name)
    motion = follow(reader.elements, settings.acceleration, settings.corner_speed, settings.tolerance)
    if len(motion.frames) < 2:
        raise DataError(f"'{name}' moves nothing")
    motion.frames[:, 1:4] += settings.origin
    return reader, motion


def summary(reader, motion):
    """Text: what the head does, and whether the volume is that of the E words."""
    frames = motion.frames
    low, high = frames[:, 1:4].min(axis=0), frames[:, 1:4].max(axis=0)
    lines = [f"{len(frames)} key frames, {frames[-1, 0]:.6g} s",
             f"volume {frames[-1, 4]:.6g} m^3; sum of E x section {reader.fed:.6g} m^3",
             f"at most {motion.speed:.6g} m/s and {motion.flow:.6g} m^3/s; {motion.layers} layers",
             "from (" + ", ".join(f"{v:.6g}" for v in low) + ") to (" + ", ".join(f"{v:.6g}" for v in high) + ") m"]
    if reader.fed < frames[-1, 4] * (1.0 - 1e-12):
        lines.append(f"{frames[-1, 4] - reader.fed:.3g} m^3 are drawn back at the end: they have come out nevertheless")
    if reader.ignored:
        lines.append("ignored: " + ", ".join(f"{name} ({count})" for name, count in sorted(reader.ignored.items())))
    return "\n".join(lines)


def draw(motion, file):
    """The path from above, coloured by height where it extrudes, and speed and flow over time."""
    import matplotlib
    matplotlib.use("Agg")
    from matplotlib import pyplot
    from matplotlib.collections import LineCollection
    frames = motion.frames
    steps = np.diff(frames, axis=0)
    pieces = 1e3 * np.stack([frames[:-1, 1:3], frames[1:, 1:3]], axis=1)
    prints = steps[:, 4] > 0.0
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 4.2), dpi=100, layout="constrained")
    left.add_collection(LineCollection(pieces[~prints], colors="0.8", linewidths=0.6))
    beads = LineCollection(pieces[prints], cmap="viridis", linewidths=1.2)
    beads.set_array(1e3 * frames[1:, 3][prints])
    left.add_collection(beads)
    left.autoscale()
    left.set(aspect="equal", xlabel="x [mm]", ylabel="y [mm]")
    figure.colorbar(beads, ax=left, label="z [mm]")
    middle = 0.5 * (frames[1:, 0] + frames[:-1, 0])
    right.plot(middle, 1e3 * np.linalg.norm(steps[:, 1:4], axis=1) / steps[:, 0], "C0", lw=0.8)
    right.set(xlabel="t [s]", ylabel="speed [mm/s]")
    other = right.twinx()
    other.plot(middle, 1e9 * steps[:, 4] / steps[:, 0], "C1", lw=0.8)
    other.set_ylabel("flow [mm$^3$/s], orange")
    figure.savefig(file)
    pyplot.close(figure)


def above_zero(text):
    value = float(text)
    if not (value > 0.0 and math.isfinite(value)):
        raise argparse.ArgumentTypeError(f"'{text}' must be above 0")
    return value


def place(text):
    values = tuple(float(part) for part in text.split(","))
    if len(values) != 3 or not all(map(math.isfinite, values)):
        raise argparse.ArgumentTypeError(f"'{text}' must be three numbers with commas between them")
    return values


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("file", type=pathlib.Path, metavar="FILE.gcode")
    parser.add_argument("--out", type=pathlib.Path, metavar="HEAD.csv", help="default: FILE.csv")
    parser.add_argument("--plot", type=pathlib.Path, metavar="HEAD.png", help="draw path, speed and flow")
    amount = parser.add_mutually_exclusive_group()
    amount.add_argument("--filament", type=above_zero, default=1.75, metavar="MM",
                        help="E is the length of a filament of this diameter; default: %(default)s")
    amount.add_argument("--volume", action="store_true", help="E is volume in mm^3")
    parser.add_argument("--acceleration", type=above_zero, default=1000.0, metavar="MM/S2", help="default: %(default)s")
    parser.add_argument("--corner-speed", type=above_zero, default=10.0, metavar="MM/S",
                        help="jump of the velocity at corners; default: %(default)s")
    parser.add_argument("--tolerance", type=above_zero, default=0.1, metavar="MM",
                        help="of arcs and ramps between key frames, such as a tenth of a cell; default: %(default)s")
    parser.add_argument("--origin", type=place, default=(0.0, 0.0, 0.0), metavar="X,Y,Z",
                        help="where the file's origin is in the scene, m; write --origin=X,Y,Z if X is negative")
    return parser.parse_args()


def run(options):
    settings = Settings(1e-3 * options.filament, options.volume, 1e-3 * options.acceleration, 1e-3 * options.corner_speed,
                        1e-3 * options.tolerance, options.origin)
    try:
        text = options.file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"cannot read '{options.file}': {error}") from None
    reader, motion = convert(text, settings, options.file)
    out = options.out or options.file.with_suffix(".csv")
    try:
        np.savetxt(out, motion.frames, fmt="%.15g", delimiter=",", header=HEADER, comments="")
        if options.plot:
            draw(motion, options.plot)
    except OSError as error:
        raise DataError(f"cannot write: {error}") from None
    print(summary(reader, motion))


def main():
    try:
        run(parse_arguments())
    except DataError as error:
        print(f"gcode: {error}", file=sys.stderr)
        sys.exit(2)
