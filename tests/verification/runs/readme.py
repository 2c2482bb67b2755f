#!/usr/bin/env python3
"""The first scene of README.md is accepted and runs."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

README = pathlib.Path(__file__).resolve().parents[3] / "README.md"


def first_scene():
    """The indented block of README.md that begins with the table [domain]."""
    blocks = README.read_text(encoding="utf-8").split("\n    [domain]", 1)
    lines = ["    [domain]" + blocks[1].split("\n", 1)[0], *blocks[1].split("\n")[1:]]
    scene = []
    for line in lines:
        if line and not line.startswith("    "):
            break
        scene.append(line[4:])
    return "\n".join(scene)


def main():
    program, work = start(parse_arguments(__doc__))
    (work / "ball.toml").write_text(first_scene(), encoding="utf-8")
    for command in (["check", "ball.toml"], ["run", "ball.toml", "--max-steps", "20"]):
        outcome = program.run(command, 1, work, 60)
        if outcome.code != 0:
            fail(f"'bulkley {' '.join(command)}' ended with {outcome.code}", outcome)
    if not (work / "out" / "ball" / "frames.xdmf").exists():
        fail("the run wrote no out/ball/frames.xdmf")


if __name__ == "__main__":
    main()
