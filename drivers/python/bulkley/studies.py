"""Parameter studies: one scene, all combinations of values of some keys, one run each, in one folder.

The folder has study.json (the cases, and what scene they are of), and for case N its output folder N and what the program
printed, N.log. Nothing else is remembered: a study that was interrupted, or runs on a cluster, is continued and read from
these files.
"""

import hashlib
import itertools
import json
import os
import pathlib
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from bulkley.faults import DataError, RunError
from bulkley.history import Table, last_row
from bulkley.launch import (EXIT_CODE, LOOKED_AT_EVERY, Job, check_whole_number, launch_words, run_command, sentence_of,
                            stop_in_order)
from bulkley.places import find_program
from bulkley.progress import Bar
from bulkley.run_folder import Run, open_run
from bulkley.scene_file import set_words, toml_text
from bulkley.slurm_array import submit, write_job_script

SILENT_AFTER = 120.0  # s without an update of status.json, after which a run that should be running was killed
FIGURES = ("case", "state", "step", "time", "wall_time", "error")
UNITS = {"time": "s", "wall_time": "s"}
JOB_GAVE_UP = ": no further part"  # in the log of a job: cluster/jobs/job_functions.sh
OF_JOB_SCRIPT = re.compile(r"^(\d{4}-\d\d-\d\d \d\d:\d\d:\d\d job |srun: |slurmstepd: ).*$", re.MULTILINE)


@dataclass(frozen=True)
class Case:
    """One run of a study. `number`: from 1, also the name of its folder; `values`: of the keys that are varied; `words`: all
    that follows --set."""

    number: int
    values: dict
    words: list[str]
    folder: pathlib.Path

    @property
    def log(self) -> pathlib.Path:
        """What the program printed; slurm_N.log is that of a job."""
        return self.folder.with_name(f"{self.number}.log")

    @property
    def status(self) -> dict:
        """status.json; empty where the run has not begun."""
        try:
            return json.loads((self.folder / "status.json").read_text(encoding="utf-8"))
        except (OSError, ValueError):
            return {}

    @property
    def state(self) -> str:
        """As in status.json; "waiting" before the run has begun, "refused" where the program did not accept its input,
        "killed" where it was ended from outside."""
        state = self.status.get("state")
        if state in (None, "running") and self._said():
            return "refused" if state is None else "killed"
        return state or "waiting"

    @property
    def error(self) -> str:
        """Why a run was refused, failed or was killed, in the words of the program or of mpirun; "" otherwise."""
        status = self.status
        return str(status.get("reason", "")) if status.get("state") == "failed" else \
            self._said() if self.state in ("refused", "killed") else ""

    def _said(self) -> str:
        """What a run that has ended badly said last; "" where its log does not say that it has ended."""
        if self.log.is_file():
            text, ending, _ = self.log.read_text(encoding="utf-8", errors="replace").rpartition(f"{EXIT_CODE} ")
            return (sentence_of(text) or "it said nothing") if ending else ""
        job_log = self.folder.with_name(f"slurm_{self.number}.log")
        text = job_log.read_text(encoding="utf-8", errors="replace") if job_log.is_file() and not self.status else ""
        return sentence_of(OF_JOB_SCRIPT.sub("", text)) if JOB_GAVE_UP in text else ""

    def is_done(self, max_steps: int | None) -> bool:
        """Whether the run has reached its end time, or the step that it is to end after."""
        status = self.status
        reached = status.get("time", 0.0) >= (1.0 - 1e-9) * status.get("end_time", np.inf)
        return self.state == "finished" and (reached or max_steps is not None and status["step"] >= max_steps)

    def is_to_run(self, max_steps: int | None, retry_failed: bool) -> bool:
        """Raises RunError where another process seems to write the run."""
        state = self.state
        if state == "running":
            age = time.time() - (self.folder / "status.json").stat().st_mtime
            if age < SILENT_AFTER:
                raise RunError(f"'{self.folder}' is written by another process, {age:.0f} s ago: wait for its end, or for "
                               f"{SILENT_AFTER:.0f} s if it was killed", folder=self.folder)
        status = self.status
        may_go_on = state != "failed" or retry_failed or status.get("unresponsive") or status.get("failed_in_set_up")
        return not self.is_done(max_steps) and may_go_on

    def start_options(self) -> dict:
        """Whether the run continues or begins anew."""
        if any(self.folder.glob("checkpoint_*.h5")):
            return {"restart": True}
        return {"overwrite": any((self.folder / name).exists() for name in ("status.json", "history.csv"))}


class Study(Sequence[Case]):
    """The cases of a study, in the order that was asked for. `script`: the job script, where one was written."""

    def __init__(self, folder: pathlib.Path, scene: pathlib.Path, cases: list[Case], script: pathlib.Path | None = None):
        self.folder, self.scene, self.script, self._cases = folder, scene, script, cases

    def __getitem__(self, index):
        return self._cases[index]

    def __len__(self) -> int:
        return len(self._cases)

    def __repr__(self) -> str:
        return f"<Study '{self.folder}', {len(self)} cases>"

    @property
    def runs(self) -> Iterator[Run]:
        """Of the cases that have an output folder, in order."""
        return (open_run(case.folder) for case in self if (case.folder / "scene.toml").is_file())

    def table(self) -> Table:
        """One row a case: its number, the values of the keys, state, last step, time (s) and wall time (s) of the last part,
        the last row of its history (with fronts and gauges), and the sentence of a case that was refused or failed. Numbers
        that a case does not have are NaN."""
        keys = list(dict.fromkeys(key for case in self for key in case.values))
        rows, units = [], dict(UNITS)
        for case in self:
            row, units_of_row = end_of(case)
            units |= units_of_row
            rows.append({**{key: case.values.get(key, np.nan) for key in keys}, **row})
        last = list(dict.fromkeys(name for row in rows for name in row if name not in (*keys, *FIGURES)))
        names = [FIGURES[0], *keys, *FIGURES[1:], *last]
        return Table({name: column([row.get(name, np.nan) for row in rows]) for name in names},
                     {name: units.get(name, "") for name in names}, self.folder / "study.json")

    def submit(self) -> str:
        """Submits the job script by sbatch; the number of the job. Raises RunError."""
        if self.script is None:
            raise RunError(
                f"the study in '{self.folder}' has no job script: give 'slurm', and some case that is not finished")
        return submit(self.script)


def end_of(case: Case) -> tuple[dict, dict[str, str]]:
    """The figures of a case's end, and units of its history's columns."""
    status = case.status
    row = {"case": case.number, "state": case.state, "step": status.get("step", np.nan), "time": status.get("time", np.nan),
           "wall_time": status.get("wall_time", np.nan), "error": case.error}
    path = case.folder / "history.csv"
    if not path.is_file():
        return row, {}
    last, units = last_row(path)
    return {**last, **row}, units


def column(values: list) -> np.ndarray:
    """Numbers as float64; anything else as text, "" for what is not known."""
    if all(isinstance(value, (int, float, np.number)) and not isinstance(value, bool) for value in values):
        return np.array(values, dtype=float)
    return np.array(["" if isinstance(value, float) and np.isnan(value) else
                     value if isinstance(value, str) else json.dumps(value) for value in values])


# --- the folder ------------------------------------------------------------------------------------------------------------

def combinations(parameters: Mapping) -> list[dict]:
    """All combinations of the values, the last key varying fastest. Raises RunError."""
    if not isinstance(parameters, Mapping) or not parameters:
        raise RunError(f"the parameters are {parameters!r}; they must be a dictionary of keys with lists of values")
    lists = {}
    for key, values in parameters.items():
        values = values.tolist() if isinstance(values, np.ndarray) else values
        if not isinstance(values, (list, tuple, range)) or not len(values):
            raise RunError(f"'{key}' is {values!r} and must be a list of at least one value")
        lists[key] = [value.item() if isinstance(value, np.generic) else value for value in values]
        if len({repr(value) for value in lists[key]}) < len(values):
            raise RunError(f"'{key}' has a value twice: {lists[key]}")
    return [dict(zip(lists, values)) for values in itertools.product(*lists.values())]


def recorded(folder: pathlib.Path) -> dict:
    """What study.json says; of a new study, no cases. Raises DataError."""
    path = folder / "study.json"
    if not path.is_file():
        return {"cases": []}
    try:
        found = json.loads(path.read_text(encoding="utf-8"))
        return {"scene": found["scene"], "sha256": found["sha256"],
                "cases": [{"values": dict(case["values"]), "words": list(case["words"])} for case in found["cases"]]}
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DataError(f"cannot read '{path}': {error}") from None


def record(folder: pathlib.Path, name: str, text: str) -> None:
    """Writes a file of the folder, whole or not at all. Raises RunError."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / f"{name}.new").write_text(text, encoding="utf-8")
        os.replace(folder / f"{name}.new", folder / name)
    except OSError as error:
        raise RunError(f"cannot write '{folder / name}': {error.strerror}") from None


def laid_out(scene: Mapping | str | os.PathLike, wanted: list[dict], sets: Mapping, folder: pathlib.Path) -> Study:
    """The study in `folder` with these cases. Those that are there already, of the same scene, keep their numbers. Raises
    RunError, DataError."""
    try:
        text = toml_text(scene).encode() if isinstance(scene, Mapping) else pathlib.Path(scene).read_bytes()
    except OSError as error:
        raise RunError(f"cannot read the scene '{scene}': {error.strerror}") from None
    file = folder / "scene.toml" if isinstance(scene, Mapping) else pathlib.Path(scene).absolute()
    found, digest = recorded(folder), hashlib.sha256(text).hexdigest()
    if found["cases"] and found["sha256"] != digest:
        raise RunError(f"'{folder}' holds a study of another scene than this one is now: give another 'folder'")
    numbers = {tuple(case["words"]): number for number, case in enumerate(found["cases"], 1)}
    cases = []
    for values in wanted:
        words = set_words({**sets, **values})
        if tuple(words) not in numbers:
            found["cases"].append({"values": values, "words": words})
            numbers[tuple(words)] = len(found["cases"])
        number = numbers[tuple(words)]
        cases.append(Case(number, values, words, folder / str(number)))
    if isinstance(scene, Mapping):
        record(folder, "scene.toml", text.decode())
    record(folder, "study.json", json.dumps(
        {"scene": str(file), "sha256": digest, "cases": found["cases"]}, indent=1) + "\n")
    return Study(folder, file, cases)


def open_study(folder: str | os.PathLike) -> Study:
    """The study in this folder, with all its cases, as its files are now. Raises DataError."""
    folder = pathlib.Path(folder)
    found = recorded(folder)
    if not found["cases"]:
        raise DataError(f"'{folder}' is not the folder of a study: it has no study.json with cases")
    cases = [Case(number, case["values"], case["words"], folder / str(number))
                  for number, case in enumerate(found["cases"], 1)]
    script = folder / "study.sh"
    return Study(folder, pathlib.Path(found["scene"]), cases, script if script.is_file() else None)


# --- the runs --------------------------------------------------------------------------------------------------------------

def study(scene: Mapping | str | os.PathLike, parameters: Mapping, ranks: int = 1, parallel: int | None = None, *,
          folder: str | os.PathLike = "out/study", sets: Mapping | None = None, max_steps: int | None = None,
          retry_failed: bool = False, slurm: Mapping | None = None, program: str | os.PathLike | None = None,
          launcher: str = "mpirun -n", progress: bool | None = None) -> Study:
    """Runs a scene with all combinations of values, {"materials.fluid.yield_stress": [10, 20], ...}, and waits for their
    ends.

    Called again, it makes what is missing: finished cases are not run again, stopped and killed ones continue from their
    newest checkpoint, failed ones stay as they are unless `retry_failed`; further values are further cases. `parallel`: runs
    at a time, 1 by default; `folder`: of the study, which belongs to one scene; `scene`, `sets`, `ranks`, `program`,
    `launcher`, `progress`: as of `run`. A case that fails does not end the others: `table()` has its sentence.

    `slurm`: options of sbatch, such as {"time": "04:00:00", "partition": "main"}; nothing is run, but study.sh is written, a
    job array of the cases that are missing; `submit()` of the result submits it. `parallel` then bounds the jobs that run at
    a time.

    Ctrl-C stops the runs in order, with checkpoints. Raises RunError where the study cannot begin, DataError where its
    folder is damaged.
    """
    program_path = find_program(program)
    launching = launch_words(ranks, launcher) if slurm is None else []
    check_whole_number("ranks", ranks)
    check_whole_number("max_steps", max_steps, may_be_none=True)
    check_whole_number("parallel", parallel, may_be_none=True)
    if not isinstance(scene, (Mapping, str, os.PathLike)):
        raise RunError(f"'scene' is {scene!r} and must be a dictionary or the path of a scene file")
    if both := set(sets or {}) & set(parameters if isinstance(parameters, Mapping) else {}):
        raise RunError(f"'{sorted(both)[0]}' is both in 'sets' and among the parameters")
    set_words(sets)
    made = laid_out(scene, combinations(parameters), sets or {}, pathlib.Path(folder))
    missing = [case for case in made if case.is_to_run(max_steps, retry_failed)]
    if slurm is not None:
        for case in missing:
            case.log.unlink(missing_ok=True)
        lines = [case["words"] for case in recorded(made.folder)["cases"]]
        options = ["--quiet", *(["--max-steps", str(max_steps)] if max_steps is not None else [])]
        made.script = write_job_script(made.folder, made.scene, lines, [case.number for case in missing], ranks=ranks,
                                       parallel=parallel, options=options, slurm=slurm, program=program_path)
        return made

    def start(case: Case) -> Job:
        case.folder.with_name(f"slurm_{case.number}.log").unlink(missing_ok=True)
        command = run_command(made.scene, case.folder, case.words, max_steps=max_steps, **case.start_options())
        return Job([*launching, program_path, *command], case.folder, case.log, max_steps)

    run_all(made, missing, start, parallel or 1, Bar(made.folder.name, progress))
    return made


def run_all(made: Study, missing: list[Case], start: Callable[[Case], Job], parallel: int, bar: Bar) -> None:
    """Keeps `parallel` cases running until all have ended."""
    waiting, jobs, n_failed = list(missing), [], 0
    try:
        while waiting or jobs:
            while waiting and len(jobs) < parallel:
                jobs.append(start(waiting.pop(0)))
            ended = [job for job in jobs if job.has_ended()]
            jobs = [job for job in jobs if job not in ended]
            n_failed += sum(job.close() is not None for job in ended)
            n_ended = len(made) - len(waiting) - len(jobs)
            done = n_ended + sum(job.progress()[0] for job in jobs)
            failed = f", {n_failed} failed" if n_failed else ""
            bar.show(done / len(made), f"{n_ended} of {len(made)} cases{failed}", is_last=not (waiting or jobs))
            if jobs:
                jobs[0].wait(LOOKED_AT_EVERY)
    except BaseException:
        stop_in_order(jobs)
        raise
    finally:
        bar.close()
