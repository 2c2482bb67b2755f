"""A small run for tests of programs that read runs."""

import pathlib
import sys

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from bulkley_program import fail  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("sample.toml")
N_FRAMES = 3


def make_run(program, work, *settings, scene=SCENE):
    """The folder of a finished run on two ranks."""
    options = [word for setting in settings for word in ("--set", setting)]
    outcome = program.run(["run", str(scene), "--out", "run", "--quiet", *options], 2, work, 120)
    frames = sorted((work / "run").glob("frame_*.h5"))
    if outcome.code != 0 or len(frames) != N_FRAMES:
        fail(f"the run ended with {outcome.code} and {len(frames)} frames, not {N_FRAMES}", outcome)
    return work / "run"


def truth(path):
    """The particles' arrays of a file as h5py reads them, and its time."""
    with h5py.File(path) as file:
        return {name: array[...] for name, array in file["particles"].items() if name != "connectivity"}, file.attrs["time"]


def chosen_by_id(ids, every):
    """is_chosen of convert.hpp in whole numbers of Python."""
    def mixed(x):
        mask = (1 << 64) - 1
        x = (x + 0x9E3779B97F4A7C15) & mask
        x = ((x ^ (x >> 30)) * 0xBF58476D1CE4E5B9) & mask
        x = ((x ^ (x >> 27)) * 0x94D049BB133111EB) & mask
        return x ^ (x >> 31)
    return np.array([mixed(int(one)) % every == 0 for one in ids], dtype=bool)


def expect(condition, sentence):
    if not condition:
        fail(sentence)
