#!/usr/bin/env python3
"""A host whose processes are killed, that vanishes, whose link is cut, or one of whose ranks stops, ends the run by itself: with one
sentence that names rank, phase and checkpoint, the state "failed" that lets job scripts go on, and no process left on any host.
The run goes on from its checkpoint, on another number of hosts, to the bits of a run that nothing happened to."""

import json
import os
import re
import signal
import time

from runs import LIMIT, SCENE, Runs, enter, fail, hosts

TIMEOUT = 4  # s, for a step and for a write
SAVED, MORE, LAST = 60, 20, 480  # steps between checkpoints; after the restart; of the run that is not disturbed
SENTENCE = re.compile(r"(?=.*rank (\d) of 4)(?=.*in the phase \w+|.*writing '\S+')(?=.*the last good checkpoint is \S+/checkpoint_\d+\.h5$)"
                      r"(?=.*longer than \S+ s \((?:time\.step_timeout|checkpoint\.timeout)\)|.*was told to end, and cannot)")
WITHOUT_FRAMES = "output.frame_interval=0"  # of all runs, or of none: steps shorten to end at the times of frames
# mpirun's daemons find a link dead sooner than a step's limit, or later.
SOONER = {"time": 1, "intvl": 1, "probes": 1}
LATER = {"time": 2, "intvl": 2, "probes": 2}
KILLED = -signal.SIGKILL  # of mpirun itself
PATIENCE = 30.0  # s, until the last process has ended, on a busy machine


class Trials:
    def __init__(self, program, work, group):
        self.work, self.group, self.runs = work, group, Runs(program, work, group)
        self.runs.run([1], "whole", LAST, f"checkpoint.steps={MORE}", f"checkpoint.keep={LAST}", WITHOUT_FRAMES)

    def begin(self, name, keepalive):
        """A run on two hosts, two ranks each, some steps after a checkpoint."""
        settings = [f"checkpoint.steps={SAVED}", "checkpoint.keep=2", f"checkpoint.timeout={TIMEOUT}", f"time.step_timeout={TIMEOUT}",
                    WITHOUT_FRAMES]
        arguments = ["run", str(SCENE), "--out", name, *(word for each in settings for word in ("--set", each))]
        launcher = [word for key, value in keepalive.items() for word in ("--mca", f"oob_tcp_keepalive_{key}", str(value))]
        log = open(self.work / f"{name}.log", "w", encoding="utf-8")
        process = self.group[0].start(self.group.mpirun([2, 2], arguments, launcher=launcher), self.work, stdout=log)
        end = time.monotonic() + LIMIT
        while not list((self.work / name).glob("checkpoint_*.h5")):
            if time.monotonic() > end or process.poll() is not None:
                fail(f"{name}: no checkpoint\n{self.log(name)}")
            time.sleep(0.02)
        time.sleep(0.3)
        return process

    def log(self, name):
        return (self.work / f"{name}.log").read_text(encoding="utf-8")

    def trial(self, name, act, speakers, codes, keepalive=LATER):
        """`act` happens to a run: one of the ranks `speakers` must say what status.json says, and mpirun end with one of `codes`. What
        a rank says is printed by mpirun, if that still lives."""
        process = self.begin(name, keepalive)
        before = time.monotonic()
        act()
        while process.poll() is None or any(host.processes() for host in self.group):
            if time.monotonic() > before + PATIENCE:
                left = {host.name: host.processes() for host in self.group}
                for host in self.group:
                    host.kill()
                fail(f"{name}: {left} live on {PATIENCE:.0f} s later, mpirun: {process.poll()}\n{self.log(name)}")
            time.sleep(0.05)
        seconds = time.monotonic() - before
        status = json.loads((self.work / name / "status.json").read_text(encoding="utf-8"))
        said = SENTENCE.match(status["reason"])
        if status["state"] != "failed" or status.get("unresponsive") is not True or not said or int(said[1]) not in speakers:
            fail(f"{name}: status.json says {status}\n{self.log(name)}")
        lines = [line for line in self.log(name).splitlines() if line.startswith("bulkley: ")]
        if process.returncode not in codes or (process.returncode != KILLED and f"bulkley: {status['reason']}" not in lines):
            fail(f"{name}: mpirun ended with {process.returncode}\n{self.log(name)}")
        print(f"{name}: all ended {seconds:.1f} s later, mpirun with {process.returncode}: {status['reason']}")
        self.goes_on(name)

    def goes_on(self, name):
        for host in self.group:
            host.restore()
        newest = max(int(path.stem.split("_")[1]) for path in (self.work / name).glob("checkpoint_*.h5"))
        self.runs.run([1, 1, 1], name, newest + MORE, "--restart", WITHOUT_FRAMES)
        self.runs.expect_same(name, newest + MORE, "whole")

    # --- what happens to the second host, or to the first, where mpirun and the root are ---------------------------------

    def kill(self):
        # Open MPI's daemons talk: mpirun finds a connection closed, ends the other ranks and has an exit code of its own.
        self.trial("killed", self.group[1].kill, {0}, {3, 205})
        self.trial("killed_root", self.group[0].kill, {2, 3}, {KILLED})

    def vanish(self):
        def act():
            self.group[1].cut()
            self.group[1].kill()

        self.trial("vanished", act, {0}, {3, 205})

    def cut(self):
        self.trial("cut", self.group[1].cut, {0, 2, 3}, {3, 205})
        self.trial("cut_noticed", self.group[1].cut, {0, 2, 3}, {3, 205}, SOONER)

    def stop(self):
        def act(host, which):
            os.kill(which(self.group[host].processes("bulkley")), signal.SIGSTOP)

        self.trial("stopped", lambda: act(1, max), {0}, {3})
        self.trial("stopped_root", lambda: act(0, min), {1}, {3})

    def disk(self):
        """The output folder on the first host's disk: refused at the start, and at a restart of a run that began there alone."""
        (self.work / "disk").mkdir()
        self.group[0].own_disk(self.work / "disk")
        self.runs.run([2], "disk/alone", MORE)
        sentence = (r"^disk/{0}: rank 1 does not see the output folder that rank 0 has made or found: the hosts of all ranks must "
                    r"share its disk$")
        for name, more in (("new", []), ("alone", ["--restart"])):
            arguments = ["run", str(SCENE), "--out", f"disk/{name}", "--max-steps", str(2 * MORE), *more]
            outcome = self.group.run([1, 1], arguments, self.work, LIMIT)
            if outcome.code != 2 or len(re.findall(sentence.format(name), outcome.text, re.MULTILINE)) != 1:
                fail(f"disk/{name}: exit code {outcome.code}", outcome)
        print("a disk of one host: refused")


def main():
    arguments, program, work = enter(__doc__, lambda parser: parser.add_argument("--trial", required=True))
    with hosts.Hosts(3, work, program.path, program.mpiexec) as group:
        getattr(Trials(program, work, group), arguments.trial)()


if __name__ == "__main__":
    main()
