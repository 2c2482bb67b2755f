#!/usr/bin/env python3
"""What the job scripts of cluster/jobs/slurm and cluster/jobs/pbs decide, without a batch system: bulkley, srun, mpirun, squeue,
scontrol, qsub and qstat are shell scripts of this test, and status.json says what each case wants it to say."""

import functools
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

CLUSTER = pathlib.Path(__file__).resolve().parents[3] / "cluster" / "jobs"
CLOCK = "2:00:00"  # the time limit
LIMIT = "--max-walltime 6900s"  # which is that less the reserve of 300 s
COMMANDS = {
    # Records its options; then follows the file "part".
    "bulkley": 'echo "bulkley $*" >>calls.txt; . ./part',
    "srun": 'shift; exec "$@"',  # --mpi=pmix
    "mpirun": 'shift 2; exec "$@"',  # -n N
    "scontrol": 'echo "scontrol $*" >>calls.txt; exit "${REFUSE:-0}"',
    "qsub": 'echo "qsub $*" >>calls.txt; exit "${REFUSE:-0}"',
    "squeue": f'case "$*" in *%L*) echo "${{LEFT:-{CLOCK}}}";; *" ${{RUNNING:-none}} "*) echo RUNNING;; *) exit 1; esac',
    "qstat": f'echo "    Resource_List.walltime = {CLOCK}"; [ "$2" != "${{RUNNING:-none}}" ] || echo "    job_state = R"',
}


def status(state, step, reason="because", unresponsive=False):
    more = {"unresponsive": True} if unresponsive else {}
    return json.dumps({"state": state, "step": step, "time": 0.5, "checkpoint": "x.h5", "reason": reason, **more}, indent=2)


class Folder:
    """One output folder and the jobs that work in it."""

    def __init__(self, work, name, script):
        self.path = work / name
        self.output = self.path / "out" / "scene"
        self.script = script
        self.output.mkdir(parents=True)
        commands = self.path / "commands"
        commands.mkdir()
        for command, body in COMMANDS.items():
            (commands / command).write_text(f"#!/bin/bash\n{body}\n", encoding="utf-8")
            (commands / command).chmod(0o755)
        (self.path / "nodes").write_text("a\na\n", encoding="utf-8")

    def job(self, number, part, script_edit=None, **environment):
        """Runs the job script, in which bulkley does `part` (bash): exit code, calls of the commands, and the log."""
        (self.path / "part").write_text(part + "\n", encoding="utf-8")
        (self.path / "calls.txt").write_text("", encoding="utf-8")
        text = (CLUSTER / self.script).read_text(encoding="utf-8")
        (self.path / "job.sh").write_text(script_edit(text) if script_edit else text, encoding="utf-8")
        outcome = subprocess.run(
            ["bash", "job.sh"], cwd=self.path, capture_output=True, text=True, timeout=30, stdin=subprocess.DEVNULL,
            env={"PATH": f"{self.path / 'commands'}:{os.environ['PATH']}", "BULKLEY_SCRIPTS": str(CLUSTER),
                 "SLURM_JOB_ID": number, "SLURM_NTASKS": "2", "PBS_JOBID": number, "PBS_O_WORKDIR": str(self.path),
                 "PBS_NODEFILE": str(self.path / "nodes"), **environment})
        calls = (self.path / "calls.txt").read_text(encoding="utf-8").splitlines()
        return outcome.returncode, calls, outcome.stdout + outcome.stderr

    def writes(self, state, step, code, checkpoint=True, reason="because", unresponsive=False):
        """What a part does that ends so."""
        touch = f"touch out/scene/checkpoint_{step:09d}.h5\n" if checkpoint else ""
        text = status(state, step, reason, unresponsive)
        return f"{touch}cat >out/scene/status.json <<'END'\n{text}\nEND\nexit {code}"


def is_request(call):
    return call.startswith(("scontrol requeue", "qsub"))


class Cases:
    def __init__(self, work, script, system, name="case"):
        self.work, self.script, self.system, self.name = work, script, system, name
        self.n_folders = 0

    def folder(self):
        self.n_folders += 1
        return Folder(self.work, f"{self.script.replace('/', '_')}_{self.name}_{self.n_folders}", self.script)

    def expect(self, what, result, code, options=None, request=None, sentence=""):
        """`options`: the part of bulkley's that the job chose, None: bulkley must not be called."""
        calls = result[1]
        runs = [call for call in calls if call.startswith("bulkley")]
        chosen = re.sub(r"^bulkley run scene.toml --out out/scene ?", "", runs[0]) if runs else None
        if self.system == "pbs" and chosen:  # whose script counts the seconds since it began, which are a few
            chosen = re.sub(r"walltime 689[0-9]s", "walltime 6900s", chosen)
        requests = [call for call in calls if is_request(call)]
        if result[0] != code or chosen != options or requests != ([request] if request else []) or sentence not in result[2]:
            print(result)
            fail(f"{self.script}: {what}: exit code {result[0]}, options {chosen}, requests {requests}; "
                 f"expected {code}, {options}, {request}, and the sentence '{sentence}'")

    def again(self, number="7"):
        if self.system == "slurm":
            return f"scontrol requeue {number}"
        return f"qsub -W depend=afterany:{number} -v BULKLEY_CHAIN=7,BULKLEY_SCRIPTS={CLUSTER} mpirun.sh"

    def chain(self, part):
        """Job number and environment of a part of a chain: Slurm keeps the number, PBS hands on that of the first."""
        return ("7", {}) if self.system == "slurm" else (str(6 + part), {"BULKLEY_CHAIN": "7"} if part > 1 else {})

    def next(self, folder, part, text, **more):
        number, environment = self.chain(part)
        return folder.job(number, text, **environment, **more)

    # --- cases ---------------------------------------------------------------------------------------------------------

    def three_parts(self):
        f = self.folder()
        self.expect("first part", self.next(f, 1, f.writes("stopped", 100, 4)), 4, LIMIT, self.again(self.chain(1)[0]))
        self.expect("second part", self.next(f, 2, f.writes("stopped", 200, 4)), 4, f"--restart {LIMIT}",
                    self.again(self.chain(2)[0]))
        self.expect("last part", self.next(f, 3, f.writes("finished", 250, 0)), 0, f"--restart {LIMIT}", None,
                    "finished at step 250")
        lines = (f.output / "parts.txt").read_text(encoding="utf-8").splitlines()
        if [line.split()[-1] for line in lines] != ["0", "100", "200"]:
            fail(f"parts.txt: {lines}")
        self.expect("finished and submitted again", f.job("90", f.writes("finished", 250, 0)), 0, f"--restart {LIMIT}")

    def no_next_part(self):
        for state, step, code, expected, sentence in (
                ("failed", 100, 3, 3, "the run failed"), ("running", 100, 3, 3, "the run failed"),
                ("failed", 100, 137, 3, "the run failed"), ("stopped", 100, 2, 2, "refused its input"),
                ("stopped", 0, 4, 1, "where it had begun")):
            f = self.folder()
            self.expect(f"{state} with {code}", self.next(f, 1, f.writes(state, step, code)), expected, LIMIT, None,
                        sentence)

    def unresponsive(self):
        for code in (3, 0, 1, 137):  # srun and mpirun say different things of a lost node
            f = self.folder()
            self.expect(f"a rank did not answer, {code}", self.next(f, 1, f.writes("failed", 100, code, unresponsive=True)), 4, LIMIT,
                        self.again(self.chain(1)[0]), "because: another part is to follow")
            self.expect("and the next part goes on", self.next(f, 2, f.writes("finished", 250, 0)), 0, f"--restart {LIMIT}", None,
                        "finished at step 250")
        f = self.folder()
        hangs = f.writes("failed", 100, 0, unresponsive=True).replace("exit 0", "exec sleep 600")
        self.expect("the launcher waits for a lost node or a stopped rank", self.next(f, 1, hangs, launcher_patience="1"), 4, LIMIT,
                    self.again(self.chain(1)[0]), "because: another part is to follow")
        f = self.folder()
        self.expect("before the first checkpoint", self.next(f, 1, f.writes("failed", 0, 3, checkpoint=False, unresponsive=True)), 4, LIMIT,
                    self.again(self.chain(1)[0]), "because: another part is to follow")
        self.expect("and the next part begins anew", self.next(f, 2, f.writes("finished", 250, 0)), 0, f"--overwrite {LIMIT}", None,
                    "finished at step 250")
        f = self.folder()
        for part in (1, 2):
            self.expect(f"never again, part {part}", self.next(f, part, f.writes("failed", 100, 3, unresponsive=True)), 4,
                        f"--restart {LIMIT}" if part > 1 else LIMIT, self.again(self.chain(part)[0]))
        self.expect("no progress", self.next(f, 3, f.writes("failed", 100, 3, unresponsive=True)), 1, f"--restart {LIMIT}", None,
                    "no third one")
        f = self.folder()
        self.expect("and input that is refused", self.next(f, 1, f.writes("failed", 100, 2, unresponsive=True)), 2, LIMIT, None,
                    "refused its input")

    def stopped_by_its_user(self):
        f = self.folder()
        self.expect("the file STOP", self.next(f, 1, f.writes("stopped", 100, 4, reason="by the file out/scene/STOP")), 4, LIMIT,
                    None, "by the file STOP")
        self.expect("submitted again", f.job("90", f.writes("finished", 150, 0), BULKLEY_CHAIN=""), 0, f"--restart {LIMIT}")

    def killed(self):
        f = self.folder()
        self.expect("killed after a checkpoint", self.next(f, 1, f.writes("running", 50, 137)), 4, LIMIT,
                    self.again(self.chain(1)[0]))
        # srun returns 0 when a node is lost.
        self.expect("killed later", self.next(f, 1, f.writes("running", 100, 0)), 4, f"--restart {LIMIT}",
                    self.again(self.chain(1)[0]))
        self.expect("killed at once", self.next(f, 2, "exit 137"), 4, f"--restart {LIMIT}", self.again(self.chain(2)[0]))
        self.expect("killed twice at one step", self.next(f, 3, "exit 137"), 1, f"--restart {LIMIT}", None,
                    "no further than step 100")
        self.expect("submitted again", f.job("90", f.writes("finished", 150, 0), BULKLEY_CHAIN=""), 0,
                    f"--restart {LIMIT}")

    def node_lost(self):
        """The script ends with the node without a message; the batch system starts it again."""
        f = self.folder()
        # The script's whole process group is killed: no message, no request.
        kill_all = "kill -KILL -- -$(ps -o pgid= $$ | tr -d ' ')"
        f_lost = f.writes("running", 0, 0, checkpoint=False).replace("exit 0", kill_all)
        for _ in range(2):
            self.lose(f, f_lost)
        if (f.output / "parts.txt").read_text(encoding="utf-8").count("\n") != 2:
            fail("a part that was lost with its node has left no line in parts.txt")
        self.expect("lost twice before a checkpoint", self.next(f, 1, "exit 0"), 1, None, None, "no further than step 0")

    def lose(self, folder, part):
        result = folder.job("7", part, functools.partial(self.beside, folder))
        if any(is_request(call) for call in result[1]):
            fail(f"a script that was killed asked for another part: {result}")

    @staticmethod
    def beside(folder, text):
        """A script that runs the job in a process group of its own."""
        (folder.path / "real.sh").write_text(text, encoding="utf-8")
        return "setsid --wait bash real.sh\n"

    def before_first_checkpoint(self):
        f = self.folder()
        self.expect("killed before a checkpoint", self.next(f, 1, f.writes("running", 0, 137, checkpoint=False)), 4,
                    LIMIT, self.again(self.chain(1)[0]))
        self.expect("starts again", self.next(f, 2, f.writes("finished", 100, 0)), 0, f"--overwrite {LIMIT}")
        f = self.folder()
        (f.output / "status.json").write_text(status("running", 50), encoding="utf-8")
        self.expect("a folder that no job made is not emptied", self.next(f, 1, "exit 2"), 2, LIMIT, None, "refused")
        f = self.folder()
        self.expect("finished without checkpoint", self.next(f, 1, f.writes("finished", 9, 0, False)), 0, LIMIT)
        self.expect("finished without checkpoint, again", self.next(f, 2, "exit 2"), 0, None, None, "nothing to do")

    def after_failure(self):
        f = self.folder()
        self.expect("fails", self.next(f, 1, f.writes("failed", 9, 3)), 3, LIMIT)
        self.expect("the batch system tries it again", self.next(f, 2, "exit 0"), 3, None, None, "has failed: because")
        self.expect("its user tries it again", f.job("90", f.writes("finished", 20, 0), BULKLEY_CHAIN=""), 0,
                    f"--restart {LIMIT}")

    def prolonged(self):
        """The run was finished, goes on to a later end, and is killed before it has written a word."""
        f = self.folder()
        self.expect("finishes", self.next(f, 1, f.writes("finished", 9, 0)), 0, LIMIT)
        self.expect("dies", f.job("20", "exit 137", BULKLEY_CHAIN="7"), 4, f"--restart {LIMIT}", self.again("20"))

    def refusals(self):
        f = self.folder()
        f.job("5", "exit 137")
        self.expect("two jobs in a folder", self.next(f, 1, "exit 0", RUNNING="5"), 1, None, None, "job 5 is running")
        self.expect("no next part to be had", self.next(f, 1, f.writes("stopped", 9, 4), REFUSE="1"), 1,
                    LIMIT, self.again(self.chain(1)[0]), "submit this script again")
        f = self.folder()
        own = self.next(f, 1, f.writes("finished", 9, 0),
                        script_edit=lambda text: text.replace("max_walltime= ", "max_walltime=90s "))
        self.expect("a wall time of its own", own, 0, "--max-walltime 90s")
        too_short = self.next(self.folder(), 1, "exit 0",
                              script_edit=lambda text: text.replace("reserve=300", "reserve=7200"))
        self.expect("nothing left of the limit", too_short, 2, None, None, "are to be kept")

    def quoted_reason(self):
        f = self.folder()
        reason = 'state "a", step: 7, "step": 9 of C:\\x'
        self.expect("a reason full of quotes", self.next(f, 1, f.writes("stopped", 100, 4, reason=reason)), 4, LIMIT,
                    self.again(self.chain(1)[0]))

    def all(self):
        for case in (self.three_parts, self.no_next_part, self.unresponsive, self.stopped_by_its_user, self.killed, self.node_lost,
                     self.before_first_checkpoint, self.after_failure, self.prolonged, self.refusals, self.quoted_reason):
            case()


def time_limits(work):
    """What squeue says of the time that is left, and what bulkley is given."""
    cases = Cases(work, "slurm/srun.sh", "slurm", "limit")
    for left, options in (("1-00:00:00", "--max-walltime 86100s"), ("06:08", "--max-walltime 68s"), ("UNLIMITED", ""),
                          ("2-08:09:08", "--max-walltime 201848s")):
        f = cases.folder()
        cases.expect(f"{left} left", f.job("7", f.writes("finished", 9, 0), LEFT=left), 0, options)


def studies(work):
    cases = Cases(work, "slurm/study.sh", "slurm")
    f = cases.folder()
    (f.path / "study.txt").write_text("# first\na.b=1\n\n  # second\nc=[0,0,-1]  d='x'\n", encoding="utf-8")
    for line, options in (("1", "--set a.b=1"), ("2", "--set c=[0,0,-1] --set d='x'")):
        result = f.job("7", f"mkdir -p out/study/{line}\n" + f.writes("finished", 9, 0).replace("scene", f"study/{line}"),
                       SLURM_ARRAY_TASK_ID=line)
        expected = f"bulkley run scene.toml --out out/study/{line} --max-walltime 6900s {options}"
        if result[0] != 0 or result[1] != [expected]:
            fail(f"study, line {line}: {result}")
    # Slurm gives the last task the number of the array: what it asks for must be for itself.
    part = f.writes("stopped", 19, 4).replace("scene", "study/2")
    result = f.job("7", part, SLURM_ARRAY_JOB_ID="7", SLURM_ARRAY_TASK_ID="2")
    if result[0] != 4 or result[1][1:] != ["scontrol requeue 7_2"]:
        fail(f"study, the array's last task: {result}")
    result = f.job("7", "exit 0", SLURM_ARRAY_TASK_ID="3")
    if result[0] != 2 or result[1] or "has no line 3" not in result[2]:
        fail(f"study, a line that is not there: {result}")


def signals(work):
    """Slurm's signal to the shell reaches mpirun, whose exit code is the job's business nevertheless."""
    for script, system in (("slurm/mpirun.sh", "slurm"), ("pbs/mpirun.sh", "pbs")):
        cases = Cases(work, script, system, "signal")
        f = cases.folder()
        wait = "trap 'got=yes' USR1\nkill -USR1 $PPID\nfor i in {1..50}; do sleep 0.1; [[ -z $got ]] || break; done\n"
        part = wait + "[[ -n $got ]] || exit 3\nsleep 0.3\n" + f.writes("stopped", 9, 4)
        cases.expect("a signal", cases.next(f, 1, part), 4, LIMIT, cases.again())


def syntax():
    scripts = [CLUSTER / "job_functions.sh", *CLUSTER.glob("slurm/*.sh"), *CLUSTER.glob("pbs/*.sh")]
    for script in scripts:
        subprocess.run(["bash", "-n", script], check=True)
    if shutil.which("shellcheck"):  # 2034, 2154: variables that go from one file to the other
        subprocess.run(["shellcheck", "--shell=bash", "--exclude=SC1090,SC1091,SC2034,SC2154", *scripts], check=True)
        print("shellcheck has read the scripts")
    else:
        print("shellcheck is not installed: only bash -n has read the scripts")


def main():
    _, work = start(parse_arguments(__doc__))
    syntax()
    for script, system in (("slurm/srun.sh", "slurm"), ("slurm/mpirun.sh", "slurm"), ("pbs/mpirun.sh", "pbs")):
        Cases(work, script, system).all()
    time_limits(work)
    studies(work)
    signals(work)
    print("all cases")


if __name__ == "__main__":
    main()
