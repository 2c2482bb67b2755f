#!/usr/bin/env python3
"""Inflows against closed forms, explicit and with an implicit pressure: a jet keeps its velocity and density at any time step, place in the cells and direction; a closed box
that is fed has the pressure of what has entered, also through a tube; a head that moves along a circle lays a bead of the same mass on every
arc, that of the flow; a jet that falls becomes thinner as its speed grows."""

import csv
import math
import pathlib
import sys

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

DENSITY, STIFFNESS = 1000.0, 1e5
CELL = 0.01
FLUID = f"""[materials.fluid]
law = "newtonian"
density = {DENSITY}
bulk_modulus = {STIFFNESS}
"""
IMEX = 'integrator = "imex"'
SLIP = "\n".join(f'{axis}_{side} = "slip"' for axis in "xyz" for side in ("lower", "upper"))


def particles_of(program, work, name, scene):
    """Those at the end of a run, as arrays by field."""
    (work / f"{name}.toml").write_text(f'title = "{name}"\n{scene}[output]\nhistory_interval = 10\n', encoding="utf-8")
    outcome = program.run(["run", f"{name}.toml", "--out", name, "--quiet"], 1, work, 120)
    if outcome.code != 0:
        fail(f"{name} did not end", outcome)
    with h5py.File(sorted((work / name).glob("checkpoint_*.h5"))[-1]) as file:
        return {key: file["particles"][key][()] for key in ("position", "velocity", "volume_ratio", "reference_volume")}


def expect_close(value, expected, tolerance, what):
    off = abs(value / expected - 1.0)
    print(f"{what}: {value:.6g}, expected {expected:.6g}, off by {off:.2e}", flush=True)
    if not off <= tolerance:
        fail(f"{what}: {value:.6g} instead of {expected:.6g}")


def check_jet(program, work, name, direction, offset, elastic_cfl, more="", stiffness=STIFFNESS):
    speed, exit_place = 0.5, numpy.array([0.06, 0.06, 0.19]) + offset * CELL
    axis = numpy.array(direction) / numpy.linalg.norm(direction)
    jet = particles_of(program, work, name, f"""gravity = [0.0, 0.0, 0.0]
[domain]
lower = [0.0, 0.0, 0.0]
upper = [0.16, 0.16, 0.24]
cell_size = {CELL}
[time]
end = 0.2
elastic_cfl = {elastic_cfl}
{more}
{FLUID.replace(str(STIFFNESS), str(stiffness))}viscosity = 1
[[inflows]]
name = "jet"
material = "fluid"
section = {{ type = "disc", radius = 0.03 }}
position = {exit_place.tolist()}
direction = {direction}
speed = {speed}
""")
    entered = DENSITY * jet["reference_volume"][(jet["position"] - exit_place) @ axis > 0.0].sum()
    area = math.pi * 0.03**2
    off = max(numpy.abs(jet["velocity"] - speed * axis).max() / speed, numpy.abs(jet["volume_ratio"] - 1.0).max())
    print(f"{name}: velocity and density off by {off:.2e}", flush=True)
    if not off <= 1e-12:
        fail(f"{name}: velocity or density is off by {off}")
    if not abs(entered - DENSITY * area * speed * 0.2) <= 0.5001 * DENSITY * area * CELL / 2:
        fail(f"{name}: {entered} kg have entered")


def check_box(program, work, name, section, area, speed, plate, tolerance, more=""):
    """A bath of 0.1 m on a floor that feeds it; the speed rises for 0.02 s."""
    bath = particles_of(program, work, name, f"""gravity = [0.0, 0.0, 0.0]
[domain]
lower = [0.0, 0.0, 0.0]
upper = [0.08, 0.08, 0.14]
cell_size = {CELL}
[time]
end = 0.1
{more}
{FLUID}viscosity = 5
[[bodies]]
name = "bath"
material = "fluid"
shape = {{ type = "box", lower = [0, 0, 0.04], upper = [0.08, 0.08, 0.14] }}
[[inflows]]
name = "floor"
material = "fluid"
section = {section}
position = [0.04, 0.04, 0.04]
direction = [0, 0, 1]
speed = "{speed} * min(1, t / 0.02)"
{plate}
[boundaries]
{SLIP}
""")
    free = bath["position"][:, 2] > 0.04
    ratio = bath["volume_ratio"][free]
    volume = bath["reference_volume"][free] * ratio
    pressure = -0.5 * STIFFNESS * (ratio - 1.0 / ratio)
    fraction = area * speed * 0.09 / (0.08 * 0.08 * 0.1)
    expect_close((volume * pressure).sum() / volume.sum(), STIFFNESS * fraction, tolerance, f"{name}: mean pressure")


def check_jolt(program, work, name, pressure, tolerance, more="", dilation="particle"):
    """A bath that a piston squeezes by 4 %, against the pressure of what has entered: how even its density is, also at the exit. Cells
    even it out by themselves (0.4 % without a pressure, 0.2 % with), so that particles have to show what the pressure does."""
    exit_place, top, speed = 0.04, 0.14, 0.05
    bath = particles_of(program, work, name, f"""gravity = [0.0, 0.0, 0.0]
[domain]
lower = [0.0, 0.0, 0.0]
upper = [0.06, 0.06, {top}]
cell_size = {CELL}
[time]
end = 0.09
{more}
[transfer]
dilation = "{dilation}"
{FLUID}viscosity = 5
[[bodies]]
name = "bath"
material = "fluid"
shape = {{ type = "box", lower = [0, 0, {exit_place}], upper = [0.06, 0.06, {top}] }}
[[inflows]]
name = "floor"
material = "fluid"
section = {{ type = "rectangle", width = 0.06, height = 0.06 }}
position = [0.03, 0.03, {exit_place}]
direction = [0, 0, 1]
speed = "{speed} * min(1, t / 0.02)"
pressure = {pressure}
[boundaries]
{SLIP}
""")
    ratio = bath["volume_ratio"][bath["position"][:, 2] > exit_place]
    off = numpy.abs(ratio / ratio.mean() - 1.0).max()
    print(f"{name}: J = {ratio.mean():.4f}, off by {off:.2e}", flush=True)
    if not off <= tolerance:
        fail(f"{name}: the density is off by {off}")
    return off


def check_rise(program, work):
    """A heavy bath with its true modulus, open above and fed from below, rises as a block: speed and density as of a jet. APIC
    keeps nothing of the start; with moment FLIP particles at the surface still have 0.4 % of speed that the grid does not see."""
    speed, exit_place = 0.1, 0.04
    bath = particles_of(program, work, "rise", f"""gravity = [0.0, 0.0, -9.81]
[domain]
lower = [0.0, 0.0, 0.0]
upper = [0.06, 0.06, 0.14]
cell_size = {CELL}
[time]
end = 0.1
{IMEX}
[transfer]
scheme = "apic"
{FLUID.replace(str(STIFFNESS), "2e9")}viscosity = 5
[[bodies]]
name = "bath"
material = "fluid"
shape = {{ type = "box", lower = [0, 0, {exit_place}], upper = [0.06, 0.06, 0.1] }}
[[inflows]]
name = "floor"
material = "fluid"
section = {{ type = "rectangle", width = 0.06, height = 0.06 }}
position = [0.03, 0.03, {exit_place}]
direction = [0, 0, 1]
speed = "{speed} * min(1, t / 0.02)"
[boundaries]
{SLIP}
""")
    free = bath["position"][:, 2] > exit_place
    off = max(numpy.abs(bath["velocity"][free] - [0.0, 0.0, speed]).max() / speed, numpy.abs(bath["volume_ratio"] - 1.0).max())
    print(f"rise: velocity and density off by {off:.2e}", flush=True)
    if not off <= 1e-3:
        fail(f"rise: velocity or density is off by {off}")


def check_pushed_back(program, work):
    """A nozzle that begins within a block: what is in the way of its feed is put to the exit, 12 x 8 x 4 particles to begin with."""
    block = particles_of(program, work, "pushed_back", f"""gravity = [0.0, 0.0, 0.0]
[domain]
lower = [0.0, 0.0, 0.0]
upper = [0.1, 0.1, 0.16]
cell_size = {CELL}
[time]
end = 0.003
{FLUID}viscosity = 0.1
[[bodies]]
name = "block"
material = "fluid"
shape = {{ type = "box", lower = [0.01, 0.01, 0.02], upper = [0.09, 0.09, 0.05] }}
[[inflows]]
name = "nozzle"
material = "fluid"
section = {{ type = "shape", shape = {{ type = "box", lower = [-0.03, -0.02, -1], upper = [0.03, 0.02, 1] }} }}
position = [0.05, 0.05, 0.06]
direction = [0, 0, 1]
speed = 0
start = 0.002
""")
    with open(work / "pushed_back" / "history.csv", encoding="utf-8") as table:
        last = list(csv.DictReader(table))[-1]
    n, own = int(last["nozzle.pushed_back_particles"]), int(last["nozzle.feed_particles"])
    place = numpy.abs(block["position"] - [0.05, 0.05, 0.045])
    inside = (place < [0.03, 0.02, 0.015 - 1e-9]).all(axis=1).sum()
    print(f"pushed back: {n} times; {inside} particles in the feed, {own} of its own", flush=True)
    if not (n >= 12 * 8 * 4 and inside == own == 12 * 8 * 6):
        fail("particles that are in the way of a feed are not put back and counted")


def check_fall(program, work):
    """A jet that gravity stretches, steady: v^2 = v_0^2 + 2 g z, and the radius falls as v^(-1/2). The lower face lets it out."""
    radius, speed, cell, g = 0.02, 1.0, 0.004, 9.81
    jet = particles_of(program, work, "fall", f"""gravity = [0.0, 0.0, -{g}]
[domain]
lower = [-0.032, -0.032, 0.0]
upper = [0.032, 0.032, 0.16]
cell_size = {cell}
[time]
end = 0.2
[boundaries]
z_lower = "outflow"
{FLUID}viscosity = 0.001
[[inflows]]
name = "jet"
material = "fluid"
section = {{ type = "disc", radius = {radius} }}
position = [0.0, 0.0, 0.14]
speed = {speed}
""")
    # Above the first section the jet still adapts to its free surface, while the nozzle keeps its speed and width.
    sections = []
    for height in (0.1, 0.07, 0.04):
        slab = numpy.abs(jet["position"][:, 2] - height) < cell
        width = math.sqrt(2.0 * (jet["position"][slab, :2]**2).sum(axis=1).mean())
        sections.append((height, -jet["velocity"][slab, 2].mean(), width))
    top, upper_speed, _ = sections[0]
    for height, fall, width in sections[1:]:
        expected = math.sqrt(upper_speed**2 + 2.0 * g * (top - height))
        expect_close(fall, expected, 0.01, f"fall: speed at {height} m")
        # First order: 3.3 % at 0.04 m with these cells, 1.8 % with half of them.
        expect_close(width, radius * math.sqrt(speed / fall), 0.04, f"fall: radius at {height} m")


def check_circle(program, work):
    """A thick liquid on a sticky floor, four cells below the head: the start and the end of the bead left out."""
    radius, section, speed, cell, n = 0.045, 0.006, 0.2, 0.003, 144
    duration, area = 2.0 * math.pi * radius / speed, math.pi * section**2
    with open(work / "circle.csv", "w", encoding="utf-8") as table:
        table.write("t,x,y,z,e\n")
        for k in range(n + 1):
            angle = 2.0 * math.pi * k / n
            table.write(f"{duration * k / n},{radius * math.cos(angle)},{radius * math.sin(angle)},{4 * cell},"
                        f"{area * speed * duration * k / n}\n")
    bead = particles_of(program, work, "circle", f"""[domain]
lower = [-0.066, -0.066, 0.0]
upper = [0.066, 0.066, 0.042]
cell_size = {cell}
[time]
end = {duration}
[materials.fluid]
law = "newtonian"
density = 1500
bulk_modulus = 5e4
viscosity = 5
[[inflows]]
name = "head"
material = "fluid"
section = {{ type = "disc", radius = {section} }}
key_frames_file = "circle.csv"
""")
    angles = numpy.degrees(numpy.arctan2(bead["position"][:, 1], bead["position"][:, 0])) % 360.0
    expected = 1500 * area * speed * duration / 4
    for first in (45, 135, 225):
        mass = 1500 * bead["reference_volume"][(angles >= first) & (angles < first + 90)].sum()
        expect_close(mass, expected, 0.01, f"circle: mass from {first} degrees")


def main():
    program, work = start(parse_arguments(__doc__))
    for d, direction in enumerate(([0.0, 0.0, -1.0], [0.3, 0.2, -1.0])):
        for offset, elastic_cfl in ((0.0, 0.5), (0.25, 0.1), (0.5, 0.3), (0.7, 0.5)):
            check_jet(program, work, f"jet_{d}_{offset}", direction, offset, elastic_cfl)
        check_jet(program, work, f"jet_{d}_imex", direction, 0.7, 0.5, IMEX, 2e9)
    floor = '{ type = "rectangle", width = 0.08, height = 0.08 }'
    check_box(program, work, "piston", floor, 0.08 * 0.08, 0.01, "", 0.01)
    check_box(program, work, "piston_imex", floor, 0.08 * 0.08, 0.01, "", 0.01, IMEX)
    plate = ('[[colliders]]\nname = "plate"\nshape = { type = "difference", parts = [{ type = "box", lower = [0, 0, 0], upper = '
             '[0.08, 0.08, 0.04] }, { type = "cylinder", start = [0.04, 0.04, -0.01], end = [0.04, 0.04, 0.05], radius = 0.02 }] }')
    # The tube is two cells in radius: nodes that move by shares give a flow larger by 1/48 (docs/theory.md, "Inflow").
    area = math.pi * 0.02**2 * (1.0 + 1.0 / 48.0)
    for name, more in (("tube", ""), ("tube_imex", IMEX)):
        check_box(program, work, name, '{ type = "disc", radius = 0.02 }', area, 0.1, plate, 0.01, more)
    stress_free = check_jolt(program, work, "stress_free", 0.0, 1.0)
    for name, more in (("measured", ""), ("measured_imex", IMEX)):
        off = check_jolt(program, work, name, '"measured"', 0.01, more)
        if not off < 0.3 * stress_free:
            fail("a pressure that is measured does not calm the flow")
    check_jolt(program, work, "measured_by_cells", '"measured"', 0.01, dilation="auto")
    check_rise(program, work)
    check_pushed_back(program, work)
    check_fall(program, work)
    check_circle(program, work)


main()
