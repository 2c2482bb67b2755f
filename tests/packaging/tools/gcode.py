#!/usr/bin/env python3
"""`python3 -m bulkley gcode`: key frames by hand-computed digits, volumes, arcs, ramps, drawn-back filament, and every kind of
line that is refused."""

import math
import pathlib
import subprocess
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tests/support"), str(ROOT / "drivers/python")]
from bulkley_program import fail, parse_arguments, start  # noqa: E402

from bulkley.faults import DataError  # noqa: E402
from bulkley.gcode import Settings, convert  # noqa: E402

SECTION = 0.25 * math.pi * 1.75e-3**2
FINE = Settings(tolerance=1e-6)
HEAD = "G21\nG90\nM83\nG0 X0 Y0 Z1\n"  # where the head appears


def expect(condition, sentence):
    if not condition:
        fail(sentence)


def near(found, wanted, what, slack=1e-9):
    if not np.allclose(found, wanted, rtol=slack, atol=slack * 1e-3):
        fail(f"{what}: {found} instead of {wanted}")


def frames(text, settings=Settings()):
    return convert(HEAD + text, settings)[1].frames


def at(rows, t):
    return [float(np.interp(t, rows[:, 0], rows[:, k])) for k in range(1, 5)]


def ramps():
    """100 mm at 100 mm/s with 1000 mm/s^2: 0.1 s up, 0.9 s even, 0.1 s down; the bead's section is even all the way."""
    rows = frames("G1 X100 E10 F6000", FINE)
    near(rows[-1], [1.1, 0.1, 0.0, 0.001, 10e-3 * SECTION], "the end of a line")
    for t, x in ((0.05, 1.25e-3), (0.1, 5e-3), (0.55, 0.05), (1.0, 0.095), (1.05, 0.09875)):
        if abs(at(rows, t)[0] - x) > 1e-6:
            fail(f"at {t} s the head is at {at(rows, t)[0]}, not at {x} m")
    near(np.diff(rows[:, 4]) / np.diff(rows[:, 1]), np.full(len(rows) - 1, 0.1 * SECTION), "de/dl in ramps")
    near(frames("G1 X1 F60000")[-1, 0], 2.0 * math.sqrt(1e-3 / 1.0), "a line too short for its speed")


def corners():
    """A right angle is passed at 10 mm/s / sqrt(2); a bend of the speed alone is none; a reversal is passed at 5 mm/s."""
    v = 0.01 / math.sqrt(2.0)
    leg = (0.1 - 0.0) / 1.0 + (0.1 - v) / 1.0 + (0.1 - 0.005 - 0.5 * (0.1 - v) * (0.1 + v)) / 0.1
    near(frames("G1 X100 F6000\nG1 Y100")[-1, 0], 2.0 * leg, "time of a right angle")
    near(frames("G1 X50 F6000\nG1 X100")[-1, 0], 1.1, "two lines in a row are one")
    back = 0.1 + 0.095 + (0.1 - 0.005 - 0.5 * 0.095 * 0.105) / 0.1
    near(frames("G1 X100 F6000\nG1 X0")[-1, 0], 2.0 * back, "time of a reversal")


def arcs():
    """Quarter of a circle of 10 mm: chords within the tolerance, length pi/2 x 10 mm, speed at most sqrt(a r) = 100 mm/s."""
    settings = Settings(tolerance=1e-5)
    for text in ("G2 X10 Y10 I10 J0 E1 F12000", "G2 X10 Y10 R10 E1 F12000"):
        motion = convert(HEAD + text, settings)[1]
        rows, length = motion.frames, 0.005 * math.pi
        near(motion.speed, 0.1, "speed on an arc")
        near(rows[-1, :4], [0.2 + (length - 0.01) / 0.1, 0.01, 0.01, 0.001], "the end of an arc")
        radii = np.hypot(rows[:, 1] - 0.01, rows[:, 2])
        near(radii, np.full(len(rows), 0.01), "points of an arc")
        middles = 0.5 * (rows[1:, 1:3] + rows[:-1, 1:3]) - [0.01, 0.0]
        expect(0.0 < 0.01 - np.linalg.norm(middles, axis=1).min() <= 1.001e-5, "the sagitta of chords")
        expect(rows[:, 2].max() <= 0.01 and rows[:, 1].max() <= 0.01, "G2 turns clockwise")
    near(frames("G3 I10 J0 E3 Z5 F600", settings)[-1, 1:], [0.0, 0.0, 0.005, 3e-3 * SECTION], "a full turn that rises")
    motion = convert(HEAD + "G3 X10 Y10 R-10 F600", settings)[1]
    near(motion.frames[-1, 0], 0.01 / 1.0 + 0.015 * math.pi / 0.01, "three quarters with R below 0")
    expect(convert(HEAD + "G3 X10 Y10 R10 F600", settings)[1].frames[:, 1].max() > 0.005, "G3 turns counter-clockwise")


def units_and_modes():
    near(frames("G20\nG1 X1 F60")[-1, :2], [1.0 + 0.0254, 0.0254], "inches", 1e-9)
    rows = frames("G91\nG1 X10 F600\nG1 X10\nG90\nG92 X0\nG1 X-5\nM82\nG92 E5\nG1 X0 E6")
    near(rows[-1, 1:], [0.02, 0.0, 0.001, 1e-3 * SECTION], "relative, absolute, renamed")
    volume = convert(HEAD + "G1 X10 E5 F600", Settings(e_is_volume=True))[1].frames[-1, 4]
    near(volume, 5e-9, "E as volume")
    near(frames("G1 X1 F600\nG4 P500\nG4 S1\n")[-1, 0] - frames("G1 X1 F600")[-1, 0], 1.5, "waits")
    near(frames("n5 g1x10f600 (right) *71 ; end")[-1, 1], 0.01, "spelling")
    reader, motion = convert(HEAD + "M104 S200\nG1 X1 E1 F600\nM104 S0\n", Settings(origin=(1.0, 2.0, 3.0)))
    expect(reader.ignored == {"M104": 2}, "ignored codes are counted")
    near(motion.frames[0, 1:4], [1.0, 2.0, 3.001], "the origin")


def drawn_back():
    """e waits while filament is drawn back, and goes on exactly where it has come forward: in the middle of a line too."""
    rows = frames("G1 X10 E1 F600\nG1 E-2\nG1 X20\nG1 E2\nG1 X30 E1")
    near(rows[-1, 4], 2e-3 * SECTION, "volume with filament drawn back")
    expect(np.diff(rows[:, 4]).min() >= 0.0, "e never falls")
    near(rows[rows[:, 1] == 0.02][:, 4], np.full((rows[:, 1] == 0.02).sum(), 1e-3 * SECTION), "e while nothing comes out")
    rows = frames("G1 X10 E2 F600\nG1 E-2\nG1 X30 E4")
    near(rows[-1, 4], 4e-3 * SECTION, "volume after a line that brings filament forward")
    crossing = rows[np.searchsorted(rows[:, 4], 2e-3 * SECTION * (1.0 + 1e-9)) - 1]
    near(crossing[1], 0.02, "where filament has come forward")


def volumes():
    """The sum of E x section comes out, whatever the path."""
    lines = [f"G1 X{20 * math.sin(k):.3f} Y{20 * math.cos(2 * k):.3f} E{0.1 + 0.01 * k:.2f} F{600 + 100 * k}" for k in range(40)]
    reader, motion = convert(HEAD + "\n".join(lines), Settings())
    total = sum(0.1 + 0.01 * k for k in range(40)) * 1e-3 * SECTION
    near([motion.frames[-1, 4], reader.fed], [total, total], "volume of forty lines", 1e-12)
    expect(np.diff(motion.frames[:, 0]).min() > 0.0, "time grows from row to row")
    piece = subprocess.run([sys.executable, ROOT / "drivers/python/examples/print_pieces.py", "wall", "--length", "50"],
                           capture_output=True, text=True, check=True).stdout
    motion = convert(piece, Settings(e_is_volume=True))[1]
    near(motion.frames[-1, 4], 5 * 12e-3 * 6e-3 * 50e-3, "volume of a wall", 1e-6)
    expect(motion.layers == 5, "layers of a wall")


REFUSED = {  # line: what the sentence says
    "G28": "G28 is not known", "T0": "it begins with T", "M600": "M600 is not known", "X10": "it begins with X",
    "G1 A3": "G1 takes no A", "G1 X1 X2": "it has X twice", "G1 G0 X1": "it has a second code", "G1 Xten": "not a letter",
    "G1 X1 (oh": "a bracket", "G1 X1 F0": "F must be above 0",
    "G1 X1": "before any F", "G4": "either P or S", "G4 P-1": "negative", "G92": "needs X", "G2 X1 F60": "either R or I",
    "G2 X1 R1 I1 F60": "either R or I", "G2 I0 J0 F60": "radius is 0", "G2 X9 Y0 I5 J5 F60": "not as far",
    "G2 X9 R1 F60": "R is less than half", "G2 R1 F60": "cannot end where it begins", "G1 X.": "not a letter",
}


def refusals():
    for line, words in REFUSED.items():
        try:
            convert(HEAD + line, Settings(), "piece.gcode")
        except DataError as error:
            if "\n" in str(error) or not str(error).startswith("'piece.gcode', line 5: ") or words not in str(error):
                fail(f"'{line}' gives: {error}")
        else:
            fail(f"'{line}' is not refused")
    for text, words in (("G91\nG1 X1 F60", "line 2: X is relative"), ("G1 X1 E1 F60", "line 1: it extrudes before"),
                        ("G2 X1 Y1 Z1 R1 F60", "line 1: an arc begins before"), (HEAD, "moves nothing"), ("", "moves nothing")):
        try:
            convert(text, Settings())
        except DataError as error:
            expect(words in str(error), f"{text!r} gives: {error}")
        else:
            fail(f"{text!r} is not refused")
    try:
        convert(HEAD + "G20\nG1 E1 F60", Settings(e_is_volume=True))
    except DataError as error:
        expect("line 6: E in cubic inches" in str(error), f"cubic inches: {error}")
    else:
        fail("cubic inches are not refused")


def command(work):
    """The file, as the command line writes it."""
    source, out, plot = (work / name for name in ("line.gcode", "head.csv", "head.png"))
    source.write_text(HEAD + "G1 X100 E10 F6000\n")
    words = [sys.executable, str(ROOT / "drivers/python/bulkley"), "gcode", str(source), "--out", str(out), "--tolerance", "10"]
    said = subprocess.run([*words, "--plot", str(plot)], capture_output=True, text=True, check=False)
    expect(said.returncode == 0 and "1 layers" in said.stdout and "1.1 s" in said.stdout, said.stdout + said.stderr)
    lines = out.read_text().splitlines()
    expect(lines[0] == "t,x,y,z,e" and len(lines) == 5, f"rows of {out}")
    section = 2.405281875e-6
    near([[float(v) for v in line.split(",")] for line in lines[1:]],
         [[0, 0, 0, 1e-3, 0], [0.1, 5e-3, 0, 1e-3, 5e-4 * section], [1.0, 0.095, 0, 1e-3, 9.5e-3 * section],
          [1.1, 0.1, 0, 1e-3, 1e-2 * section]], "key frames of a line", 1e-8)
    expect(plot.read_bytes()[:4] == b"\x89PNG", "the plot")
    source.write_text(HEAD + "G28\n")
    said = subprocess.run(words, capture_output=True, text=True, check=False)
    expect(said.returncode == 2 and said.stderr == f"gcode: '{source}', line 5: G28 is not known\n", said.stderr)
    said = subprocess.run([*words[:3], str(work / "none.gcode")], capture_output=True, text=True, check=False)
    expect(said.returncode == 2 and "cannot read" in said.stderr, said.stderr)


def shipped_path(work):
    """The scene's path is what its own commands make of the project's tools."""
    folder = ROOT / "drivers/scenes/paths"
    words = (folder.parent / "print_cylinder.toml").read_text(encoding="utf-8")
    for piece, begin in (("cylinder", "print_pieces.py "), ("gcode", "bulkley ")):
        expect(begin + piece in words, f"print_cylinder.toml does not say how {piece} is made")
    make = words.split("print_pieces.py ")[1].split(" > ")[0].split()
    said = subprocess.run([sys.executable, str(ROOT / "drivers/python/examples/print_pieces.py"), *make], capture_output=True,
                          text=True, check=True)
    expect(said.stdout == (folder / "cylinder.gcode").read_text(encoding="utf-8"), "paths/cylinder.gcode is out of date")
    options = words.split("bulkley gcode cylinder.gcode ")[1].split(" --out")[0].split()
    out = work / "cylinder.csv"
    subprocess.run([sys.executable, str(ROOT / "drivers/python/bulkley"), "gcode", str(folder / "cylinder.gcode"), *options, "--out",
                    str(out)], capture_output=True, check=True)
    near(np.loadtxt(out, delimiter=",", skiprows=1), np.loadtxt(folder / "cylinder.csv", delimiter=",", skiprows=1),
         "paths/cylinder.csv", 1e-12)


def main():
    _, work = start(parse_arguments(__doc__))
    for part in (ramps, corners, arcs, units_and_modes, drawn_back, volumes, refusals):
        part()
    command(work)
    shipped_path(work)


if __name__ == "__main__":
    main()
