"""Runs the real `bulkley` for tests that are written in Python."""

import argparse
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass


@dataclass
class Outcome:
    code: int  # exit status; None: killed at the time limit
    text: str  # stdout and stderr
    seconds: float


class Program:
    """The program and how to start it on several ranks."""

    def __init__(self, path, mpiexec):
        self.path = path
        self.mpiexec = mpiexec

    def run(self, arguments, ranks, folder, limit, environment=None):
        """`bulkley arguments` on `ranks` ranks in `folder`, ended after `limit` seconds. One rank needs no mpiexec.
        `environment`: variables beside those of this process."""
        launcher = [self.mpiexec, "-n", str(ranks)] if ranks > 1 else []
        command = [*launcher, self.path, *arguments]
        start = time.monotonic()
        process = subprocess.Popen(command, cwd=folder, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                                   stderr=subprocess.STDOUT, text=True, errors="replace", start_new_session=True,
                                   env={**os.environ, **(environment or {})})
        try:
            text, _ = process.communicate(timeout=limit)
            code = process.returncode
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)  # mpiexec and the ranks it started
            text, _ = process.communicate()
            code = None
        return Outcome(code, text, time.monotonic() - start)


def parse_arguments(description, add=lambda parser: None):
    """--program, --mpiexec, --work (a folder of this test's own), and what `add` adds."""
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--program", required=True)
    parser.add_argument("--mpiexec", default="mpiexec")
    parser.add_argument("--work", required=True, help="folder that this test may fill and empty")
    add(parser)
    return parser.parse_args()


def start(arguments):
    """The program, and the folder that `parse_arguments` was given, emptied."""
    work = pathlib.Path(arguments.work)
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    return Program(arguments.program, arguments.mpiexec), work


def fail(sentence, outcome=None):
    """Ends the test with `sentence` and what the program printed."""
    if outcome is not None:
        print(outcome.text)
    sys.exit(f"FAILED: {sentence}")
