"""What the adaptive time step gains: every figure with fixed and with adaptive steps, as tables in Markdown.

    python3 -m bulkley adaptive-gain [--figures 1,8-pie] [--size small|default] [--ranks 2] [--out DIR]

Each figure runs with: the report's fixed step (1e-4 s at cells of 25 mm, scaled with the cell); the fixed step that keeps
within our limits throughout; the largest fixed step that is stable, found by bisection; the adaptive step with the
report's factors (0.1 of the elastic limit, 0.5 of a cell), with the program's default (0.4), and as the scene has it. Runs
that are in --out already are not repeated. What the tables mean: docs/adaptive-step.md. Needs numpy and h5py.
"""

import argparse
import dataclasses
import json
import math
import os
import pathlib
import subprocess
import sys
import tomllib

import numpy as np

from bulkley.markdown import markdown
from bulkley.pieces import cell_keys, cells_of, pieces
from bulkley.places import BUILT
from bulkley.run_folder import EndedRun

SHARED = pathlib.Path(__file__).resolve().parents[2]  # drivers, or share/bulkley where it is installed
SCENES = SHARED / "scenes"
REPORT_STEP, REPORT_CELL = 1e-4, 0.025  # s, m
REPORT_FACTORS = ["time.elastic_cfl=0.1", "time.cfl=0.5"]
DEFAULT_ELASTIC_CFL = 0.4  # of the program; safe for every spline
SMALL_CELL = 0.0125
# Other than the trial interval and no divisor of it: trials must be seen neither always nor never.
HISTORY_INTERVAL = 7
ENERGY_GROWTH = 0.01  # of the initial energy: the largest growth of a stable run
BISECTION = 1.06  # ratio of the smallest unstable to the largest stable step at which the search ends
SHAPE_CELLS = 2  # width in grid cells of the boxes that shapes are compared by

# Name: scene, and what differs from it.
FIGURES = {
    "1": ("figure_1_oobleck_bunny", []),
    "1-bouncing": ("figure_1_oobleck_bunny", ["materials.fluid.preset=bouncing_oobleck"]),
    "3": ("figure_3_spinning_body", []),
    "4": ("figure_4_elastic_bunny", []),
    "5": ("figure_5_pie_bunny", []),
    "6": ("figure_6_oobleck_dragon", []),
    "7": ("figure_7_cream_splash", []),
    "8": ("figure_8_colliding_balls", []),
    "8-pie": ("figure_8_colliding_balls", ["materials.fluid.preset=pie"]),
    "9": ("figure_9_rod", []),
}


# --- runs -----------------------------------------------------------------------------------------------------------------

@dataclasses.dataclass
class Outcome:
    """Result of a run. `fault` is empty if it reached its end with its energy in bounds; `processor_time`: s, of all ranks."""
    name: str
    folder: pathlib.Path
    fault: str
    processor_time: float


class Study:
    """Runs of one figure."""

    def __init__(self, figure, options):
        self.figure = figure
        self.options = options
        scene, self.settings = FIGURES[figure]
        self.scene = SCENES / f"{scene}.toml"
        self.settings = [*self.settings, *options.set]
        if options.size == "small":
            self.settings = [f"domain.cell_size={SMALL_CELL}", *self.settings]
        # Frames at the start and at the end only: no output shortens steps.
        self.settings += [f"output.history_interval={HISTORY_INTERVAL}",
                          f"output.frame_interval={self.number('time', 'end')}", 'output.fields=["velocity"]',
                          "checkpoint.at_end=false"]

    def run(self, name, settings):
        """The outcome of the figure's scene with `settings`, from its folder if it has run before."""
        folder = self.options.out / self.options.size / f"figure_{self.figure}" / name
        command = [*self.options.launcher, self.options.program, "run", str(self.scene), "--out", str(folder), "--overwrite",
                   "--quiet"]
        for setting in [*self.settings, *settings]:
            command += ["--set", setting]
        identity = json.dumps([*command, self.scene.read_text(encoding="utf-8")])
        log = folder / "gain.json"
        if self.options.dry_run:
            print(" ".join(command))
            return None
        if not (log.is_file() and json.loads(log.read_text(encoding="utf-8")).get("identity") == identity):
            begin = children_time()
            process = subprocess.run(command, stdin=subprocess.DEVNULL, capture_output=True, text=True, errors="replace",
                                     check=False)
            if process.returncode == 2:
                sys.exit(f"adaptive-gain: {process.stdout}{process.stderr}")
            fault = said(process.stderr) if process.returncode else ""
            folder.mkdir(parents=True, exist_ok=True)  # a step that is refused at once leaves none
            entry = {"identity": identity, "fault": fault, "processor_time": children_time() - begin}
            log.write_text(json.dumps(entry), encoding="utf-8")
        entry = json.loads(log.read_text(encoding="utf-8"))
        outcome = Outcome(name, folder, entry["fault"] or energy_fault(EndedRun(folder)), entry["processor_time"])
        print(f"figure {self.figure}, {name}: {outcome.fault or 'ended'}", file=sys.stderr, flush=True)
        return outcome

    def fixed(self, name, step, allow_unstable=True):
        allowed = str(allow_unstable).lower()
        return self.run(name, ["time.mode=fixed", f"time.dt={step:.6g}", f"time.allow_unstable={allowed}"])

    def number(self, table, key):
        """A number of the scene in effect."""
        for setting in reversed(self.settings):
            name, value = setting.split("=", 1)
            if name == f"{table}.{key}":
                return float(value)
        return tomllib.loads(self.scene.read_text(encoding="utf-8"))[table][key]


def children_time():
    """Processor time of the programs that have ended, s."""
    times = os.times()
    return times.children_user + times.children_system


def said(text):
    """What the program gave as the reason, without its warnings and the banner of mpirun."""
    lines = [line for line in text.splitlines() if line.strip("- ") and not line.startswith("warning")]
    return lines[0] if lines else "no reason given"


def energies(run):
    """Sum of all energies, including the dissipated one, and the initial energy: of motion, and of the fall to
    the floor."""
    history = run.history
    total = sum(history[f"{kind}_energy"] for kind in ("kinetic", "elastic", "gravitational", "dissipated"))
    fall = history["mass"][0] * max(run.gravity, 0.0) * (history["lower_z"][0] - run.floor)
    return total, history["kinetic_energy"][0] + fall


def energy_fault(run):
    total, at_hand = energies(run)
    growth = (np.nan_to_num(total, nan=math.inf).max() - total[0]) / at_hand
    return f"its energy grows by {100 * growth:.3g} %" if growth > ENERGY_GROWTH else ""


def largest_stable(study, stable, guess):
    """The run with the largest stable fixed step, between the step `stable` and the first failing one from `guess` on."""
    low, high = stable, guess
    best = None
    while True:
        outcome = study.fixed(f"fixed_{high:.4g}", high)
        if outcome.fault:
            break
        low, best, high = high, outcome, 1.5 * high
    while high / low > BISECTION:
        middle = math.sqrt(low * high)
        outcome = study.fixed(f"fixed_{middle:.4g}", middle)
        if outcome.fault:
            high = middle
        else:
            low, best = middle, outcome
    return best


# --- the report of a run --------------------------------------------------------------------------------------------------

def limits(run):
    """Each limit of (T26) on every row of the history, in s, by name."""
    history, time, dx = run.history, run.scene["time"], run.cell_size
    with np.errstate(divide="ignore"):
        return {"speed": time["cfl"] * dx / history["max_speed"],
                "elastic": time["elastic_cfl"] * dx / history["max_wave_speed"],
                "deformation": 0.8 * time["deformation_limit"] / history["max_velocity_gradient"]}


def smallest_stability_limit(run):
    """The fixed step that the program accepts throughout: what it checks are speed and waves."""
    found = limits(run)
    return min(found["speed"].min(), found["elastic"].min())


def wall_time(run):
    """s in steps."""
    history = run.history
    return float(np.sum(history["wall_time_per_step"][1:] * np.diff(history["step"])))


def limiter_shares(run):
    """What limited the steps, in percent, of the rows of the history."""
    names, counts = np.unique(run.history["limiter"][1:], return_counts=True)
    return {str(name): 100 * count / counts.sum() for name, count in sorted(zip(names, counts), key=lambda pair: -pair[1])}


def body_size(run):
    """Largest extent of the largest piece of the first frame, in m."""
    position = run.frames[0].positions
    return float(np.ptp(position[pieces(position, run.cell_size) == 0], axis=0).max())


def center_difference(run, reference):
    """Largest distance of the ways that the centres of mass have gone by the same time over the body's size, in percent."""
    def way(one, axis):
        path = one.history[f"center_of_mass_{axis}"]
        return path - path[0]

    then, times = run.history["time"], reference.history["time"]
    apart = [way(run, axis) - np.interp(then, times, way(reference, axis)) for axis in "xyz"]
    return 100 * float(np.sqrt(sum(part**2 for part in apart)).max()) / body_size(reference)


def shape_difference(run, reference):
    """Boxes that only one of the last frames occupies, over those that any does, in percent."""
    position = [one.frames[-1].positions for one in (run, reference)]
    keys, _ = cell_keys(cells_of(np.concatenate(position), SHAPE_CELLS * run.cell_size))
    first, second = (np.unique(part) for part in np.split(keys, [len(position[0])]))
    shared = len(np.intersect1d(first, second))
    either = len(first) + len(second) - shared
    return 100 * (either - shared) / either


def describe(name, run, reference, finer):
    """One row of the table of runs; differences from the smallest fixed step, and from the run on finer cells if there is
    one."""
    history = run.history
    return {"run": name, "steps": int(history["step"][-1]), "wall": wall_time(run),
            "step": (history["time"][-1] / history["step"][-1]), "trials": int(history["trials"][-1]),
            "rejected": int(history["rejected_steps"][-1]), "shares": limiter_shares(run),
            "center": center_difference(run, reference),
            "center_finer": center_difference(run, finer) if finer else None, "shape": shape_difference(run, reference),
            "energy": 100 * (energies(run)[0].max() - energies(run)[0][0]) / energies(run)[1]}


# --- a figure -------------------------------------------------------------------------------------------------------------

def study_figure(figure, options):
    """All runs of a figure; the rows of its table, and the limits over the run."""
    study = Study(figure, options)
    ours = study.run("ours", [])
    plain = study.run("program", [f"time.elastic_cfl={DEFAULT_ELASTIC_CFL}"])
    theirs = study.run("report", REPORT_FACTORS)
    reference = study.fixed("fixed_report", REPORT_STEP * study.number("domain", "cell_size") / REPORT_CELL)
    if options.dry_run:
        return None
    for outcome in (ours, plain, theirs, reference):
        if outcome.fault:
            sys.exit(f"adaptive-gain: figure {figure}, {outcome.name}: {outcome.fault}")
    adaptive = EndedRun(ours.folder)
    within, step = careful(study, adaptive)
    start = limits(adaptive)
    factors = adaptive.scene["time"]
    guess = min(start["elastic"][0] / factors["elastic_cfl"], start["speed"][0] / factors["cfl"])
    lucky = largest_stable(study, step, guess) or within
    finer = None
    if options.finer:
        finer = EndedRun(study.run("finer", [f"domain.cell_size={study.number('domain', 'cell_size') / 2:.6g}"]).folder)
    rows = [describe(name, EndedRun(outcome.folder), EndedRun(reference.folder), finer)
            for name, outcome in (("fixed, the report's", reference), ("fixed, within the limits", within),
                                  ("fixed, largest stable", lucky), ("adaptive, the report's factors", theirs),
                                  ("adaptive, the program's default", plain), ("adaptive, the scene's", ours))]
    told_limits = {name: [float(values[0]), float(values.min()), float(np.median(values))] for name, values in start.items()}
    return {"figure": figure, "rows": rows, "limits": told_limits,
            "elastic_cfl": adaptive.scene["time"]["elastic_cfl"], "particles": int(adaptive.history["particles"][0])}


def careful(study, adaptive):
    """The run with the largest fixed step that the program accepts throughout, by what the adaptive run has shown, and that
    step; smaller where the limits of the run itself turn out to be."""
    step = smallest_stability_limit(adaptive)
    for _ in range(8):
        outcome = study.fixed(f"within_limits_{step:.4g}", step, allow_unstable=False)
        if not outcome.fault:
            return outcome, step
        step *= 0.97
    sys.exit(f"adaptive-gain: figure {study.figure} has no fixed step within its limits near {step:.3g} s")


# --- tables ---------------------------------------------------------------------------------------------------------------

def summary(studies):
    """Gains of the adaptive step, one row a figure, in steps and (in brackets) in wall time."""
    rows = []
    for study in studies:
        *others, ours = study["rows"]
        gains = [f"{row['steps'] / ours['steps']:.2f} ({row['wall'] / ours['wall']:.2f})" for row in others]
        rows.append([study["figure"], str(study["particles"]), *gains, f"{ours['center']:.2f}", f"{ours['shape']:.1f}"])
    return markdown(["figure", "particles", "over the report's fixed step", "over the fixed step within the limits",
                     "over the largest stable", "over the report's adaptive step", "over the program's default",
                     "centre of mass off by [%]", "last shape off by [%]"], rows)


def table_of_runs(study):
    rows = []
    for row in study["rows"]:
        shares = ", ".join(f"{name} {share:.0f}" for name, share in row["shares"].items() if share >= 0.5)
        rows.append([row["run"], f"{row['step']:.3g}", str(row["steps"]), f"{row['wall']:.1f}", shares,
                     f"{row['trials']}, {row['rejected']}", f"{row['center']:.2f}", told(row["center_finer"]),
                     f"{row['shape']:.1f}", f"{row['energy']:+.2f}"])
    return markdown(["run", "mean step [s]", "steps", "wall time [s]", "limited by [% of steps]", "trials, rejected steps",
                     "centre of mass off by [%]", "and from finer cells [%]", "last shape off by [%]",
                     "largest growth of the energy [%]"], rows)


def told(number):
    return "-" if number is None else f"{number:.2f}"


def table_of_limits(studies):
    rows = []
    for study in studies:
        cells = [f"{at_start:.3g}, {smallest:.3g}, {median:.3g}" for at_start, smallest, median in study["limits"].values()]
        rows.append([study["figure"], f"{study['elastic_cfl']:g}", *cells])
    return markdown(["figure", "elastic_cfl", "speed [s]", "elastic [s]", "deformation [s]"], rows)


def report(studies):
    parts = ["### Gains of the adaptive step", summary(studies),
             "### The limits of the adaptive runs: at the start, the smallest, the median", table_of_limits(studies)]
    for study in studies:
        parts += [f"### Figure {study['figure']}", table_of_runs(study)]
    return "\n\n".join(parts)


def parse_arguments(description=__doc__):
    parser = argparse.ArgumentParser(description=description,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--figures", default=",".join(FIGURES), help=f"of {', '.join(FIGURES)}; default: all")
    parser.add_argument("--size", choices=("small", "default"), default="small",
                        help=f"small: cells of {SMALL_CELL} m; default: those of the scenes")
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/adaptive_gain"), help="folder of the runs")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE", help="for every run, as of bulkley run")
    parser.add_argument("--program", default=os.environ.get("BULKLEY", str(BUILT) if BUILT.is_file() else "bulkley"))
    parser.add_argument("--mpiexec", default="mpirun")
    parser.add_argument("--finer", action="store_true",
                        help="run each scene on cells of half the width, too, at 16 times the cost, and compare with that")
    parser.add_argument("--dry-run", action="store_true", help="print the commands that are known beforehand, run nothing")
    options = parser.parse_args()
    options.figures = options.figures.split(",")
    unknown = [figure for figure in options.figures if figure not in FIGURES]
    if unknown:
        parser.error(f"there is no figure {unknown[0]}: give some of {', '.join(FIGURES)}")
    options.launcher = [options.mpiexec, "-n", str(options.ranks)] if options.ranks > 1 else []
    return options


def main():
    options = parse_arguments()
    studies = [study_figure(figure, options) for figure in options.figures]
    if not options.dry_run:
        print(report(studies))


if __name__ == "__main__":
    main()
