#!/usr/bin/env python3
"""Makes docs/verification.md from the results that the long versions of the verification cases leave in
build/verification. A case that has not been run anew keeps its part of the page, also if an older result of it is still there."""

import argparse
import json
import pathlib
import re
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
Sections say when a case was run, with which commit and, since 28 November 2026, on what. Fluids of cases with an earlier date than
1 December 2026 left voids at floors ([theory](theory.md#voids-at-floors)), which changes layers that come to rest by up to 2 %, their run-out by up to 4 % ([decision 013](decisions/013-voids-at-floors.md)), and
those with a yield stress sheared on sticky floors in whole cells, which makes as much ([decision 014](decisions/014-thin-shear-layers.md)). Commit 876382747c and earlier ones closed
more voids than there are: with them the layer on the incline moves by 2 % less on 2.7 mm.
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
             f"`tests/verification/cases/{result['name']}`. Truth: {result['truth']}. Run on {result['date']}, commit {result['commit']}" +
             (f", {result['machine']}." if "machine" in result else "."), ""]
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


def part(result):
    """What the page says of a case, of what study.py's `finish` wrote: the lines of its table, and those of its section."""
    if not result["quantities"]:
        raise Broken(f"{result['name']} compares nothing")
    return [row(result["title"], quantity) for quantity in result["quantities"]], section(result)


def parts_of(text):
    """The parts of the page `text`, by case."""
    table = [line for line in text.splitlines() if line.startswith("| ")]
    parts = {}
    for piece in text.split(MARK)[1:]:
        lines = (MARK + piece).rstrip().splitlines()
        title = lines[1].removeprefix("## ")
        parts[listed(lines[0])[0]] = [line for line in table if line.startswith(f"| {title} | ")], lines + [""]
    return parts


def date_of(part):
    """The day of the run that a part of the page is of."""
    found = re.search(r"\. Run on ([\d-]+), commit ", "\n".join(part[1]))
    return found[1] if found else ""


def page(parts):
    lines = [INTRODUCTION, "| Case | Quantity | Error | Order (least) | At most | |", "|---|---|---|---|---|---|"]
    for rows, _ in parts:
        lines += rows
    lines.append("")
    for _, text in parts:
        lines += text
    return "\n".join(lines).rstrip() + "\n"


def load(folder, names):
    """The results of those of the cases `names` that have been run, by name."""
    files = {name: folder / f"{name}.json" for name in names}
    return {name: json.loads(file.read_text(encoding="utf-8")) for name, file in files.items() if file.exists()}


def case_names(cases):
    """The folders of `cases` that are cases, in order."""
    return sorted(file.parent.name for file in cases.glob("*/case.py"))


def listed(text):
    """The cases that the page `text` holds."""
    return [line[len(MARK):].removesuffix(" -->") for line in text.splitlines() if line.startswith(MARK)]


def copy_plots(results, source, target, text):
    """The plots of the page `text`, and no others: those of `results` anew."""
    target.mkdir(parents=True, exist_ok=True)
    for result in results:
        for plot in result["plots"]:
            shutil.copyfile(source / plot["file"], target / plot["file"])
    for file in target.iterdir():
        if f"(pictures/verification/{file.name})" not in text:
            file.unlink()


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--results", type=pathlib.Path, default=root / "build/verification")
    parser.add_argument("--cases", type=pathlib.Path, default=root / "tests/verification/cases")
    parser.add_argument("--docs", type=pathlib.Path, default=root / "docs")
    arguments = parser.parse_args()
    target = arguments.docs / "verification.md"
    names = case_names(arguments.cases)
    try:
        parts = parts_of(target.read_text(encoding="utf-8")) if target.exists() else {}
        results = load(arguments.results, names)
        for name in [name for name in results if name in parts and results[name]["date"] < date_of(parts[name])]:
            print(f"report.py: left out: {arguments.results / name}.json, of {results[name]['date']}; the page has a younger run")
            del results[name]
        parts.update({name: part(result) for name, result in results.items()})
        for name in names:
            if name not in parts:
                raise Broken(f"{arguments.results / name}.json is missing: run the long version of the case first")
        text = page([parts[name] for name in names])
    except Broken as reason:
        sys.exit(f"report.py: {reason}")
    copy_plots(results.values(), arguments.results, arguments.docs / "pictures/verification", text)
    target.write_text(text, encoding="utf-8")


if __name__ == "__main__":
    main()
