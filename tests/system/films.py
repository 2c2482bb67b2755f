#!/usr/bin/env python3
"""`bulkley check` warns of films that the cells do not resolve, where there is a floor and a yield stress, and nowhere else; a run,
`bulkley status` and the report tell how many cells thick the material is."""

import csv
import json
import math
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SIZE, YIELD_STRESS, DENSITY, G, RADIUS = 0.4, 20.0, 1000.0, 9.81, 0.05
SCENE = f"""
[domain]
lower = [0.0, 0.0, 0.0]
upper = [{SIZE}, {SIZE}, 0.2]
cell_size = 0.01
[time]
end = 0.02
[materials.sauce]
law = "herschel_bulkley"
density = {DENSITY}
bulk_modulus = 1e5
shear_modulus = 1e4
yield_stress = {YIELD_STRESS}
consistency = 5.0
flow_index = 0.5
[[bodies]]
name = "ball"
material = "sauce"
shape = {{ type = "sphere", center = [0.2, 0.2, 0.06], radius = {RADIUS} }}
[boundaries]
z_upper = "open"
[output]
history_interval = 5
"""
WATER = 'materials.sauce={law="newtonian",density=1000,bulk_modulus=1e5,viscosity=1}'
PLANE = 'colliders=[{name="table",shape={type="plane",point=[0,0,0.02],normal=[0,0,2]}}]'
CUP = ('colliders=[{name="cup",shape={type="complement",parts=[{type="cylinder",start=[0.2,0.2,0.001],end=[0.2,0.2,1],'
       'radius=0.1}]}}]')


def main():
    program, work = start(parse_arguments(__doc__))
    (work / "scene.toml").write_text(SCENE, encoding="utf-8")

    def warning(*settings):
        more = [word for setting in settings for word in ("--set", setting)]
        outcome = program.run(["check", "scene.toml", *more], 1, work, 60)
        if outcome.code != 0:
            fail(f"check with {settings}", outcome)
        found = [line for line in outcome.text.splitlines() if "as a film" in line]
        return found[0] if found else ""

    volume = 4.0 / 3.0 * math.pi * RADIUS**3
    radius = (225.0 * DENSITY * G * volume**2 / (128.0 * math.pi**2 * YIELD_STRESS))**0.2
    thickness = volume / (math.pi * radius**2)
    expected = f"'sauce' comes to rest on the floor as a film about {thickness:.2g} m thick or thinner, {thickness / 0.01:.2g} cells"
    if expected not in warning():
        fail(f"'{warning()}' should contain '{expected}'")
    if warning("boundaries.z_lower=open", PLANE) != warning():
        fail("a plane as a collider is a floor, too")
    if "a film" not in warning("gravity=[9.81,0,0]"):
        fail("a wall towards which gravity points is a floor")
    for what, settings in {"fine cells": ["domain.cell_size=0.0025"], "no floor": ["boundaries.z_lower=open"],
                           "no gravity": ["gravity=[0,0,0]"], "oblique gravity": ["gravity=[1,0,-9]"], "water": [WATER],
                           "a cup": [CUP], "a stiff ball": ["materials.sauce.yield_stress=2000"]}.items():
        if warning(*settings):
            fail(f"a warning with {what}: {warning(*settings)}")

    outcome = program.run(["run", "scene.toml", "--out", "out", "--quiet"], 2, work, 120)
    if outcome.code != 0:
        fail("the run", outcome)
    with open(work / "out" / "history.csv", newline="", encoding="utf-8") as file:
        last = float(list(csv.DictReader(file))[-1]["thickness_decile [cells]"])
    status = program.run(["status", "out"], 1, work, 60).text
    numbers = json.loads(program.run(["status", "out", "--json"], 1, work, 60).text)
    numbers = numbers[0] if isinstance(numbers, list) else numbers
    if not 1.0 < last < 10.0 or abs(numbers["thickness_decile"] - last) > 1e-3 * last:
        fail(f"history.csv has {last} cells, status {numbers['thickness_decile']}")
    if "cells in the thinnest tenth of the material" not in status:
        fail(f"status does not tell the thickness:\n{status}")
    report = program.run(["report", "out"], 1, work, 120)
    if report.code != 0 or "Thickness of the thinnest tenth" not in (work / "out/report.html").read_text(encoding="utf-8"):
        fail("the report does not show the thickness", report)
    print(f"warnings as expected; {last:g} cells in the thinnest tenth of the ball")


if __name__ == "__main__":
    main()
