#!/usr/bin/env python3
"""report.py makes the page of small made-up results; and docs/verification.md lists exactly the cases that there are."""

import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

FOLDER = pathlib.Path(__file__).resolve().parents[1]
ROOT = FOLDER.parents[1]
sys.path.insert(0, str(FOLDER))
import report  # noqa: E402


def made_up(name, **more):
    levels = [{"label": "4.00123", "value": 0.04, "error": 0.04}, {"label": "8", "value": 0.01, "error": 0.01}]
    converging = {"quantity": "height", "unit": "", "levels": levels, "truth": None, "tolerance": 0.02, "relative": True,
                  "order": 2.0, "least_order": 1.5, "note": "", "passed": True}
    single = {"quantity": "speed", "unit": "m/s", "levels": [{"label": "", "value": 2.5, "error": 0.25}], "truth": 2.0,
              "tolerance": 0.1, "relative": True, "order": None, "least_order": None, "note": "coarse only", "passed": False}
    return {"name": name, "title": name.capitalize(), "truth": "made up", "quantities": [converging, single],
            "remarks": ["It is small."], "plots": [{"file": f"{name}.png", "caption": "A plot."}], "date": "2026-01-02",
            "commit": "0123456789", **more}


def page(*results):
    return report.page([report.part(result) for result in results])


class Page(unittest.TestCase):
    def test_rows_state_error_order_gate_and_outcome(self):
        text = page(made_up("apple"))
        self.assertIn("| Apple | height | 4: 0.04, 8: 0.01 | 2.00 (1.5) | 0.02 | passed |", text)
        self.assertIn("| Apple | speed | 0.25 |  | 0.1 | **FAILED** |", text)

    def test_sections_state_truth_values_notes_remarks_and_plots(self):
        text = page(made_up("apple"))
        for piece in ("Truth: made up.", "speed: 2.5 against 2 m/s.", "speed: coarse only.", "It is small.",
                      "![A plot.](pictures/verification/apple.png)", "do not edit"):
            self.assertIn(piece, text)

    def test_units_of_absolute_errors_are_printed(self):
        result = made_up("apple")
        result["quantities"][0].update(unit="mm")
        self.assertIn("| 4: 0.04 mm, 8: 0.01 mm | 2.00 (1.5) | 0.02 mm |", page(result))

    def test_a_case_that_compares_nothing_is_refused(self):
        with self.assertRaises(report.Broken):
            page(made_up("apple", quantities=[]))

    def test_the_listed_cases_are_those_of_the_page(self):
        self.assertEqual(report.listed(page(made_up("apple"), made_up("pear"))), ["apple", "pear"])


class Script(unittest.TestCase):
    def run_report(self, folder, names, results):
        for name in names:
            (folder / "cases" / name).mkdir(parents=True)
            (folder / "cases" / name / "case.py").touch()
        for sub in ("results", "docs/pictures/verification"):
            (folder / sub).mkdir(parents=True)
        (folder / "docs/pictures/verification/old.png").touch()
        for name in results:
            (folder / "results" / f"{name}.json").write_text(json.dumps(made_up(name)))
            (folder / "results" / f"{name}.png").write_bytes(b"picture")
        return subprocess.run([sys.executable, FOLDER / "report.py", "--results", folder / "results", "--cases", folder / "cases",
                               "--docs", folder / "docs"], capture_output=True, text=True)

    def test_writes_the_page_and_its_plots_only(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            outcome = self.run_report(folder, ["pear", "apple"], ["pear", "apple", "plum"])
            self.assertEqual(outcome.returncode, 0, outcome.stderr)
            self.assertEqual(report.listed((folder / "docs/verification.md").read_text()), ["apple", "pear"])
            pictures = sorted(file.name for file in (folder / "docs/pictures/verification").iterdir())
            self.assertEqual(pictures, ["apple.png", "pear.png"])

    def test_a_case_that_was_not_run_anew_keeps_its_part(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            self.run_report(folder, ["apple", "pear"], ["apple", "pear"])
            before = (folder / "docs/verification.md").read_text()
            (folder / "results/pear.json").unlink()
            (folder / "results/apple.json").write_text(json.dumps(made_up("apple", remarks=["It is large."])))
            command = [sys.executable, FOLDER / "report.py", "--results", folder / "results", "--cases", folder / "cases", "--docs", folder / "docs"]
            subprocess.run(command, check=True)
            after = (folder / "docs/verification.md").read_text()
            pear = before.index("<!-- generated: case pear")
            self.assertEqual(after, before[:pear].replace("It is small.", "It is large.") + before[pear:])
            self.assertTrue((folder / "docs/pictures/verification/pear.png").exists())

            (folder / "results/apple.json").write_text(json.dumps(made_up("apple", date="2026-01-01")))
            older = subprocess.run(command, check=True, capture_output=True, text=True)
            self.assertIn("apple.json, of 2026-01-01; the page has a younger run", older.stdout)
            self.assertEqual((folder / "docs/verification.md").read_text(), after)

    def test_a_case_without_results_is_named(self):
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            outcome = self.run_report(folder, ["apple", "pear"], ["apple"])
            self.assertNotEqual(outcome.returncode, 0)
            self.assertIn("pear.json is missing", outcome.stderr)
            self.assertFalse((folder / "docs/verification.md").exists())


class Committed(unittest.TestCase):
    def setUp(self):
        self.text = (ROOT / "docs/verification.md").read_text(encoding="utf-8")

    def test_lists_exactly_the_cases(self):
        self.assertEqual(report.listed(self.text), report.case_names(FOLDER / "cases"), "run cluster/verify.sh")

    def test_pictures_are_those_of_the_page_and_small(self):
        folder = ROOT / "docs/pictures/verification"
        named = sorted(re.findall(r"\(pictures/verification/(.+?)\)", self.text))
        self.assertEqual(sorted(file.name for file in folder.iterdir()), named)
        for name in named:
            self.assertLess((folder / name).stat().st_size, 100_000, name)


if __name__ == "__main__":
    unittest.main()
