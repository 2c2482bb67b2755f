"""What tests expect of runs that must agree bit for bit, and of the energy account of any run."""

import csv

from bulkley_program import fail

ROUNDING = 1e-12  # of the energy account's largest term


def expect_identical(program, work, one, other, step, what):
    """The checkpoints of the folders `one` and `other` at a step."""
    name = f"checkpoint_{step:09d}.h5"
    compare = program.run(["compare", str(one / name), str(other / name)], 1, work, 60)
    if compare.code != 0 or "identical" not in compare.text:
        fail(f"{what}: different", compare)
    print(f"{what}: identical", flush=True)


def last_row(folder):
    """Of history.csv, as texts by column."""
    with open(folder / "history.csv", encoding="utf-8") as table:
        return list(csv.DictReader(table))[-1]


def expect_closed_account(folder, name):
    """Energies and losses of the last row sum up but for rounding."""
    last = {key: float(value) for key, value in last_row(folder).items() if key.endswith("[J]")}
    largest = max(abs(value) for value in last.values() if value == value)
    if not abs(last["energy_residual [J]"]) <= ROUNDING * largest:
        fail(f"{name}: the energy account is off by {last['energy_residual [J]']} J of {largest} J")
