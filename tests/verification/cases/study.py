"""What a verification case is made of: runs of the real program, quantities compared with the truth, errors over resolutions.

A case is a folder with `scene.toml` and `case.py`; the latter makes one `Study`, runs the scene through it and ends with
`finish()`, which writes the results for docs/verification.md and fails if a gate was missed. `study.long` is true in the
version with finer resolutions (ctest label `slow`)."""

import datetime
import json
import math
import os
import pathlib
import platform
import re
import sys

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402


COMPARED_STEPS = 200  # of the short version, on one rank and on two


class Run:
    """The output folder of a run that has ended well."""

    def __init__(self, folder, seconds):
        self.folder = folder
        self.seconds = seconds

    def history(self):
        """history.csv as a structured array: one name per column."""
        return numpy.genfromtxt(self.folder / "history.csv", delimiter=",", names=True, dtype=None, encoding="utf-8")

    def checkpoint(self):
        """The particles of the last checkpoint, sorted by id: {field: array}; and "time"."""
        return read_particles(sorted(self.folder.glob("checkpoint_*.h5"))[-1])

    def frames(self):
        """The particles of every frame in order of time, read one by one."""
        for file in sorted(self.folder.glob("frame_*.h5")):
            yield read_particles(file)


def read_particles(file):
    with h5py.File(file, "r") as data:
        particles = {name: array[()] for name, array in data["particles"].items() if name != "connectivity"}
        if "kirchhoff_stress" in particles:  # a scene whose output.fields names it; without what other fields hold
            if "cell_mean_stress" in particles:
                spherical = particles["volume_ratio"] * particles["cell_mean_stress"]
                particles["kirchhoff_stress"][:, :3] += spherical[:, None]
            if "viscous_stress" in particles:
                particles["kirchhoff_stress"] += particles["viscous_stress"]
        time = float(data.attrs["time"])
    if "id" in particles:
        order = numpy.argsort(particles["id"])
        particles = {name: array[order] for name, array in particles.items()}
    return {**particles, "time": time}


class Study:
    def __init__(self, name, title, truth):
        """`name`: the folder; `truth`: where the reference comes from, for the table of docs/verification.md."""
        def add(parser):
            parser.add_argument("--long", action="store_true", help="finer resolutions")
            parser.add_argument("--imex", action="store_true", help="with the implicit pressure")
            parser.add_argument("--ranks", type=int, help="of runs that are not compared; default: 2, in short versions 1")
            parser.add_argument("--results", help="folder for the results and plots of docs/verification.md")
        arguments = parse_arguments(f"{title}. {truth}", add)
        self.name, self.title, self.truth, self.long = name, title, truth, arguments.long
        self.imex, self.ranks = arguments.imex, arguments.ranks or (2 if arguments.long else 1)
        self.program, self.work = start(arguments)
        self.results = pathlib.Path(arguments.results or self.work)
        self.results.mkdir(parents=True, exist_ok=True)
        self.scene = pathlib.Path(sys.argv[0]).resolve().with_name("scene.toml")
        self.compared = False  # whether a run on one rank has been compared
        self.quantities, self.remarks, self.plots, self.misses = [], [], [], []

    def run(self, label, sets=None, ranks=None, limit=3600, scene=None, max_steps=None):
        """Runs the scene with `sets` ({key path: value}) into the folder `label`, the short version on one rank: two cases side
        by side are done sooner than one on two ranks."""
        ranks = ranks or self.ranks
        arguments = ["run", str(scene or self.scene), "--out", label, "--quiet"]
        for key, value in {**(sets or {}), **({"time.integrator": "imex"} if self.imex else {})}.items():
            arguments += ["--set", f"{key}={toml(value)}"]
        if max_steps:
            arguments += ["--max-steps", str(max_steps)]
        outcome = self.program.run(arguments, ranks, self.work, limit)
        if outcome.code != 0:
            fail(f"{label}: the run on {ranks} ranks ended with {outcome.code}", outcome)
        print(f"{self.name}: {label} on {ranks} ranks took {outcome.seconds:.1f} s", flush=True)
        return Run(self.work / label, outcome.seconds)

    def run_on_both(self, label, sets=None, limit=3600, scene=None):
        """A run on one rank and on two, which must give the same bits. The short version compares the first COMPARED_STEPS of the
        first run of a case only, usually the coarsest, and returns a run on one rank."""
        steps = None if self.long else COMPARED_STEPS
        if self.long or not self.compared:
            self.compared = True
            one = self.run(f"{label}_one_rank", sets, 1, limit, scene, steps)
            two = self.run(label if self.long else f"{label}_two_ranks", sets, 2, limit, scene, steps)
            files = [sorted(run.folder.glob("checkpoint_*.h5"))[-1] for run in (one, two)]
            outcome = self.program.run(["compare", *map(str, files)], 1, self.work, 300)
            if outcome.code != 0 or "identical" not in outcome.text:
                fail(f"{label}: two ranks differ from one", outcome)
        return two if self.long else self.run(label, sets, None, limit, scene)

    def expect(self, quantity, value, truth, tolerance, unit="", relative=True, note=""):
        """One number against the truth. The error is relative to `truth` unless told otherwise."""
        error = abs(value - truth) / (abs(truth) if relative else 1.0)
        self._record(quantity, [{"label": "", "value": float(value), "error": float(error)}], truth, tolerance, unit, None,
                     None, relative, note)

    def expect_at_most(self, quantity, error, tolerance, unit="", note=""):
        """An error that the case has worked out itself, such as the norm of a field."""
        self._record(quantity, [{"label": "", "value": float(error), "error": float(error)}], None, tolerance, unit, None, None,
                     True, note)

    def expect_convergence(self, quantity, cells, errors, tolerance, order, unit="", note="", truth_error=0.0):
        """Errors over resolutions: `cells` (cells per characteristic length, ascending), `errors` at each. The finest error is
        at most `tolerance`, and the observed order from the coarsest to the finest at least `order`, unless all errors are below
        `truth_error`, how far the truth itself may be off: they have no order."""
        levels = [{"label": f"{n:g}", "value": float(e), "error": float(e)} for n, e in zip(cells, errors)]
        observed = math.log(errors[0] / errors[-1]) / math.log(cells[-1] / cells[0])
        if max(errors) <= truth_error:
            observed, order, note = None, None, f"{note}; " * bool(note) + f"no order: the truth itself may be off by {truth_error:.2g}"
        self._record(quantity, levels, None, tolerance, unit, observed, order, True, note)

    def remark(self, sentence):
        """A sentence for the page: a measured limit, an explanation."""
        self.remarks.append(sentence)
        print(f"{self.name}: {sentence}", flush=True)

    def plot(self, draw, caption, suffix=""):
        """`draw(axes)` fills a plot for the page; only in the long version, which makes the page."""
        if not self.long:
            return
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        figure, axes = pyplot.subplots(figsize=(5.6, 3.6), dpi=100, layout="constrained")
        draw(axes)
        file = f"{self.name}{suffix}.png"
        figure.savefig(self.results / file)
        pyplot.close(figure)
        self.plots.append({"file": file, "caption": caption})

    def finish(self):
        """Writes the results; ends the process, with 1 if a gate was missed."""
        result = {"name": self.name, "title": self.title, "truth": self.truth, "quantities": self.quantities,
                  "remarks": self.remarks, "plots": self.plots, "date": datetime.date.today().isoformat(),
                  "commit": commit(self.program), "machine": machine()}
        (self.results / f"{self.name}.json").write_text(json.dumps(result, indent=1) + "\n")
        if not self.quantities:
            fail(f"{self.name} compares nothing")
        if self.misses:
            fail("; ".join(self.misses))

    def _record(self, quantity, levels, truth, tolerance, unit, observed, order, relative, note):
        error = levels[-1]["error"]
        passed = bool(error <= tolerance and (order is None or observed >= order))  # false for NaN
        self.quantities.append({"quantity": quantity, "unit": unit, "levels": levels,
                                "truth": None if truth is None else float(truth), "tolerance": tolerance, "relative": relative,
                                "order": observed, "least_order": order, "note": note, "passed": passed})
        errors = ", ".join((f"{level['label']} cells: " if level["label"] else "") + f"{level['error']:.3g}" for level in levels)
        text = f"{quantity}: " + (f"{levels[-1]['value']:.6g} against {truth:.6g} {unit}, " if truth is not None else "")
        text += f"error {errors} (at most {tolerance:g})"
        if order is not None:
            text += f", order {observed:.2f} (at least {order:g})"
        print(f"{self.name}: {text}: {'passed' if passed else 'FAILED'}", flush=True)
        if not passed:
            self.misses.append(f"{self.name}: {text}")


def commit(program):
    """The commit that a program was built from, with a + if its sources differed from it."""
    text = program.run(["--version"], 1, pathlib.Path(__file__).parent, 60).text
    found = re.search(r"commit (\w{1,10})\w*(-dirty)?", text)
    return found[1] + ("+" if found[2] else "") if found else "unknown"


def machine():
    """The processors of this machine in words."""
    info = pathlib.Path("/proc/cpuinfo")
    found = re.search(r"^model name\s*: (.+)$", info.read_text() if info.exists() else "", re.MULTILINE)
    return f"{os.cpu_count()} processors of {found[1].strip() if found else platform.machine()}"


def scheme_name(scheme):
    """A transfer scheme as the page calls it."""
    return "moment FLIP" if scheme == "moment_flip" else scheme.upper()


def toml(value):
    """A value as TOML text."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return value if re.fullmatch(r"[\w.]+", value) else json.dumps(value)
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{key} = {json.dumps(v) if isinstance(v, str) else toml(v)}" for key, v in value.items()) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(json.dumps(v) if isinstance(v, str) else toml(v) for v in value) + "]"
    return repr(float(value)) if isinstance(value, float) else str(value)
