#!/usr/bin/env python3
"""Makes docs/validation.md and its pictures from the records of the long validation runs.

    report.py [--new FOLDER]    takes records from FOLDER (build/validation) into tests/validation/results first, unless younger ones are there

Runs that were not made again keep their shipped records, with their date and commit."""

import argparse
import importlib.util
import pathlib
import shutil
import sys

from comparison import FOLDER, Sheet, load, store

ORDER = ("filmed_dams", "filmed_dressings", "martin_moyce", "hertz_ball", "viscous_current", "wall_pressure",
         "power_law_current",
         "towed_sphere", "sand_cylinder")  # of the page; others follow
MARK = "<!-- generated: case "
INTRODUCTION = """<!-- Written by tests/validation/report.py from the records of long validation runs; do not edit. -->
# Validation

[Verification](verification.md) compares the program with solutions of its own equations. This page compares it with
measurements: what a film or a gauge saw. No parameter is adjusted to an experiment. Tolerances were fixed before the runs
were made, but those of the films behind a gate after runs of two boxes on 2 mm had been seen. A run that misses one is listed
with the others. Cases are in `tests/validation/cases`, measured points with their sources in `tests/validation/measured`.

    ctest --test-dir build -L validation        # short versions with coarse cells and wider tolerances
    cluster/verify.sh --validation              # long versions: writes this page; hours on one core

Gates are for the program's default transfer; the tables also have others. Some runs take long. What was measured on each run is
kept as a record with date and commit in `tests/validation/results`, and the page is made of the records: a run that is made
again replaces its own numbers, and runs that nobody could wait for are missing in the tables. `case.py --long [--imex] --only REGEX
--transfer SCHEME` makes single runs; `--imex`, those with the [implicit pressure](theory.md#implicit-pressure) and the true bulk
modulus of water, 2.2e9 Pa, which the dam breaks have beside the explicit runs with a softened fluid. Errors are signed where a sign makes sense: positive means that the simulation is ahead, larger or longer.

Fluids of runs before 1 December 2026 left voids at floors, which are closed since ([theory](theory.md#voids-at-floors)). Tables of films and of the drop
say which are which. The dam break without friction and the wall behind another were made again with the default transfer: slopes of fronts move by less than 0.1 % of
the measured one where the floor slips (by 0.2 % on 64 cells, which are of a program that closed more), on a sticky floor by 0.7 and 0.2 % (`imex`), pressures by 1 % of the plateau. The power-law current (2 mm) does not change, for its plate is a collider. Flows that are alike across are
[plane](howto.md#a-plane-case) since, with an eighth of the particles.
"""
END = """## What is not validated

- **Oobleck.** The preset `oobleck` is a shear-thickening fluid, stress over rate with an index above 1. Experiments on
  suspensions of starch (Waitukaitis, Jaeger 2012; Maharjan et al. 2017) state that neither steady shear thickening nor added
  mass explains the stress under an impact: a front of jammed grains travels through the suspension. Bulkley has no such
  front. Its oobleck is not validated, and must not be taken for a prediction of impact solidification.
- **Sand** is compared with fits to experiments only, [above](#collapse-of-a-cylinder-of-sand) and, in a plane, in
  [verification](verification.md#collapse-of-a-sand-column) (Lajeunesse et al. 2005), with tolerances of 25 %, because prefactors depend on the material.
- **Slumps, drops and Carbopol on an incline**: no table with complete numbers (geometry, flow curve and front) could be
  found in public sources. Verification compares slumps with formulas.
- **Surface tension, thixotropy, wall slip** are in none of these runs. Fronts thinner than the capillary length (2.5 mm) and
  drops of millimetres need the first.
"""


class Broken(Exception):
    """Records that the page cannot be made of."""


def case_names(cases):
    """The folders of `cases` that are cases, in the order of the page."""
    names = [file.parent.name for file in cases.glob("*/case.py")]
    return sorted(names, key=lambda name: (ORDER.index(name) if name in ORDER else len(ORDER), name))


def load_module(cases, name):
    """case.py of a folder."""
    spec = importlib.util.spec_from_file_location(f"case_{name}", cases / name / "case.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def load_case(cases, name):
    """The case of a folder."""
    return load_module(cases, name).CASE


def row(title, entry):
    unit = f" {entry['unit']}" if entry["unit"] else ""
    note = f" ({entry['note']})" if entry["note"] else ""
    cells = [title, entry["quantity"] + note, f"{entry['error']:+.3g}{unit}", f"{entry['tolerance']:.3g}{unit}",
             "passed" if entry["passed"] else "**missed**"]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def made(records):
    """When the runs of `records` were made, and on what, where they say so."""
    dates = sorted(record["date"].split()[0] for record in records.values() if "date" in record)
    machines = sorted({record["machine"] for record in records.values() if "machine" in record})
    if not dates:
        return ""
    span = dates[0] if dates[0] == dates[-1] else f"{dates[0]} to {dates[-1]}"
    return f" Runs of {span}" + (f", since 28 November 2026 on {' and '.join(machines)}." if machines else ".")


def page(entries):
    """The page of `entries`: (case, sheet that it was judged on, when that was) each."""
    lines = [INTRODUCTION, "| Case | Quantity | Error | At most | |", "|---|---|---|---|---|"]
    for case, sheet, _ in entries:
        if not sheet.rows:
            raise Broken(f"{case.name} compares nothing")
        lines += [row(case.title, entry) for entry in sheet.rows]
    for case, sheet, when in entries:
        lines += ["", f"{MARK}{case.name} -->", f"## {case.title}", "",
                  f"`tests/validation/cases/{case.name}`. Source: {case.source}.{when}", ""]
        for part in sheet.parts:
            lines += [part, ""]
        lines += [f"**Missing:** {case.missing[0].lower()}{case.missing[1:]}."]
    return "\n".join([*lines, "", END]).rstrip() + "\n"


def judged(cases, results, pictures=None):
    """(case, sheet, when it was run) of every case, of the records in `results`."""
    entries = []
    for name in case_names(cases):
        records = load(results / f"{name}.json")
        if not records:
            raise Broken(f"{results / name}.json is missing: run the long version of the case first")
        sheet = Sheet(pictures=pictures)
        case = load_case(cases, name)
        case.judge(records, sheet)
        entries.append((case, sheet, made(records)))
    return entries


def listed(text):
    """The cases that the page `text` holds."""
    return [line[len(MARK):].removesuffix(" -->") for line in text.splitlines() if line.startswith(MARK)]


def take(new, results, names):
    """Puts the records of `new` among those of `results`, but not in place of younger ones: a build folder keeps what was measured long ago.
    Returns how many are older."""
    n_older = 0
    for name in names:
        records, kept = load(new / f"{name}.json"), load(results / f"{name}.json")
        taken = {label: record for label, record in records.items() if label not in kept or record["date"] >= kept[label]["date"]}
        n_older += len(records) - len(taken)
        if taken:
            store(results / f"{name}.json", {**kept, **taken})
    return n_older


def main():
    root = FOLDER.parents[1]
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--new", type=pathlib.Path, default=root / "build/validation")
    parser.add_argument("--cases", type=pathlib.Path, default=FOLDER / "cases")
    parser.add_argument("--results", type=pathlib.Path, default=FOLDER / "results")
    parser.add_argument("--docs", type=pathlib.Path, default=root / "docs")
    arguments = parser.parse_args()
    n_older = take(arguments.new, arguments.results, case_names(arguments.cases))
    if n_older:
        print(f"report.py: left out of {arguments.new}: {n_older} records that are older than those of {arguments.results}")
    pictures = arguments.docs / "pictures/validation"
    shutil.rmtree(pictures, ignore_errors=True)
    pictures.mkdir(parents=True)
    try:
        text = page(judged(arguments.cases, arguments.results, pictures))
    except Broken as reason:
        sys.exit(f"report.py: {reason}")
    (arguments.docs / "validation.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
