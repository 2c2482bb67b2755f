#!/usr/bin/env python3
"""A run that grows from a thousand particles to 17 thousand: the balancer follows, so that the most loaded rank has at most 10 % more than the
mean, averaged over the steps after the first thousand particles have become eight, with which each rank has four tiles; the map of
the start does not."""

import csv
import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

RANKS = 4
EVEN = 1.1
ATTEMPTS = 3  # auto weighs measured times, which on too few cores may mislead it in one run, hardly in three
SCENE = """title = "growth"
gravity = [0.0, 0.0, -9.81]
[domain]
lower = [0.0, 0.0, 0.0]
upper = [0.64, 0.24, 0.2]
cell_size = 0.01
[time]
end = 0.5
[materials.fluid]
law = "newtonian"
density = 1000.0
bulk_modulus = 1e4
viscosity = 1.0
[[inflows]]
name = "slot"
material = "fluid"
section = { type = "rectangle", width = 0.04, height = 0.1 }
position = [0.12, 0.12, 0.15]
direction = [0.5, 0.0, -1.0]
side = [1.0, 0.0, 0.0]
speed = 1.0
[output]
history_interval = 10
"""


def rows_of(program, work, out, method):
    outcome = program.run(["run", "growth.toml", "--out", out, "--quiet", "--set", f"partition.method={method}"], RANKS, work, 200)
    if outcome.code != 0:
        fail(f"{out} did not end", outcome)
    with open(work / out / "history.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def uneven(rows):
    """Particles at the start and the end, the imbalance at the end, and its mean since there are eight times as many."""
    first, last = int(rows[0]["particles"]), int(rows[-1]["particles"])
    later = [float(row["imbalance"]) for row in rows if int(row["particles"]) > 8 * first]
    return first, last, float(rows[-1]["imbalance"]), sum(later) / len(later)


def follows(program, work, attempt):
    rows = rows_of(program, work, f"auto_{attempt}", "auto")
    first, last, end, mean = uneven(rows)
    print(f"auto: {first} to {last} particles, {rows[-1]['repartitions']} maps, imbalance {end:.3f} at the end, {mean:.3f} in the mean",
          flush=True)
    return mean <= EVEN


def main():
    program, work = start(parse_arguments(__doc__))
    (work / "growth.toml").write_text(SCENE, encoding="utf-8")
    first, last, end, _ = uneven(rows_of(program, work, "fixed", "metis"))
    print(f"map of the start: {first} to {last} particles, imbalance {end:.3f} at the end", flush=True)
    if not last > 15 * first or not end > 1.5:
        fail("the run does not grow out of the map of the start: this test shows nothing")
    if not any(follows(program, work, attempt) for attempt in range(ATTEMPTS)):
        fail("the balancer does not follow the growth")


main()
