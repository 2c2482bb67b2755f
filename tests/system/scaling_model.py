#!/usr/bin/env python3
"""The tool `scaling-model` of the Python package: reads what `bulkley partition` writes, finds a law that a table was made
from, and the limits that can be worked out by hand."""

import csv
import math
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

DRIVERS = pathlib.Path(__file__).resolve().parents[2] / "drivers"
PACKAGE = DRIVERS / "python" / "bulkley"
sys.path.insert(0, str(PACKAGE.parent))
from bulkley import scaling_model  # noqa: E402

FACE, EDGE = 7000.0, 2500.0  # bytes: of the law
GRAIN, BUSIEST = 0.75, 1.5


def table_of_law(columns, path):
    """A table like that of `bulkley partition --csv` of parts that follow the law exactly."""
    with open(path, "w", newline="", encoding="utf-8") as stream:
        writer = csv.DictWriter(stream, columns)
        writer.writeheader()
        for n_tiles in (20000, 200000):
            for ranks in (512, 1024, 4096):
                share = n_tiles / ranks
                sent = FACE * share ** (2 / 3) + EDGE * share ** (1 / 3)
                row = dict.fromkeys(columns, 10)
                row |= {"ranks": ranks, "method": "metis", "chosen": "metis", "load_max_over_mean": 1 + GRAIN / share,
                        "sent_mean [B]": sent, "sent_max [B]": BUSIEST * sent, "n_tiles": n_tiles, "moved_fraction": ""}
                writer.writerow(row)
                writer.writerow(row | {"chosen": "hilbert", "sent_mean [B]": 1e9})  # METIS could not: no row of METIS


def expect(what, found, wanted, tolerance=1e-6):
    if not abs(found - wanted) <= tolerance * abs(wanted):
        fail(f"{what} is {found:g} and should be {wanted:g}")


def check_laws(module, path):
    sys.argv = ["scaling-model", str(path), "--method", "metis"]
    constants = module.parse_arguments()
    laws = module.Laws(*module.read_rows([str(path)], "metis", 512, 4096))
    expect("the term of faces", laws.mean[0], FACE)
    expect("the term of edges", laws.mean[1], EDGE)
    expect("the busiest rank", laws.busiest, BUSIEST)
    expect("the load of the most loaded of ranks with five tiles", laws.imbalance(5.0), 1 + GRAIN / 5)
    expect("the load of the most loaded of ranks with many tiles", laws.imbalance(1e4), 1.02)

    # A node's bandwidth is shared by its ranks; the exchange is its bytes over the link's share and its messages.
    run = module.Run(laws, constants, 1e9, 1e4)
    expect("a particle's time", run.per_particle, 883 * 128 / 400e9)
    share = 1e9 / 480 / 1e4
    sent = BUSIEST * (FACE * share ** (2 / 3) + EDGE * share ** (1 / 3))
    expect("the exchange", run.exchange, sent * 128 / 25e9 + 10 * 2e-6)
    expect("the all-reduce", run.sync, math.log2(1e4) * 3e-6)
    expect("the map", run.map_bytes, 4 * 8 * 1e9 / 480)
    constants.method = "bisection"  # the same parts, made without a root
    together = module.Run(laws, constants, 1e9, 1024)
    expect("the map", together.map_bytes, 8 * 1024)
    expect("a map", together.making, (6 * 55 + 20) * 3e-6 + 3 * 55 * 12e3 * 128 / 25e9)
    expect("the root's memory", together.root_memory, together.rank_memory)
    constants.method = "metis"
    if module.Run(laws, constants, 1e6, 1).step != module.Run(laws, constants, 1e6, 1).compute + 0.1 * 40e-9 * 1e6:
        fail("one rank pays for more than its particles and its rebuilds")

    limit = module.first_particles(lambda n: module.Run(laws, constants, n, n / 1e6).box >= 2**31)
    expect("the particles at which tiles of the box outgrow 32 bits", limit, 2**31 / 8 * 480)
    if not math.isinf(module.first_particles(lambda n: False)):
        fail("what never breaks has a size")


def check_program(program, work):
    """The whole way, from a scene to tables and picture."""
    table, picture = work / "ball.csv", work / "picture.png"
    scene = str(DRIVERS / "scenes" / "partition_ball.toml")
    outcome = program.run(["partition", scene, "--set", "domain.cell_size=0.0078125", "-n", "8,16,32,64", "--methods",
                           "bisection", "--csv", str(table)], 1, work, 120)
    if outcome.code != 0:
        fail(outcome.text)
    command = [sys.executable, str(PACKAGE), "scaling-model", str(table), "--least-ranks", "8", "--picture", str(picture),
               "--run", "5e6,40"]
    found = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    if found.returncode != 0:
        fail(found.stderr)
    for words in ("Requested runs", "| 40 |", "What breaks"):
        if words not in found.stdout:
            fail(f"its tables do not hold '{words}'")
    if "nan" in found.stdout:
        fail("its tables hold what is not a number")
    if not 10_000 < picture.stat().st_size < 300_000:
        fail(f"its picture has {picture.stat().st_size} bytes")
    few = subprocess.run([*command, "--least-ranks", "33"], capture_output=True, text=True, timeout=120, check=False)
    if few.returncode == 0 or "nothing to fit" not in few.stderr:
        fail("one row is enough for it")
    with open(table, newline="", encoding="utf-8") as stream:
        return next(csv.reader(stream))


def main():
    program, work = start(parse_arguments(__doc__))
    columns = check_program(program, work)
    path = work / "law.csv"
    table_of_law(columns, path)
    check_laws(scaling_model, path)
    print("the model finds the law of its table, and what breaks where it must")


if __name__ == "__main__":
    main()
