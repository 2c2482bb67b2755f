#!/usr/bin/env python3
"""A whole run opened by the real ParaView: particle counts, bounds, times and field names through both of its readers."""

import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("splash.toml")
ROOT = pathlib.Path(__file__).resolve().parents[2]


def main():
    arguments = parse_arguments(__doc__, lambda p: p.add_argument("--pvpython", required=True))
    program, work = start(arguments)

    run = program.run(["run", str(SCENE), "--out", "run", "--set", "time.end=0.02", "--set", "output.grid=true",
                       "--set", "output.tiles=true", "--set", 'output.fields=["velocity","cauchy_stress","rank"]'],
                      3, work, 120)
    if run.code != 0:
        fail(f"the run ended with {run.code}", run)
    if len(list((work / "run").glob("frame_*.h5"))) != 5:
        fail("0.02 s with a frame every 0.005 s make five frames, the one at the start included")
    for series in ("frames.xdmf", "grid.xdmf", "tiles.xdmf"):
        if not (work / "run" / series).exists():
            fail(f"{series} was not written", run)
    check = subprocess.run([arguments.pvpython, "--force-offscreen-rendering",
                            str(ROOT / "drivers/paraview/check_output.py"), "--run", str(work / "run")],
                           stdin=subprocess.DEVNULL, timeout=120, check=False)
    if check.returncode != 0:
        fail(f"check_output.py ended with {check.returncode}")


if __name__ == "__main__":
    main()
