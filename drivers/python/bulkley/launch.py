"""Runs of the program, started from Python: one process each, followed by the files that it writes, ended in order."""

import contextlib
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time
import warnings
from collections.abc import Mapping

from bulkley.faults import DataError, RunError
from bulkley.history import last_row
from bulkley.places import find_program
from bulkley.progress import Bar
from bulkley.run_folder import Run
from bulkley.scene_file import set_words, toml_text

STOPPED = 4  # exit code: stopped early with a checkpoint
EXIT_CODE = "bulkley ended with exit code"  # in the last line of a kept log
LOOKED_AT_EVERY = 0.05  # s
PATIENCE = 10.0  # s, for a process that was told to end a second time
# cluster/environment.sh, for Open MPI outside a batch system; what the environment says already is kept.
WORKSTATION = {
    "OMPI_MCA_rmaps_base_oversubscribe": "1", "PRTE_MCA_rmaps_default_mapping_policy": ":oversubscribe",
    "OMPI_MCA_hwloc_base_binding_policy": "none", "PRTE_MCA_hwloc_default_binding_policy": "none",
    "OMPI_MCA_btl_vader_single_copy_mechanism": "none", "OMPI_MCA_pml": "ob1", "HWLOC_COMPONENTS": "-gl",
    "OPENBLAS_NUM_THREADS": "1", "OMP_NUM_THREADS": "1"}
AS_ROOT = {"OMPI_ALLOW_RUN_AS_ROOT": "1", "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1"}
BATCH_SYSTEMS = ("SLURM_JOB_ID", "PBS_JOBID")


def environment() -> dict[str, str]:
    """Of the program's process."""
    if any(name in os.environ for name in BATCH_SYSTEMS):
        return dict(os.environ)
    return {**WORKSTATION, **(AS_ROOT if os.geteuid() == 0 else {}), **os.environ}


def launch_words(ranks: int, launcher: str) -> list[str]:
    """What comes before the program's name. Raises RunError."""
    check_whole_number("ranks", ranks)
    if ranks == 1:
        return []
    words = launcher.split()
    if not words or shutil.which(words[0]) is None:
        raise RunError(f"there is no '{launcher}' to start {ranks} ranks: install MPI, or set 'launcher'")
    return [*words, str(ranks)]


def sentence_of(text: str) -> str:
    """What the program said of its end, a line for each fault, without warnings. Where it said nothing, what mpirun says of it
    between lines of dashes, on one line."""
    parts = re.split(r"^-{20,}$", text, flags=re.MULTILINE)
    for number, part in enumerate(parts):
        lines = [line.strip().removeprefix("bulkley: ") for line in part.splitlines() if line.strip()]
        lines = [line for line in lines if not line.startswith("warning: ")]
        if lines and not lines[0].startswith("Primary job "):  # which says no more than that there was an error
            return ("\n" if number == 0 else " ").join(lines)
    return ""


class Job:
    """One run of the program in its own process group, so that Ctrl-C does not reach mpirun, which would end its ranks at
    once."""

    def __init__(self, command: list[str], folder: pathlib.Path, log: pathlib.Path | None = None, max_steps: int | None = None):
        """`log`: file for what the program prints, kept; None: none is kept."""
        self.folder, self.log, self.max_steps = folder, log, max_steps
        self._output = tempfile.TemporaryFile() if log is None else open(log, "w+b")
        self.started = time.time()
        self._end_time: float | None = None
        try:
            self.process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=self._output, stderr=self._output,
                                            start_new_session=True, env=environment())
        except OSError as error:
            self._output.close()
            raise RunError(f"'{command[0]}' cannot be started: {error.strerror}") from None

    def has_ended(self) -> bool:
        """Does not wait."""
        return self.process.poll() is not None

    def wait(self, seconds: float | None = None) -> bool:
        """Whether the process has ended within this time."""
        with contextlib.suppress(subprocess.TimeoutExpired):
            self.process.wait(seconds)
        return self.has_ended()

    def ask_to_stop(self) -> None:
        """The program finishes its step, writes a checkpoint and ends; mpirun hands the signal on."""
        if not self.has_ended():
            self.process.send_signal(signal.SIGUSR1)

    def end_at_once(self) -> None:
        """Without a checkpoint of the last step."""
        if not self.has_ended():
            self.process.terminate()
            if not self.wait(PATIENCE):
                os.killpg(self.process.pid, signal.SIGKILL)
                self.process.wait()

    def progress(self) -> tuple[float, str]:
        """Part of the run that is done, and where it is: from the files it has written since it was started."""
        row = self._fresh("history.csv", lambda path: last_row(path)[0])
        status = self._fresh("status.json", lambda path: json.loads(path.read_text(encoding="utf-8")))
        time_, step = (max(float(found.get(name, 0.0)) for found in (row, status)) for name in ("time", "step"))
        self._end_time = status.get("end_time", self._end_time)
        parts = [time_ / self._end_time if self._end_time else 0.0, step / self.max_steps if self.max_steps else 0.0]
        if not status and not row:
            return 0.0, "starts"
        return max(parts), f"t = {time_:.4g} of {self._end_time or 0.0:.4g} s, step {step:.0f}"

    def _fresh(self, name: str, read) -> dict:
        path = self.folder / name
        try:
            return read(path) if path.stat().st_mtime >= self.started - 1.0 else {}
        except (OSError, ValueError, DataError):  # not there yet, or of a run that is just being replaced
            return {}

    def text(self) -> str:
        """What the program has printed."""
        self._output.seek(0)
        return self._output.read().decode("utf-8", errors="replace")

    def close(self) -> RunError | None:
        """To be called when the process has ended: what went wrong, if anything did."""
        text = self.text()
        self._output.close()
        code = self.process.returncode
        if code in (0, STOPPED):
            return None
        if code < 0:
            text = f"{text}\nthe run was ended by signal {-code} ({signal.Signals(-code).name})"
        if self.log is not None:  # so that the log tells a run that has ended from one whose MPI library is talkative
            self.log.write_text(f"{text.rstrip()}\n{EXIT_CODE} {code}\n", encoding="utf-8")
        return RunError(sentence_of(text) or f"the run ended with exit code {code} and said nothing", code, self.folder)


def stop_in_order(jobs: list[Job]) -> None:
    """All end with a checkpoint; a second interruption ends them at once."""
    try:
        for job in jobs:
            job.ask_to_stop()
        for job in jobs:
            job.wait()
    except BaseException:
        for job in jobs:
            job.end_at_once()
        raise


def run_command(scene: str | os.PathLike, folder: pathlib.Path, words: list[str], *, restart: bool = False,
                overwrite: bool = False, max_steps: int | None = None, max_walltime: str | None = None) -> list[str]:
    """`run SCENE --out ...`, without the program. `words`: of the options --set."""
    command = ["run", os.fspath(scene), "--out", str(folder), "--quiet"]
    for word in words:
        command += ["--set", word]
    for option, value in (("--max-steps", max_steps), ("--max-walltime", max_walltime)):
        if value is not None:
            command += [option, str(value)]
    return command + ["--restart"] * restart + ["--overwrite"] * overwrite


def run(scene: Mapping | str | os.PathLike, ranks: int = 1, *, out: str | os.PathLike | None = None,
        sets: Mapping | None = None, restart: bool = False, overwrite: bool = False, max_steps: int | None = None,
        max_walltime: str | None = None, program: str | os.PathLike | None = None, launcher: str = "mpirun -n",
        progress: bool | None = None) -> Run:
    """Runs a scene and waits for its end; returns the run, finished or (by the file STOP, `max_walltime`) stopped.

    `scene`: a dictionary as the scene file has it, or a path of one; `out`: folder for everything the run writes, out/NAME
    of the file by default, out/scene of a dictionary, which is written there as input.toml; `sets`: keys that differ, such
    as {"materials.cream.yield_stress": 30.0}. Paths of meshes in dictionaries are taken from the current folder. `ranks`
    above 1 are started by `launcher`, to which their number is added. `restart` continues from the newest checkpoint,
    `overwrite` deletes an earlier run. `progress`: a bar; by default on a terminal and in a notebook.

    Ctrl-C stops the run in order, with a checkpoint, and raises KeyboardInterrupt; a second one ends it at once. Raises
    RunError.
    """
    program_path, launching, words = find_program(program), launch_words(ranks, launcher), set_words(sets)
    check_whole_number("max_steps", max_steps, may_be_none=True)
    if restart and overwrite:
        raise RunError("'restart' continues an earlier run and 'overwrite' deletes it: give one of them")
    if not isinstance(scene, (Mapping, str, os.PathLike)):
        raise RunError(f"'scene' is {scene!r} and must be a dictionary or the path of a scene file")
    name = "scene" if isinstance(scene, Mapping) else pathlib.Path(scene).stem
    folder = pathlib.Path(out) if out is not None else pathlib.Path("out") / name
    if not (restart or overwrite) and holds_run(folder):
        raise RunError(f"'{folder}' holds an earlier run: continue it with restart=True, replace it with overwrite=True, or give "
                       "another 'out'", folder=folder)
    file = written_scene(scene, folder / "input.toml") if isinstance(scene, Mapping) else scene
    command = run_command(file, folder, words, restart=restart, overwrite=overwrite, max_steps=max_steps,
                          max_walltime=max_walltime)
    job = Job([*launching, program_path, *command], folder, max_steps=max_steps)
    follow(job, Bar(folder.name, progress))
    fault = job.close()
    if fault is not None:
        raise fault
    made = Run(folder)
    for sentence in made.status["warnings"]:
        warnings.warn(sentence, stacklevel=2)
    return made


def holds_run(folder: pathlib.Path) -> bool:
    """Whether the folder holds a run that has begun, or something else named like one."""
    if (folder / "history.csv").exists() or not (folder / "status.json").exists():
        return (folder / "history.csv").exists()
    try:
        return not json.loads((folder / "status.json").read_text(encoding="utf-8")).get("failed_in_set_up")
    except (OSError, ValueError, AttributeError):
        return True


def check_whole_number(name: str, value, may_be_none: bool = False) -> None:
    """Raises RunError for anything but a number from 1."""
    if may_be_none and value is None:
        return
    if isinstance(value, bool) or not isinstance(value, int) or value < 1:
        raise RunError(f"'{name}' is {value!r} and must be a whole number of at least 1")


def written_scene(scene: Mapping, path: pathlib.Path) -> pathlib.Path:
    """The file that a dictionary was written to. Raises RunError."""
    text = toml_text(scene)
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise RunError(f"cannot write '{path}': {error.strerror}") from None
    return path


def follow(job: Job, bar: Bar) -> None:
    """Shows how far the run is until it has ended."""
    try:
        while not job.wait(LOOKED_AT_EVERY):
            bar.show(*job.progress())
        bar.show(*job.progress(), is_last=True)
    except BaseException as reason:
        stop_in_order([job])
        if isinstance(reason, KeyboardInterrupt) and bar.is_shown:
            bar.show(job.progress()[0], "stopped: restart=True continues it", is_last=True)
        raise
    finally:
        bar.close()
