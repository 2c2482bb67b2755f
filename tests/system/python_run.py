#!/usr/bin/env python3
"""bulkley.run of drivers/python: scenes from dictionaries and files, the sentences of refused and failed runs, the bar of
progress, and Ctrl-C, which stops a run with a checkpoint that it continues from, bit for bit."""

import io
import os
import pathlib
import pty
import signal
import subprocess
import sys
import threading
import time
import tomllib

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE = ROOT / "drivers/python"
sys.path[:0] = [str(ROOT / "tests/support"), str(PACKAGE)]
import bulkley  # noqa: E402
from bulkley.history import last_row  # noqa: E402
from bulkley.launch import AS_ROOT, WORKSTATION, environment, sentence_of  # noqa: E402
from bulkley.progress import WIDTH, Bar, time_left  # noqa: E402
from bulkley.scene_file import set_words, toml_text  # noqa: E402
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from small_scene import small_scene  # noqa: E402

LIMIT = 60.0  # s


def expect(condition, sentence):
    if not condition:
        fail(sentence)


def refused(work, code, *words):
    """The RunError of `work`, whose text must be one line with these words."""
    try:
        work()
    except bulkley.RunError as error:
        if error.code != code or "\n" in str(error) or not all(word in str(error) for word in words):
            fail(f"expected code {code} and one line with {words}: {error.code}, {error}")
        return error
    fail(f"nothing is said about {words}")


# --- what needs no run -----------------------------------------------------------------------------------------------------

def check_scene_text():
    scene = small_scene()
    scene["materials"]["odd name"] = {"preset": "cream", "note": 'a "quote"\n\\ and \x7f'}
    scene["numbers"] = {"huge": 1e300, "tiny": 5e-324, "whole": np.int64(3), "flag": np.bool_(True), "list": np.arange(3.0),
                        "float": np.float32(0.5), "empty": [], "tables": [], "nothing": {}}
    read = tomllib.loads(toml_text(scene))
    expect(read["bodies"][0]["shape"] == {"type": "sphere", "center": [0.1, 0.1, 0.05], "radius": 0.03}, "a table in a list")
    expect(read["materials"] == scene["materials"] and read["domain"] == scene["domain"], "tables")
    expect(read["numbers"] == {"huge": 1e300, "tiny": 5e-324, "whole": 3, "flag": True, "list": [0.0, 1.0, 2.0], "float": 0.5,
                               "empty": [], "tables": [], "nothing": {}}, f"numbers: {read['numbers']}")
    expect(read["output"]["front"] == scene["output"]["front"], "lists of tables in tables")
    mesh = tomllib.loads(toml_text({"shape": {"type": "mesh", "file": "a.obj"}, "other": {"file": "builtin:hare"}}))
    expect(mesh["shape"]["file"] == str(pathlib.Path("a.obj").absolute()) and mesh["other"]["file"] == "builtin:hare",
           "paths of meshes")
    expect(set_words({"a.b": [1, 2.5], "c": "x", "d": True}) == ["a.b=[1,2.5]", 'c="x"', "d=true"], "words of --set")
    refused(lambda: toml_text({"time": {"end": None}}), None, "'time.end' is None")
    refused(lambda: toml_text({"time": {1: 2}}), None, "key 1", "time")
    refused(lambda: set_words([1]), None, "'sets'", "dictionary")
    for key in ("a b", "", "#a", "a=b", 3):
        refused(lambda: set_words({key: 1}), None, repr(key))


def check_sentences():
    mpirun = "-" * 74 + "\nmpirun detected that one\nprocess ended\n" + "-" * 74 + "\n"
    expect(sentence_of("warning: thin\nbulkley: step 3: crushed\n" + mpirun) == "step 3: crushed", "the program's sentence")
    expect(sentence_of(mpirun) == "mpirun detected that one process ended", "mpirun's own sentence")
    primary = "-" * 74 + "\nPrimary job  terminated normally, but 1 process\nreturned\n" + "-" * 74 + "\n"
    expect(sentence_of(primary + mpirun) == "mpirun detected that one process ended", "the second of mpirun's sentences")
    expect(sentence_of("warning: thin\n") == "", "a warning alone")


def check_environment():
    """That of cluster/environment.sh, but in a batch system none."""
    script = f". {ROOT}/cluster/environment.sh; env -0"
    clean = {name: value for name, value in os.environ.items() if name not in (*WORKSTATION, *AS_ROOT, "SLURM_JOB_ID")}
    text = subprocess.run(["bash", "-c", script], env={"PATH": os.environ["PATH"]},
                          capture_output=True, text=True, check=True).stdout
    told = dict(entry.split("=", 1) for entry in text.split("\0") if "=" in entry)
    told = {name: value for name, value in told.items() if name.startswith(("OMP", "PRTE", "HWLOC", "OPENBLAS"))}
    kept = dict(os.environ)
    try:
        os.environ.clear()
        os.environ.update(clean)
        mine = {name: value for name, value in environment().items() if name not in clean}
        expect(mine == told, f"the settings differ from cluster/environment.sh: {mine}, {told}")
        os.environ["SLURM_JOB_ID"] = "7"
        expect(environment() == dict(os.environ), "settings in a batch system")
    finally:
        os.environ.clear()
        os.environ.update(kept)


def check_bar():
    silent, told = io.StringIO(), io.StringIO()
    Bar("x", None, silent).show(0.5, "half")
    expect(silent.getvalue() == "", "a bar that nobody asked for, elsewhere than on a terminal")
    bar = Bar("x", True, told)
    for part in (0.0, 0.04, 0.5, 0.51, 2.0):
        bar.show(part, "t")
    bar.show(1.0, "t", is_last=True)
    bar.close()
    lines = told.getvalue().splitlines()
    expect([line.split("]")[1].split()[0] for line in lines] == ["0", "50", "100"], f"a line for each tenth: {lines}")
    left = [time_left(*times) for times in ((1.0, 0.5, 0.5), (3.0, 0.0, 1.0),
                      (3.0, 0.5, 0.5), (3.0, 0.02, 0.9), (3.0, 1e-4, 0.9))]
    expect(left == ["", "", ", 3 s left", ", 2 min 15 s left", ", 7 h 30 min left"], f"times left: {left}")
    expect(lines[1].startswith(f"x [{'#' * (WIDTH // 2)}{'-' * (WIDTH // 2)}]"), f"half a bar: {lines[1]}")


# --- runs ------------------------------------------------------------------------------------------------------------------

def check_dictionary():
    """A run on two ranks from a dictionary: the same particles as the program's own from the file."""
    bar = io.StringIO()
    stdout, sys.stdout = sys.stdout, bar
    try:
        run = bulkley.run(small_scene(), ranks=2, out="two", progress=True)
    finally:
        sys.stdout = stdout
    expect(run.status["state"] == "finished" and run.status["ranks"] == 2 and len(run.frames) == 5, f"{run.status}")
    lines = bar.getvalue().splitlines()
    expect(lines[0].startswith("two [") and "100 %" in lines[-1] and "t = 0.02 of 0.02 s" in lines[-1], f"the bar: {lines}")
    again = bulkley.run("two/input.toml", out="one", sets={"materials.fluid.yield_stress": 30.0})
    rows = again.checkpoints[-1].rows_of(run.checkpoints[-1].ids)
    expect(np.array_equal(again.checkpoints[-1]["position"][rows],
           run.checkpoints[-1]["position"]), "a dictionary and its file")
    other = bulkley.run("two/input.toml", out="one", sets={"materials.fluid.yield_stress": 3.0}, overwrite=True)
    expect(other.scene["materials"]["fluid"]["yield_stress"] == 3.0, "a key that was set")
    short = bulkley.run(small_scene(), out="short", max_steps=7)
    expect(short.status["step"] == 7, "max_steps")
    last, units = last_row("two/history.csv")
    expect(last["reach.reach"] == run.history["reach.reach"][-1] and units["sensor.force_z"] == "N" and last["limiter"]
           == run.history["limiter"][-1] and list(last) == list(run.history), "the last row")
    return run


def check_refusals(work):
    scene = small_scene()
    refused(lambda: bulkley.run(scene, out="bad", sets={"time.end": -1}), 2, "time.end", "greater than 0")
    refused(lambda: bulkley.run({**scene, "tyme": {}}, 2, out="bad"), 2, "bad/input.toml:", "tyme", "time")
    refused(lambda: bulkley.run("nowhere.toml"), 2, "nowhere.toml")
    refused(lambda: bulkley.run(scene, out="two"), None, "'two' holds an earlier run", "overwrite=True")
    refused(lambda: bulkley.run(scene, out="two", restart=True, overwrite=True), None, "'restart'", "'overwrite'")
    refused(lambda: bulkley.run(scene, out="none", restart=True), 2, "none", "checkpoint")
    for value in (0, 1.5, "2", True, None):
        refused(lambda: bulkley.run(scene, ranks=value), None, "'ranks' is", repr(value))
    refused(lambda: bulkley.run(scene, max_steps=0), None, "'max_steps' is 0")
    refused(lambda: bulkley.run(3), None, "'scene' is 3")
    refused(lambda: bulkley.run(scene, out=work / "two/input.toml"), None, "cannot write", "input.toml")
    refused(lambda: bulkley.run(scene, program="nowhere/bulkley"), None, "'nowhere/bulkley'", "BULKLEY")
    refused(lambda: bulkley.run(scene, 2, launcher="no-such-mpirun -n"), None, "no-such-mpirun", "'launcher'")
    error = refused(lambda: bulkley.run(scene, 2, out="fails", sets={"bodies.ball.velocity": [0, 0, -500]}), 3, "step", "crushed",
                    "material 'fluid'")
    expect(error.folder == pathlib.Path("fails") and bulkley.open_run("fails").status["state"] == "failed", "a failed run")
    try:
        bulkley.run(scene, out="bad", sets={"time.end": -1, "gravity": 3})
    except bulkley.RunError as error:
        expect(len(str(error).splitlines()) == 2, f"a line for each fault: {error}")
    pathlib.Path("killed.sh").write_text("#!/bin/sh\nkill -KILL $$\n", encoding="utf-8")
    pathlib.Path("killed.sh").chmod(0o755)
    refused(lambda: bulkley.run(scene, out="killed", program="./killed.sh"), -9, "signal 9", "SIGKILL")


def check_killed_rank():
    """A rank that is killed: mpirun's sentence, with the signal."""
    def kill():
        history = pathlib.Path("lost/history.csv")
        while not history.exists():
            time.sleep(0.02)
        found = subprocess.run(["pgrep", "-f", f"^{os.environ['BULKLEY']} run lost/input.toml"], capture_output=True, text=True)
        os.kill(int(found.stdout.split()[0]), signal.SIGKILL)

    thread = threading.Thread(target=kill)
    thread.start()
    refused(lambda: bulkley.run(small_scene(), 2, out="lost", sets={"time.end": 100.0, "output.frame_interval": 0}), 137,
            "signal 9", "rank")
    thread.join()


def check_warnings():
    """What the program warns of is a warning of Python's."""
    import warnings
    scene = small_scene(end=0.001)
    scene["materials"]["fluid"] = {"preset": "carbopol"}
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = bulkley.run(scene, out="warned", max_steps=2)
    expect(run.status["warnings"] and [str(one.message) for one in caught] == run.status["warnings"], f"warnings: {caught}")


# --- Ctrl-C ----------------------------------------------------------------------------------------------------------------

LONG = """
import signal, sys
signal.signal(signal.SIGINT, signal.default_int_handler)  # ignored where the test itself is in the background of a shell
sys.path[:0] = {path!r}
import bulkley, bulkley.launch
from small_scene import small_scene
bulkley.launch.PATIENCE = 0.5
bulkley.run({scene}, ranks={ranks}, out={out!r}, sets={{"time.end": 100.0, "output.frame_interval": 0}}, program={program!r})
"""


class Script:
    """A Python process on a terminal of its own, whose Ctrl-C reaches its process group."""

    def __init__(self, program, out, ranks):
        text = LONG.format(path=[str(ROOT / "tests/support"), str(PACKAGE)], scene="small_scene()", ranks=ranks, out=out,
                           program=str(program))
        self.terminal, inner = pty.openpty()
        self.process = subprocess.Popen([sys.executable, "-c", text], stdin=subprocess.DEVNULL, stdout=inner,
                                        stderr=subprocess.PIPE, text=True, start_new_session=True)
        os.close(inner)
        self.drawn = b""
        self.reader = threading.Thread(target=self.read)
        self.reader.start()

    def read(self):
        """Until the last process has closed the terminal."""
        try:
            while part := os.read(self.terminal, 4096):
                self.drawn += part
        except OSError:
            pass

    def wait_for(self, what, met):
        end = time.monotonic() + LIMIT
        while not met():
            if time.monotonic() > end or self.process.poll() is not None:
                fail(f"{what} never came: {self.process.poll()}")
            time.sleep(0.02)

    def interrupt(self):
        os.killpg(self.process.pid, signal.SIGINT)

    def end(self):
        """What was drawn, and the last line of the traceback."""
        try:
            _, errors = self.process.communicate(timeout=LIMIT)
        except subprocess.TimeoutExpired:
            os.killpg(self.process.pid, signal.SIGKILL)
            fail("a run goes on after Ctrl-C")
        self.reader.join()
        os.close(self.terminal)
        return self.drawn.decode(), (errors.strip().splitlines() or [""])[-1]


def check_interruption(program, ranks):
    out = f"stopped_{ranks}"
    script = Script(program, out, ranks)
    history = pathlib.Path(out, "history.csv")
    script.wait_for("the tenth row", lambda: history.exists() and history.read_bytes().count(b"\n") > 10)
    script.interrupt()
    drawn, last = script.end()
    run = bulkley.open_run(out)
    status = run.status
    expect(last == "KeyboardInterrupt" and status["state"] ==
           "stopped" and "signal" in status["reason"], f"{last}, {status}")
    expect(run.checkpoints[-1].step == status["step"] > 0, "the checkpoint of the last step")
    expect(drawn.count("\r") >= 2 and f"{out} [" in drawn and "restart=True continues it" in drawn, f"the bar: {drawn!r}")
    sets = {"time.end": 100.0, "output.frame_interval": 0}
    steps = status["step"] + 50
    continued = bulkley.run(f"{out}/input.toml", out=out, sets=sets, restart=True, max_steps=steps)
    whole = bulkley.run(f"{out}/input.toml", out=f"whole_{ranks}", sets=sets, max_steps=steps)
    rows = continued.checkpoints[-1].rows_of(whole.checkpoints[-1].ids)
    expect(continued.status["first_step"] == status["step"] and np.array_equal(
        continued.checkpoints[-1]["velocity"][rows], whole.checkpoints[-1]["velocity"]), "the run that was continued")


def check_second_interruption():
    """A program that does not stop is ended by the second Ctrl-C."""
    program = pathlib.Path("deaf.sh").absolute()
    program.write_text("#!/bin/bash\ntrap 'touch asked' USR1\ntrap '' TERM\ntouch started\nwhile true; do sleep 0.1; done\n",
                       encoding="utf-8")
    program.chmod(0o755)
    script = Script(program, "deaf", 1)
    script.wait_for("the start", lambda: pathlib.Path("started").exists())
    script.interrupt()
    script.wait_for("the signal", lambda: pathlib.Path("asked").exists())
    script.interrupt()
    _, last = script.end()
    left = subprocess.run(["pgrep", "-f", str(program)], capture_output=True, text=True).stdout.split()
    expect(last == "KeyboardInterrupt" and not left, f"{last}, processes {left} are left")


def main():
    program, work = start(parse_arguments(__doc__))
    work = work.resolve()
    os.environ["BULKLEY"] = str(pathlib.Path(program.path).resolve())
    os.chdir(work)
    check_scene_text()
    check_sentences()
    check_environment()
    check_bar()
    check_dictionary()
    check_refusals(work)
    check_killed_rank()
    check_warnings()
    for ranks in (1, 2):
        check_interruption(os.environ["BULKLEY"], ranks)
    check_second_interruption()
    print("runs from Python: dictionaries, refusals, bar, Ctrl-C")


if __name__ == "__main__":
    main()
