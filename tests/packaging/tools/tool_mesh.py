#!/usr/bin/env python3
"""`python3 -m bulkley tool-mesh`: every tool is closed, has the volume and the genus that its numbers say, in three formats, and
`bulkley check` takes it without a warning."""

import math
import pathlib
import re
import struct
import subprocess
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tests/support"), str(ROOT / "drivers/python")]
from bulkley_program import fail, parse_arguments, start  # noqa: E402

from bulkley import tool_mesh  # noqa: E402
from bulkley.faults import DataError  # noqa: E402
from bulkley.solids import faults, genus, volume  # noqa: E402

SCENE = """
[domain]
lower = [-0.114, -0.114, -0.019]
upper = [0.114, 0.114, 0.209]
cell_size = 0.0019
[time]
end = 0.1
[materials.cream]
preset = "cream"
[[bodies]]
name = "body"
material = "cream"
shape = {{ type = "mesh", file = "{file}", rotation = {{ axis = [3, 1, 8], angle = 20, origin = [0, 0, 0.05] }} }}
[[colliders]]
name = "tool"
shape = {{ type = "mesh", file = "{file}", rotation = {{ axis = [3, 1, 8], angle = 20, origin = [0, 0, 0.05] }} }}
"""


def expect(condition, sentence):
    if not condition:
        fail(sentence)


def near(found, wanted, what, slack=1e-9):
    if not abs(found / wanted - 1.0) <= slack:
        fail(f"{what}: {found} instead of {wanted}")


def options(tool, words=()):
    return tool_mesh.parse_arguments([tool, *map(str, words), "--out", "unused.stl"])


def polygon(n, radius=1.0):
    """Area of a regular polygon."""
    return 0.5 * n * math.sin(2.0 * math.pi / n) * radius**2


def vane_volume(o):
    s, half = 0.5 * o.shaft, math.asin(o.thickness / o.shaft)
    between = max(1, round(o.segments / o.blades * (1.0 - half * o.blades / math.pi)))
    hub = o.blades * 0.5 * s * s * (math.sin(2.0 * half) + between * math.sin(2.0 * (math.pi / o.blades - half) / between))
    blades = o.blades * o.thickness * (0.5 * o.diameter - s * math.cos(half))
    return (hub + blades) * o.height + hub * o.shaft_length


def ribbon_volume(o):
    n = o.segments - o.segments % o.starts
    outer, inner, shaft = 0.5 * o.diameter, 0.5 * o.diameter - o.width, 0.5 * o.shaft
    sectors = round((o.height - o.thickness) / o.pitch * n)
    broad = math.ceil(o.thickness / (2.0 * math.pi * shaft / n))
    cells = sectors * (outer**2 - inner**2) + o.spokes * broad * (inner**2 - shaft**2)
    return o.starts * polygon(n) / n * cells * o.thickness + polygon(n, shaft) * (o.height + o.shaft_length)


def whisk_volume(o):
    wires = 0.0
    for k in range(o.loops):
        steps = np.diff(tool_mesh.loop_curve(o, o.height - 0.5 * o.thickness - 1.5 * o.thickness * k), axis=0)
        wires += 2.0 * np.hypot(*steps.T).sum()
    around = 2 * o.loops * max(2, o.segments // (2 * o.loops))
    return polygon(o.sides, 0.5 * o.thickness) * wires + polygon(around, 0.5 * o.handle) * o.handle_length


def bowl_volume(o):
    """Of smooth half ellipsoids; the outer one is cut by its foot."""
    outer = 0.5 * o.diameter
    deep = o.height / math.sqrt(1.0 - (o.foot / o.diameter) ** 2)
    outside = math.pi * outer**2 * (o.height - o.height**3 / (3.0 * deep**2))
    return outside - 2.0 / 3.0 * math.pi * (outer - o.thickness) ** 2 * (o.height - o.thickness)


CASES = (  # tool, options, volume, slack, genus
    ("vane", (), vane_volume, 1e-9, 0), ("vane", ("--blades", 6, "--thickness", 0.003, "--shaft-length", 0), vane_volume, 1e-9, 0),
    ("vane", ("--blades", 2, "--segments", 12), vane_volume, 1e-9, 0),
    ("ribbon", (), ribbon_volume, 1e-9, 3), ("ribbon", ("--starts", 2, "--spokes", 3), ribbon_volume, 1e-9, 4),
    ("ribbon", ("--pitch", 0.05, "--spokes", 2, "--segments", 30), ribbon_volume, 1e-9, 1),
    ("whisk", (), whisk_volume, 1e-9, 3), ("whisk", ("--loops", 1), whisk_volume, 1e-9, 1),
    ("whisk", ("--loops", 5, "--thickness", 0.004, "--handle", 0.036, "--sides", 7), whisk_volume, 1e-9, 5),
    ("bowl", ("--segments", 200, "--curve", 100), bowl_volume, 1e-3, 0), ("bowl", ("--foot", 0), bowl_volume, 1e-2, 0),
)


def shapes():
    for tool, words, formula, slack, handles in CASES:
        o = options(tool, words)
        points, triangles = tool_mesh.build(tool, o)
        what = f"{tool} {words}"
        expect(not faults(triangles), f"{what} is not closed")
        expect(genus(points, triangles) == handles, f"{what} has genus {genus(points, triangles)}")
        near(volume(points, triangles), formula(o), f"volume of {what}", slack)
        size = points.max(axis=0) - points.min(axis=0)
        expect(abs(points[:, 2].min()) < 2e-3 * size[2], f"{what} does not stand on z = 0")
        expect(size[0] <= o.diameter * (1.0 + 2e-2), f"{what} is {size[0]} m wide")
        if tool == "whisk":
            flats = o.thickness / o.diameter * (1.0 - math.cos(math.pi / o.sides))  # a wire's section is a polygon
            near(size[0], o.diameter, f"width of {what}", 1e-3 + flats)
    expect(len(faults(triangles[1:])) == 3, "a missing triangle is seen")


SMALL = {"bowl": ("--segments", "24", "--curve", "6", "--diameter", "0.08", "--height", "0.04", "--foot", "0.03")}  # soon checked


def files(program, work):
    """The program reads every tool, and one in all formats, with the volume that was said, and without warnings; the
    particles of a body fill that volume."""
    for tool in tool_mesh.TOOLS:
        for suffix in ("stl", "obj", "ply") if tool == "vane" else ("stl",):
            file = work / f"{tool}.{suffix}"
            said = subprocess.run([sys.executable, str(ROOT / "drivers/python/bulkley"), "tool-mesh", tool, "--cell-size", "0.0019",
                                   "--out", str(file), *SMALL.get(tool, ())], capture_output=True, text=True, check=False)
            expect(said.returncode == 0, said.stderr)
            volume_said = float(re.search(r"volume (\S+) m", said.stdout)[1])
            if suffix == "stl":
                expect(len(file.read_bytes()) == 84 + 50 * struct.unpack("<I", file.read_bytes()[80:84])[0], "size of an STL file")
            scene = work / f"{tool}_{suffix}.toml"
            scene.write_text(SCENE.format(file=file))
            outcome = program.run(["check", str(scene)], 1, work, 100)
            found = re.search(r"volume (\S+) m\^3 by the divergence theorem, seeded \S+ m\^3, ratio (\S+)", outcome.text)
            expect(outcome.code == 0 and found, outcome.text)
            near(float(found[1]), volume_said, f"volume of {file} as it is read", 1e-5)
            near(float(found[2]), 1.0, f"particles in {file}", 0.02)
            expect("closed, 1 component" in outcome.text, outcome.text)
            expect(not re.search(r"warning.*(mesh|hole|revers|component|triangle)", outcome.text), outcome.text)


REFUSED = (
    ("vane", ("--blades", 1), "at least 2"), ("vane", ("--blades", 9), "do not fit around"), ("vane", ("--diameter", 0.006), "wider"),
    ("vane", ("--height", -1), "--height is -1"), ("vane", ("--thickness", "nan"), "--thickness is nan"),
    ("vane", ("--cell-size", 0.003), "must be two cells thick: 0.006 m"), ("ribbon", ("--spokes", 1), "takes 2 to"),
    ("ribbon", ("--width", 0.05), "wider than its shaft"), ("ribbon", ("--pitch", 0.008), "do not fit into the pitch"),
    ("ribbon", ("--cell-size", 0.003), "two cells"), ("whisk", ("--loops", 0), "above 0"), ("whisk", ("--loops", 9), "do not fit on"),
    ("whisk", ("--sides", 2), "at least 3"), ("whisk", ("--height", 0.02), "higher whisk"), ("bowl", ("--thickness", 0.09), "too thick"),
)


def refusals(work):
    for tool, words, sentence in REFUSED:
        try:
            tool_mesh.build(tool, options(tool, words))
        except DataError as error:
            expect(sentence in str(error) and "\n" not in str(error), f"{tool} {words} gives: {error}")
        else:
            fail(f"{tool} {words} is not refused")
    for words in ((str(work / "a.dae"),), (str(work / "none/a.stl"),), (str(work / "a.stl"), "--blades", "1")):
        said = subprocess.run([sys.executable, str(ROOT / "drivers/python/bulkley"), "tool-mesh", "vane", "--out", *words],
                              capture_output=True, text=True, check=False)
        expect(said.returncode == 2 and said.stderr.startswith("tool-mesh: ") and said.stderr.count("\n") == 1, said.stderr)


def main():
    program, work = start(parse_arguments(__doc__))
    shapes()
    refusals(work)
    files(program, work)


if __name__ == "__main__":
    main()
