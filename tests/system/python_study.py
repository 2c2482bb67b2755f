#!/usr/bin/env python3
"""bulkley.study of drivers/python: all combinations run once, several at a time; what is finished is not run again, what was
stopped or killed goes on, failed cases are rows with the program's sentence; the job script that it writes for Slurm; bad
arguments."""

import io
import json
import os
import pathlib
import signal
import subprocess
import sys
import threading
import time

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/support"), str(ROOT / "drivers/python")]
import bulkley  # noqa: E402
from bulkley.slurm_array import array_of  # noqa: E402
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from small_scene import small_scene  # noqa: E402

STRESS, VELOCITY = "materials.fluid.yield_stress", "bodies.ball.velocity"
PARAMETERS = {STRESS: [10, 30.0], VELOCITY: [[0, 0, -1], [0, 0, -500], [0, 0]]}  # the second fails, the third is refused


def expect(condition, sentence):
    if not condition:
        fail(sentence)


def refused(kind, work, *words):
    try:
        work()
    except kind as error:
        if "\n" in str(error) or not all(word in str(error) for word in words):
            fail(f"the sentence must hold {words}: {error}")
    else:
        fail(f"nothing is said about {words}")


def starts(folder="out/study"):
    """When each output folder's run began last, by the time of the file that is written first."""
    return {path.parent.name: path.stat().st_mtime_ns for path in pathlib.Path(folder).glob("*/scene.toml")}


def check_study():
    bar = io.StringIO()
    stdout, sys.stdout = sys.stdout, bar
    try:
        study = bulkley.study(small_scene(), PARAMETERS, parallel=2, progress=True)
    finally:
        sys.stdout = stdout
    lines = bar.getvalue().splitlines()
    expect(lines[-1].startswith("study [") and lines[-1].endswith("100 %  6 of 6 cases, 4 failed"), f"the bar: {lines}")
    table = study.table()
    expect(list(table)[:8] == ["case", STRESS, VELOCITY, "state", "step",
           "time", "wall_time", "error"], f"columns {list(table)}")
    expect(list(table["state"]) == ["finished", "failed", "refused"] * 2, f"states {table['state']}")
    expect(list(table[STRESS]) == [10.0] * 3 + [30.0] * 3 and list(table[VELOCITY])[:2] == ["[0, 0, -1]", "[0, 0, -500]"],
           "the values of the keys")
    errors = table["error"]
    expect(errors[0] == "" and "crushed" in errors[1] and "'bodies.0.velocity' has 2 entries" in errors[2]
           and "\n" not in errors[2], f"errors {errors}")
    first = bulkley.open_run("out/study/1")
    expect(first.scene["materials"]["fluid"]["yield_stress"] ==
           10.0 and first.scene["bodies"][0]["velocity"] == [0, 0, -1], "1")
    for name in ("reach.reach", "sensor.force_z", "kinetic_energy"):
        expect(table[name][0] == first.history[name][-1] and np.isnan(table[name][2]), f"the last row's {name}")
    expect(table["step"][0] == first.status["step"] and table["wall_time"][0] == first.status["wall_time"]
           and table["time"][0] == 0.02 and np.isnan(table["time"][2]), "figures of status.json")
    expect(table.units["reach.reach"] == "m" and table.units["wall_time"] == "s" and table.units["state"] == "", "units")
    expect(table["limiter"][0] == first.history["limiter"][-1] and table["limiter"][2] == "", "words of the last row")
    expect([run.folder.name for run in study.runs] == ["1", "2", "4", "5"] and len(study) == 6, "runs")
    try:
        import pandas  # noqa: F401
        expect(list(table.to_pandas()["state"]) == list(table["state"]), "to_pandas")
    except ImportError:
        refused(bulkley.DataError, table.to_pandas, "pandas")
    return study


def check_resumption():
    before = starts()
    bulkley.study(small_scene(), PARAMETERS)
    expect(starts() == before, "finished and failed cases were run again")
    bulkley.study(small_scene(), {STRESS: [30.0], VELOCITY: PARAMETERS[VELOCITY]}, retry_failed=True)
    expect({name for name, time_ in starts().items() if time_ != before[name]} == {"5"}, "retry_failed")
    # One whose rank or node did not answer goes on by itself.
    case, before = bulkley.open_study("out/study")[4], starts()
    (case.folder / "status.json").write_text(json.dumps({**case.status, "unresponsive": True}), encoding="utf-8")
    bulkley.study(small_scene(), {STRESS: [30.0], VELOCITY: PARAMETERS[VELOCITY]})
    expect({name for name, time_ in starts().items() if time_ != before[name]} == {"5"}, "an unresponsive case")
    # Further values are further cases; those that there are keep their folders.
    before = starts()
    more = bulkley.study(small_scene(), {STRESS: [20, 10], VELOCITY: [[0, 0, -1]]}, ranks=2)
    expect([case.number for case in more] == [7, 1] and {
           n for n in starts() if starts()[n] != before.get(n)} == {"7"}, "more")
    expect(bulkley.open_run("out/study/7").status["ranks"] == 2, "ranks")
    whole = bulkley.open_study("out/study")
    expect(len(whole) == 7 and whole.script is None and [case.state for case in whole][-1] == "finished", "open_study")
    refused(bulkley.RunError, lambda: bulkley.study(small_scene(end=0.03), PARAMETERS), "'out/study'", "another scene")
    # A longer run of the same cases continues the shorter.
    short = bulkley.study(small_scene(), {STRESS: [10]}, folder="steps", max_steps=5)
    expect(short[0].status["step"] == 5, "max_steps")
    before = starts("steps")
    bulkley.study(small_scene(), {STRESS: [10]}, folder="steps", max_steps=5)
    expect(starts("steps") == before, "a case that has reached max_steps was run again")
    longer = bulkley.study(small_scene(), {STRESS: [10]}, folder="steps")
    expect(longer[0].status["first_step"] == 5 and longer[0].status["time"] == 0.02, "the steps that were missing")


def check_interruption():
    """Ctrl-C stops all with checkpoints, and the study goes on from these."""
    scene, sets = small_scene(), {"output.frame_interval": 0, "time.end": 1.0}
    parameters = {STRESS: [10, 20, 30]}

    def interrupt():
        histories = [pathlib.Path(f"stopped/{n}/history.csv") for n in (1, 2)]
        while not all(path.exists() and path.read_bytes().count(b"\n") > 10 for path in histories):
            time.sleep(0.02)
        os.kill(os.getpid(), signal.SIGINT)

    signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where the test is in the background of a shell
    thread = threading.Thread(target=interrupt)
    thread.start()
    try:
        bulkley.study(scene, parameters, parallel=2, folder="stopped", sets=sets)
        fail("Ctrl-C did not end the study")
    except KeyboardInterrupt:
        pass
    thread.join()
    cases = bulkley.open_study("stopped")
    expect([case.state for case in cases] == ["stopped", "stopped", "waiting"], f"{[case.state for case in cases]}")
    steps = cases[0].status["step"]
    # One that was killed has a status that says "running", and a log with the reason.
    killed = dict(cases[1].status, state="running")
    (cases[1].folder / "status.json").write_text(json.dumps(killed), encoding="utf-8")
    refused(bulkley.RunError, lambda: bulkley.study(scene, parameters,
            folder="stopped", sets=sets), "stopped/2", "another process")
    cases[1].log.write_text("rank 0 was killed\n", encoding="utf-8")  # which a run that goes on may say of something else
    refused(bulkley.RunError, lambda: bulkley.study(scene, parameters,
            folder="stopped", sets=sets), "stopped/2", "another process")
    cases[1].log.write_text("rank 0 was killed\nbulkley ended with exit code 137\n", encoding="utf-8")
    expect(cases[1].state == "killed" and cases[1].error == "rank 0 was killed", "a killed case")
    bulkley.study(scene, parameters, parallel=3, folder="stopped", sets=sets, max_steps=steps + 200)
    expect(all(case.state == "finished" for case in cases) and cases[0].status["first_step"] == steps
           and cases[1].status["first_step"] > 0 and cases[2].status["first_step"] == 0, "the cases that were continued")
    expect(cases[1].error == "", "the reason of a case that goes on")


def check_paths(work):
    """A scene by its path, from another folder; the bits are those of the dictionary's run."""
    pathlib.Path("elsewhere").mkdir()
    (work / "elsewhere/ball.toml").write_text(pathlib.Path("out/study/scene.toml").read_text(encoding="utf-8"), encoding="utf-8")
    found = bulkley.study("elsewhere/ball.toml", {STRESS: np.array([10])}, folder="by_path", sets={VELOCITY: [0, 0, -1]})
    a, b = bulkley.open_run("out/study/1").checkpoints[-1], next(found.runs).checkpoints[-1]
    expect(np.array_equal(a["velocity"], b["velocity"][b.rows_of(a.ids)]), "a scene by its path")


def check_refusals():
    scene, error = small_scene(), bulkley.RunError
    for wrong in ({}, [1], None):
        refused(error, lambda: bulkley.study(scene, wrong, folder="bad"), "parameters", "dictionary")
    for wrong in ([], "10", 10, None):
        refused(error, lambda: bulkley.study(scene, {STRESS: wrong}, folder="bad"), STRESS, repr(wrong), "list")
    refused(error, lambda: bulkley.study(scene, {STRESS: [1, 1]}, folder="bad"), STRESS, "twice")
    refused(error, lambda: bulkley.study(scene, {"a b": [1]}, folder="bad"), "'a b'")
    refused(error, lambda: bulkley.study(scene, {STRESS: [1]}, folder="bad", sets={STRESS: 2}), STRESS, "'sets'")
    refused(error, lambda: bulkley.study(scene, {STRESS: [1]}, 0, folder="bad"), "'ranks' is 0")
    refused(error, lambda: bulkley.study(scene, {STRESS: [1]}, parallel=0, folder="bad"), "'parallel' is 0")
    refused(error, lambda: bulkley.study(7, {STRESS: [1]}, folder="bad"), "'scene' is 7")
    refused(error, lambda: bulkley.study("none.toml", {STRESS: [1]}, folder="bad"), "none.toml")
    expect(not pathlib.Path("bad").exists(), "a study that was refused left a folder")
    refused(bulkley.DataError, lambda: bulkley.open_study("elsewhere"), "'elsewhere'", "study.json")
    pathlib.Path("elsewhere/study.json").write_text('{"cases": 3}', encoding="utf-8")
    refused(bulkley.DataError, lambda: bulkley.open_study("elsewhere"), "cannot read", "study.json")
    refused(error, lambda: bulkley.study(scene, {STRESS: [1]}, folder="elsewhere/ball.toml/x"), "cannot write", "ball.toml")


def check_job_script(work):
    """Of the cases that are missing; with the settings of cluster/jobs/slurm/study.sh."""
    refused_here = bulkley.open_study("out/study")[2]
    expect(refused_here.state == "refused", "a case that was refused")
    first = bulkley.study(small_scene(), PARAMETERS, slurm={})
    expect(refused_here.state == "waiting" and "--array=3,6\n" in first.script.read_text(encoding="utf-8"), "refused cases")
    values = {STRESS: [10, 20, 40], VELOCITY: [[0, 0, -1], [0, 0, -2]]}
    before = starts()
    made = bulkley.study(small_scene(), values, ranks=3, parallel=2, max_steps=9,
                         slurm={"time": "00:20:00", "partition": "main", "exclusive": True, "mem_per_cpu": "1G"})
    expect(starts() == before and made.script == pathlib.Path("out/study/study.sh"), "nothing is to be run")
    numbers = [case.number for case in made]
    expect(numbers == [1, 8, 7, 9, 10, 11], f"cases {numbers}")
    text = made.script.read_text(encoding="utf-8")
    options = [line.split(" #")[0].strip() for line in text.splitlines() if line.startswith("#SBATCH")]
    for option in ("--array=8-11%2", "--ntasks=3", "--time=00:20:00", "--partition=main", "--exclusive", "--mem-per-cpu=1G",
                   f"--output={work}/out/study/slurm_%a.log", "--nodes=1", "--requeue"):
        expect(options.count(f"#SBATCH {option}") == 1, f"{option} in {options}")
    expect(not any("ntasks-per-node" in option for option in options), "two numbers of ranks")
    for line in (f"scene={work}/out/study/scene.toml", f"folder={work}/out/study/$SLURM_ARRAY_TASK_ID",
                 f"program={os.environ['BULKLEY']}", "options=(--quiet --max-steps 9)"):
        expect(sum(found.startswith(line) for found in text.splitlines()) == 1, f"{line} in the script")
    expect(subprocess.run(["bash", "-n", str(made.script)]).returncode == 0, "bash does not read the script")
    lines = pathlib.Path("out/study/study.txt").read_text(encoding="utf-8").splitlines()
    expect(len(lines) == 11 and lines[7] == f"{STRESS}=10 {VELOCITY}=[0,0,-2]", f"study.txt: {lines}")
    # A case whose job was refused: the sentence is in the job's log, among the script's own.
    pathlib.Path("out/study/slurm_8.log").write_text("2026-01-01 10:00:00 job 5_8: part 1 of the run\nscene.toml: unknown key 'x'\n"
                                                     "srun: error: node: task 0: Exited with exit code 2\n", encoding="utf-8")
    expect(made[1].state == "waiting", "a job that may go on")
    with open("out/study/slurm_8.log", "a", encoding="utf-8") as log:
        log.write("2026-01-01 10:00:01 job 5_8: bulkley refused its input (exit code 2): no further part\n")
    expect((made[1].state, made[1].error) == ("refused", "scene.toml: unknown key 'x'"), f"{made[1].state}, {made[1].error}")
    done = bulkley.study(small_scene(), {STRESS: [10], VELOCITY: [[0, 0, -1]]}, slurm={})
    expect(done.script is None and not pathlib.Path("out/study/study.sh").exists(), "a script without cases")
    refused(bulkley.RunError, done.submit, "no job script", "'slurm'")
    expect(array_of([7, 1, 2, 3, 9, 10]) == "1-3,7,9-10" and array_of([4]) == "4", "array_of")

    def by_slurm(parameters=None, folder="slurm", **slurm):
        return bulkley.study(small_scene(), parameters or {STRESS: [1]}, folder=folder, slurm=slurm)
    for name in ("array", "ntasks", "output", "signal"):
        refused(bulkley.RunError, lambda: by_slurm(**{name: 1}), f"slurm['{name}']")
    refused(bulkley.RunError, lambda: by_slurm(time="1 h"), "slurm['time']", "blanks")
    refused(bulkley.RunError, lambda: bulkley.study(small_scene(), {STRESS: [1]}, folder="slurm", slurm=["time"]), "'slurm'")
    refused(bulkley.RunError, lambda: by_slurm({"title": ["a b"]}, folder="words"), "title", "blanks")
    refused(bulkley.RunError, lambda: by_slurm(folder="with blank"), "with blank", "'folder'")
    script = by_slurm().script
    kept = os.environ["PATH"]
    try:
        os.environ["PATH"] = str(work)
        refused(bulkley.RunError, bulkley.open_study("slurm").submit, "sbatch", str(script))
        (work / "sbatch").write_text("#!/bin/sh\necho sbatch: error: no such partition >&2\nexit 1\n", encoding="utf-8")
        (work / "sbatch").chmod(0o755)
        refused(bulkley.RunError, bulkley.open_study("slurm").submit, "no such partition")
        (work / "sbatch").write_text("#!/bin/sh\necho 41\n", encoding="utf-8")
        expect(bulkley.open_study("slurm").submit() == "41", "the number of a job")
    finally:
        os.environ["PATH"] = kept


def main():
    program, work = start(parse_arguments(__doc__))
    work = work.resolve()
    os.environ["BULKLEY"] = str(pathlib.Path(program.path).resolve())
    os.chdir(work)
    check_study()
    check_resumption()
    check_interruption()
    check_paths(work)
    check_refusals()
    check_job_script(work)
    print("studies from Python: combinations, resumption, Ctrl-C, job script")


if __name__ == "__main__":
    main()
