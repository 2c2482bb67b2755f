#!/usr/bin/env python3
"""The tool `fit-front` of the Python package: least squares against a model whose answer is known, wrong input, and a front
made by the solver with known parameters and noise, which must be found again within the errors that the tool states: yield
stress and consistency, with the index given; with --long all three, which takes four times as many runs."""

import json
import math
import pathlib
import re
import subprocess
import sys

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "drivers/python/bulkley"
sys.path.insert(0, str(ROOT / "tests/support"))
sys.path.insert(0, str(PACKAGE.parent))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from bulkley.fit_front import Front, flow_curve, read_front, report  # noqa: E402
from bulkley.history import read_history  # noqa: E402
from bulkley.least_squares import minimise, whitener  # noqa: E402

SCENE = pathlib.Path(__file__).with_name("fit_front.toml")
TRUTH = (5.0, 2.0, 0.5)  # yield stress, consistency, index in SCENE
EDGE = 0.03              # m, of the dam
SIGMA = 5e-4             # m, of the noise
SIGMAS = 3.0             # of the stated errors: how far the truth may be
FRONT = "time_s,reach_m,reach_sigma_m\n0.1,0.01,0.001\n0.2,0.02,0.001\n0.3,0.025,0.001\n"


def check_least_squares():
    """A straight line has a closed form; a curve is found from far away, and its errors are those of its derivatives."""
    x, sigma = np.linspace(0.0, 2.0, 12), 0.1
    noise = np.random.default_rng(3).normal(0.0, sigma, x.size)
    wide = np.full(2, 1e3)
    bounds = np.array([[-10.0, 10.0]] * 2)
    fit = minimise(lambda points: [(p[0] + p[1] * x - 1.0 - 3.0 * x - noise) / sigma for p in points], np.zeros(2), wide,
                   np.full(2, 0.1), bounds)
    matrix = np.column_stack([np.ones_like(x), x])
    exact, covariance = np.linalg.lstsq(matrix, 1.0 + 3.0 * x + noise,
                                        rcond=None)[0], np.linalg.inv(matrix.T @ matrix) * sigma**2
    if not (fit.converged and np.allclose(fit.point, exact, atol=2e-3)
            and np.allclose(fit.covariance, covariance, rtol=1e-3)):
        fail(f"a straight line: {fit.point} instead of {exact}, {fit.covariance} instead of {covariance}")
    fit = minimise(lambda points: [(np.exp(p[0] * x) * p[1] - 2.0 * np.exp(-1.5 * x)) / 0.01 for p in points],
                   np.array([1.0, 5.0]),
                   wide, np.full(2, 0.01), bounds, iterations=40)
    if not (fit.converged and np.allclose(fit.point, [-1.5, 2.0], atol=5e-3)):
        fail(f"an exponential: {fit.point} instead of (-1.5, 2)")
    fit = minimise(lambda points: [np.array([(p[0] - 1.0) / 0.5, (p[1] - p[0]**2) / 0.02]) for p in points], np.array([-1.0, 1.2]),
                   wide, np.full(2, 0.1), bounds, iterations=60)
    if not (fit.converged and fit.cost < 1.0 and abs(fit.point[0] - 1.0) < 2.0 * math.sqrt(fit.covariance[0, 0])):
        fail(f"a narrow bent valley: it stops at {fit.point} with {fit.cost}")
    fit = minimise(lambda points: [(p[0] - 20.0) / 0.1 * np.ones(3) for p in points], np.zeros(2), wide, np.full(2, 0.1),
                   bounds)
    if abs(fit.point[0] - 10.0) > 1e-12 or abs(fit.covariance[1, 1] / 1e6 - 1.0) > 1e-6:
        fail(f"a bound and a parameter without effect: {fit.point}, {fit.covariance}")


def check_whitener():
    """A shift of all points costs little where most of the variance is shared, and as much as that variance says."""
    sigma = np.array([1.0, 2.0, 3.0])
    if not np.allclose(whitener(sigma, 0.0), np.diag(1.0 / sigma)):
        fail("independent errors are divided by sigma")
    found = whitener(sigma, 0.96) @ sigma  # a miss of one sigma everywhere: 1/(0.96 + 0.04/3) of a unit
    if abs(found @ found - 1.0 / (0.96 + 0.04 / 3.0)) > 1e-12:
        fail(f"a shared error of one sigma has the cost {found @ found}")


class Line:
    """Stands for the tool's model: the point is the parameters."""
    runs = 0

    class options:
        fix, shift = [], 0.0

    class front:
        time = np.arange(5)

    @staticmethod
    def shift(point):
        return 0.0

    @staticmethod
    def flow(point):
        return tuple(np.exp(point))


def check_flow_curve():
    """The band of the stress at the rate 1 is that of tau_y + K, whatever the index."""
    class fit:
        point, covariance = np.log([3.0, 1.0, 0.5]), np.diag([0.04, 0.09, 4.0])
    stress, error = flow_curve(fit, Line, np.array([1.0]))
    if abs(stress[0] - 4.0) > 1e-12 or abs(error[0] - math.hypot(3.0 * 0.2, 1.0 * 0.3) / 4.0) > 1e-6:
        fail(f"flow curve: {stress} and {error}")


def check_report():
    """Parameters whose product alone is known are undetermined, each by itself and in the other combination."""
    class fit:
        point, cost, iterations, converged = np.log([3.0, 1.0, 0.5]), 2.0, 7, True
        covariance = np.array([[4.0, -4.0, 0.0], [-4.0, 4.01, 0.0], [0.0, 0.0, 1e-4]])
    said, numbers = report(fit, Line, Line.options, (1.0, 100.0))
    if said.count("**undetermined by itself**") != 2 or said.count("(**undetermined**)") != 1 or "quote the flow curve" not in said:
        fail(f"of parameters that depend on each other the report says {said}")
    if abs(numbers["combinations"][-1]["log_sigma"] - math.sqrt(8.0)) > 0.01:
        fail(f"the combinations are {numbers['combinations']}")


def tool(program, words, code=0):
    outcome = subprocess.run([sys.executable, str(PACKAGE), "fit-front", *map(str, words), "--program", program.path],
                             capture_output=True, text=True, timeout=500, check=False)
    if outcome.returncode != code:
        fail(f"fit-front {words} ended with {outcome.returncode}: {outcome.stdout}{outcome.stderr}")
    return outcome.stdout + outcome.stderr


def check_wrong_input(program, work):
    good, bad = work / "good.csv", work / "bad.csv"
    good.write_text("# made up\n" + FRONT)
    if not np.allclose(read_front(good).reach, [0.01, 0.02, 0.025]) or not isinstance(read_front(good), Front):
        fail("a good front is not read")
    for text, words in ((FRONT.replace("0.2,", "x,"), "line 3"), (FRONT.replace("0.2,", "0.05,"), "grow"),
                        (FRONT.replace("0.001\n0.2", "0\n0.2"), "line 2"), ("time_s,reach_m\n1,2\n", "reach_sigma_m"),
                        ("", "time_s")):
        bad.write_text(text)
        said = tool(program, [SCENE, bad, "--material", "paste"], 2)
        if words not in said or "Traceback" in said or said.count("\n") != 1 or "bad.csv" not in said:
            fail(f"of {text!r} it says {said!r}")
    for words, expected in ((["--material", "cream"], "no material 'cream'"),
                            (["--material", "paste", "--column", "way"], "no column 'way'"),
                            (["--material", "paste", "--set", "domain.cell_size=-1"], "cell_size"),
                            (["--material", "paste", "--shared", "1"], "--shared"),
                            (["--material", "paste", "--start", "1,2"], "--start")):
        said = tool(program, [SCENE, good, "--out", work / "wrong", *words], 2)
        if expected not in said or "Traceback" in said:
            fail(f"of {words} it says {said!r}")


def check_fit(program, work, long):
    """The front of a run with TRUTH, with noise, is fitted from far away."""
    finer = ("domain.cell_size=0.002", "domain.upper=[0.162,0.008,0.036]", "bodies.dam.shape.upper=[0.03,0.008,0.024]")
    setting = [word for key in finer for word in ("--set", key)] if long else []
    outcome = program.run(["run", str(SCENE), "--out", "truth", "--quiet", *setting], 1, work, 300)
    if outcome.code != 0:
        fail("the run of the truth", outcome)
    history = read_history(work / "truth/history.csv")
    times = np.arange(1, 16) * 0.025
    noise = np.random.default_rng(7).normal(0.0, SIGMA, times.size)
    reach = np.interp(times, history["time"], history["upper_x"]) - EDGE + noise
    rows = [f"{time:.5f},{value:.6f},{SIGMA}" for time, value in zip(times, reach)]
    (work / "front.csv").write_text("\n".join(["time_s,reach_m,reach_sigma_m", *rows]) + "\n")
    words = [SCENE, work / "front.csv", "--material", "paste", "--zero", EDGE, "--start", "4,3,0.5", "--jobs", 2, "--out",
             work / "fit", *setting, *([] if long else ["--fix", "flow_index"])]
    said = tool(program, words)
    print(said)
    found = json.loads((work / "fit/fit.json").read_text())
    if not found["converged"] or found["chi2"] > 3.0 * len(times):
        fail(f"the fit has not converged, or has chi-square {found['chi2']}")
    for name, truth in zip(("yield_stress", "consistency", "flow_index")[:3 if long else 2], TRUTH):
        value, sigma = found[name]["value"], found[name]["sigma"]
        if not abs(value - truth) <= SIGMAS * sigma:
            fail(f"{name} is {value} +- {sigma}, the truth {truth}")
    curve = {name: np.array(values) for name, values in found["flow_curve"].items()}
    miss = np.log(curve["stress"] / (TRUTH[0] + TRUTH[1] * curve["shear_rate"]**TRUTH[2]))
    if np.any(np.abs(miss) > SIGMAS * curve["log_sigma"]) or np.abs(miss).max() > 0.15 or curve["log_sigma"].min() > 0.05:
        fail(f"the flow curve is off by {miss}, one sigma {curve['log_sigma']}")
    for name in ("front.csv", "flow_curve.csv"):
        if np.loadtxt(work / "fit" / name, delimiter=",", skiprows=1).shape[1] != 4:
            fail(f"{name} has not four columns")
    if "flow curve" not in said.lower() or long and "undetermined" not in said:
        fail("yield stress, consistency and index of one front depend on each other: that must be said")
    again = tool(program, words)
    runs = re.search(r"^(\d+) runs", again, re.MULTILINE)
    if not runs or int(runs[1]) != 0 or json.loads((work / "fit/fit.json").read_text())["chi2"] != found["chi2"]:
        fail(f"a fit that is started again must use its runs: {again}")


def main():
    arguments = parse_arguments(__doc__, lambda parser: parser.add_argument("--long", action="store_true"))
    program, work = start(arguments)
    check_least_squares()
    check_whitener()
    check_flow_curve()
    check_report()
    check_wrong_input(program, work)
    check_fit(program, work, arguments.long)


if __name__ == "__main__":
    main()
