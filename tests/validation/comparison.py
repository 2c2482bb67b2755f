"""What a validation case is made of: runs of the real program, what is measured on them, and a comparison with an
experiment.

A case is a folder with `scene.toml` and `case.py`, which holds a class derived from `Case`. `main` makes the runs of its
short version (ctest label `validation`) or of its long one, keeps what was measured on each run as a record, and judges the
records. The records of long runs are shipped in `results/CASE.json` with their date and commit, because some runs take long:
report.py makes docs/validation.md of the records alone, so that a run made again changes its numbers on the page and nothing
else."""

import csv
import datetime
import json
import math
import pathlib
import re
import shutil
import sys
import tomllib
from dataclasses import dataclass, field, replace

import h5py
import numpy

FOLDER = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(FOLDER.parent / "support"))
sys.path.insert(0, str(FOLDER.parent / "verification/cases"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from study import Run, commit, machine, toml  # noqa: E402

DIGITS = 5                            # significant digits of what records keep
TRANSFERS = ("", "moment_flip", "apic")  # schemes of long runs; empty: the program's default
OF_PARTICLES = ", particle"           # follows the transfer of records of runs with transfer.dilation = "particle"
VOIDS_OPEN = ", voids open"           # likewise with transfer.close_voids = false, as all runs were before 1 December 2026
TRUE_MODULUS = 2.2e9                  # Pa, bulk modulus of water
# What limits the time step in an implicit run, with the program's defaults.
LIMITS = {"time.cfl": 0.5, "time.elastic_cfl": 0.4, "time.viscous_cfl": 0.5, "time.deformation_limit": 0.1}


@dataclass
class Plan:
    """One run. `key` names it among the runs of its case: what differs but the transfer; `sets`: {key path: value}."""
    key: str
    sets: dict
    facts: dict = field(default_factory=dict)  # kept in the record: cell size, stiffness, box, ...
    transfer: str = ""                         # scheme; empty: the program's default
    limit: float = 36000.0                     # s of wall time
    addition: str = ""                         # text that follows the case's scene, such as one more collider

    def sets_for(self, default):
        """With the transfer, if it is not the program's default."""
        return self.sets if self.transfer == default else {**self.sets, "transfer.scheme": self.transfer}

    def imex(self, material, limits=1.0):
        """The same run with the implicit pressure and the true bulk modulus of water for `material`; all limits of the time step
        are multiplied by `limits`."""
        sets = {**self.sets, "time.integrator": "imex", f"materials.{material}.bulk_modulus": TRUE_MODULUS}
        facts = {**self.facts, "bulk_modulus": TRUE_MODULUS}
        key = f"{self.key}, imex"
        if limits != 1.0:
            sets |= {name: limits * value for name, value in LIMITS.items()}
            facts["limits"] = limits
            key += f", limits times {limits:g}"
        return replace(self, key=key, sets=sets, facts=facts)


class Case:
    """Derived classes set the texts and define plans, measure and judge."""
    name = title = ""
    source = ""   # of the experiment: a sentence
    missing = ""  # sentences: what the simulation leaves out

    def plans(self, long):
        """The runs, as a list of Plan."""
        raise NotImplementedError

    def imex_plans(self, long):
        """The runs of `--imex`, as a list of Plan made by Plan.imex; empty if the case has none."""
        return []

    def measure(self, run, plan):
        """What a run gave: {name: number or list of numbers}."""
        raise NotImplementedError

    def judge(self, records, sheet):
        """Compares `records` ({label: record}) with the experiment: gates, sentences and pictures on `sheet`."""
        raise NotImplementedError

    def execute(self, plan, program, work, arguments, default):
        """Makes the run of a plan with a program whose default transfer is `default`; returns its record."""
        label = re.sub(r"[^\w.]+", "_", f"{plan.key}_{plan.transfer}")
        scene = self.folder / "scene.toml"
        if plan.addition:
            text = scene.read_text(encoding="utf-8") + plan.addition
            scene = work / f"{label}.toml"
            scene.write_text(text, encoding="utf-8")
        run = make(scene, label, plan.sets_for(default), program, work, arguments.ranks, plan.limit)
        record = record_of(self, run, plan, default, program)
        print(f"{self.name}: {label} took {run.seconds:.1f} s", flush=True)
        if not arguments.keep:
            shutil.rmtree(run.folder)
        return record

    @property
    def folder(self):
        return FOLDER / "cases" / self.name


class Sheet:
    """What a case says: gated quantities, remarks, tables and pictures. `short`: whether the records are of the short
    version."""

    def __init__(self, short=False, pictures=None):
        self.short = short
        self.folder = pictures
        self.rows, self.parts, self.pictures = [], [], []

    def gate(self, quantity, error, tolerance, unit="", note=""):
        """An error that must not be larger than `tolerance` in magnitude. Returns whether it is not."""
        passed = bool(abs(error) <= tolerance)  # false for NaN
        self.rows.append({"quantity": quantity, "error": float(error), "tolerance": float(tolerance), "unit": unit,
                          "note": note,
                          "passed": passed})
        return passed

    def say(self, sentence):
        self.parts.append(sentence)

    def table(self, header, rows):
        lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
        self.parts.append("\n".join(lines + ["| " + " | ".join(map(str, row)) + " |" for row in rows]))

    def picture(self, name, caption, draw, columns=1, rows=1, size=(5.6, 3.6)):
        """`draw(axes)` fills a picture, of one plot or of an array of them."""
        self.parts.append(f"![{caption}](pictures/validation/{name}.png)\n\n{caption}")
        self.pictures.append(f"{name}.png")
        if self.folder is None:
            return
        import matplotlib
        matplotlib.use("Agg")
        from matplotlib import pyplot
        figure, axes = pyplot.subplots(rows, columns, figsize=(size[0] * columns, size[1] * rows), dpi=80,
                                       layout="constrained")
        draw(axes)
        figure.savefig(self.folder / f"{name}.png", metadata={"Software": None})
        pyplot.close(figure)


def whole_cells(length, cell):
    """The next multiple of `cell`, m, that is not less than `length`, m."""
    return cell * math.ceil(length / cell - 1e-9)


# --- measured numbers ------------------------------------------------------------------------------------------------------

def measured(name):
    """The columns of measured/NAME.csv as {column: array}, and its comment lines "# key: value" as {key: value}."""
    lines = (FOLDER / "measured" / f"{name}.csv").read_text(encoding="utf-8").splitlines()
    header = dict(match.groups() for match in (re.match(r"# ([\w ]+): (.*)", line) for line in lines) if match)
    rows = list(csv.DictReader(line for line in lines if not line.startswith("#")))
    return {column: numpy.array([float(row[column]) for row in rows]) for column in rows[0]}, header


def positions(file):
    """Time and particle positions (n, 3), m, of a frame."""
    with h5py.File(file, "r") as data:
        return float(data.attrs["time"]), data["particles"]["position"][()].astype(float)


def frames(run):
    """(time, positions) of every frame in order of time, read one by one."""
    for file in sorted(run.folder.glob("frame_*.h5")):
        yield positions(file)


# --- records ---------------------------------------------------------------------------------------------------------------

def rounded(value):
    """Numbers with the digits that a record keeps; anything else as it is."""
    if isinstance(value, (list, tuple, numpy.ndarray)):
        return [rounded(entry) for entry in value]
    if isinstance(value, (float, numpy.floating)):
        return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None
    return int(value) if isinstance(value, numpy.integer) else value


def record_of(case, run, plan, default, program):
    """What is kept of a run of a program whose default transfer is `default`."""
    scene = tomllib.loads((run.folder / "scene.toml").read_text(encoding="utf-8"))
    history = run.history()
    return {"key": plan.key, "transfer": scene["transfer"]["scheme"] + OF_PARTICLES * of_particles(plan) + VOIDS_OPEN * leaves_voids(plan), "default_transfer": default,
            "date": datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M"), "commit": commit(program), "machine": machine(),
            "integrator": scene["time"]["integrator"], "seconds": round(run.seconds), "steps": int(history["step"][-1]),
            "particles": int(history["particles"][0]), "smallest_volume_ratio": rounded(history["min_volume_ratio"].min()),
            **plan.facts, **{name: rounded(value) for name, value in case.measure(run, plan).items()}}


def of_particles(plan):
    """Whether the particles of a run keep their volume each by itself, not as the program's default says."""
    return plan.sets.get("transfer.dilation") == "particle"


def leaves_voids(plan):
    """Whether fluids leave empty what fronts do on floors, not as the program's default says."""
    return plan.sets.get("transfer.close_voids") is False


def integrator_of(record):
    """"explicit" or "imex". Records of the time when all runs were explicit do not state it."""
    return record.get("integrator", "explicit")


def is_imex(record):
    return integrator_of(record) == "imex"


def label_of(record):
    return f"{record['key']}, {record['transfer']}"


def load(file):
    """{label: record} of a file of records; empty if there is none."""
    return json.loads(file.read_text(encoding="utf-8")) if file.exists() else {}


def store(file, records):
    """One line a number or list, so that a run made again changes its own lines only."""
    file.parent.mkdir(parents=True, exist_ok=True)
    blocks = []
    for label in sorted(records):
        lines = ",\n".join(f"  {json.dumps(name)}: {json.dumps(value)}" for name, value in records[label].items())
        blocks.append(f" {json.dumps(label)}: {{\n{lines}\n }}")
    file.write_text("{\n" + ",\n".join(blocks) + "\n}\n", encoding="utf-8")


def schemes_of(records):
    """Names of the transfers, the one that the newest program runs by default first."""
    newest = max(records.values(), key=lambda record: record["date"])
    return sorted({record["transfer"] for record in records.values()},
                  key=lambda scheme: (scheme != newest["default_transfer"], OF_PARTICLES in scheme, scheme))


# --- a test ----------------------------------------------------------------------------------------------------------------

def main(case):
    """Makes the runs, keeps their records, judges them; ends the process, with 1 if a gate was missed."""
    def add(parser):
        parser.add_argument("--long", action="store_true", help="the runs of docs/validation.md")
        parser.add_argument("--imex", action="store_true", help="the runs with the implicit pressure instead of the explicit ones")
        parser.add_argument("--results", help="folder for the records; default: the work folder")
        parser.add_argument("--only", default="", help="make only the runs whose key matches this regular expression")
        parser.add_argument("--transfer", default="", help="transfer scheme of all runs; default: as the case plans")
        parser.add_argument("--dilation", default="", help="transfer.dilation of all runs; default: the program's")
        parser.add_argument("--leave-voids", action="store_true", help="all runs with transfer.close_voids = false")
        parser.add_argument("--ranks", type=int, default=1)
        parser.add_argument("--keep", action="store_true", help="keep frames and checkpoints")
        parser.add_argument("--list", action="store_true", help="print the keys of the runs and end")
    arguments = parse_arguments(f"{case.title}. {case.source}", add)
    planned = case.imex_plans(arguments.long) if arguments.imex else case.plans(arguments.long)
    plans = [plan for plan in planned if re.search(arguments.only, plan.key)]
    if not plans:
        fail(f"no run of {case.name} matches '{arguments.only}'; --list tells them")
    if arguments.list:
        print("\n".join(f"{plan.key}{', ' if plan.transfer else ''}{plan.transfer}" for plan in plans))
        return
    program, work = start(arguments)
    default = re.search(r"^\| `scheme` \| name \|  \| `\"(\w+)\"`", program.run(["input-reference"], 1, work, 60).text,
                        re.MULTILINE)[1]
    file = pathlib.Path(arguments.results or work) / f"{case.name}.json"
    shipped = load(FOLDER / "results" / f"{case.name}.json") if arguments.long else {}
    made = set()
    for plan in plans:
        plan.transfer = arguments.transfer or plan.transfer or default
        if (plan.key, plan.transfer) in made:
            continue
        made.add((plan.key, plan.transfer))
        if arguments.dilation:
            plan.sets = {**plan.sets, "transfer.dilation": arguments.dilation}
        if arguments.leave_voids:
            plan.sets = {**plan.sets, "transfer.close_voids": False}
        record = case.execute(plan, program, work, arguments, default)
        if arguments.imex and not is_imex(record):
            fail(f"{plan.key} ran with the explicit step")
        records = {**load(file), label_of(record): record}
        store(file, records)
    sheet = Sheet(short=not arguments.long)
    case.judge({**shipped, **records}, sheet)
    if not sheet.rows:
        fail(f"{case.name} compares nothing")
    misses = []
    for row in sheet.rows:
        text = f"{row['quantity']}: {row['error']:+.3g} {row['unit']} (at most {row['tolerance']:g})"
        print(f"{case.name}: {text}: {'passed' if row['passed'] else 'FAILED'}", flush=True)
        misses += [] if row["passed"] else [f"{case.name}: {text}"]
    if misses:
        fail("; ".join(misses))


def make(scene, label, sets, program, work, ranks=1, limit=36000.0):
    """Runs `scene` with `sets` into the folder `label` of `work`; returns the Run."""
    words = ["run", str(scene), "--out", label, "--quiet"]
    for key, value in sets.items():
        words += ["--set", f"{key}={toml(value)}"]
    outcome = program.run(words, ranks, work, limit)
    if outcome.code != 0:
        fail(f"{label}: the run on {ranks} ranks ended with {outcome.code}", outcome)
    return Run(work / label, outcome.seconds)
