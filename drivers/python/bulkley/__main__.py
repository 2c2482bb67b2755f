"""The package's tools: `python3 -m bulkley TOOL ...`, or `python3 drivers/python/bulkley TOOL ...` without installing.

    measure         rebound, spreading, pieces, collision and spin of runs
    scaling-model   predicts runs on many ranks from tables of `bulkley partition`
    adaptive-gain   what the adaptive time step gains on the scenes of the figures
    imex-gain       what the implicit pressure costs and changes on them
    fit-front       finds the flow curve of a fluid from a front that was filmed, by running the solver
    gcode           key frames of a print head from a G-code file
    tool-mesh       closed meshes of tools: vane, helical ribbon, whisk, bowl
    plot-rheometer  draws a table of `bulkley rheometer` (the program calls it for --plot)
    report          writes the page of `bulkley report` (the program calls it)

`TOOL --help` tells the options of each. Exit code 4: a module that the tool imports is not installed, or Python is too old.
"""

import importlib
import os
import pathlib
import sys

TOOLS = ("measure", "scaling-model", "adaptive-gain", "imex-gain", "fit-front", "gcode", "tool-mesh", "plot-rheometer",
         "report")
CALLED_BY_PROGRAM = ("plot-rheometer", "report")  # which says by itself what is missing
MODULE_MISSING = 4
OLDEST_PYTHON = (3, 11)


def main():
    """Runs the tool that the command line names."""
    name = sys.argv[1] if len(sys.argv) > 1 else "--help"
    if name in ("-h", "--help"):
        print(__doc__.strip())
        return
    if name not in TOOLS:
        sys.exit(f"there is no tool '{name}': give one of {', '.join(TOOLS)}")
    sys.argv[:2] = [f"python3 -m bulkley {name}"]
    try:
        if sys.version_info < OLDEST_PYTHON:
            raise ImportError("this needs Python 3.11 or newer")
        tool = importlib.import_module(f"bulkley.{name.replace('-', '_')}")
    except ImportError as missing:
        if name not in CALLED_BY_PROGRAM:
            print(f"{name}: {missing}", file=sys.stderr)
        sys.exit(MODULE_MISSING)
    try:
        tool.main()
        sys.stdout.flush()
    except BrokenPipeError:  # who reads has had enough, like `head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        sys.exit(1)


if __name__ == "__main__":
    if not __package__:  # the folder was given to Python, and is the first place where modules are looked for
        sys.path[0] = str(pathlib.Path(__file__).resolve().parent.parent)
    main()
