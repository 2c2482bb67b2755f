#!/usr/bin/env python3
"""A message that belongs to another map, plan, pool or piece of work than the one that its receiver is at (version_shim.c) ends all ranks at
once, with a sentence that says so, whatever the message is about; so does a call of MPI that fails."""

import json
import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENES = pathlib.Path(__file__).resolve().parents[1] / "system"
RANKS, STEPS = 4, 40
LIMIT = 100  # s, of a run of a few seconds
IMEX = ("time.integrator=imex", "materials.cream.bulk_modulus=2e9")
NEW_MAPS = ("partition.method=bisection", "partition.remake_interval=3", "partition.decision_interval=3")
# what messages are about, their tag, the place of the number in them, which message it is, settings, what the sentence names
CASES = (
    ("particles that change the rank", 1, 1, 20, NEW_MAPS, "map"),
    ("plans", 9, 0, 1, NEW_MAPS, "map"),
    ("sums of nodes", 13, 0, 30, NEW_MAPS, "plan"),
    ("values of nodes", 15, 0, 30, NEW_MAPS, "plan"),
    ("censuses and their sums", 11, 0, 20, NEW_MAPS, "joint work of number"),
    ("lists for the root", 2, 0, 1, ("partition.method=auto",), "joint work of number"),
    ("wanted cells", 3, 0, 1, IMEX, "pools of version"),
    ("places of cells", 7, 0, 1, IMEX, "pools of version"),
    ("counts of cells", 5, 0, 1, IMEX, "pools of version"),
    ("pressures of cells", 5, 0, 40, IMEX, "pools of version"),
)


def main():
    arguments = parse_arguments(__doc__, lambda parser: parser.add_argument("--shim", required=True))
    program, work = start(arguments)

    def run(out, tag, place, message, settings, words=()):
        sets = [word for key in ("output.frame_interval=0", *settings) for word in ("--set", key)]
        environment = {"LD_PRELOAD": arguments.shim, "WRONG_RANK": "1", "WRONG_TAG": str(tag), "WRONG_PLACE": str(place),
                       "WRONG_MESSAGE": str(message)}
        return program.run(["run", str(SCENES / "splash.toml"), "--out", out, "--max-steps", str(STEPS), *words, *sets], RANKS, work, LIMIT,
                           environment)

    def expect_status(about, out, outcome, sentence, unresponsive):
        status = json.loads((work / out / "status.json").read_text(encoding="utf-8"))
        if status["state"] != "failed" or not sentence.search(status["reason"]) or status.get("unresponsive", False) != unresponsive:
            fail(f"{about}: status.json says {status}", outcome)

    for number, (about, tag, place, message, settings, named) in enumerate(CASES):
        out = f"run_{number}"
        outcome = run(out, tag, place, message, settings)
        sentence = re.compile(rf"rank 1 sends what belongs to {named} (\d+), but rank (\d) is at {named} (\d+)")
        found = sentence.search(outcome.text)
        if outcome.code != 3 or not found:
            fail(f"{about}: the run ended with {outcome.code}" + " (it hangs)" * (outcome.code is None), outcome)
        theirs, rank, ours = map(int, found.groups())
        if theirs != ours + 1 or rank == 1:
            fail(f"{about}: '{found.group()}'", outcome)
        print(f"{about}: {found.group()}", flush=True)
        expect_status(about, out, outcome, sentence, False)

    # The machine is to blame: job scripts go on from the checkpoint.
    outcome = run("call", 13, -1, 30, NEW_MAPS)
    sentence = re.compile(r"MPI_Isend\(.*\) failed: ")
    if outcome.code != 3 or not sentence.search(outcome.text):
        fail(f"a call that fails: the run ended with {outcome.code}", outcome)
    expect_status("a call that fails", "call", outcome, sentence, True)
    print(f"a call that fails: {sentence.search(outcome.text).group()}...")

    # So it is while a run is being continued; what that status said before stays.
    whole = program.run(["run", str(SCENES / "splash.toml"), "--out", "again", "--max-steps", "5"], RANKS, work, LIMIT)
    outcome = run("again", 9, -1, 1, NEW_MAPS, ("--restart",))
    if whole.code != 0 or outcome.code != 3 or "step 5" not in whole.text:
        fail(f"a call that fails at a restart: {whole.code}, {outcome.code}", outcome)
    expect_status("a call that fails at a restart", "again", outcome, sentence, True)
    if json.loads((work / "again/status.json").read_text(encoding="utf-8"))["step"] != 5:
        fail("a call that fails at a restart: the step is lost", outcome)


if __name__ == "__main__":
    main()
