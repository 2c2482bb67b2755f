#!/usr/bin/env python3
"""Magnetic bodies give the same bits on any number of ranks and through restarts between two solutions of the field, with either
integrator and several transfers; the energy account closes. PETSc's solver finds the same to the tolerance, and says that it is no more."""

import json
import pathlib
import sys

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from identity import expect_closed_account, expect_identical, last_row  # noqa: E402

SCENE = pathlib.Path(__file__).with_name("magnetic_puddle.toml")
STEPS, INTERRUPTION = 80, 33
SLICE = ['magnetics.sources=[{ kind = "formula", field = ["-1e6*(x-0.04)", "0", "3e4+1e6*z"] }]',
         *(f"boundaries.y_{side}=\"periodic\"" for side in ("lower", "upper"))]
# name, overrides, ranks of the whole run, ranks before and after a restart
VARIANTS = (
    ("apic", [], (2, 3, 7), (3, 4)),
    ("moment_flip", ["transfer.scheme=\"moment_flip\"", "transfer.order=\"cubic\"", *SLICE], (3,), (7, 2)),
    ("layers", ['magnetics.mixing="layers"'], (4,), (3, 2)),
    ("imex", ["time.integrator=\"imex\"", "materials.ferro.bulk_modulus=2e9"], (4,), (2, 5)),
)
WARNING = "magnetics.solver = \"petsc\": results depend on the number of ranks"
# Largest differences between the two solvers, over the largest range of values along an axis and the tolerance.
ALLOWED = {"magnetic_force": 1.0, "position": 0.01}


class Test:
    def __init__(self, program, work):
        self.program = program
        self.work = work

    def run(self, out, ranks, steps, overrides, *more):
        sets = [word for override in overrides for word in ("--set", override)]
        outcome = self.program.run(["run", str(SCENE), "--out", out, "--max-steps", str(steps), *sets, *more], ranks, self.work, 300)
        if outcome.code not in (0, 4):
            fail(f"{out} on {ranks} ranks ended with {outcome.code}", outcome)
        return self.work / out

    def particles(self, out):
        with h5py.File(self.work / out / f"checkpoint_{STEPS:09d}.h5") as file:
            order = numpy.argsort(file["particles/id"][:])
            return {name: file[f"particles/{name}"][:][order] for name in ALLOWED}

    def expect_agreement(self, tolerance, ranks):
        found = {}
        for solver in ("own", "petsc"):
            out = f"{solver}_{ranks}"
            self.run(out, ranks, STEPS, [f"magnetics.solver=\"{solver}\"", f"magnetics.tolerance={tolerance}",
                                         f"magnetics.picard_tolerance={tolerance}"], "--overwrite")
            found[solver] = self.particles(out)
            kept = json.loads((self.work / out / "status.json").read_text(encoding="utf-8"))["warnings"]
            if any(WARNING in warning for warning in kept) != (solver == "petsc"):
                fail(f"{out}: warnings are {kept}")
        for name, allowed in ALLOWED.items():
            own, petsc = found["own"][name], found["petsc"][name]
            error = abs(own - petsc).max() / numpy.ptp(own, axis=0).max()
            print(f"petsc on {ranks} ranks, tolerance {tolerance:g}: {name} {error:.2g} apart", flush=True)
            if not 0.0 < error <= allowed * tolerance:
                fail(f"petsc on {ranks} ranks, tolerance {tolerance:g}: {name} is {error} of its range apart")

    def expect_identical(self, one, other, what):
        expect_identical(self.program, self.work, one, other, STEPS, what)


def expect_same_figures(one, other, what):
    one, other = last_row(one), last_row(other)
    for key in one:
        if key.startswith("magnetic_") and one[key] != other[key]:
            fail(f"{what}: {key} is {other[key]}, not {one[key]}")


def expect_sound(folder, name):
    expect_closed_account(folder, name)
    if not float(last_row(folder)["magnetic_field_work [J]"]) > 0.0:
        fail(f"{name}: the magnet has pulled nothing")


def main():
    test = Test(*start(parse_arguments(__doc__)))
    for name, overrides, ranks, (before, after) in VARIANTS:
        one = test.run(f"{name}_1", 1, STEPS, overrides)
        expect_sound(one, name)
        for n in ranks:
            test.expect_identical(one, test.run(f"{name}_{n}", n, STEPS, overrides), f"{name} on {n} ranks")
        if name == "apic":
            other = test.run("apic_metis", 4, STEPS, [*overrides, 'partition.method="metis"'])
            test.expect_identical(one, other, "apic on 4 ranks, partition by METIS")
        parted = f"{name}_{before}to{after}"
        test.run(parted, before, INTERRUPTION, overrides)
        what = f"{name} on {before} ranks, restarted on {after}"
        restarted = test.run(parted, after, STEPS, overrides, "--restart")
        test.expect_identical(one, restarted, what)
        expect_same_figures(one, restarted, what)
    for tolerance, ranks in ((1e-3, 1), (1e-6, 1), (1e-6, 3)):
        test.expect_agreement(tolerance, ranks)


if __name__ == "__main__":
    main()
