#!/usr/bin/env python3
"""Runs that are stopped - by signals to mpirun, to one rank or to a run without mpirun, once or twice, during set-up or
checkpoints, by the file STOP, by their wall time - end in order with a whole checkpoint and tell the command that goes on;
that command ends where an uninterrupted run ends, bit for bit."""

import json
import os
import pathlib
import re
import shlex
import signal
import subprocess
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

BASE = pathlib.Path(__file__).resolve().with_name("base.toml")
STEPS = 900
STOPPED = 4
LIMIT = 60.0  # s
LONGEST_START = 10.0  # s, until main
OFTEN = ["--set", "checkpoint.steps=1"]  # so that the run is slow, and signals arrive during a checkpoint, or nearly


class Run:
    """A run in the background."""

    def __init__(self, program, work, name, ranks, *more):
        self.folder = work / name
        self.name = name
        launcher = [program.mpiexec, "-n", str(ranks)] if ranks > 1 else []
        command = [*launcher, program.path, "run", "scene.toml", "--out", name, "--max-steps", str(STEPS), *more]
        self.process = subprocess.Popen(command, cwd=work, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                        stderr=subprocess.STDOUT, text=True, start_new_session=True)

    def ranks(self):
        text = subprocess.run(["ps", "-o", "pid=", "--ppid", str(self.process.pid)], capture_output=True, text=True).stdout
        return [int(word) for word in text.split()]

    def wait_for(self, what, met):
        end = time.monotonic() + LIMIT
        while not met():
            if time.monotonic() > end or self.process.poll() is not None:
                fail(f"{self.name}: {what} never came")
            time.sleep(0.01)

    def wait_for_rows(self, n):
        history = self.folder / "history.csv"
        self.wait_for(f"row {n} of history.csv", lambda: history.exists() and history.read_bytes().count(b"\n") > n)

    def end(self):
        """Exit code and text; a run that does not end is a failure."""
        try:
            text, _ = self.process.communicate(timeout=LIMIT)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            fail(f"{self.name}: still running {LIMIT:.0f} s after it was asked to stop")
        return self.process.returncode, text


def status_of(run):
    return json.loads((run.folder / "status.json").read_text(encoding="utf-8"))


def checkpoint(folder, step):
    return folder / f"checkpoint_{step:09d}.h5"


class Stops:
    def __init__(self, program, work):
        self.program, self.work = program, work
        text = BASE.read_text(encoding="utf-8").replace("cell_size = 0.01", "cell_size = 0.005").replace("end = 0.01", "end = 1.0")
        (work / "scene.toml").write_text(text + "[output]\nhistory_interval = 5\n", encoding="utf-8")
        outcome = program.run(["run", "scene.toml", "--out", "whole", "--max-steps", str(STEPS)], 2, work, LIMIT)
        if outcome.code != 0:
            fail("the run that is not interrupted failed", outcome)
        print(f"whole run: {outcome.seconds:.1f} s")

    def run(self, name, ranks, *more):
        return Run(self.program, self.work, name, ranks, *more)

    def go_on(self, run, command, ranks):
        """Runs `command`, on `ranks` ranks, to the last step, and compares."""
        words = shlex.split(command)
        assert words[:2] == ["bulkley", "run"], command
        outcome = self.program.run([*words[1:], "--set", "checkpoint.steps=0", "--max-steps", str(STEPS)], ranks, self.work,
                                   LIMIT)
        if outcome.code != 0:
            fail(f"{run.name}: '{command}' on {ranks} ranks ended with {outcome.code}", outcome)
        compare = self.program.run(["compare", str(checkpoint(self.work / "whole", STEPS)),
                                    str(checkpoint(run.folder, STEPS))], 1, self.work, LIMIT)
        if compare.code != 0 or "identical" not in compare.text:
            fail(f"{run.name}: the continued run differs from the whole one", compare)

    def expect_stop(self, run, reason, ranks):
        code, text = run.end()
        if code != STOPPED:
            print(text)
            fail(f"{run.name}: exit code {code} instead of {STOPPED}")
        said = re.search(r"^stopped: (.*) at step (\d+); continue with: mpirun -n \d+ (bulkley run .*)$", text, re.MULTILINE)
        if not said or reason not in said.group(1):
            print(text)
            fail(f"{run.name}: no sentence on '{reason}' and how to go on")
        step = int(said.group(2))
        status = status_of(run)
        if status["state"] != "stopped" or status["step"] != step or not checkpoint(run.folder, step).exists():
            fail(f"{run.name}: status.json is {status} after a stop at step {step}")
        if not 0 < step < STEPS:
            fail(f"{run.name}: stopped at step {step}, not on the way")
        self.go_on(run, re.sub(r" --max-walltime \S+", "", said.group(3)), ranks)
        print(f"{run.name}: stopped at step {step}, continued on {ranks} ranks: identical")

    # --- what can ask ----------------------------------------------------------------------------------------------------

    def signal_to_mpirun(self):
        run = self.run("signal_to_mpirun", 3, *OFTEN)
        run.wait_for_rows(5)
        run.process.send_signal(signal.SIGUSR1)
        self.expect_stop(run, "by a signal", 2)

    def signal_to_one_rank(self, number):
        run = self.run(f"signal_{number}_to_one_rank", 3, *OFTEN)
        run.wait_for_rows(5)
        os.kill(run.ranks()[-1], number)
        self.expect_stop(run, "by a signal", 1)

    def signal_without_mpirun(self):
        run = self.run("signal_without_mpirun", 1, *OFTEN)
        run.wait_for_rows(5)
        run.process.send_signal(signal.SIGTERM)
        self.expect_stop(run, "by a signal", 2)

    def signal_twice(self):
        run = self.run("signal_twice", 2, *OFTEN)
        run.wait_for_rows(5)
        for _ in range(2):
            run.process.send_signal(signal.SIGUSR1)
            time.sleep(0.02)
        self.expect_stop(run, "by a signal", 3)

    def signal_during_checkpoints(self):
        run = self.run("signal_during_checkpoints", 2, *OFTEN)
        run.wait_for_rows(3)
        for number in (signal.SIGUSR2, signal.SIGUSR1, signal.SIGUSR1):
            run.process.send_signal(number)
            time.sleep(0.003)
        self.expect_stop(run, "by a signal", 1)

    def signal_during_set_up(self):
        """To one rank as soon as it is there: before main the rank is killed and no file is written, later the run stops."""
        n_stopped = 0
        delays = [0.0, 0.1, 0.2, 0.4, 0.6]
        for delay in delays:
            run = self.run(f"signal_during_set_up_{delay:g}", 2, *OFTEN)
            run.wait_for("the ranks", lambda: len(run.ranks()) == 2)
            time.sleep(delay)
            os.kill(run.ranks()[0], signal.SIGUSR1)
            if delay > 0.0 and (run.folder / "status.json").exists():
                self.expect_stop(run, "by a signal", 1)
                n_stopped += 1
                continue
            code, text = run.end()
            if code == STOPPED:
                n_stopped += 1
                if status_of(run)["state"] != "stopped":
                    fail(f"{run.name}: exit code {code} and status.json {status_of(run)}")
            elif code == 0 or (run.folder / "status.json").exists():
                print(text)
                fail(f"{run.name}: exit code {code}")
            if delay == delays[-1] and n_stopped == 0 and delay < LONGEST_START:
                delays.append(2.0 * delay)  # a slow machine
        if n_stopped == 0:
            fail("no signal during set-up led to a stop in order")
        print(f"signal_during_set_up: {n_stopped} of {len(delays)} stopped in order, the others had not begun")

    def terminated_mpirun(self):
        """mpirun kills its ranks soon after TERM: the newest complete checkpoint remains."""
        run = self.run("terminated_mpirun", 3, *OFTEN)
        run.wait_for_rows(4)
        run.process.send_signal(signal.SIGTERM)
        code, _ = run.end()
        if code == 0:
            fail(f"{run.name}: exit code 0")
        self.go_on(run, "bulkley run scene.toml --out terminated_mpirun --restart", 2)
        print(f"{run.name}: exit code {code}, continued on 2 ranks: identical")

    def stop_file(self):
        run = self.run("stop_file", 2, *OFTEN)
        run.wait_for_rows(3)
        (run.folder / "STOP").touch()
        self.expect_stop(run, "by the file stop_file/STOP", 3)
        if (run.folder / "STOP").exists():
            fail("stop_file: the file STOP is still there")

    def wall_time(self, seconds):
        for _ in range(3):  # no run can predict that the disk stalls; that it does three times has another cause
            before = time.monotonic()
            run = self.run("wall_time", 2, "--overwrite", "--max-walltime", f"{seconds:g}s", *OFTEN)
            code, text = run.end()
            took = time.monotonic() - before
            if code != STOPPED or f"before its wall time of {seconds:g} s is over" not in text:
                print(text)
                fail(f"wall_time: exit code {code}")
            if took <= seconds + 3.0:  # mpirun and MPI_Init come before the program's clock starts
                break
            print(f"wall_time: ended after {took:.1f} s, asked for {seconds:g} s")
        else:
            fail("wall_time: three runs ended too late")
        self.go_on(run, "bulkley run scene.toml --out wall_time --restart", 3)
        print(f"wall_time: ended after {took:.1f} s of {seconds:g} s, continued on 3 ranks: identical")

    def checkpoint_and_on(self):
        run = self.run("checkpoint_and_on", 2)
        run.wait_for_rows(5)
        run.process.send_signal(signal.SIGUSR2)
        code, text = run.end()
        found = sorted(path.name for path in run.folder.glob("checkpoint_*.h5"))
        if code != 0 or len(found) != 2:
            print(text)
            fail(f"checkpoint_and_on: exit code {code}, {found}")
        self.go_on(run, "bulkley run scene.toml --out checkpoint_and_on --restart checkpoint_and_on/" + found[0], 3)
        print(f"checkpoint_and_on: {found[0]} on the way to the end, continued from there: identical")


def main():
    program, work = start(parse_arguments(__doc__))
    stops = Stops(program, work)
    stops.signal_to_mpirun()
    for number in (signal.SIGTERM, signal.SIGINT):
        stops.signal_to_one_rank(int(number))
    stops.signal_without_mpirun()
    stops.signal_twice()
    stops.signal_during_checkpoints()
    stops.signal_during_set_up()
    stops.terminated_mpirun()
    stops.stop_file()
    stops.wall_time(3.0)
    stops.checkpoint_and_on()


if __name__ == "__main__":
    main()
