#!/usr/bin/env python3
"""`bulkley check` says what limits either integrator and which is cheaper; a run with an implicit pressure tells its iterations and its
volume error in history.csv, status.json, `bulkley status` and the report, the same rows through a restart."""

import csv
import json
import math
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

DX, DENSITY, SHEAR, BULK, END = 0.01, 1000.0, 1e4, 1e9, 0.02
SCENE = f"""
[domain]
lower = [0.0, 0.0, 0.0]
upper = [0.24, 0.24, 0.12]
cell_size = {DX}
[time]
end = {END}
integrator = "imex"
[materials.clay]
law = "neo_hookean"
density = {DENSITY}
bulk_modulus = {BULK}
shear_modulus = {SHEAR}
[[bodies]]
name = "ball"
material = "clay"
shape = {{ type = "sphere", center = [0.12, 0.12, 0.04], radius = 0.03 }}
velocity = [0.0, 0.0, -1.0]
[output]
history_interval = 7
"""
MACHINE = {"imbalance", "repartitions", "moved_particles", "migrated_particles", "halo_bytes_largest [B]", "halo_bytes_mean [B]",
           "wall_time_per_step [s]"}
SAND = 'materials.clay={preset="sand"}'


class Checks:
    """What `bulkley check` says of the scene with other settings."""

    def __init__(self, program, work):
        self.program, self.work = program, work

    def lines(self, *settings):
        more = [word for setting in settings for word in ("--set", setting)]
        outcome = self.program.run(["check", "scene.toml", *more], 1, self.work, 60)
        if outcome.code != 0:
            fail(f"check with {settings}", outcome)
        return outcome.text.splitlines()

    def number(self, pattern, *settings):
        text = "\n".join(self.lines(*settings))
        found = re.search(pattern, text)
        if not found:
            fail(f"check with {settings} does not say '{pattern}':\n{text}")
        return float(found.group(1))

    def expect(self, text, *settings):
        if not any(text in line for line in self.lines(*settings)):
            fail(f"check with {settings} does not say '{text}':\n" + "\n".join(self.lines(*settings)))

    def expect_not(self, text, *settings):
        if any(text in line for line in self.lines(*settings)):
            fail(f"check with {settings} should not say '{text}'")


def check_forecast(checks):
    waves = {name: 0.4 * DX / math.sqrt((kappa + 4.0 / 3.0 * SHEAR) / DENSITY) for name, kappa in
             {"explicit": BULK, "imex": 0.0}.items()}
    for name, dt in waves.items():
        checks.expect(f"{name:<10} about {dt:.2g} s a step once bodies move at U, limited by: elastic; {math.ceil(END / dt)} steps")
    checks.expect("limited by: speed", "materials.clay.shear_modulus=10")
    checks.expect("cheaper    imex, which the scene has")
    checks.expect("each at about 4.3 times the cost")
    checks.expect("each at about 6.1 times the cost", "time.pressure.tolerance=1e-6")
    checks.expect("cheaper    imex: its steps", "time.integrator=explicit")
    checks.expect("cheaper    explicit: steps of imex are", "materials.clay.bulk_modulus=1e5")
    checks.expect("'clay': a bulk_modulus below 1e+08 Pa is softer", "materials.clay.bulk_modulus=1e5")
    checks.expect_not("is softer")
    checks.expect("'clay': its bulk_modulus of 1e+09 Pa limits the explicit step", "time.integrator=explicit")
    checks.expect("'clay': the stress of drucker_prager has no part that depends on volume alone", SAND)
    checks.expect("cheaper    explicit: steps of imex are 1 times as long", SAND)
    checks.expect_not("cheaper", "time.mode=fixed", "time.dt=1e-4")
    check_impacts(checks)
    check_memory(checks)


def check_impacts(checks):
    """A fluid that is thrown at a wall within the run needs more steps than the same fluid away from it; a solid does not."""
    fluid, end = 'materials.clay={preset="cream"}', "time.end=0.015"
    aside, thrown = "bodies.ball.velocity=[5,0,0]", "bodies.ball.velocity=[0,0,-5]"
    smooth, impact = (checks.number(r"imex .*; (\d+) steps", fluid, end, velocity) for velocity in (aside, thrown))
    if not 1.5 * smooth < impact < 10.0 * smooth:
        fail(f"{smooth} steps without an impact, {impact} with one")
    checks.expect("for impacts", fluid, end, thrown)
    for sets in ((fluid, end, aside), (thrown,), (fluid, thrown, "time.end=0.001")):
        checks.expect_not("for impacts", *sets)
    looser = checks.number(r"deformation_limit = 0.3 there are (\d+)", fluid, end, thrown)
    taken = checks.number(r"imex .*; (\d+) steps", fluid, end, thrown, "time.deformation_limit=0.3")
    if not looser == taken < impact:
        fail(f"{impact} steps with an impact, {looser} in the note and {taken} predicted with a larger deformation limit")
    for sets in ((fluid, end, aside), (fluid, end, thrown, "time.deformation_limit=0.3"), (fluid, end, thrown, "time.integrator=explicit")):
        checks.expect_not("deformation_limit = 0.3", *sets)


def check_memory(checks):
    """Implicit parts take memory: rows of the pressure, PETSc's matrix, viscosity."""
    oil = 'materials.clay={law="newtonian", density=1000, viscosity=1, bulk_modulus=1e9}'
    viscous = "time.viscosity=implicit"
    bytes_of = [checks.number(r"([\d.]+) bytes per particle", oil, *sets) for sets in
                (["time.integrator=explicit"], [], [viscous], ['time.pressure={solver="petsc"}'], [viscous, 'time.pressure={solver="petsc"}'])]
    if not bytes_of[0] + 100.0 < bytes_of[1] < bytes_of[2] < bytes_of[3] < bytes_of[4]:
        fail(f"bytes a particle: {bytes_of}")


def rows_of(folder):
    with open(folder / "history.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def check_rows(program, work):
    for arguments in (["--out", "whole"], ["--out", "parts", "--max-steps", "17"], ["--out", "parts", "--restart"]):
        outcome = program.run(["run", "scene.toml", "--quiet", *arguments], 2, work, 120)
        if outcome.code != 0:
            fail("the run", outcome)
    whole, parts = rows_of(work / "whole"), rows_of(work / "parts")
    if len(whole) != len(parts) or len(whole) < 4:
        fail(f"{len(whole)} rows, through a restart {len(parts)}")
    for one, other in zip(whole, parts):
        different = [name for name in one if name not in MACHINE and one[name] != other[name]]
        if different:
            fail(f"step {one['step']}: a restart changes {different}")
    means = [float(row["pressure_iterations"]) for row in whole[1:]]
    largest = [int(row["pressure_iterations_max"]) for row in whole[1:]]
    if not all(0.0 < mean <= most for mean, most in zip(means, largest)) or all(mean == most for mean, most in zip(means, largest)):
        fail(f"iterations {means}, at most {largest}")
    if not all(float(row["contact_rounds"]) >= 1.0 for row in whole[1:]):
        fail("a step without a solution")
    if not 0.0 < float(whole[-1]["volume_error"]) < 1e-2:
        fail(f"volume error {whole[-1]['volume_error']}")
    return whole[-1]


def check_reports(program, work, last):
    status = json.loads((work / "whole" / "status.json").read_text(encoding="utf-8"))
    told = json.loads(program.run(["status", "whole", "--json"], 1, work, 60).text)
    told = told[0] if isinstance(told, list) else told
    for numbers in (status, told):
        for name in ("pressure_iterations", "pressure_iterations_max", "contact_rounds", "volume_error"):
            if not math.isclose(numbers[name], float(last[name]), rel_tol=1e-3):
                fail(f"{name} is {numbers[name]}, in history.csv {last[name]}")
    line = f"implicit pressure: {float(last['pressure_iterations']):.1f} iterations a step (at most"
    if line not in program.run(["status", "whole"], 1, work, 60).text:
        fail(f"status does not say '{line}'")
    report = program.run(["report", "whole"], 1, work, 120)
    page = (work / "whole/report.html").read_text(encoding="utf-8")
    if report.code != 0 or "Iterations of the implicit pressure" not in page or "Volume error" not in page:
        fail("the report does not show the pressure", report)


def main():
    program, work = start(parse_arguments(__doc__))
    (work / "scene.toml").write_text(SCENE, encoding="utf-8")
    check_forecast(Checks(program, work))
    last = check_rows(program, work)
    check_reports(program, work, last)
    print(f"forecasts as expected; {last['pressure_iterations']} iterations a step, volume error {float(last['volume_error']):.2g}")


if __name__ == "__main__":
    main()
