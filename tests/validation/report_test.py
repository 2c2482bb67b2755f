#!/usr/bin/env python3
"""docs/validation.md is what report.py makes of the shipped records; films.py throws shadows and finds shifts as it
should."""

import pathlib
import re
import sys
import tempfile
import unittest

import numpy

FOLDER = pathlib.Path(__file__).resolve().parent
ROOT = FOLDER.parents[1]
sys.path.insert(0, str(FOLDER))
import comparison  # noqa: E402
import films  # noqa: E402
import report  # noqa: E402


class Committed(unittest.TestCase):
    def setUp(self):
        self.text = (ROOT / "docs/validation.md").read_text(encoding="utf-8")

    def test_the_page_is_that_of_the_records(self):
        made = report.page(report.judged(FOLDER / "cases", FOLDER / "results"))
        self.assertEqual(self.text, made, "run tests/validation/report.py")
        self.assertEqual(report.listed(self.text), report.case_names(FOLDER / "cases"))

    def test_pictures_are_those_of_the_page_and_small(self):
        folder = ROOT / "docs/pictures/validation"
        named = sorted(re.findall(r"\(pictures/validation/(.+?)\)", self.text))
        self.assertEqual(sorted(file.name for file in folder.iterdir()), named)
        for name in named:
            self.assertLess((folder / name).stat().st_size, 300_000, name)

    def test_every_record_has_a_date_and_a_commit(self):
        for file in (FOLDER / "results").glob("*.json"):
            for label, record in comparison.load(file).items():
                self.assertEqual(label, comparison.label_of(record), file.name)
                self.assertRegex(record["date"], r"^\d{4}-\d\d-\d\d \d\d:\d\d$")
                self.assertRegex(record["commit"], r"^[0-9a-f]{10}\+?$")

    def test_measured_points_state_their_source(self):
        for file in (FOLDER / "measured").glob("*.csv"):
            self.assertRegex(file.read_text(encoding="utf-8"), r"(?m)^# .*(github|doi|own computation)", file.name)


class SoftBall(unittest.TestCase):
    """What the case of the soft ball computes beside Hertz's theory."""
    ball = report.load_module(FOLDER / "cases", "hertz_ball")

    def test_without_the_correction_it_is_hertz(self):
        table = comparison.measured("hertz_impact")[0]
        window, travel = self.ball.hertz_window()
        for k, speed in enumerate(table["speed_m_per_s"]):
            force, time, way = self.ball.impact(speed, 0.0)
            self.assertAlmostEqual(force / table["largest_force_N"][k], 1.0, delta=1e-3)
            self.assertAlmostEqual(time / (window * table["deepest_m"][k] / speed), 1.0, delta=1e-3)
            self.assertAlmostEqual(way / (travel * table["deepest_m"][k]), 1.0, delta=1e-3)

    def test_a_narrow_contact_is_that_on_a_half_space(self):
        """The half-space gives way by 0.75 (1 - nu^2) F/(E a): of that, no more than a constant must be missing."""
        wide, narrow = self.ball.finite_size(0.1), self.ball.finite_size(0.02)
        self.assertLess(abs(narrow - wide), 1e-3 * 0.75 * (1.0 - self.ball.POISSON**2) / 0.02)
        self.assertAlmostEqual(wide, -0.35, delta=0.02)  # finite elements, with the pressure along the axis: -0.356


class MadeUp(comparison.Case):
    name, title, source, missing = "apple", "Apple", "made up", "Everything"

    def judge(self, records, sheet):
        for label, record in records.items():
            sheet.gate(f"height, {label}", record["error"], 0.1, note="coarse")
        sheet.say("It is small.")
        sheet.table(["a", "b"], [[1, 2]])


class Page(unittest.TestCase):
    def of(self, error):
        sheet = comparison.Sheet()
        MadeUp().judge({"one": {"error": error}}, sheet)
        return report.page([(MadeUp(), sheet, "")])

    def test_states_error_gate_and_outcome(self):
        self.assertIn("| Apple | height, one (coarse) | -0.09 | 0.1 | passed |", self.of(-0.09))
        self.assertIn("| Apple | height, one (coarse) | -0.11 | 0.1 | **missed** |", self.of(-0.11))
        self.assertIn("**missed**", self.of(float("nan")))

    def test_states_source_sentences_tables_and_what_is_missing(self):
        for piece in ("Source: made up.", "It is small.", "| 1 | 2 |", "**Missing:** everything.", "do not edit"):
            self.assertIn(piece, self.of(0.0))

    def test_a_case_that_compares_nothing_is_refused(self):
        with self.assertRaises(report.Broken):
            report.page([(MadeUp(), comparison.Sheet(), "")])

    def test_records_are_stored_taken_and_rounded(self):
        with tempfile.TemporaryDirectory() as name:
            new, old = pathlib.Path(name) / "new", pathlib.Path(name) / "old"
            early, late = {"date": "2026-01-01 09:30"}, {"date": "2026-01-01 10:00"}
            comparison.store(old / "apple.json", {"a": {"x": 1, **late}, "b": {"x": 2, **early}, "c": {"x": 3, **late}})
            fresh = comparison.rounded([3.1234567, float("nan")])
            comparison.store(new / "apple.json", {"b": {"x": fresh, **late}, "c": {"x": 4, **early}, "d": {"x": 5, **early}})
            self.assertEqual(report.take(new, old, ["apple", "pear"]), 1)
            self.assertEqual({label: record["x"] for label, record in comparison.load(old / "apple.json").items()},
                             {"a": 1, "b": [3.1235, None], "c": 3, "d": 5})

    def test_the_default_transfer_is_that_of_the_newest_program(self):
        records = {"a": {"transfer": "apic", "default_transfer": "apic", "date": "2026-01-01 00:00"},
                   "b": {"transfer": "other", "default_transfer": "other", "date": "2026-01-02 00:00"},
                   "c": {"transfer": "apic", "default_transfer": "other", "date": "2026-01-01 12:00"}}
        self.assertEqual(comparison.schemes_of(records), ["other", "apic"])


class Films(unittest.TestCase):
    def test_shadows_end_where_the_ray_from_the_eye_meets_the_floor(self):
        eye = numpy.array([0.3, -0.2, 0.4])
        points = numpy.random.default_rng(1).uniform(0.0, 0.1, (20, 3))
        thrown = films.shadow(points, eye)
        share = (points[:, 2] / (eye[2] - points[:, 2]))[:, None]  # from the point on, of the way from the eye to it
        numpy.testing.assert_allclose(numpy.c_[thrown, numpy.zeros(20)], points + share * (points - eye), atol=1e-15)

    def test_a_delayed_copy_of_a_film_is_found_by_its_shift_and_has_no_error(self):
        film = films.Film("chuno_sauce_H20_W30")
        late = {"time": [0.0, 0.017, *(film.time + 0.017)], "reach": [0.0, 0.0, *film.reach]}
        self.assertAlmostEqual(films.best_shift(film, late), 0.017, places=6)
        self.assertLess(films.errors(film, late, 0.017)[0], 1e-9)
        self.assertGreater(films.errors(film, late)[0], 0.05)

    def test_errors_are_signed_and_over_the_last_reach(self):
        film = films.Film("okonomiyaki_sauce_H46_W63")  # 18 frames, of which 3 to 8 count
        longer = {"time": film.time, "reach": film.reach + 0.1 * film.reach[7]}
        worst, last = films.errors(film, longer)
        self.assertAlmostEqual(worst, 0.1)
        self.assertAlmostEqual(last, 0.1)
        self.assertAlmostEqual(films.errors(film, {"time": film.time, "reach": 0.9 * film.reach})[1], -0.1)


if __name__ == "__main__":
    unittest.main()
