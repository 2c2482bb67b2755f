#!/usr/bin/env python3
"""The Python package installs with pip into an environment of its own, without a network, and makes runs there. Exit code 77: cannot be tried."""

import importlib.util
import os
import pathlib
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402


def main():
    program, work = start(parse_arguments(__doc__))
    missing = [name for name in ("venv", "ensurepip", "pip", "setuptools") if importlib.util.find_spec(name) is None]
    if missing:
        print(f"skipped: this Python has no {', '.join(missing)}")
        sys.exit(77)
    # A copy: building leaves folders beside the sources.
    source = shutil.copytree(ROOT / "drivers/python", work / "source", ignore=shutil.ignore_patterns("__pycache__"))
    environment = work / "environment"
    python = environment / "bin/python"
    for command in ([sys.executable, "-m", "venv", "--system-site-packages", "--without-pip", environment],
                    [python, "-m", "pip", "install", "--no-build-isolation", "--no-deps", "--no-index", source]):
        result = subprocess.run([str(word) for word in command], capture_output=True, text=True, timeout=120, check=False)
        if result.returncode != 0:
            fail(f"{command} ended with {result.returncode}: {result.stdout}{result.stderr}")
    question = "import bulkley, importlib.metadata as m; print(bulkley.__file__, bulkley.__version__, m.version('bulkley'))"
    said = subprocess.run([str(python), "-c", question], capture_output=True, text=True, check=True, cwd=work).stdout.split()
    if not said[0].startswith(str(environment)) or said[1] != said[2]:
        fail(f"what was installed is not what is imported: {said}")
    for name in ("py.typed", "report_template.html"):
        if not (pathlib.Path(said[0]).parent / name).is_file():
            fail(f"{name} is not installed")
    for tool in ([environment / "bin/bulkley-tools"], [python, "-m", "bulkley"]):
        said = subprocess.run([str(word) for word in (*tool, "measure", "--help")], capture_output=True, text=True, check=True,
                              cwd=work).stdout
        if "output folder of a run" not in said:
            fail(f"{tool} does not know the tool `measure`: {said}")
    # It finds the program by BULKLEY, and the scripts next to that: a run, and a job script.
    script = ("import bulkley; from small_scene import small_scene; s = small_scene(); print(bulkley.run(s, max_steps=3).status['step'], "
              "bulkley.study(s, {'title': ['x']}, slurm={}).script)")
    said = subprocess.run([str(python), "-c", script], capture_output=True, text=True, check=False, cwd=work,
                          env={**os.environ, "BULKLEY": str(pathlib.Path(program.path).resolve()),
                               "PYTHONPATH": str(ROOT / "tests/support")})
    if said.stdout.split() != ["3", "out/study/study.sh"]:
        fail(f"the installed package makes no run or job script: {said.stdout}{said.stderr}")


if __name__ == "__main__":
    main()
