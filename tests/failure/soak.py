#!/usr/bin/env python3
"""A long run in many parts: a shaken tank on four ranks, with new partitions, checkpoints and frames, continued again and again
on another number of ranks. Mass and particles must stay exactly, memory and open files flat, and the end must have the bits of
one uninterrupted run.

    soak.py --program build/bulkley --work out/soak [--steps 40000] [--parts 40]
"""

import csv
import os
import pathlib
import shutil
import subprocess
import sys
import time

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("soak.toml")
RANKS = (4, 3, 4, 5, 4, 2, 4, 1)  # of the parts in turn; four is the rule
SECONDS_BETWEEN_LOOKS = 0.25
# Particles move between ranks and buffers follow them; a leak of one particle's bytes a step would be 0.3 MB in 1000 steps.
LARGEST_SLOPE = 0.1  # MiB of one rank in 1000 steps
WARM_UP = 0.6  # of the run: memory approaches the need of the largest rank


def looks_at(pid):
    """(resident MiB, open files) of a process; None when it is gone."""
    try:
        with open(f"/proc/{pid}/status", encoding="ascii") as file:
            memory = next(int(line.split()[1]) for line in file if line.startswith("VmRSS"))
        return memory / 1024, len(os.listdir(f"/proc/{pid}/fd"))
    except (OSError, StopIteration):
        return None


def children_of(pid):
    text = subprocess.run(["ps", "-o", "pid=", "--ppid", str(pid)], capture_output=True, text=True).stdout
    return [int(word) for word in text.split()]


def last_step(folder):
    try:
        return int((folder / "history.csv").read_bytes().rstrip().rsplit(b"\n", 1)[-1].split(b",")[0])
    except (OSError, ValueError):
        return 0


def watched_run(program, ranks, work, name, until, *more):
    """Runs to step `until`; gives the rows (step, rank, MiB, files) seen on the way, and seconds."""
    command = [program.mpiexec, "-n", str(ranks), program.path, "run", str(SCENE), "--out", name, "--max-steps", str(until),
               "--quiet", *more]
    begin = time.monotonic()
    seen = []
    with open(work / f"{name}.log", "ab") as log:
        process = subprocess.Popen(command, cwd=work, stdin=subprocess.DEVNULL, stdout=log, stderr=log)
        while process.poll() is None:
            step = last_step(work / name)
            for rank, pid in enumerate(sorted(children_of(process.pid))):
                look = looks_at(pid)
                if look:
                    seen.append((step, rank, *look))
            time.sleep(SECONDS_BETWEEN_LOOKS)
    if process.returncode != 0:
        print((work / f"{name}.log").read_text(encoding="utf-8", errors="replace")[-3000:])
        fail(f"{name}: the run to step {until} on {ranks} ranks ended with {process.returncode}")
    return seen, time.monotonic() - begin


def slopes(seen, first, last):
    """Of each rank after the warm-up: MiB in 1000 steps, change of open files."""
    result = []
    for rank in sorted({row[1] for row in seen}):
        # Before the last row of the history: after it the run takes itself down.
        rows = np.array([row for row in seen if row[1] == rank and first + WARM_UP * (last - first) <= row[0] < last - 20],
                        dtype=float)
        if len(rows) < 8 or rows[-1, 0] - rows[0, 0] < 0.2 * (last - first):
            continue
        third = max(len(rows) // 3, 1)  # a look may find a frame or a checkpoint open; not all of a third do
        files = rows[-third:, 3].min() - rows[:third, 3].min()
        result.append((1000 * np.polyfit(rows[:, 0], rows[:, 2], 1)[0], files))
    return result


def columns(folder, *names):
    with open(folder / "history.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    return [[row[name] for row in rows] for name in names]


def main():
    def add(parser):
        parser.add_argument("--steps", type=int, default=40000)
        parser.add_argument("--parts", type=int, default=40)

    arguments = parse_arguments(__doc__, add)
    program, work = start(arguments)
    steps, parts = arguments.steps, arguments.parts
    seen, seconds = watched_run(program, 4, work, "whole", steps)
    print(f"whole run: {steps} steps on 4 ranks in {seconds:.0f} s")
    leaks = slopes(seen, 0, steps)
    frames = len(list((work / "whole").glob("frame_*.h5")))
    for rank, (memory, files) in enumerate(leaks):
        print(f"  rank {rank}: {memory:+.3f} MiB in 1000 steps, {files:+.0f} open files")
    for rank, (memory, files) in enumerate(leaks):
        if memory > LARGEST_SLOPE and steps >= 20000:  # in a shorter run memory still grows to what the splash needs
            fail(f"memory of rank {rank} grows by {memory:.3f} MiB in 1000 steps, allowed are {LARGEST_SLOPE:.3f}")
        if files > 0:
            fail(f"rank {rank} holds {files:.0f} more open files at the end than at the start")

    shutil.rmtree(work / "parted", ignore_errors=True)
    for part in range(parts):
        until = steps * (part + 1) // parts
        ranks = RANKS[part % len(RANKS)]
        seen, seconds = watched_run(program, ranks, work, "parted", until, *(["--restart"] if part else []))
        print(f"part {part + 1}: to step {until} on {ranks} ranks in {seconds:.0f} s", flush=True)

    end = f"checkpoint_{steps:09d}.h5"
    compare = program.run(["compare", f"whole/{end}", f"parted/{end}"], 1, work, 120)
    if compare.code != 0 or "identical" not in compare.text:
        fail("the run in parts ends with other bits", compare)
    for name in ("whole", "parted"):
        step, mass, particles = columns(work / name, "step", "mass [kg]", "particles")
        if len(set(mass)) != 1 or len(set(particles)) != 1:
            fail(f"{name}: mass or number of particles change: {sorted(set(mass))}, {sorted(set(particles))}")
        if [int(s) for s in step] != [0, *range(20, steps + 1, 20)]:
            fail(f"{name}: history.csv has gaps or doubles")
    print(f"{frames} frames, {steps // 250} checkpoints")
    repartitions = columns(work / "whole", "repartitions")[0][-1]
    print(f"identical; {particles[0]} particles and {mass[0]} kg in every row; {repartitions} new partitions")


if __name__ == "__main__":
    main()
