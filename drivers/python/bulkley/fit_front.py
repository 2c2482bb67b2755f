"""Finds the flow curve of a fluid from a front that was filmed, by running the solver.

    python3 -m bulkley fit-front SCENE.toml FRONT.csv --material sauce --column upper_x --zero 0.03

SCENE is the experiment with any flow parameters; its material has law "herschel_bulkley" with yield_stress, consistency and
flow_index. FRONT has the columns time_s, reach_m, reach_sigma_m (one sigma); lines that begin with # are comments. The
reach of a run is a column of its history.csv less --zero. docs/fit-from-video.md explains the method and the output:

    OUT/fit.json, OUT/front.csv, OUT/flow_curve.csv, OUT/fit.png    parameters with errors, fronts, flow curve with its band
    OUT/run_*                                                       the runs; a fit that is started again uses them again

Needs numpy; h5py for the shear rates that the flow visits, else give --rates; matplotlib for the picture. Exit code 2: bad
input.
"""

import argparse
import concurrent.futures
import csv
import dataclasses
import hashlib
import json
import math
import os
import pathlib
import shlex
import subprocess
import sys
import tomllib

import numpy as np

from bulkley.faults import DataError
from bulkley.history import read_history
from bulkley.least_squares import Fit, minimise, whitener
from bulkley.markdown import markdown
from bulkley.places import BUILT

FLOW = ("yield_stress", "consistency", "flow_index")
UNITS = {"yield_stress": "Pa", "consistency": "Pa s^n", "flow_index": ""}
# What is fitted: the yield stress over the stress at REFERENCE, the logarithms of that stress and of the index, the shift of
# time over its prior. These hardly depend on each other, and a yield stress of 0 is nothing special.
REFERENCE = 10.0                                    # 1/s
PRIOR = (0.5, 2.5, 0.7)                             # how far data may carry each from its start with little resistance
STEP = (0.08, 0.08, 0.12)                           # of the finite differences
BOUNDS = ((0.0, 0.97), (math.log(1e-4), math.log(1e5)), (math.log(0.12), math.log(2.5)))
FIXED = 1e-6          # prior of what is not fitted
UNDETERMINED = 0.5    # standard deviation of a logarithm: a factor of 1.65 up and down
SHEAR_SHARE = 0.05    # of all shear: below the lower and above the upper end of the visited rates
RATE_FRAMES = 24      # frames that the visited rates are taken from


@dataclasses.dataclass
class Front:
    """The measured front: (n,) each, s and m."""
    time: np.ndarray
    reach: np.ndarray
    sigma: np.ndarray


def read_front(path) -> Front:
    """Reads FRONT.csv. Raises DataError."""
    columns = ("time_s", "reach_m", "reach_sigma_m")
    try:
        lines = [(number, line) for number, line in enumerate(pathlib.Path(path).read_text(encoding="utf-8").splitlines(), 1)
                 if line.strip() and not line.startswith("#")]
    except (OSError, UnicodeDecodeError) as error:
        raise DataError(f"cannot read '{path}': {error}") from None
    header = [name.strip() for name in lines[0][1].split(",")] if lines else []
    for name in columns:
        if name not in header:
            raise DataError(f"'{path}' has no column {name}: it must have {', '.join(columns)}")
    rows = []
    for number, line in lines[1:]:
        row = dict(zip(header, next(csv.reader([line]))))
        try:
            rows.append([float(row[name]) for name in columns])
        except (KeyError, ValueError):
            raise DataError(f"'{path}', line {number}: {', '.join(columns)} must be numbers") from None
        if not all(map(math.isfinite, rows[-1])) or rows[-1][2] <= 0.0 or rows[-1][0] < 0.0:
            raise DataError(f"'{path}', line {number}: time_s must be >= 0 and reach_sigma_m > 0, both finite")
        if len(rows) > 1 and rows[-1][0] <= rows[-2][0]:
            raise DataError(f"'{path}', line {number}: time_s must grow from row to row")
    if len(rows) < 3:
        raise DataError(f"'{path}' has {len(rows)} points; a fit needs at least 3")
    return Front(*np.array(rows).T)


class Model:
    """Runs of the solver for points of the fit."""

    def __init__(self, options, front):
        self.options, self.front = options, front
        try:
            text = options.scene.read_text(encoding="utf-8")
            scene = tomllib.loads(text)
        except (OSError, ValueError) as error:
            raise DataError(f"cannot read '{options.scene}': {error}") from None
        if options.material not in scene.get("materials", {}):
            raise DataError(f"'{options.scene}' has no material '{options.material}'")
        # The program resolves paths of the scene from the scene's folder, so that the scene is run where it is.
        self.end = float(front.time[-1]) + 3.0 * options.shift
        self.identity = repr((text, sorted(options.set), self.end))
        self.whitener = whitener(front.sigma, options.shared)
        self.curves = {}  # flow parameters: (time, reach)
        self.runs = 0

    def command(self, flow, folder, more=()):
        material = f"materials.{self.options.material}"
        sets = {f"{material}.{name}": f"{value!r}" for name, value in zip(FLOW, flow)}
        sets |= {"time.end": repr(self.end), "output.frame_interval": "0", "checkpoint.at_end": "false"}
        words = [*shlex.split(self.options.program), "run", str(self.options.scene), "--out", str(folder), "--overwrite", "--quiet"]
        for entry in [*(f"{key}={value}" for key, value in sets.items()), *self.options.set, *more]:
            words += ["--set", entry]
        return words

    def folder(self, flow):
        return self.options.out / f"run_{hashlib.sha256(repr((self.identity, flow)).encode()).hexdigest()[:16]}"

    def execute(self, words):
        outcome = subprocess.run(words, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                 text=True,
                                 errors="replace", check=False)
        if outcome.returncode != 0:
            said = [line for line in outcome.stdout.splitlines() if line.strip()]
            raise DataError(f"'{shlex.join(words)}' ended with {outcome.returncode}: "
                            f"{said[-1] if said else 'it said nothing'}")

    def run(self, flow, folder, more=()):
        """Makes a run, unless an earlier fit has finished it."""
        try:
            if json.loads((folder / "status.json").read_text(encoding="utf-8"))["state"] == "finished":
                return
        except (OSError, ValueError, KeyError):
            pass
        self.execute(self.command(flow, folder, more))
        self.runs += 1

    def curve(self, flow):
        """Times and reach of the run with flow parameters."""
        folder = self.folder(flow)
        self.run(flow, folder)
        history = read_history(folder / "history.csv")
        return history["time"], history[self.options.column] - self.options.zero

    def prepare(self, flows):
        """Makes the runs that have not been made, several at a time."""
        missing = [flow for flow in dict.fromkeys(flows) if flow not in self.curves]
        with concurrent.futures.ThreadPoolExecutor(self.options.jobs) as pool:
            self.curves |= dict(zip(missing, pool.map(self.curve, missing)))

    def flow(self, point):
        """Yield stress, consistency and index of a point, rounded so that equal runs are found again."""
        share, stress, index = float(point[0]), math.exp(point[1]), math.exp(point[2])
        tau = self.options.start[0] if "yield_stress" in self.options.fix else share * stress
        return tuple(float(f"{value:.9g}") for value in (tau, max(stress - tau, 1e-3 * stress) / REFERENCE**index, index))

    def reach(self, point):
        """Reach (n,) at the front's times."""
        time, reach = self.curves[self.flow(point)]
        return np.interp(self.front.time + self.shift(point), time, reach)

    def shift(self, point):
        """s, by which the run is ahead of the film's clock."""
        return float(point[3]) * self.options.shift if len(point) > 3 else 0.0

    def residuals(self, points):
        self.prepare([self.flow(point) for point in points])
        return [self.whitener @ (self.reach(point) - self.front.reach) for point in points]

    def visited_rates(self, flow):
        """(low, high), 1/s: the ends of the rates between which all shear happens, but for SHEAR_SHARE at either end."""
        try:
            from bulkley.run_folder import open_run
            folder = pathlib.Path(f"{self.folder(flow)}_rates")
            self.run(flow, folder, [f"output.frame_interval={self.end / RATE_FRAMES!r}", 'output.fields=["plastic_shear_rate"]'])
            rates = np.concatenate([frame["plastic_shear_rate"] for frame in open_run(folder).frames])
        except (ImportError, DataError) as error:
            raise DataError(f"the shear rates that the flow visits are not known ({error}): give --rates LOW,HIGH") from None
        rates = np.sort(rates[rates > 0.0].astype(float))
        if not len(rates):
            raise DataError("nothing flows in the run of the fit: give --rates LOW,HIGH")
        share = np.cumsum(rates) / np.sum(rates)  # the shear of a particle is in proportion to its rate
        return float(rates[np.searchsorted(share, SHEAR_SHARE)]), float(rates[np.searchsorted(share, 1.0 - SHEAR_SHARE)])


# --- what the fit says -----------------------------------------------------------------------------------------------------

def spread(fit: Fit, quantity) -> np.ndarray:
    """(k, k): covariance of `quantity(point)`, (k,), by its differences at the fit's point."""
    slopes = []
    for axis in np.eye(len(fit.point)):
        low, high = fit.point - 1e-4 * axis, fit.point + 1e-4 * axis
        slopes.append((np.asarray(quantity(high)) - np.asarray(quantity(low))) / 2e-4)
    return np.transpose(slopes) @ fit.covariance @ np.array(slopes)


def flow_curve(fit: Fit, model: Model, rates: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Stress (n,), Pa, at shear rates (n,), 1/s, and the standard deviation of its logarithm (n,)."""
    def stress(point):
        tau, consistency, index = model.flow(point)
        return tau + consistency * rates**index
    return stress(fit.point), np.sqrt(np.diag(spread(fit, lambda point: np.log(stress(point)))))


def directions(fit: Fit, model: Model) -> list[tuple[float, str]]:
    """(standard deviation of its logarithm, text) of the independent combinations of the parameters, the best first; without
    the yield stress if that is hardly there, and without what is fixed."""
    names = [name for name, value in zip(FLOW, model.flow(fit.point)) if name not in model.options.fix and value > 1e-4]
    rows = [FLOW.index(name) for name in names]
    values, vectors = np.linalg.eigh(spread(fit, lambda point: np.log(np.maximum(model.flow(point), 1e-9))[rows]))
    found = []
    for value, vector in zip(values, vectors.T):
        vector = vector * np.sign(vector[np.argmax(np.abs(vector))])
        found.append((math.sqrt(max(value, 0.0)), " ".join(f"{name}^{power:.2f}" for name, power in zip(names, vector)
                                                            if abs(power) >= 0.05)))
    return found


def report(fit, model, options, rates):
    """The text of the fit, and its numbers for fit.json."""
    n_points, n_free = len(model.front.time), len(fit.point) - len(options.fix)
    misfit = fit.cost / max(1, n_points - n_free)
    flow = model.flow(fit.point)
    errors = np.sqrt(np.diag(spread(fit, model.flow)))
    rows, numbers = [], {}
    for name, value, error in zip(FLOW, flow, errors):
        held, loose = name in options.fix, error > UNDETERMINED * value
        rows.append([name, f"{value:.4g} {UNITS[name]}".strip(), "given" if held else f"{error:.2g} {UNITS[name]}".strip(),
                     "" if held else ("**undetermined by itself**" if loose else "determined")])
        numbers[name] = {"value": value, "sigma": 0.0 if held else float(error)}
    shift = model.shift(fit.point)
    if options.shift:
        late = math.sqrt(fit.covariance[3, 3]) * options.shift
        rows.append(["shift of time", f"{1e3 * shift:.1f} ms", f"{1e3 * late:.1f} ms", ""])
        numbers["shift"] = {"value": shift, "sigma": late}
    text = [f"{model.runs} runs, {fit.iterations} iterations, " + ("converged" if fit.converged else "**not converged**")
            + f". Chi-square {fit.cost:.3g} for {n_points} points and {n_free} parameters"
            + (f"; errors are enlarged by its root, {math.sqrt(misfit):.2f}." if misfit > 1.0 else "."),
            markdown(["parameter", "value", "one sigma", ""], rows)]
    combinations = directions(fit, model)
    text.append("Independent combinations of the parameters and one sigma of each, as a factor: "
                + "; ".join(f"{name}: {math.exp(min(sigma, 20.0)):.3g}" + (" (**undetermined**)"
                                                                           if sigma > UNDETERMINED else "")
                            for sigma, name in combinations)
                + (". Do not quote the parameters one by one, quote the flow curve."
                   if combinations[-1][0] > UNDETERMINED else "."))
    grid = np.geomspace(*rates, 9)
    stress, error = flow_curve(fit, model, grid)
    text.append(f"Flow curve over the rates that the flow visits, {rates[0]:.3g} to {rates[1]:.3g} 1/s:")
    text.append(markdown(["shear rate [1/s]", "stress [Pa]", "one sigma"],
                         [[f"{rate:.3g}", f"{value:.4g}", f"{100 * sigma:.1f} %"] for rate, value,
                          sigma in zip(grid, stress, error)]))
    numbers |= {"chi2": fit.cost, "points": n_points, "converged": fit.converged, "runs": model.runs, "rates": list(rates),
                "covariance": spread(fit, model.flow).tolist(),
                "combinations": [{"log_sigma": sigma, "combination": name} for sigma, name in combinations],
                "flow_curve": {"shear_rate": grid.tolist(), "stress": stress.tolist(), "log_sigma": error.tolist()}}
    return "\n\n".join(text), numbers


def write(fit, model, options, rates, numbers):
    """fit.json, front.csv, flow_curve.csv and, with matplotlib, fit.png."""
    (options.out / "fit.json").write_text(json.dumps(numbers, indent=1) + "\n", encoding="utf-8")
    front, fitted = model.front, model.reach(fit.point)
    grid = np.geomspace(*rates, 41)
    stress, error = flow_curve(fit, model, grid)
    for name, header, columns in (("front", "time_s,reach_m,reach_sigma_m,fitted_reach_m",
                                   (front.time, front.reach, front.sigma, fitted)),
                                  ("flow_curve", "shear_rate_1_per_s,stress_Pa,low_Pa,high_Pa",
                                   (grid, stress, stress * np.exp(-error), stress * np.exp(error)))):
        np.savetxt(options.out / f"{name}.csv", np.column_stack(columns), fmt="%.6g", delimiter=",", header=header,
                   comments="")
    try:
        import matplotlib
    except ImportError:
        return
    matplotlib.use("Agg")
    from matplotlib import pyplot
    figure, (left, right) = pyplot.subplots(1, 2, figsize=(10, 4), layout="constrained")
    left.errorbar(front.time, front.reach, front.sigma, fmt="ko", ms=4, capsize=2, label="measured")
    time, reach = model.curves[model.flow(fit.point)]
    shown = time >= model.shift(fit.point)
    left.plot(time[shown] - model.shift(fit.point), reach[shown], "C0", label="fit")
    left.set(xlabel="time [s]", ylabel="reach [m]")
    left.legend(frameon=False)
    right.fill_between(grid, stress * np.exp(-2 * error), stress * np.exp(2 * error), color="C0", alpha=0.15, lw=0)
    right.fill_between(grid, stress * np.exp(-error), stress * np.exp(error), color="C0", alpha=0.25, lw=0)
    right.loglog(grid, stress, "C0")
    right.set(xlabel="shear rate [1/s]", ylabel="stress [Pa], bands of 1 and 2 sigma")
    figure.savefig(options.out / "fit.png", dpi=100)


# --- command line ----------------------------------------------------------------------------------------------------------

def numbers_of(n):
    def parse(text):
        values = tuple(float(part) for part in text.split(","))
        if len(values) != n or not all(value > 0.0 and math.isfinite(value) for value in values):
            raise argparse.ArgumentTypeError(f"'{text}' must be {n} numbers above 0, with commas between them")
        return values
    return parse


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("scene", type=pathlib.Path, metavar="SCENE.toml")
    parser.add_argument("front", type=pathlib.Path, metavar="FRONT.csv")
    parser.add_argument("--material", required=True, help="name of the material in the scene")
    parser.add_argument("--column", default="upper_x", help="column of history.csv, without its unit; default: %(default)s")
    parser.add_argument("--zero", type=float, default=0.0, metavar="M", help="what is taken off that column")
    parser.add_argument("--start", type=numbers_of(3), default=(5.0, 5.0, 0.6), metavar="TAU_Y,K,N", help="default: 5,5,0.6")
    parser.add_argument("--fix", action="append", default=[], choices=("yield_stress", "flow_index"),
                        help="keep this one at its start; may be repeated")
    parser.add_argument("--shift", type=float, default=0.0, metavar="S",
                        help="fit a shift of time too, 0 give or take so much (one sigma): of a gate that takes time")
    parser.add_argument("--shared", type=float, default=0.0, metavar="PART",
                        help="part of the variance of the points, 0 to 0.99, that "
                        "is one error common to all, such as that of the scale")
    parser.add_argument("--rates", type=numbers_of(2), metavar="LOW,HIGH",
                        help="shear rates of the flow curve, 1/s; default: those visited")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="for every run, as of bulkley run")
    parser.add_argument("--jobs", type=int, default=min(4, os.cpu_count() or 1), help="runs at a time; default: %(default)s")
    parser.add_argument("--iterations", type=int, default=15, help="at most, in each descent; default: %(default)s")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/fit_front"), help="default: %(default)s")
    parser.add_argument("--program", default=os.environ.get("BULKLEY", str(BUILT) if BUILT.is_file() else "bulkley"),
                        help="the program, or a command that starts it, such as 'mpirun -n 4 build/bulkley'")
    options = parser.parse_args()
    if not 0.0 <= options.shared <= 0.99:
        parser.error(f"--shared is {options.shared:g} and must be from 0 to 0.99")
    if options.shift < 0.0 or options.jobs < 1 or options.iterations < 1:
        parser.error("--shift must be at least 0, --jobs and --iterations at least 1")
    if not 0.12 <= options.start[2] <= 2.5:
        parser.error(f"--start: the index is {options.start[2]:g} and must be from 0.12 to 2.5")
    return options


def fit_front(options):
    """Runs the fit; returns the text of its report."""
    model = Model(options, read_front(options.front))
    options.out.mkdir(parents=True, exist_ok=True)
    tau, consistency, index = options.start
    stress = tau + consistency * REFERENCE**index
    start = np.array([tau / stress, math.log(stress), math.log(index)])
    held = np.array(["yield_stress" in options.fix, False, "flow_index" in options.fix])
    prior, step, bounds = np.where(held, FIXED, PRIOR), np.array(STEP), np.array(BOUNDS)
    if options.shift:
        start, prior, step = np.append(start, 0.0), np.append(prior, 1.0), np.append(step, 0.2)
        bounds = np.vstack([bounds, [-3.0, 3.0]])

    def tell(iteration, point, cost):
        values = ", ".join(f"{name} {value:.4g} {UNITS[name]}".strip() for name, value in zip(FLOW, model.flow(point)))
        print(f"iteration {iteration}: {values}, shift {1e3 * model.shift(point):.1f} ms: chi-square {cost:.4g} "
              f"({model.runs} runs)", flush=True)

    fit = minimise(model.residuals, start, prior, step, bounds, iterations=options.iterations, tell=tell)
    n_free = len(fit.point) - len(options.fix)
    fit.covariance *= max(1.0, fit.cost / max(1, len(model.front.time) - n_free))
    rates = options.rates or model.visited_rates(model.flow(fit.point))
    text, numbers = report(fit, model, options, rates)
    write(fit, model, options, rates, numbers)
    return text


def main():
    try:
        print("\n" + fit_front(parse_arguments()))
    except DataError as error:
        print(f"fit-front: {error}", file=sys.stderr)
        sys.exit(2)


if __name__ == "__main__":
    main()
