#!/usr/bin/env python3
"""Makes docs/verification.md from the results that the long versions of the verification cases leave in
build/verification."""

import argparse
import json
import pathlib
import shutil
import sys

MARK = "<!-- generated: case "
INTRODUCTION = """<!-- Written by tests/verification/report.py from the results of long verification runs; do not edit. -->
# Verification

Every case runs the real program on a scene of its own and compares what comes out with an analytic or published truth: on
one rank and on two (the finest of several runs on one count only), which must agree bit for bit, and, where the error is one of
discretisation, at several resolutions. The cases are in `tests/verification/cases`, a scene and a script each.

    ctest --test-dir build -L verification      # short versions, coarser; part of cluster/test.sh
    ctest --test-dir build -L slow              # long versions: the numbers of this page
    cluster/verify.sh                           # builds, runs the long versions and writes this page

**Errors** are relative to the truth unless a unit is given. Where there are several, the number before the colon is the
resolution, in cells per characteristic length of the case, and the **order** is that observed from coarsest to finest.
A row passes if its last error (the finest resolution) is within **at most** and its order is at least the one in brackets.
"""


class Broken(Exception):
    """A result that the page cannot be made of."""


def number(value):
    return f"{value:.2g}"


def error_text(quantity):
    unit = f" {quantity['unit']}" if quantity["unit"] and (quantity["truth"] is None or not quantity["relative"]) else ""
    parts = [(f"{float(level['label']):.3g}: " if level["label"] else "") + number(level["error"]) + unit
             for level in quantity["levels"]]
    return ", ".join(parts)


def row(case, quantity):
    unit = f" {quantity['unit']}" if quantity["unit"] and (quantity["truth"] is None or not quantity["relative"]) else ""
    order = "" if quantity["order"] is None else f"{quantity['order']:.2f} ({quantity['least_order']:g})"
    passed = "passed" if quantity["passed"] else "**FAILED**"
    cells = [case, quantity["quantity"], error_text(quantity), order, number(quantity["tolerance"]) + unit, passed]
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def section(result):
    lines = [f"{MARK}{result['name']} -->", f"## {result['title']}", "",
             f"`tests/verification/cases/{result['name']}`. Truth: {result['truth']}.", ""]
    for quantity in result["quantities"]:
        if quantity["truth"] is not None:
            value = quantity["levels"][-1]["value"]
            found = f"{value:.6g} against {quantity['truth']:.6g} {quantity['unit']}".rstrip()
            lines.append(f"- {quantity['quantity']}: {found}.")
        if quantity["note"]:
            lines.append(f"- {quantity['quantity']}: {quantity['note']}.")
    lines += [f"- {remark}" for remark in result["remarks"]]
    if lines[-1]:
        lines.append("")
    for plot in result["plots"]:
        lines += [f"![{plot['caption']}](pictures/verification/{plot['file']})", "", plot["caption"], ""]
    return lines


def page(results):
    """The page of `results`, a list of what study.py's `finish` wrote."""
    lines = [INTRODUCTION, "| Case | Quantity | Error | Order (least) | At most | |", "|---|---|---|---|---|---|"]
    for result in results:
        if not result["quantities"]:
            raise Broken(f"{result['name']} compares nothing")
        lines += [row(result["title"], quantity) for quantity in result["quantities"]]
    lines.append("")
    for result in results:
        lines += section(result)
    return "\n".join(lines).rstrip() + "\n"


def load(folder, names):
    results = []
    for name in names:
        file = folder / f"{name}.json"
        if not file.exists():
            raise Broken(f"{file} is missing: run the long version of the case first")
        results.append(json.loads(file.read_text(encoding="utf-8")))
    return results


def case_names(cases):
    """The folders of `cases` that are cases, in order."""
    return sorted(file.parent.name for file in cases.glob("*/case.py"))


def listed(text):
    """The cases that the page `text` holds."""
    return [line[len(MARK):].removesuffix(" -->") for line in text.splitlines() if line.startswith(MARK)]


def copy_plots(results, source, target):
    """The plots of the page, and no others."""
    shutil.rmtree(target, ignore_errors=True)
    target.mkdir(parents=True)
    for result in results:
        for plot in result["plots"]:
            shutil.copyfile(source / plot["file"], target / plot["file"])


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", type=pathlib.Path, default=root / "build/verification")
    parser.add_argument("--cases", type=pathlib.Path, default=root / "tests/verification/cases")
    parser.add_argument("--docs", type=pathlib.Path, default=root / "docs")
    arguments = parser.parse_args()
    try:
        results = load(arguments.results, case_names(arguments.cases))
        text = page(results)
    except Broken as reason:
        sys.exit(f"report.py: {reason}")
    copy_plots(results, arguments.results, arguments.docs / "pictures/verification")
    (arguments.docs / "verification.md").write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
