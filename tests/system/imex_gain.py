#!/usr/bin/env python3
"""The tool `imex-gain` of the Python package: its means and estimates, and one figure, coarse and short."""

import pathlib
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

PACKAGE = pathlib.Path(__file__).resolve().parents[2] / "drivers" / "python" / "bulkley"
sys.path.insert(0, str(PACKAGE.parent))
from bulkley import imex_gain  # noqa: E402


class MadeUpRun:
    cell_size = 0.01
    scene = {"time": {"end": 2.0, "elastic_cfl": 0.5},
             "materials": {"jelly": {"density": 1000.0, "shear_modulus": 1.5e9}}}  # waves of 2000 m/s with the real modulus
    history = {"step": np.array([0.0, 400.0])}


def check_numbers():
    history = {"step": np.array([0.0, 1.0, 11.0]), "pressure_iterations": np.array([0.0, 20.0, 9.0])}
    if abs(imex_gain.mean_iterations(history) - 10.0) > 1e-12:
        fail("iterations are not weighted by the steps of their row")
    row = imex_gain.estimate("explicit, estimated", "2e9", MadeUpRun(), "jelly")
    if row["steps"] != 800000 or abs(row["time"] - 2000.0) > 1e-9:
        fail(f"the explicit run with the real modulus is estimated as {row}")


def rows_of(text):
    """Cells of the rows of the first table, without its header."""
    lines = [line for line in text.splitlines() if line.startswith("|")][2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def check_program(arguments, work):
    command = [sys.executable, str(PACKAGE), "imex-gain", "--program", arguments.program, "--ranks", "1", "--figures", "8-pie",
               "--out", str(work / "runs"), "--set", "domain.cell_size=0.025", "--set", "time.end=0.1", "--set", "transfer.scheme=apic",
               "--finer"]  # APIC: on two cells a radius moment FLIP keeps the volume to a seventh of the softened run's error
    first = subprocess.run(command, capture_output=True, text=True, timeout=300, check=False)
    if first.returncode != 0:
        fail(first.stderr)
    rows = rows_of(first.stdout)
    if [row[:3] for row in rows] != [["8-pie", "explicit", "1.09e+05"], ["8-pie", "imex", "1.09e+05"], ["8-pie", "imex", "2e+09"],
                                     ["8-pie", "explicit, estimated", "2e+09"]]:
        fail(f"the rows are others: {first.stdout}")
    explicit, softened, real, _ = rows
    if explicit[4] != "1.00" or explicit[5] != "-" or explicit[9] != "0.0" or "-" in (softened[5], real[5], real[10]):
        fail(f"the explicit run is not what the others are over: {first.stdout}")
    if float(real[7]) < float(explicit[7]) or float(real[8]) > 0.1 * float(explicit[8]):  # the report's pies are crushed
        fail(f"a real modulus keeps the volume no better than to {real[8]}: {first.stdout}")
    again = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    if again.stdout != first.stdout:
        fail("runs that are there are repeated")


def main():
    arguments = parse_arguments(__doc__)
    arguments.program = str(pathlib.Path(arguments.program).resolve())
    _, work = start(arguments)
    check_numbers()
    check_program(arguments, work)
    print("a figure's tables come out, and a real modulus keeps the volume")


if __name__ == "__main__":
    main()
