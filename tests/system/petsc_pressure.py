#!/usr/bin/env python3
"""PETSc's solvers find the pressures that our conjugate gradients find, to the tolerance, on 1, 2 and 3 ranks, with everything that
takes part in the system. They say that results depend on the ranks, measure the residual alike, and keep no memory."""

import csv
import json
import os
import pathlib
import re
import subprocess
import sys

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from imex_runs import SCENES, ImexRuns  # noqa: E402

WARNING = "results depend on the number of ranks and on the partition"
PETSC = ["time.pressure.solver=petsc"]
JACOBI = [*PETSC, "time.pressure.petsc_options='-bulkley_pressure_pc_type jacobi'"]
# A column that goes around and is squeezed, so that rows of nodes cross the end of the grid.
PERIODIC = ["domain.upper=[0.35,0.4,0.3]",
            "bodies.ball.shape={type=\"box\", lower=[0.05, 0.05, 0.0], upper=[0.2, 0.25, 0.3]}",
            "bodies.ball.velocity_field=[\"-20 * (x - 0.125)\", \"0\", \"3 * sin(20.94 * z)\"]"]
PERIODIC += [f"boundaries.{axis}_{side}=\"periodic\"" for axis in "yz" for side in ("lower", "upper")]
# name, scene, overrides, steps
VARIANTS = (
    ("splash", "splash.toml", ["materials.cream.bulk_modulus=2e9"], 10),
    ("cubic", "splash.toml", ["transfer.order=\"cubic\"", "transfer.gradient=\"bspline\"", "boundaries.z_lower={type=\"sticky\"}"], 10),
    ("periodic", "splash.toml", PERIODIC, 10),
    ("moving", "moving_colliders.toml", ["time.end=1.0", "time.growth=1.5"], 10),
    ("parting", "tank.toml", ["materials.water.tension=false", "gravity=[3.0, 0.0, -10.0]"], 20),
)
# Largest differences, as parts of the largest velocity or pressure times the tolerance. What residuals say of velocities they do not
# say of pressures that are smooth over many cells.
ALLOWED = {"velocity": 1.0, "cell_mean_stress": 20.0}


class Test(ImexRuns):
    def run(self, out, ranks, steps, scene, overrides, *more):
        return super().run(out, ranks, steps, scene, overrides, "--overwrite", "--quiet", *more).text


def particles_of(folder, steps):
    with h5py.File(folder / f"checkpoint_{steps:09d}.h5") as file:
        order = numpy.argsort(file["particles/id"][:])
        return [file[f"particles/{name}"][:][order] for name in ALLOWED]


def check_agreement(test, name, scene, overrides, steps):
    for tolerance, all_ranks in ((1e-3, (2,)), (1e-8, (1, 2, 3))):
        settings = [*overrides, f"time.pressure.tolerance={tolerance}"]
        test.run(f"{name}_cg", 1, steps, scene, settings)
        expected = particles_of(test.work / f"{name}_cg", steps)
        for ranks in all_ranks:
            test.run(f"{name}_petsc", ranks, steps, scene, settings + PETSC)
            found = particles_of(test.work / f"{name}_petsc", steps)
            errors = [abs(a - b).max() / abs(a).max() for a, b in zip(expected, found)]
            print(f"{name} on {ranks} ranks, tolerance {tolerance:g}: velocity {errors[0]:.2g}, pressure {errors[1]:.2g}", flush=True)
            if not all(error <= allowed * tolerance for error, allowed in zip(errors, ALLOWED.values())):
                fail(f"{name} on {ranks} ranks: solutions differ by {errors} at a tolerance of {tolerance}")


def iterations_of(folder):
    with open(folder / "history.csv", newline="", encoding="utf-8") as file:
        return [float(row["pressure_iterations"]) for row in csv.DictReader(file)][1:]


def check_measure_of_residuals(test):
    """With the same preconditioner the same number of iterations, and fewer with a better one."""
    settings = ["materials.cream.bulk_modulus=2e9", "time.pressure.contact_rounds=1"]
    counts = {}
    for name, more in (("cg", []), ("jacobi", JACOBI), ("petsc", PETSC)):
        test.run(name, 1, 40, "splash.toml", settings + more)
        counts[name] = sum(iterations_of(test.work / name)) / 8
    print(f"iterations a step: {counts}", flush=True)
    if not (abs(counts["jacobi"] - counts["cg"]) <= 0.02 * counts["cg"] and counts["petsc"] < 0.6 * counts["cg"]):
        fail(f"iterations a step: {counts}")


def check_warnings(test):
    arguments = ["check", str(SCENES / "tank.toml"), "--set", "time.integrator=imex"]
    for more, expected in (([], 0), (["--set", PETSC[0]], 1)):
        told = [test.program.run(arguments + more, 1, test.work, 60).text, test.run("told", 1, 2, "tank.toml", more[1:])]
        kept = json.loads((test.work / "told/status.json").read_text(encoding="utf-8"))["warnings"]
        counts = [len(re.findall(WARNING, text)) for text in (*told, " ".join(kept))]
        if counts != [expected] * 3:
            fail(f"check, run and status.json warn {counts} times instead of {expected}:\n{told}\n{kept}")


def check_memory(test):
    """Matrices and solvers of all steps together would take a hundred times as much as is allowed."""
    peaks = []
    for steps in (20, 220):
        command = [test.program.path, "run", str(SCENES / "tank.toml"), "--out", f"memory_{steps}", "--quiet", "--max-steps", str(steps),
                   "--set", "time.integrator=imex", "--set", PETSC[0], "--set", "output.frame_interval=0", "--set", "time.end=10"]
        with subprocess.Popen(command, cwd=test.work) as process:
            _, code, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(code)
        if process.returncode not in (0, 4):
            fail(f"{command} ended with {process.returncode}")
        peaks.append(usage.ru_maxrss / 1024)
    print(f"{peaks[0]:.1f} MiB after 20 steps, {peaks[1]:.1f} MiB after 220", flush=True)
    if peaks[1] > peaks[0] + 4.0:
        fail(f"memory grows from {peaks[0]:.1f} to {peaks[1]:.1f} MiB in 200 steps")


def main():
    test = Test(*start(parse_arguments(__doc__)))
    for name, scene, overrides, steps in VARIANTS:
        check_agreement(test, name, scene, overrides, steps)
    check_measure_of_residuals(test)
    check_warnings(test)
    check_memory(test)


if __name__ == "__main__":
    main()
