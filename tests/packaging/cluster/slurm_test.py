#!/usr/bin/env python3
"""The job scripts of cluster/jobs/slurm in a real Slurm: runs that need several jobs finish by themselves, with the bits of one
long run, started by srun and by mpirun, alone and as a study; the job that waits for them comes last; Slurm's signal ends a
part in order; a run that is cancelled stays so. Ends with 77, and the reason, where no Slurm can be started."""

import json
import pathlib
import re
import resource
import sys
import time

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from slurm_server import CannotRun, Slurm  # noqa: E402

TESTS = pathlib.Path(__file__).resolve().parents[2]
CLUSTER = TESTS.parent / "cluster" / "jobs"
STEPS = 3000
LIMITS = 3  # times that a run is ended by its wall time
RANKS = 2
# Folders of runs that need several jobs, and the runs in one part that they must equal.
RUNS = {"out/srun": "whole", "out/mpirun": "whole", "out/study/1": "whole", "out/study/2": "other"}
LIMIT = 400.0  # s, for all jobs on a busy machine; a quiet one needs a minute
SKIPPED = 77


def edited(name, **settings):
    """Text of a job script, with settings and #SBATCH options changed as its user would; it must have each of them once."""
    text = (CLUSTER / "slurm" / name).read_text(encoding="utf-8")
    for key, value in settings.items():
        option = f"#SBATCH --{key.replace('_', '-')}"
        text, n_options = re.subn(rf"^{option}=\S+", f"{option}={value}", text, flags=re.MULTILINE)
        text, n_settings = re.subn(rf"^{key}=(\([^)]*\)|\S*)", f"{key}={value}", text, flags=re.MULTILINE)
        n = n_options + n_settings
        if n != 1:
            fail(f"{name} has {n} lines that set {key}")
    return text


class Jobs:
    def __init__(self, program, work, slurm):
        self.program, self.work, self.slurm = program, work, slurm
        text = (TESTS / "failure" / "base.toml").read_text(encoding="utf-8")
        # No machine comes to this end within the jobs' time limits: a part ends by its steps, its wall time or a signal.
        text = text.replace("cell_size = 0.01", "cell_size = 0.005").replace("end = 0.01", "end = 1000.0")
        (work / "scene.toml").write_text(text + "[output]\nhistory_interval = 50\n", encoding="utf-8")
        (work / "study.txt").write_text("# two yield stresses\nmaterials.fluid.sigma_Y=31.9\n\n"
                                        "materials.fluid.sigma_Y=10 bodies.ball.velocity=[0,0,-1.5]\n", encoding="utf-8")

    def whole_run(self, name, *more):
        arguments = ["run", "scene.toml", "--out", name, "--max-steps", str(STEPS), *more]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        outcome = self.program.run(arguments, RANKS, self.work, LIMIT)
        if outcome.code != 0:
            fail(f"{name}: the run that is not interrupted failed", outcome)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return (after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime) / RANKS

    def submit(self, script, *arguments, **settings):
        """Number of a job from the script of that name with these settings; a colon and a name of its own may follow."""
        template, _, name = script.partition(":")
        file = self.work / f"{name or template}.sh"
        settings = {"ntasks_per_node": RANKS, "program": self.program.path, **settings}
        file.write_text(edited(f"{template}.sh", **settings), encoding="utf-8")
        return self.slurm.submit(self.work, *arguments, file.name, BULKLEY_SCRIPTS=str(CLUSTER))

    def status(self, folder):
        file = self.work / folder / "status.json"
        return json.loads(file.read_text(encoding="utf-8")) if file.exists() else {"state": "none", "step": 0}

    def wait_for(self, what, met, limit=LIMIT):
        end = time.monotonic() + limit
        while not met():
            if time.monotonic() > end:
                print(self.slurm.call("squeue").stdout)
                for log in sorted(self.work.glob("*.log")):
                    print(f"--- {log.name}\n{log.read_text(encoding='utf-8', errors='replace')}")
                fail(f"{what}: not within {limit:.0f} s")
            time.sleep(0.5)

    def parts(self, folder):
        file = self.work / folder / "parts.txt"
        return file.read_text(encoding="utf-8").splitlines() if file.exists() else []

    def expect_whole(self, folder, whole):
        """Finished in parts of one job, all but the last ended by their wall time, with the bits of the run `whole`."""
        status, lines = self.status(folder), self.parts(folder)
        steps = [int(line.split()[-1]) for line in lines]
        if status["state"] != "finished" or status["step"] != STEPS:
            fail(f"{folder}: {status}")
        if len(lines) != LIMITS + 1 or steps != sorted(set(steps)) or len({line.split()[5] for line in lines}) != 1:
            fail(f"{folder}: expected {LIMITS + 1} parts of one job, each further on: {lines}")
        last = f"checkpoint_{STEPS:09d}.h5"
        outcome = self.program.run(["compare", f"{whole}/{last}", f"{folder}/{last}"], 1, self.work, LIMIT)
        if outcome.code != 0 or "identical" not in outcome.text:
            fail(f"{folder}: not the bits of the run in one part", outcome)
        print(f"{folder}: {len(lines)} parts, from steps {steps}: identical")

    # --- what is shown ---------------------------------------------------------------------------------------------------

    def submit_all(self, seconds):
        # However busy the machine is, no run needs less wall time than processor time: these limits end it, all of them.
        short = f"{0.8 / LIMITS * seconds:.2f}s"
        walltime = f"$([[ $(grep -c chain $folder/parts.txt 2>/dev/null) -ge {LIMITS} ]] && echo 1h || echo {short})"
        several = {"max_walltime": walltime, "options": f"(--max-steps {STEPS})"}
        chains = [self.submit("srun", folder="out/srun", **several), self.submit("mpirun", folder="out/mpirun", **several)]
        study = self.submit("study", "--array=1-2", **several)
        self.write_after()
        depends = "--dependency=afterok:" + ":".join([*chains, study])
        self.slurm.submit(self.work, depends, "--kill-on-invalid-dep=yes", "after.sh", *RUNS)
        # Slurm looks at signals every half minute and sends them up to half a minute early: these come 15 to 45 s after the
        # job's start, when every rank is under way however busy the machine is.
        self.signalled = {}
        for template, signal in (("srun", "USR1@75"), ("mpirun", "B:USR1@75")):
            name = f"signal_{template}"
            self.signalled[name] = self.submit(f"{template}:{name}", folder=f"out/{name}", signal=signal, time="2",
                                               reserve="1")
        self.cancelled = self.submit("srun:cancelled", folder="out/cancelled")

    def write_after(self):
        """after.sh with another thing to do: it lists the states it finds."""
        text, n = re.subn(r"^  xvfb-run .*$", '  echo "$1 $(grep state "$1/status.json")" >>after.txt', edited("after.sh"),
                          flags=re.MULTILINE)
        if n != 1:
            fail("after.sh has another command than xvfb-run")
        (self.work / "after.sh").write_text(text, encoding="utf-8")

    def expect_cancelled(self):
        """A rank that is ended by scancel saves and stops with exit code 4; that must not count as a wish to go on."""
        self.wait_for("the run that is cancelled", lambda: self.status("out/cancelled")["state"] == "running")
        time.sleep(1.0)
        self.slurm.call("scancel", self.cancelled)
        self.wait_for("the end of the cancelled job", lambda: self.slurm.job(self.cancelled)["JobState"] == "CANCELLED")

    def expect_signalled(self):
        for name, number in self.signalled.items():
            self.wait_for(f"{name}: the part's end", lambda: self.slurm.job(number).get("Restarts") == "1")
            status = self.status(f"out/{name}")
            if status["state"] != "stopped" or not status["reason"].startswith("by a signal") or status["step"] == 0:
                fail(f"{name}: {status}")
            self.slurm.call("scancel", number)
            print(f"{name}: stopped by Slurm's signal at step {status['step']}, and queued again")

    def run(self):
        seconds = self.whole_run("whole")
        self.whole_run("other", "--set", "materials.fluid.sigma_Y=10", "--set", "bodies.ball.velocity=[0,0,-1.5]")
        print(f"whole run: {seconds:.1f} s of a processor on each rank")
        self.submit_all(seconds)
        self.expect_cancelled()
        self.expect_signalled()
        after = self.work / "after.txt"
        self.wait_for("the job that waits for the others", lambda: after.exists() and after.read_text().count("\n") == 4)
        if after.read_text(encoding="utf-8").count('"finished"') != 4:
            fail(f"the job that waits came too early:\n{after.read_text(encoding='utf-8')}")
        for folder, whole in RUNS.items():
            self.expect_whole(folder, whole)
        job = self.slurm.job(self.cancelled)
        if job["JobState"] != "CANCELLED" or job["Restarts"] != "0" or len(self.parts("out/cancelled")) != 1:
            fail(f"the cancelled job came back: {job}")


def main():
    program, work = start(parse_arguments(__doc__))
    try:
        with Slurm(work / "slurm") as slurm:
            Jobs(program, work, slurm).run()
    except CannotRun as reason:
        print(f"SKIPPED: no Slurm can be run here: {reason}")
        sys.exit(SKIPPED)


if __name__ == "__main__":
    main()
