#!/usr/bin/env python3
"""A step that does not come back, because a rank or its launcher is gone, ends every rank with one sentence and exit code 3, and
the run goes on from its checkpoint to the bits of a run that nothing happened to. A job that is suspended and resumed as a
whole goes on by itself. A checkpoint that is not read to its end ends all ranks likewise."""

import json
import os
import pathlib
import re
import signal
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from stops import BASE, LIMIT, STEPS, Run, status_of  # noqa: E402

TIMEOUT = 3.0  # s
RANKS = 3
SAVED = 300  # steps between checkpoints: ranks are stopped soon after the first
SAVING = ["--set", f"checkpoint.steps={SAVED}", "--set", "checkpoint.keep=2", "--set", "partition.method=ranges"]
SENTENCE = re.compile(r"bulkley: step (\d+) has taken longer than 3 s \(time\.step_timeout\); rank (\d) of 3, which says this, is in "
                      r"the phase (\w+): another rank does not answer, or the machine is too slow; the last good checkpoint "
                      r"is \S+/checkpoint_\d+\.h5\n")


def is_alive(pid):
    try:
        return pathlib.Path(f"/proc/{pid}/stat").read_text(encoding="utf-8").rsplit(")", 1)[1].split()[0] != "Z"
    except OSError:
        return False


class Cases:
    def __init__(self, program, work):
        self.program, self.work = program, work
        text = BASE.read_text(encoding="utf-8").replace("cell_size = 0.01", "cell_size = 0.005").replace("end = 0.01", "end = 1.0")
        (work / "scene.toml").write_text(text + "[output]\nhistory_interval = 5\n", encoding="utf-8")
        outcome = program.run(["run", "scene.toml", "--out", "whole", "--max-steps", str(STEPS)], 2, work, 3 * LIMIT)
        if outcome.code != 0:
            fail("the run that is not disturbed failed", outcome)

    def begin(self, name, timeout=TIMEOUT):
        """A run of three ranks that has written its first checkpoint and gone on, to be stopped in a step; and its ranks'
        processes, in no order."""
        run = Run(self.program, self.work, name, RANKS, "--set", f"time.step_timeout={timeout}", *SAVING)
        run.wait_for_rows(SAVED // 5 + 2)
        pids = run.ranks()
        if len(pids) != RANKS:
            fail(f"{name}: {len(pids)} ranks found")
        return run, pids

    def root_of(self, run, pids):
        """The process that renews status.json: the one that has history.csv open."""
        for pid in pids:
            for link in pathlib.Path(f"/proc/{pid}/fd").iterdir():
                if os.path.realpath(link) == str((run.folder / "history.csv").resolve()):
                    return pid
        fail(f"{run.name}: no rank has history.csv open")

    def stopped_rank(self, name, is_root):
        run, pids = self.begin(name)
        root = self.root_of(run, pids)
        victim = root if is_root else next(pid for pid in pids if pid != root)
        os.kill(victim, signal.SIGSTOP)
        before = time.monotonic()
        code, text = run.end()
        seconds = time.monotonic() - before
        found = SENTENCE.findall(text)
        if code != 3 or len(found) != 1 or (found[0][1] == "0") == is_root:
            fail(f"{name}: exit code {code}, {len(found)} sentences\n{text}")
        if seconds > TIMEOUT + 12.0:
            fail(f"{name}: ended {seconds:.1f} s after the rank was stopped")
        if any(is_alive(pid) for pid in pids):
            time.sleep(2.0)
            if any(is_alive(pid) for pid in pids):
                fail(f"{name}: a rank lives on")
        status = status_of(run)
        if status["state"] != "failed" or status.get("unresponsive") is not True or "step_timeout" not in status["reason"]:
            fail(f"{name}: status.json says {status}")
        print(f"{name}: ended {seconds:.1f} s after the rank was stopped, in the phase {found[0][2]}")
        self.goes_on(run)

    def goes_on(self, run):
        outcome = self.program.run(["run", "scene.toml", "--out", run.name, "--restart", "--max-steps", str(STEPS)], 2, self.work,
                                   3 * LIMIT)
        if outcome.code != 0:
            fail(f"{run.name}: did not go on", outcome)
        if "unresponsive" in status_of(run):
            fail(f"{run.name}: status.json still says unresponsive")
        self.same(run)

    def same(self, run):
        files = [str(folder / f"checkpoint_{STEPS:09d}.h5") for folder in (run.folder, self.work / "whole")]
        outcome = self.program.run(["compare", *files], 1, self.work, LIMIT)
        if outcome.code != 0 or "identical" not in outcome.text:
            fail(f"{run.name}: other bits than without the stop", outcome)

    def suspended_job(self):
        """All ranks stop for longer than the limit, and go on."""
        run, pids = self.begin("suspended")
        for pid in pids:
            os.kill(pid, signal.SIGSTOP)
        time.sleep(TIMEOUT + 4.0)
        for pid in pids:
            os.kill(pid, signal.SIGCONT)
        code, text = run.end()
        if code != 0 or "step_timeout" in text:
            fail(f"suspended: exit code {code}\n{text}")
        self.same(run)
        print("suspended: went on")

    def never(self):
        """With 0 a rank may take as long as it likes."""
        run, pids = self.begin("never", 0)
        os.kill(pids[0], signal.SIGSTOP)
        time.sleep(TIMEOUT + 4.0)
        os.kill(pids[0], signal.SIGCONT)
        code, text = run.end()
        if code != 0:
            fail(f"never: exit code {code}\n{text}")
        self.same(run)
        print("never: went on")

    def silent_file(self, shim, rank):
        """A file system that never answers one rank, which reads the checkpoint to continue from."""
        folder = self.work / "silent"
        outcome = self.program.run(["run", "scene.toml", "--out", "silent", "--overwrite", "--max-steps", "20"], 1, self.work, LIMIT)
        if outcome.code != 0:
            fail("silent: the run before failed", outcome)
        command = ["run", "scene.toml", "--out", "silent", "--restart", "--max-steps", "40"]
        fault = {"LD_PRELOAD": shim, "FAULT_PATH": "checkpoint_000000020", "FAULT_CALLS": "pread", "FAULT_KIND": "hang",
                 "FAULT_RANK": str(rank)}
        outcome = self.program.run([*command, "--set", "checkpoint.timeout=3"], RANKS, self.work, LIMIT, fault)
        said = re.findall(r"bulkley: starting from the newest checkpoint of silent has taken longer than 3 s \(checkpoint\.timeout\), "
                          r"says rank (\d) of 3: the file system or another rank does not answer\n", outcome.text)
        status = json.loads((folder / "status.json").read_text(encoding="utf-8"))
        if outcome.code != 3 or len(said) != 1 or status["state"] != "failed" or status.get("unresponsive") is not True:
            fail(f"silent: exit code {outcome.code}, {len(said)} sentences, {status}", outcome)
        outcome = self.program.run(command, RANKS, self.work, LIMIT)
        if outcome.code != 0:
            fail("silent: did not go on", outcome)
        print(f"a file that does not answer rank {rank}: ended, says rank {said[0]}, and went on")

    def silent_start(self, shim):
        """A file system that never answers while a new run begins: there is no status yet."""
        fault = {"LD_PRELOAD": shim, "FAULT_PATH": "scene.toml", "FAULT_CALLS": "write", "FAULT_KIND": "hang", "FAULT_RANK": "0"}
        command = ["run", "scene.toml", "--out", "silent_start", "--max-steps", "20"]
        outcome = self.program.run([*command, "--set", "time.step_timeout=3"], RANKS, self.work, LIMIT, fault)
        said = re.findall(r"bulkley: (the start of the run has taken longer than 3 s \(time\.step_timeout\), says rank 0 of 3: .*)\n",
                          outcome.text)
        status = json.loads((self.work / "silent_start/status.json").read_text(encoding="utf-8"))
        if outcome.code != 3 or len(said) != 1 or status["reason"] != said[0] or status.get("unresponsive") is not True:
            fail(f"silent start: exit code {outcome.code}, {len(said)} sentences, {status}", outcome)
        outcome = self.program.run(command, RANKS, self.work, LIMIT)
        if outcome.code != 0:
            fail("silent start: the next run in this folder", outcome)
        print("a file that does not answer a new run: ended, and another one began")

    def lost_launcher(self):
        """Ranks whose launcher was killed do not live on, not even one that was stopped then."""
        run, pids = self.begin("orphans")
        os.kill(pids[0], signal.SIGSTOP)
        os.kill(run.process.pid, signal.SIGKILL)
        run.process.communicate(timeout=LIMIT)
        os.kill(pids[0], signal.SIGCONT)
        end = time.monotonic() + 10.0
        while any(is_alive(pid) for pid in pids):
            if time.monotonic() > end:
                fail(f"orphans: {[pid for pid in pids if is_alive(pid)]} live on")
            time.sleep(0.1)
        self.goes_on(run)
        print("orphans: ended")


def main():
    arguments = parse_arguments(__doc__, lambda parser: parser.add_argument("--shim", help="storage_shim.c"))
    program, work = start(arguments)
    cases = Cases(program, work)
    cases.stopped_rank("stopped", False)
    cases.stopped_rank("stopped_root", True)
    cases.suspended_job()
    cases.never()
    cases.lost_launcher()
    if arguments.shim:
        cases.silent_file(arguments.shim, 0)
        cases.silent_file(arguments.shim, 2)
        cases.silent_start(arguments.shim)


if __name__ == "__main__":
    main()
