#!/usr/bin/env python3
"""The tool `adaptive-gain` of the Python package: the search for the largest stable step, what is unstable, and one figure,
coarse and short."""

import argparse
import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

DRIVERS = pathlib.Path(__file__).resolve().parents[2] / "drivers"
PACKAGE = DRIVERS / "python" / "bulkley"
sys.path.insert(0, str(PACKAGE.parent))
from bulkley import adaptive_gain  # noqa: E402


class MadeUpStudy:
    """Runs that are stable up to a step."""

    def __init__(self, limit):
        self.limit, self.steps = limit, []

    def fixed(self, name, step):
        self.steps.append(step)
        return argparse.Namespace(name=name, step=step, fault="" if step <= self.limit else "inside out")


class MadeUpRun:
    cell_size, gravity, floor = 0.01, 10.0, 0.0
    scene = {"time": {"cfl": 0.5, "elastic_cfl": 0.4, "deformation_limit": 0.1}}

    def __init__(self, **history):
        self.history = history


def check_search():
    for limit in (1.05e-3, 1.9e-3, 7.7e-3):
        study = MadeUpStudy(limit)
        found = adaptive_gain.largest_stable(study, 1e-3, 2e-3)
        if found is None or not limit / adaptive_gain.BISECTION <= found.step <= limit:
            fail(f"the largest stable step is {limit} and was found to be {found}")
        if len(study.steps) > 12:
            fail(f"the search took {len(study.steps)} runs")


def check_energy():
    zero = np.zeros(3)
    history = {"kinetic_energy": np.array([4.0, 2.0, 0.0]), "elastic_energy": np.array([0.0, 3.0, 0.0]),
               "gravitational_energy": np.array([20.0, 10.0, 10.0]), "dissipated_energy": np.array([0.0, 4.0, 14.0]),
               "mass": zero + 1.0, "lower_z": zero + 1.0}
    if adaptive_gain.energy_fault(MadeUpRun(**history)):
        fail("energy that is kept is a fault")
    for value in (17.0, np.nan):  # the initial energy is 14 J
        history["dissipated_energy"] = np.array([0.0, 4.0, value])
        if not adaptive_gain.energy_fault(MadeUpRun(**history)):
            fail(f"energy that becomes {value} is no fault")


def check_limits():
    history = {"max_speed": np.array([5.0, 10.0, 1.0]), "max_wave_speed": np.array([20.0, 10.0, 40.0]),
               "max_velocity_gradient": np.array([0.0, 1000.0, 1.0])}
    found = adaptive_gain.smallest_stability_limit(MadeUpRun(**history))
    if abs(found - 0.4 * 0.01 / 40.0) > 1e-15:
        fail(f"the smallest limit of speed and waves is {found}")
    if abs(adaptive_gain.limits(MadeUpRun(**history))["deformation"].min() - 0.8 * 0.1 / 1000.0) > 1e-15:
        fail("the limit of deformation is another")


def check_program(arguments, work):
    command = [sys.executable, str(PACKAGE), "adaptive-gain", "--program", arguments.program, "--ranks", "1",
               "--out", str(work / "runs")]
    short = ["--set", "domain.cell_size=0.025", "--set", "time.end=0.1"]
    dry = subprocess.run([*command, "--dry-run"], capture_output=True, text=True, timeout=60, check=False)
    if dry.returncode != 0 or dry.stdout.count("time.mode=fixed") != len(adaptive_gain.FIGURES) or (work / "runs").exists():
        fail(f"--dry-run: {dry.stdout}{dry.stderr}")
    first = subprocess.run([*command, *short, "--figures", "8"], capture_output=True, text=True, timeout=300, check=False)
    if first.returncode != 0:
        fail(first.stderr)
    # 0.1 s in steps of 1e-4 s, the report's with the report's cells.
    for words in ("### Gains of the adaptive step", "| fixed, the report's | 0.0001 | 1000 |", "| adaptive, the scene's |"):
        if words not in first.stdout:
            fail(f"its tables do not hold '{words}': {first.stdout}")
    again = subprocess.run([*command, *short, "--figures", "8"], capture_output=True, text=True, timeout=60, check=False)
    if again.stdout != first.stdout:
        fail("runs that are there are repeated")
    unknown = subprocess.run([*command, "--figures", "2"], capture_output=True, text=True, timeout=60, check=False)
    if unknown.returncode != 2 or "there is no figure 2" not in unknown.stderr:
        fail(unknown.stderr)


def main():
    arguments = parse_arguments(__doc__)
    arguments.program = str(pathlib.Path(arguments.program).resolve())
    _, work = start(arguments)
    check_search()
    check_energy()
    check_limits()
    check_program(arguments, work)
    print("the search finds the step it must, and a figure's tables come out")


if __name__ == "__main__":
    main()
