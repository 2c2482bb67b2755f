#!/usr/bin/env python3
"""The notebook drivers/python/examples/tutorial.ipynb runs from end to end, and its cells show pictures, a bar and the
study's rows; it is kept without outputs. Ends with 77, and the reason, where nbconvert or a kernel of Python is missing."""

import importlib.util
import json
import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

NOTEBOOK = ROOT / "drivers/python/examples/tutorial.ipynb"
SKIPPED = 77
LIMIT = 600.0  # s, on a busy machine; a quiet one needs 20


def code_cells(path):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return [cell for cell in cells if cell["cell_type"] == "code"]


def main():
    program, work = start(parse_arguments(__doc__))
    for cell in code_cells(NOTEBOOK):
        if cell["outputs"] or cell["execution_count"] is not None:
            fail(f"{NOTEBOOK.name} is kept with outputs: clear them")
    missing = [name for name in ("nbconvert", "ipykernel", "matplotlib") if importlib.util.find_spec(name) is None]
    if missing:
        print(f"SKIPPED: this Python has no {', '.join(missing)}; cluster/install_packages.sh installs them")
        sys.exit(SKIPPED)
    environment = {**os.environ, "BULKLEY": str(pathlib.Path(program.path).resolve()), "PYTHONPATH": str(ROOT / "drivers/python"),
                   "HOME": str(work.resolve())}  # settings of a user must not matter
    (work / NOTEBOOK.name).write_bytes(NOTEBOOK.read_bytes())
    outcome = subprocess.run([sys.executable, "-m", "nbconvert", "--to", "notebook", "--execute", "--output", "executed.ipynb",
                              f"--ExecutePreprocessor.timeout={LIMIT:.0f}", NOTEBOOK.name],
                             cwd=work, env=environment, stdin=subprocess.DEVNULL, capture_output=True, text=True, timeout=LIMIT)
    if outcome.returncode != 0:
        fail(f"the notebook does not run:\n{outcome.stdout}{outcome.stderr}")
    outputs = [output for cell in code_cells(work / "executed.ipynb") for output in cell["outputs"]]
    pictures = [output for output in outputs if any(kind in output.get("data", {}) for kind in ("image/png", "image/gif"))]
    text = "".join("".join(output.get("text", [])) for output in outputs)
    # The history, the view, the slice, the film and the study's curve, each once.
    if len(pictures) != 5:
        fail(f"{len(pictures)} pictures instead of 5")
    for what, words in {"the bar of the run": "ball [", "its end": "100 %", "the sentence of a fault": "did you mean 'yield_stress'?",
                        "the bar of the study": "6 of 6 cases"}.items():
        if words not in text:
            fail(f"{what} is not shown: {text}")
    if text.count("finished  spread") != 6:
        fail(f"the study has not six rows that are finished: {text}")
    print("the notebook runs, with five pictures and six rows")


if __name__ == "__main__":
    main()
