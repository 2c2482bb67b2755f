#!/usr/bin/env python3
"""`bulkley rheometer` from the command line: every mode's table, pictures, the fit, and the sentences about bad input."""

import concurrent.futures
import csv
import io
import math
import os
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENE = """
[domain]
lower = [0.0, 0.0, 0.0]
upper = [0.4, 0.4, 0.4]
cell_size = 0.02
[time]
end = 0.1
{materials}
[[bodies]]
name = "ball"
material = "{material}"
shape = {{ type = "sphere", center = [0.2, 0.2, 0.2], radius = 0.06 }}
"""
MATERIALS = """
[materials.syrup]
law = "herschel_bulkley"
density = 1000
bulk_modulus = 1e5
shear_modulus = 1000
yield_stress = 0
consistency = 20
flow_index = 1
[materials.rubber]
law = "neo_hookean"
density = 1000
bulk_modulus = 1e6
shear_modulus = 2000
"""
PAGE = pathlib.Path(__file__).resolve().parents[2] / "docs" / "rheometer.md"
CREAM = ["--preset", "cream"]
MRF = ["--preset", "mrf_132dg"]
SYRUP = ["scene.toml", "--material", "syrup"]
RUBBER = ["scene.toml", "--material", "rubber"]

# arguments, columns that must be there, rows
TABLES = [
    (CREAM + ["--rates", "0.1:10:3"],
     "shear_rate shear_stress first_normal_stress_difference second_normal_stress_difference viscosity pressure strain "
     "steady analytic_stress small_strain_stress", 3),
    (CREAM + ["--mode", "extension", "--rates", "1,2"],
     "extension_rate tensile_stress extensional_viscosity pressure strain steady analytic_stress small_strain_stress", 2),
    (CREAM + ["--mode", "planar", "--rates", "1", "--strain", "0.5", "--points", "10"],
     "time extension_rate strain tensile_stress pressure", 11),
    (RUBBER + ["--mode", "extension"], "time extension_rate strain tensile_stress pressure analytic_stress", 201),
    (SYRUP + ["--mode", "startup", "--rates", "1,2", "--strain", "0.1", "--points", "10"],
     "time shear_rate strain shear_stress first_normal_stress_difference second_normal_stress_difference pressure "
     "analytic_stress", 22),
    (SYRUP + ["--mode", "relaxation", "--strain", "0.02", "--duration", "0.1", "--points", "20"],
     "time strain shear_stress relaxation_modulus first_normal_stress_difference pressure analytic_stress", 20),
    (SYRUP + ["--mode", "creep", "--stresses", "5,10", "--duration", "1", "--points", "20"],
     "time shear_stress strain shear_rate pressure analytic_strain analytic_steady_rate", 40),
    (RUBBER + ["--mode", "creep", "--stresses", "20", "--points", "5"],
     "time shear_stress strain shear_rate pressure analytic_strain", 5),
    (SYRUP + ["--mode", "oscillation", "--frequencies", "10,50", "--amplitudes", "0.001"],
     "angular_frequency strain_amplitude storage_modulus loss_modulus loss_angle complex_viscosity third_harmonic cycles "
     "steady analytic_storage_modulus analytic_loss_modulus", 2),
    (CREAM + ["--mode", "thixotropy", "--rates", "0.5,5,0", "--durations", "1,0.5,1", "--points", "10"],
     "time interval shear_rate strain shear_stress first_normal_stress_difference pressure analytic_steady_stress", 30),
    (MRF + ["--field", "80e3", "--rates", "0.1:10:2"],
     "shear_rate shear_stress first_normal_stress_difference second_normal_stress_difference viscosity pressure strain "
     "steady analytic_stress small_strain_stress magnetic_field_strength", 2),
    (MRF + ["--mode", "magnetic", "--fields", "0,18e3,80e3"],
     "magnetic_field_strength magnetisation yield_stress shear_rate shear_stress analytic_stress", 3),
]

# arguments, part of the sentence
REFUSED = [
    (CREAM + ["--mode", "shaer"], "--mode 'shaer': no such mode; did you mean 'shear'?"),
    (CREAM + ["--rates", "1:x:3"], "--rates '1:x:3': LOWER:UPPER:COUNT must be three numbers"),
    (CREAM + ["--rates", "0,1"], "--rates '0,1': 0 is not above 0"),
    (CREAM + ["--frequencies", "1"], "--frequencies: only with --mode oscillation"),
    (CREAM + ["--mode", "startup", "--strain", "-1"], "--strain '-1': not a number above 0"),
    (CREAM + ["--mode", "creep"], "--mode creep needs --stresses"),
    (CREAM + ["--mode", "thixotropy", "--rates", "1,2"], "thixotropy needs three numbers"),
    (CREAM + ["--pressure", "1e12"], "--pressure 1e+12: the material cannot take it"),
    (CREAM + ["--field", "1e4"], "--field: material 'cream' is not magnetic"),
    (CREAM + ["--mode", "magnetic"], "--mode magnetic: material 'cream' is not magnetic"),
    (MRF + ["--field", "-1"], "--field '-1': not a number of at least 0"),
    (MRF + ["--fields", "1e4"], "--fields: only with --mode magnetic"),
    (MRF + ["--mode", "magnetic", "--field", "1e4"], "--field: only with --mode shear, extension"),
    (MRF + ["--mode", "magnetic", "--rates", "1,2"], "--mode magnetic takes one rate"),
    (CREAM + ["--weights", "error"], "--weights: only with --fit"),
    (["--preset", "creme"], "--preset 'creme': no such preset; known: "),
    ([], "give a scene file and --material, or --preset, or --fit"),
    (["scene.toml"], "holds several materials; choose one with --material: 'syrup', 'rubber'"),
    (["scene.toml", "--material", "rubbr"], "--material 'rubbr': not in scene.toml; did you mean 'rubber'?"),
    (["missing.toml"], "missing.toml: cannot be opened"),
    (["--fit", "missing.csv"], "missing.csv: cannot be opened"),
    (["--fit", "curve.csv", "--preset", "cream"], "--preset: not with --fit"),
    (["--fit", "curve.csv", "--weights", "best"], "--weights 'best': must be relative, uniform or error"),
    (["--fit", "curve.csv", "--weights", "error"], "curve.csv: --weights error: the file has no column 'error'"),
    (["--fit", "curve.csv", "--range", "5"], "--range '5': not LOWER:UPPER"),
    (["--fit", "curve.csv", "--range", "900:1000"], "points within --range are too few to fit"),
    (["--fit", "curve.csv", "--fix", "yield=0"], "--fix 'yield=0': no such parameter"),
    (["--fit", "curve.csv", "--fix", "flow_index=9"], "flow_index must be between 0.1 and 3"),
    (["--fit", "letters.csv"], "letters.csv:3: stress 'many' is not a finite number"),
    (["--fit", "columns.csv"], "columns.csv:1: the header has no column 'shear_rate'"),
    (["--fit", "empty.csv"], "empty.csv: is empty"),
    (["--fit", "three.csv"], "three.csv: 3 points are too few to fit; at least 4 are needed"),
]


def curve(rates):
    lines = [f"{rate:.6g},{5.0 + 8.0 * math.sqrt(rate):.8g}" for rate in rates]
    return "shear_rate,stress\n" + "\n".join(lines) + "\n"


def write_inputs(work):
    files = {
        "scene.toml": SCENE.format(materials=MATERIALS, material="syrup"),
        "curve.csv": curve([10 ** (k / 4) for k in range(-8, 9)]),
        "letters.csv": "shear_rate,stress\n1,2\n2,many\n",
        "columns.csv": "rate,stress\n1,2\n",
        "empty.csv": "",
        "three.csv": curve([1, 2, 3]),
    }
    for name, text in files.items():
        (work / name).write_text(text, encoding="utf-8")


def is_picture(path):
    return path.exists() and path.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n" and path.stat().st_size > 5000


def main():
    program, work = start(parse_arguments(__doc__))
    write_inputs(work)

    def rheometer(*arguments, code=0):
        outcome = program.run(["rheometer", *arguments], 1, work, 60)
        if outcome.code != code:
            fail(f"'bulkley rheometer {' '.join(arguments)}' ended with {outcome.code} instead of {code}", outcome)
        return outcome

    def measures(number):
        arguments, columns, n_rows = TABLES[number]
        table, picture = work / "out" / f"{number}.csv", work / "out" / f"{number}.png"
        rheometer(*arguments, "--out", str(table), "--plot", str(picture))
        rows = list(csv.DictReader(io.StringIO(table.read_text(encoding="utf-8"))))
        if list(rows[0]) != columns.split() or len(rows) != n_rows:
            fail(f"{arguments}: columns {list(rows[0])}, {len(rows)} rows")
        values = [float(value) for row in rows for value in row.values()]
        if "thixotropy" not in arguments and not all(map(math.isfinite, values)):  # there is no steady flow at rest
            fail(f"{arguments}: a value is not finite")
        if rows[0].get("steady", "1") != "1":
            fail(f"{arguments}: not steady")
        if not is_picture(picture):
            fail(f"{arguments}: no picture")

    def refuses(case):
        arguments, sentence = case
        outcome = rheometer(*arguments, code=2)
        if sentence not in outcome.text or outcome.text.strip().count("\n") > 0:
            fail(f"{arguments}: expected the sentence '{sentence}' alone", outcome)

    with concurrent.futures.ThreadPoolExecutor(2) as pool:  # mostly the starting of programs
        list(pool.map(measures, range(len(TABLES))))
        list(pool.map(refuses, REFUSED))
    if list((work / "out").glob("*.part.csv")):
        fail("a passing file was left")

    page = PAGE.read_text(encoding="utf-8")
    if missing := {c for _, columns, _ in TABLES for c in columns.split() if f"`{c}`" not in page}:
        fail(f"docs/rheometer.md does not explain these columns: {missing}")

    # On two ranks one of them measures, and without --out it prints.
    two = program.run(["rheometer", *TABLES[0][0]], 2, work, 60)
    if two.code != 0 or two.text != (work / "out" / "0.csv").read_text(encoding="utf-8"):
        fail("two ranks print something else than one wrote", two)

    # The fit, and its snippet in a scene.
    printed = rheometer("--fit", "curve.csv", "--name", "sauce", "--out", "out/fit.csv", "--plot", "out/fit.png").text
    snippet = printed[printed.index("[materials.sauce]"):]
    for line in ("yield_stress = 5 ", "consistency = 8 ", "flow_index = 0.5\n"):
        if line not in snippet:
            fail(f"the fit did not find '{line}'")
    (work / "fitted.toml").write_text(SCENE.format(materials=snippet, material="sauce"), encoding="utf-8")
    check = program.run(["check", "fitted.toml"], 1, work, 60)
    if check.code != 0 or "yield_stress = 5 Pa" not in check.text:
        fail("the printed material does not fit into a scene", check)
    measured = rheometer("fitted.toml", "--rates", "1", "--out", "out/again.csv").text
    if not is_picture(work / "out" / "fit.png") or "1 rows" not in measured:
        fail("no picture of the fit, or no flow curve of the fitted material")
    again = list(csv.DictReader((work / "out" / "again.csv").open(encoding="utf-8")))[0]
    if abs(float(again["shear_stress"]) - 13.0) > 0.004 * 13.0:
        fail(f"the fitted material has the stress {again['shear_stress']} instead of 13 Pa at 1 1/s")

    # Without matplotlib the table is still there.
    os.environ["BULKLEY_PYTHON"] = "no_such_python"
    outcome = rheometer(*TABLES[0][0], "--out", "out/kept.csv", "--plot", "out/kept.png", code=3)
    if "no python3 with matplotlib was found" not in outcome.text or not (work / "out" / "kept.csv").exists():
        fail("no clear sentence, or no table, without matplotlib", outcome)


if __name__ == "__main__":
    main()
