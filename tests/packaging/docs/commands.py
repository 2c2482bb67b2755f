#!/usr/bin/env python3
"""Runs the commands of README.md and of the pages in docs/; tests/packaging/docs/README.md has the conventions.

Every page gets a folder of its own that looks like the repository after a build, with a small scene and its output. Ends
with how many commands were run, validated and skipped, and with the reasons. `--page NAME` takes the pages whose path
holds NAME. `--list` prints what would be done.
"""

import argparse
import collections
import concurrent.futures
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time

sys.dont_write_bytecode = True
from blocks import Block, PageError, blocks, commands, is_shell, is_toml, without_variables  # noqa: E402
from validation import Validator  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[3]
HERE = pathlib.Path(__file__).resolve().parent
# Pages that programs write, so that they hold no comments: what to do with their commands, and why.
WRITTEN_PAGES = {
    "docs/command-line.md": ("skip", "printed by `bulkley command-reference`: synopses, not commands"),
    "docs/verification.md": ("validate", "written by tests/verification/report.py: they are tests themselves"),
    "docs/validation.md": ("validate", "written by tests/validation/report.py: they are tests themselves"),
}
# Run unless a comment excludes it. Any other program must have a comment.
RUN = {".", "bulkley", "build/bulkley", "mpirun", "pvpython", "python3", "cat", "cp", "grep", "head", "ls", "mkdir", "rm",
       "sed", "tail", "touch"}
LIMIT = 300.0  # s, for one block, on a machine that does much else

WRAPPER = """#!/bin/sh
# The program; in runs, with what the page's comment adds at the end of the command line.
if [ "$1" = run ]; then exec {program} "$@" $BULKLEY_TEST_ADD; fi
exec {program} "$@"
"""


class Failure(Exception):
    """A command that does not work as its page describes."""


def parse_arguments():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", required=True)
    parser.add_argument("--work", required=True, help="folder that this test may fill and empty")
    parser.add_argument("--page", default="", help="part of the paths of the pages to take")
    parser.add_argument("--list", action="store_true")
    return parser.parse_args()


def pages():
    return [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted((ROOT / "tests").rglob("README.md"))]


class Tester:
    def __init__(self, program, work):
        self.program = str(pathlib.Path(program).resolve())
        self.work = pathlib.Path(work).resolve()
        self.validator = Validator(ROOT, self.program)
        self.counts = collections.Counter()
        self.reasons = collections.defaultdict(list)
        self.failures = []
        self.seconds = collections.Counter()

    def prepare(self):
        """The folder that each page gets a copy of."""
        shutil.rmtree(self.work, ignore_errors=True)
        model = self.work / "model"
        (model / "build").mkdir(parents=True)
        wrapper = model / "build/bulkley"
        wrapper.write_text(WRAPPER.format(program=self.program), encoding="utf-8")
        wrapper.chmod(0o755)
        (model / "build/python3").symlink_to(sys.executable)  # the one that has the packages
        for entry in ROOT.iterdir():
            if not re.fullmatch(r"build.*|out|\.git", entry.name):
                (model / entry.name).symlink_to(entry)
        for file in (HERE / "scratch").iterdir():
            shutil.copy(file, model)
        shutil.copy(ROOT / "docs/examples/yoghurt.csv", model / "measured.csv")
        outcome = self.shell("build/bulkley run scene.toml --quiet", model)
        if outcome.returncode != 0:
            sys.exit(f"FAILED: the scene of the scratch folder does not run:\n{outcome.stdout}")
        for name in ("run", "a", "b"):
            shutil.copytree(model / "out/scene", model / "out" / name)

    def shell(self, script, folder, add="", limit=LIMIT):
        environment = {**os.environ, "BULKLEY_TEST_ADD": add, "PYTHONDONTWRITEBYTECODE": "1",
                       "PATH": f"{folder}/build:{os.environ['PATH']}"}
        return subprocess.run(["bash", "-ec", script], cwd=folder, env=environment, stdin=subprocess.DEVNULL, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT, errors="replace", timeout=limit)

    def test_page(self, path):
        name = path.relative_to(ROOT).as_posix()
        try:
            found = blocks(name, path.read_text(encoding="utf-8"))
        except PageError as error:
            self.failures.append(name)
            print(f"FAILED {error}", flush=True)
            return
        for block in found:
            if name in WRITTEN_PAGES and is_shell(block, ROOT):
                block.mode, block.reason = WRITTEN_PAGES[name]
        folder = self.work / re.sub(r"\W", "_", name)
        if any(is_shell(block, ROOT) for block in found):
            shutil.copytree(self.work / "model", folder, symlinks=True)
        output = None
        begin = time.monotonic()
        for block in found:
            try:
                output = self.test_block(block, folder, output)
            except (Failure, PageError, ValueError) as error:
                self.failures.append(block.place)
                print(f"FAILED {block.place}: {error}", flush=True)
        self.seconds[name] = time.monotonic() - begin

    def test_block(self, block: Block, folder, output):
        """Deals with one block; returns the output that an `output` block after it is compared with."""
        if block.mode in ("save", "append"):
            with open(folder / block.options["file"], "w" if block.mode == "save" else "a", encoding="utf-8") as file:
                file.write(block.text + "\n")
        if block.mode == "output":
            self.compare(block, output)
        elif block.mode == "text":
            self.counts["other blocks"] += 1
        elif block.mode in ("run", "validate", "skip") or is_shell(block, ROOT):
            return self.test_commands(block, folder)
        elif block.language == "toml" or is_toml(block.text):
            if not is_toml(block.text):
                raise Failure("this is no TOML")
            self.counts["blocks of TOML that parse"] += 1
        else:
            self.counts["other blocks"] += 1
        return output

    def test_commands(self, block, folder):
        lines = list(commands(block.text))
        if block.mode == "skip":
            self.counts["skipped"] += len(lines)
            self.reasons["skipped", block.reason].append((block.place, len(lines)))
            return None
        if block.mode == "validate":
            for words in lines:
                fault = self.validator.fault(words, folder)
                if fault:
                    raise Failure(f"{' '.join(words)}: {fault}")
            self.counts["validated"] += len(lines)
            self.reasons["validated", block.reason].append((block.place, len(lines)))
            return None
        if block.mode == "":
            for words in lines:
                name = without_variables(words)[0]
                if name not in RUN:
                    raise Failure(f"'{name}' is not run unasked; say <!-- test: run -->, or validate or skip with a reason")
        return self.run(block, folder, len(lines))

    def run(self, block, folder, n_commands):
        add = block.options.get("add", "")
        begin = time.monotonic()
        try:
            outcome = self.shell(block.text, folder, add, float(block.options.get("limit", LIMIT)))
        except subprocess.TimeoutExpired:
            raise Failure("takes too long") from None
        expected = int(block.options.get("code", 0))
        if outcome.returncode != expected:
            raise Failure(f"exit code {outcome.returncode} instead of {expected}\n{block.text}\n{outcome.stdout[-3000:]}")
        self.counts["run"] += n_commands
        if add:
            self.reasons[f"run with {add}", block.reason].append((block.place, n_commands))
        if time.monotonic() - begin > 3.0:
            print(f"  {block.place}: {time.monotonic() - begin:.1f} s")
        return outcome.stdout

    def compare(self, block, output):
        """Every line of the block must be in the output; "..." matches any text."""
        if output is None:
            raise Failure("an output block follows a block that was run")
        text = " ".join(output.split())
        # A sentence may be broken into lines that begin with spaces.
        for line in re.sub(r"\n +", " ", block.text).splitlines():
            parts = [re.escape(" ".join(part.split())) for part in line.split("...")]
            if line.strip() and not re.search(".*?".join(parts), text):
                raise Failure(f"the output does not hold the line\n  {line}\nbut is\n{output}")
        self.counts["outputs compared"] += 1

    def report(self):
        for (what, reason), places in sorted(self.reasons.items()):
            where = ", ".join(f"{place} ({n})" for place, n in places)
            print(f"{what}: {reason}: {where}")
        slowest = ", ".join(f"{name} {seconds:.0f} s" for name, seconds in self.seconds.most_common(5))
        print(f"Longest: {slowest}")
        print("Commands " + ", ".join(f"{key}: {self.counts[key]}" for key in ("run", "validated", "skipped")))
        print("Also " + ", ".join(f"{key}: {n}" for key, n in sorted(self.counts.items())
                                  if key not in ("run", "validated", "skipped")))


def main():
    arguments = parse_arguments()
    chosen = [path for path in pages() if arguments.page in path.as_posix()]
    if arguments.list:
        for path in chosen:
            for block in blocks(path.relative_to(ROOT).as_posix(), path.read_text(encoding="utf-8")):
                if is_shell(block, ROOT):
                    print(f"{block.place}: {block.mode or 'run'} {block.reason}\n  " + block.text.replace("\n", "\n  "))
        return
    tester = Tester(arguments.program, arguments.work)
    tester.prepare()
    # The pages with the most commands first; two at a time, for most of a small run is waiting for files.
    with concurrent.futures.ThreadPoolExecutor(2) as pool:
        list(pool.map(tester.test_page, sorted(chosen, key=lambda path: path.name not in ("tutorial.md", "faq.md"))))
    tester.report()
    if tester.failures:
        sys.exit("FAILED: " + ", ".join(sorted(tester.failures)))


if __name__ == "__main__":
    main()
