#!/usr/bin/env python3
"""Runs are killed with SIGKILL at random moments and restarted on other numbers of ranks until they end; what they leave must
be what a run leaves that nobody killed.

Killed are one rank, mpirun alone, or everything at once; at a random moment, or at the moment a file is being written. Compared
are the last checkpoint (identical), history.csv (row by row, all but what depends on clocks and rank counts), frames.xdmf and
the data of every frame. Nothing unfinished may be left over.
"""

import csv
import json
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import sys
import time

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("splash.toml")
# Columns of history.csv that depend on the clock or on the number of ranks.
OWN_COLUMNS = {"imbalance", "repartitions", "moved_particles", "migrated_particles", "halo_bytes_largest [B]",
               "halo_bytes_mean [B]", "wall_time_per_step [s]"}
LONGEST_END = 30.0  # s from the death of one process to that of all
NO_CHECKPOINT = "no whole checkpoint to restart from"


def children(pid):
    """Processes started by `pid`, and by those, that still run."""
    found = []
    for task in pathlib.Path(f"/proc/{pid}/task").glob("*/children"):
        try:
            for child in task.read_text(encoding="ascii").split():
                found += [int(child), *children(child)]
        except OSError:
            pass  # it ended meanwhile
    return found


def is_running(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rpartition(")")[2].split()[0] not in "ZX"
    except OSError:
        return False


def shared_memory_of(pids):
    """Files in /dev/shm that Open MPI would have removed, had it not been killed."""
    found = set()
    for pid in pids:
        try:
            maps = pathlib.Path(f"/proc/{pid}/maps").read_text(encoding="utf-8", errors="replace")
            found |= set(re.findall(r"/dev/shm/vader_segment\S+", maps))
        except OSError:
            pass  # it ended meanwhile
    return found


def end_of(pids, limit):
    """Seconds until none of `pids` runs; None if one still does after `limit`."""
    begin = time.monotonic()
    while time.monotonic() - begin < limit:
        if not any(is_running(pid) for pid in pids):
            return time.monotonic() - begin
        time.sleep(0.01)
    return None


def names_in(folder):
    return os.listdir(folder) if folder.exists() else []


def unfinished(folder, suffix):
    """Files under temporary names, and when they were last changed."""
    found = {}
    for name in names_in(folder):
        try:
            if name.endswith(suffix):
                found[name] = (folder / name).stat().st_mtime_ns
        except OSError:
            pass  # it has its name by now
    return found


def has_finished(folder):
    """Whether the run in `folder` had finished before a kill."""
    status = folder / "status.json"
    return status.exists() and json.loads(status.read_text(encoding="utf-8"))["state"] == "finished"


def kill(pid):
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        pass  # it ended meanwhile


class Attempts:
    """Starts the program in one folder and kills it; keeps the figures."""

    def __init__(self, program, work, dice, kills, only_all, scene_end):
        self.program, self.work, self.dice = program, work, dice
        self.wanted, self.only_all = kills, only_all
        self.scene = ["run", str(SCENE), "--set", f"time.end={scene_end}"]
        self.kills = 0
        self.hit = {"before the first checkpoint": 0, "while a checkpoint was being written": 0,
                    "while a frame was being written": 0, "while a text file was being written": 0, "between writes": 0}
        self.target = {"one rank": 0, "mpirun": 0, "everything": 0}
        self.slowest_end = 0.0
        self.n_restarts = self.n_fresh = 0

    def launch(self, out, ranks, *more):
        compression = self.dice.choice((0, 0, 0, 1))  # compressed frames are written in another way
        command = [self.program.path, *self.scene, "--set", f"output.compression={compression}", "--out", out, "--quiet", *more]
        if ranks > 1:
            command = [self.program.mpiexec, "-n", str(ranks), *command]
        log = open(self.work / f"{out}.log", "w+", encoding="utf-8", errors="replace")
        return subprocess.Popen(command, cwd=self.work, stdin=subprocess.DEVNULL, stdout=log, stderr=log,
                                start_new_session=True), log

    def wait_for_moment(self, process, folder):
        """Until a random moment, or until a file is being written after it; False if the run ended before."""
        moment = time.monotonic() + self.dice.uniform(0.05, 3.0)
        at_write = self.dice.random() < 0.5
        while process.poll() is None and time.monotonic() < moment:
            time.sleep(0.002)
        give_up = time.monotonic() + 2.0
        while at_write and process.poll() is None and time.monotonic() < give_up and not unfinished(folder, ".h5.tmp"):
            time.sleep(0.0005)
        return process.poll() is None

    def place(self, folder, earlier):
        """What the kill hit, by what was left; `earlier`: what an earlier kill had left."""
        left = [name for name, made in unfinished(folder, ".tmp").items() if earlier.get(name) != made]
        for kind in ("checkpoint", "frame"):
            if any(name.startswith(kind) and ".h5." in name for name in left):
                return f"while a {kind} was being written"
        if left:
            return "while a text file was being written"
        has_checkpoint = any(re.fullmatch(r"checkpoint_\d+\.h5", name) for name in names_in(folder))
        return "between writes" if has_checkpoint else "before the first checkpoint"

    def strike(self, process, folder):
        ranks = children(process.pid)  # none yet, or one rank without mpirun
        whole = [process.pid, *ranks]
        shared_memory = shared_memory_of(whole)
        kind = "everything" if self.only_all else self.dice.choice(sorted(self.target))
        if len(ranks) < 1:
            kind = "everything"
        if kind == "one rank":
            kill(self.dice.choice(ranks))
        elif kind == "mpirun":
            kill(process.pid)
        else:
            for pid in whole:
                kill(pid)
        self.target[kind] += 1
        seconds = end_of(whole, LONGEST_END)
        process.wait(timeout=LONGEST_END)
        if seconds is None:
            for pid in whole:
                kill(pid)
            fail(f"{LONGEST_END:.0f} s after SIGKILL to {kind} some of {whole} still ran")
        for name in shared_memory:
            pathlib.Path(name).unlink(missing_ok=True)
        self.slowest_end = max(self.slowest_end, seconds)
        if process.returncode == 0 and not has_finished(folder):
            fail(f"exit code 0 after SIGKILL to {kind}")
        return kind

    def run_to_end(self, out, allowed):
        """Kills the run in `out` up to `allowed` times, restarting it after each, until it ends by itself."""
        folder = self.work / out
        ranks, more = self.dice.randint(1, 5), []
        struck = 0
        while True:
            earlier = unfinished(folder, ".tmp")
            process, log = self.launch(out, ranks, *more)
            about = f"on {ranks} ranks"
            if struck < allowed and self.wait_for_moment(process, folder):
                kind = self.strike(process, folder)
                struck += 1
                self.kills += 1
                where = self.place(folder, earlier)
                self.hit[where] += 1
                print(f"kill {self.kills}: {kind} {about}, {where}", flush=True)
                ranks, more = self.dice.choice([n for n in range(1, 6) if n != ranks]), ["--restart"]
                self.n_restarts += 1
                log.close()
                continue
            code = process.wait(timeout=300)
            log.seek(0)
            text = log.read()
            log.close()
            if code == 2 and NO_CHECKPOINT in text and more == ["--restart"]:
                if any(re.fullmatch(r"checkpoint_\d+\.h5", name) for name in names_in(folder)):
                    print(text)
                    fail(f"{out}: has a checkpoint, but none was found whole")
                more = ["--overwrite"]
                self.n_fresh += 1
                continue
            if code != 0:
                print(text)
                fail(f"{out}: ended with {code} {about} after {struck} kills")
            if "passed over" in text or "left out" in text:
                print(text)
                fail(f"{out}: something on the disk was damaged")
            return struck


def rows_of(folder):
    with open(folder / "history.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.reader(file))
    keep = [n for n, column in enumerate(rows[0]) if column not in OWN_COLUMNS]
    for row in rows:
        if len(row) != len(rows[0]):
            fail(f"{folder}: history.csv has a row of {len(row)} values: {','.join(row)}")
    return [[row[n] for n in keep] for row in rows]


def by_id(file):
    particles = file["particles"]
    order = numpy.argsort(particles["id"][...], kind="stable")
    return {name: particles[name][...][order] for name in particles if name != "connectivity"}


def compare_frames(whole, out):
    names = sorted(path.name for path in whole.glob("frame_*.h5"))
    found = sorted(path.name for path in out.glob("frame_*.h5"))
    if names != found:
        fail(f"{out}: frames {sorted(set(names) ^ set(found))} are missing or too many")
    series = (out / "frames.xdmf").read_text(encoding="utf-8")
    listed = re.findall(r">(frame_\d+\.h5):/particles/position<", series)
    if listed != names:
        fail(f"{out}: frames.xdmf lists {listed}")
    for name in names:
        if not (out / name).with_suffix(".xdmf").exists():
            fail(f"{out}: {name} has no sidecar")
        with h5py.File(whole / name, "r") as a, h5py.File(out / name, "r") as b:
            for key in ("index", "step", "time", "n_particles"):
                if a.attrs[key] != b.attrs[key]:
                    fail(f"{out}: {key} of {name} is {b.attrs[key]} instead of {a.attrs[key]}")
            ours, theirs = by_id(a), by_id(b)
            for field, values in ours.items():
                if values.tobytes() != theirs[field].tobytes():
                    fail(f"{out}: {field} of {name} differs")
            if a["colliders/vertices"][...].tobytes() != b["colliders/vertices"][...].tobytes():
                fail(f"{out}: the colliders of {name} differ")


def compare_runs(program, work, out):
    folder, whole = work / out, work / "whole"
    left = sorted(path.name for path in folder.iterdir() if path.name.endswith(".tmp"))
    if left:
        fail(f"{out}: left over are {left}")
    ours = {path.name for path in whole.iterdir()}
    theirs = {path.name for path in folder.iterdir()}
    strange = {name for name in ours ^ theirs if not name.startswith("checkpoint_")}
    if strange:
        fail(f"{out}: {sorted(strange)} are missing or too many")
    if len(list(folder.glob("checkpoint_*.h5"))) != 2 or len(list(folder.glob("checkpoint_*.xdmf"))) != 2:
        fail(f"{out}: does not hold two checkpoints with their sidecars: {sorted(theirs)}")
    outcome = program.run(["compare", "whole", out], 1, work, 60)
    if outcome.code != 0 or "identical" not in outcome.text:
        fail(f"{out}: the last checkpoint differs", outcome)
    if rows_of(folder) != rows_of(whole):
        wrong = [a[0] for a, b in zip(rows_of(folder), rows_of(whole)) if a != b]
        fail(f"{out}: history.csv differs, in {len(wrong)} rows, first at step {wrong[:1]}; "
             f"{len(rows_of(folder))} rows for {len(rows_of(whole))}")
    compare_frames(whole, folder)


def main():
    def add(parser):
        parser.add_argument("--kills", type=int, default=20)
        parser.add_argument("--seed", type=int, default=1)
        parser.add_argument("--all", action="store_true", help="kill everything at once, never one process alone")
        parser.add_argument("--kills-per-run", type=int, default=8, help="a run that was killed so often may end")
        parser.add_argument("--end", type=float, default=0.06, help="simulated time of a run, s")
        parser.add_argument("--keep-files", action="store_true")
    arguments = parse_arguments(__doc__, add)
    program, work = start(arguments)
    attempts = Attempts(program, work, random.Random(arguments.seed), arguments.kills, arguments.all, arguments.end)
    whole, log = attempts.launch("whole", 2)
    if whole.wait(timeout=300) != 0:
        fail("the run that nobody kills failed")
    log.close()
    n_runs = 0
    while attempts.kills < arguments.kills:
        out = f"run{n_runs}"
        struck = attempts.run_to_end(out, min(arguments.kills_per_run, arguments.kills - attempts.kills))
        compare_runs(program, work, out)
        n_runs += 1
        print(f"{out}: {struck} kills, then it ended: identical", flush=True)
        if not arguments.keep_files:
            shutil.rmtree(work / out)
    print(f"{attempts.kills} kills in {n_runs} runs, all survived; {attempts.n_restarts - attempts.n_fresh} restarts from a "
          f"checkpoint, {attempts.n_fresh} new beginnings; at most {attempts.slowest_end:.1f} s until every process had ended")
    for figures in (attempts.hit, attempts.target):
        print(", ".join(f"{name}: {n}" for name, n in figures.items()))


if __name__ == "__main__":
    main()
