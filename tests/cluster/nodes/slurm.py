#!/usr/bin/env python3
"""A Slurm of three hosts, and a run on two of them. A rank stops: the run ends itself, and its job queues itself again. A host is lost:
Slurm queues the job again. Both go on from their checkpoint, the second on the hosts that are left, and end with the bits of a run on one
rank."""

import getpass
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import time

from runs import SCENE, LIMIT, Runs, enter, fail, hosts

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "packaging" / "cluster"))
import slurm_server  # noqa: E402
from slurm_test import CLUSTER, edited  # noqa: E402

STEPS, SAVED = 400, 60
TIMEOUT = 4  # s, for a step and for a write
# Ports may be any: nobody else is on these hosts.
NODES = """
SlurmdTimeout=5
TmpFS=/run
NodeName=node[1-3] NodeAddr={subnet}.[1-3] CPUs=4 RealMemory=1000 State=UNKNOWN
PartitionName=main Nodes=node[1-3] Default=YES MaxTime=INFINITE State=UP OverSubscribe=NO
"""
OF_ONE_NODE = ("NodeName", "PartitionName", "SlurmdSpoolDir", "SlurmdPidFile", "SlurmdLogFile")


class Slurm(slurm_server.Slurm):
    """The controller on the first host, a slurmd on each; munge's socket is a file that all of them see."""

    def __init__(self, folder, group):
        super().__init__(folder)
        self.group = group

    def start(self):
        for name in ("controller", "munge", *(host.name for host in self.group)):
            (self.folder / name).mkdir(parents=True, mode=0o700)
        self.sockets = pathlib.Path(tempfile.mkdtemp(prefix="slurm_", dir=self.folder.parent))
        self.sockets.chmod(0o711)
        text = slurm_server.CONFIGURATION.format(
            host="node1", user=getpass.getuser(), folder=self.folder, sockets=self.sockets, controller_port=6817, node_port=6818)
        text = text.replace("(127.0.0.1)", f"({self.group[0].address})")
        lines = [line for line in text.splitlines() if not line.startswith(OF_ONE_NODE)]
        lines += [f"Slurmd{key}={self.folder}/%n/{key.lower()}" for key in ("SpoolDir", "PidFile", "LogFile")]
        (self.folder / "slurm.conf").write_text("\n".join(lines) + NODES.format(subnet=hosts.SUBNET), encoding="utf-8")
        (self.folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\nCgroupAutomount=no\n", encoding="utf-8")
        self.environment = {**os.environ, "SLURM_CONF": str(self.folder / "slurm.conf")}
        self.start_munge()
        self.daemon("slurmctld", *self.group[0].command(["slurmctld", "-D"], self.folder))
        for host in self.group:
            self.daemon(f"slurmd_{host.name}", *host.command(["slurmd", "-D", "-N", host.name], self.folder))
        self.wait_for("the nodes", lambda: self.call("sinfo", "--noheader", "--format=%D %T").stdout.strip() == "3 idle")

    def last_line(self, name):
        return super().last_line("slurmctld" if name == "slurmd" else name)

    def call(self, *command, cwd=None, **environment):
        try:
            return subprocess.run(self.group[0].command(command, cwd or self.folder), env={**self.environment, **environment},
                                  stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=10)
        except subprocess.TimeoutExpired:
            return subprocess.CompletedProcess(command, 124, "", "no answer within 10 s")


def trial(name, settings, act, nodes_after, program, work, slurm):
    """A job on the first two hosts, `act` after its first checkpoint: Slurm starts it twice, and it ends on `nodes_after`."""
    script = work / f"{name}.sh"
    words = [f"--set {key}" for key in (f"checkpoint.steps={SAVED}", "output.frame_interval=0", *settings)]
    script.write_text(edited("srun.sh", nodes=2, ntasks_per_node=1, program=program.path, scene=str(SCENE), folder=name,
                             options=f"(--max-steps {STEPS} {' '.join(words)})"), encoding="utf-8")
    number = slurm.submit(work, script.name, BULKLEY_SCRIPTS=str(CLUSTER), launcher_patience="2")

    def wait_for(what, met):
        end = time.monotonic() + LIMIT
        while not met():
            if time.monotonic() > end or slurm.job(number)["JobState"] == "FAILED":
                print(slurm.call("scontrol", "show", "job", number).stdout, slurm.call("sinfo").stdout)
                for log in work.glob("*.log"):
                    print(log.read_text(encoding="utf-8", errors="replace"))
                fail(f"{name}: {what}: not within {LIMIT:.0f} s")
            time.sleep(0.1)

    wait_for("a checkpoint", lambda: list((work / name).glob("checkpoint_*.h5")))
    if slurm.job(number)["NodeList"] != "node[1-2]":
        fail(f"{name}: the job runs on {slurm.job(number)['NodeList']}")
    before = time.monotonic()
    act()
    wait_for("the job's second start", lambda: slurm.job(number).get("Restarts") == "1")
    wait_for("the job's end", lambda: slurm.job(number)["JobState"] in ("COMPLETED", "FAILED", "CANCELLED"))
    job = slurm.job(number)
    status = json.loads((work / name / "status.json").read_text(encoding="utf-8"))
    parts = (work / name / "parts.txt").read_text(encoding="utf-8").splitlines()
    if job["JobState"] != "COMPLETED" or job["NodeList"] != nodes_after or status["state"] != "finished" or len(parts) != 2:
        fail(f"{name}: job {job['JobState']} on {job['NodeList']}, {status['state']}, {parts}")
    start = int(parts[1].split()[-1])
    if not 0 < start < STEPS:
        fail(f"{name}: the second part began at step {start}")
    print(f"{name}: queued again by Slurm, continued from step {start} on {nodes_after}, ended {time.monotonic() - before:.0f} s later")


def main():
    _, program, work = enter(__doc__)
    try:
        slurm_server.expect_tools()
        with hosts.Hosts(3, work, program.path, program.mpiexec) as group, Slurm(work / "slurm", group) as slurm:
            runs = Runs(program, work, group)
            runs.run([1], "whole", STEPS, "output.frame_interval=0")

            def stop_rank():
                os.kill(max(group[1].processes("bulkley")), signal.SIGSTOP)

            def lose_host():
                group[1].cut()
                group[1].kill()

            trial("silent_rank", [f"time.step_timeout={TIMEOUT}", f"checkpoint.timeout={TIMEOUT}"], stop_rank, "node[1-2]", program, work,
                  slurm)
            trial("lost_node", [], lose_host, "node[1,3]", program, work, slurm)
            for name in ("silent_rank", "lost_node"):
                runs.expect_same(name, STEPS, "whole")
                print(f"{name}: identical")
    except slurm_server.CannotRun as reason:
        hosts.skip(reason)


if __name__ == "__main__":
    main()
