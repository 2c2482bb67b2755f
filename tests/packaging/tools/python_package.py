#!/usr/bin/env python3
"""drivers/python: every function of the package compared with h5py, csv and plain loops on a small run."""

import csv
import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tomllib

import h5py
import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from sample_run import N_FRAMES, chosen_by_id, expect, make_run, truth  # noqa: E402

PACKAGE = ROOT / "drivers/python"
sys.path.insert(0, str(PACKAGE))
import bulkley  # noqa: E402
from bulkley.report_curves import ThinnedCurve  # noqa: E402
from bulkley.run_folder import EndedRun  # noqa: E402


def same(found, wanted, what):
    numbers = np.asarray(wanted).dtype.kind == "f"  # among which NaN is what is not known
    if not (np.shape(found) == np.shape(wanted) and np.array_equal(found, wanted, equal_nan=numbers)):
        fail(f"{what} is not what the files say")


def near(found, wanted, what):
    if not (np.shape(found) == np.shape(wanted) and np.allclose(found, wanted, rtol=1e-12, atol=0.0, equal_nan=True)):
        fail(f"{what} is not what plain loops find")


def refuses(work, *words):
    try:
        work()
    except bulkley.DataError as error:
        if "\n" in str(error) or not all(word in str(error) for word in words):
            fail(f"the sentence must hold {words}: {error}")
    else:
        fail(f"nothing is said about {words}")


# --- history and status ---------------------------------------------------------------------------------------------

def check_history(folder, run):
    with open(folder / "history.csv", newline="", encoding="utf-8") as stream:
        header, *rows = csv.reader(stream)
    history = run.history
    expect(len(history) == len(header) and "time" in history and list(history)[0] == "step", "the history's columns")
    for number, name in enumerate(header):
        plain, _, unit = name.partition(" [")
        expect(history.units[plain] == unit.rstrip("]"), f"the unit of {name}")
        column = [row[number] for row in rows]
        same(history[plain], column if plain == "limiter" else np.array(column, float), plain)
    refuses(lambda: history["tme"], "history.csv", "no column 'tme'", "time")
    try:
        import pandas  # noqa: F401
        same(history.to_pandas()["time"].to_numpy(), history["time"], "to_pandas")
        same(run.frames[0].to_pandas(["velocity"])["velocity_y"].to_numpy(), run.frames[0]["velocity"][:, 1], "to_pandas")
    except ImportError:
        refuses(history.to_pandas, "pandas")
        refuses(run.frames[0].to_pandas, "pandas")
    expect(run.status == json.loads((folder / "status.json").read_text()) and run.status["state"] == "finished", "status")
    expect(run.scene == tomllib.loads((folder / "scene.toml").read_text()), "scene")


def check_run_that_goes_on(folder, work):
    """A folder as it is while a run writes: a torn row, a frame under its temporary name, no status yet."""
    live = work / "live"
    shutil.copytree(folder, live)
    text = (live / "history.csv").read_text()
    rows = text.count("\n") - 1
    (live / "history.csv").write_text(text[:-9])
    shutil.copy(live / "frame_000002.h5", live / "frame_000003.h5.tmp")
    run = bulkley.open_run(live)
    expect(len(run.history["time"]) == rows - 1 and len(run.frames) == N_FRAMES, "a run that goes on")
    (live / "history.csv").write_text(text)
    shutil.copy(live / "frame_000002.h5", live / "frame_000003.h5")
    expect(len(run.history["time"]) == rows and len(run.frames) == N_FRAMES + 1, "what has come since is not seen")
    (live / "history.csv").write_text(text.splitlines()[0] + "\n")
    expect(len(run.history["time"]) == 0, "a history without rows")
    (live / "history.csv").write_text(text + "1,2\n")
    refuses(lambda: run.history, "history.csv", f"line {rows + 2}")
    (live / "status.json").unlink()
    refuses(lambda: run.status, "status.json")
    (live / "history.csv").unlink()
    refuses(lambda: run.history, "there is no", "history.csv")


# --- particles ------------------------------------------------------------------------------------------------------

def check_files(folder, run):
    expect(len(run.frames) == N_FRAMES and len(run.checkpoints) == 1, "the numbers of files")
    times = []
    for number, frame in enumerate(run.frames):
        arrays, time = truth(folder / f"frame_{number:06}.h5")
        times.append(time)
        expect(frame.index == number and frame.time == time and frame.n_particles == len(arrays["id"]), f"{frame}: header")
        expect(sorted(frame.fields) == sorted(arrays) and frame.units["velocity"] == "m/s" and frame.units["id"] == "1",
               f"{frame}: fields")
        with frame:
            for name, array in arrays.items():
                same(frame[name], array, f"{frame}, {name}")
        same(frame.positions, arrays["position"].astype(float), "positions")
        same(frame.ids, arrays["id"], "ids")
        expect(frame.materials == ["cream", "rubber"] and "mass" in frame and "density" not in frame, "materials and fields")
    same(run.frames.times, times, "times")
    expect(run.frames.nearest(0.0021).index == 1 and [f.index for f in run.frames[1:]] == [1, 2], "which frames")
    checkpoint = run.checkpoints[-1]
    arrays, time = truth(checkpoint.path)
    expect(checkpoint.time == time and checkpoint.step == h5py.File(checkpoint.path).attrs["step"], "the checkpoint's header")
    for name, array in arrays.items():
        same(checkpoint[name], array, f"checkpoint, {name}")
    expect(checkpoint.scene["domain"] == run.scene["domain"], "the checkpoint's scene")
    kinds = [type(bulkley.open_file(path)) for path in (checkpoint.path, run.frames[0].path)]
    expect(kinds == [bulkley.Checkpoint, bulkley.Frame], "open_file")
    same(bulkley.open_file(run.frames[0].path).bodies(), run.frames[0].bodies(), "bodies of a file opened by its name")
    with h5py.File(run.frames[1].path) as file:
        grid = run.frames[1].grid()
        same(grid.fields["velocity"], file["grid/velocity"][...], "the grid's velocity")
        shape = file["grid/mass_density"].shape
        expect((len(grid.z), len(grid.y), len(grid.x)) == shape and grid.units["velocity"] == "m/s", "the grid's axes")
        near(np.diff(grid.x), np.full(shape[2] - 1, np.diff(grid.x)[0]), "x of the grid")
        expect(grid.y[0] == file["grid"].attrs["origin"][1], "the grid's origin")


def check_selections(run):
    frame = run.frames[1]
    position, ids, material = frame.positions, frame.ids, frame["material"]
    same(frame.select(), np.ones(len(ids), bool), "select")
    same(frame.select(region=((0.1, None), (None, None), (0.04, 0.06))),
         [p[0] >= 0.1 and 0.04 <= p[2] < 0.06 for p in position], "select by region")
    same(frame.select(every=3), chosen_by_id(ids, 3), "select by id")
    same(bulkley.is_chosen(ids, 7), chosen_by_id(ids, 7), "is_chosen")
    same(frame.select(material="rubber"), material == 1, "select by material")
    same(frame.select(material=0, every=2), (material == 0) & chosen_by_id(ids, 2), "select by material and id")
    # In the sample each body is of a material of its own.
    same(frame.bodies(), material, "bodies")
    same(run.checkpoints[0].bodies(), run.checkpoints[0]["material"], "bodies of the checkpoint")
    same(frame.select(body="cube"), material == 1, "select by body")
    expect(0 < (material == 1).sum() < len(material), "the sample has one body only")
    rows = run.frames[2].rows_of(ids[:100])
    same(run.frames[2].ids[rows], ids[:100], "rows_of")
    expect(list(frame.rows_of([ids[5], -3])) == [5, -1], "rows_of an id that is not there")
    columns = frame.columns(["velocity", "cauchy_stress", "id"], material=1)
    same(columns["velocity_z"], frame["velocity"][material == 1, 2], "columns")
    same(columns["cauchy_stress_xy"], frame["cauchy_stress"][material == 1, 0, 1], "columns of a tensor")
    refuses(lambda: frame.select(material="creem"), "no material 'creem'", "cream")
    refuses(lambda: frame.select(body=7), "no body 7")


def check_values_and_maps(run):
    frame, checkpoint = run.frames[2], run.checkpoints[0]
    velocity, stress = frame["velocity"].astype(float), frame["cauchy_stress"].astype(float)
    same(bulkley.values_of(frame, "pressure"), frame["pressure"].astype(float), "a scalar")
    same(bulkley.values_of(frame, "velocity", "y"), velocity[:, 1], "a component")
    same(bulkley.values_of(frame, "cauchy_stress", "yz"), stress[:, 1, 2], "a component of a tensor")
    same(bulkley.values_of(frame, "cauchy_stress", 8), stress[:, 2, 2], "a component by number")
    speed = bulkley.values_of(frame, "velocity", "magnitude")
    near(speed, np.linalg.norm(velocity, axis=1), "a magnitude")
    strain = checkpoint["left_cauchy_green"]
    full = strain[:, [0, 3, 5, 3, 1, 4, 5, 4, 2]]
    near(bulkley.values_of(checkpoint, "left_cauchy_green", "magnitude"), np.linalg.norm(full, axis=1), "of six components")
    refuses(lambda: bulkley.values_of(frame, "velocity"), "velocity has 3 components", "magnitude")
    refuses(lambda: bulkley.values_of(frame, "density"), frame.path.name, "/particles/density", "output.fields")

    position, mass = frame.positions, frame["mass"].astype(float)
    cut = bulkley.slab(frame, "y", 0.1, 0.03)
    same(cut, [0.085 <= p < 0.115 for p in position[:, 1]], "slab")
    for weights in (None, "mass"):
        found = bulkley.binned(frame, "velocity", "xz", 0.02, component="magnitude", chosen=cut, weights=weights)
        for row in range(found.values.shape[0]):
            for column in range(found.values.shape[1]):
                inside = (cut & (position[:, 0] >= found.columns[column]) & (position[:, 0] < found.columns[column + 1])
                          & (position[:, 2] >= found.rows[row]) & (position[:, 2] < found.rows[row + 1]))
                expect(found.counts[row, column] == inside.sum(), "counts of a map")
                if inside.any():
                    mean = np.average(speed[inside], weights=mass[inside] if weights else None)
                    near(found.values[row, column], mean, "a map")
                else:
                    expect(np.isnan(found.values[row, column]), "an empty cell of a map")
        expect(found.counts.sum() == cut.sum() and found.label == "velocity, magnitude [m/s]", "a map leaves particles out")
    given = bulkley.binned(frame, "pressure", "yx", bounds=((0.0, 0.1), (0.05, 0.1)))
    expect(given.values.shape == (4, 8) and given.columns[-1] == 0.1, "a map in given bounds")

    start, end, radius = np.array([0.05, 0.1, 0.02]), np.array([0.2, 0.11, 0.06]), 0.02
    line = bulkley.profile(frame, "velocity", start, end, radius, n=6, component="z")
    length = np.linalg.norm(end - start)
    sums, counts = np.zeros(6), np.zeros(6, int)
    for place, value in zip(position, velocity[:, 2]):
        along = (place - start) @ (end - start) / length
        aside = np.linalg.norm(np.cross(place - start, end - start)) / length
        if aside < radius and 0 <= along < length:
            sums[int(along / length * 6)] += value
            counts[int(along / length * 6)] += 1
    same(line.counts, counts, "counts of a profile")
    expect(counts.min() > 0, "a part of the profile is empty")
    near(line.values, sums / counts, "a profile")
    near(line.distance, (np.arange(6) + 0.5) * length / 6, "distances of a profile")


def check_pictures(run, folder, work):
    import matplotlib
    matplotlib.use("Agg")
    from bulkley import plot
    frame = run.frames[-1]
    axes = plot.plot_slice(frame, "velocity", "y", component="magnitude", thickness=0.02)
    drawn = axes.collections[0]
    chosen = bulkley.slab(frame, "y", 0.5 * (frame.positions[:, 1].min() + frame.positions[:, 1].max()), 0.02)
    same(np.asarray(drawn.get_offsets()), frame.positions[chosen][:, [0, 2]], "the points of a slice")
    found = bulkley.binned(frame, "pressure", "xy")
    colours = plot.plot_map(found).collections[0].get_array().compressed()
    same(colours, found.values[found.counts > 0], "the colours of a map")
    line = plot.plot_history(run.history, "kinetic_energy").lines[0]
    same(line.get_ydata(), run.history["kinetic_energy"], "a curve of the history")
    along = bulkley.profile(frame, "pressure", (0.05, 0.1, 0.05), (0.12, 0.1, 0.05), 0.02, n=5)
    same(plot.plot_profile(along).lines[0].get_ydata(), along.values, "a profile's curve")

    picture = work / "example.png"
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE), "MPLBACKEND": "Agg"}
    subprocess.run([sys.executable, str(PACKAGE / "examples/look_at_a_run.py"), str(folder), str(picture)], check=True,
                   timeout=100, env=environment)
    from matplotlib.image import imread
    pixels = imread(picture)[:, :, :3]
    expect(pixels.shape[0] > 400 and 0.02 < np.mean(pixels.min(axis=2) < 0.9) < 0.6, "the example's picture is empty or dark")


def check_faults(folder, work):
    refuses(lambda: bulkley.open_run(work), "not the folder of a run", "scene.toml")
    refuses(lambda: bulkley.open_file(folder / "frame_000099.h5"), "frame_000099.h5")
    (work / "text.h5").write_text("no HDF5")
    refuses(lambda: bulkley.open_file(work / "text.h5"), "cannot read", "text.h5")
    with h5py.File(work / "foreign.h5", "w") as file:
        file["x"] = 1
    refuses(lambda: bulkley.open_file(work / "foreign.h5"), "neither a frame nor a checkpoint")
    shutil.copy(folder / "frame_000000.h5", work / "alone.h5")
    with h5py.File(work / "alone.h5", "r+") as file:
        del file["particles/id"], file["grid"]
    alone = bulkley.open_file(work / "alone.h5")
    refuses(lambda: alone.ids, "alone.h5", "/particles/id", "output.fields")
    refuses(alone.grid, "alone.h5", "output.grid")
    refuses(lambda: alone.scene, "scene.toml")


# --- the tools ------------------------------------------------------------------------------------------------------

def check_ended_run(run):
    ended = EndedRun(run.folder)
    expect(ended.history is ended.history and run.history is not run.history, "the history of a run that has ended")
    domain = run.scene["domain"]
    expect((run.cell_size, run.floor, run.gravity) == (domain["cell_size"], domain["lower"][2], -run.scene["gravity"][2]),
           "cell size, floor and gravity")
    expect(len(ended.frames) == N_FRAMES, "the frames of a run that has ended")


def check_thinning():
    """A short curve is kept; of a long one, added in parts, the extremes of each of 500 parts are."""
    rng = np.random.default_rng(3)
    x, y = np.arange(70000) * 1e-5, rng.standard_normal(70000)
    y[::777] = np.nan
    short = ThinnedCurve(0.7)
    short.add(x[:1000], y[:1000])
    same(short.y, y[:1000][np.isfinite(y[:1000])], "a short curve")
    curve = ThinnedCurve(0.7)
    for part in np.array_split(np.arange(70000), 7):
        curve.add(x[part], y[part])
    wanted = [k for part in np.array_split(np.arange(70000), 500) for k in sorted((part[np.nanargmin(y[part])],
                                                                                   part[np.nanargmax(y[part])]))]
    found = {(a, b) for a, b in zip(curve.x, curve.y)}
    missing = [k for k in wanted if (x[k], y[k]) not in found]
    expect(len(curve.x) <= 1000 and np.all(np.diff(curve.x) >= 0.0), "a thinned curve")
    expect(len(missing) <= 4, f"extremes are lost: {missing}")  # parts of the time and of the rows differ by rounding


def check_tools(work):
    """Without installing; and without h5py, which reports and histories do not need."""
    def tool(*arguments, python=()):
        return subprocess.run([sys.executable, *python, *map(str, arguments)], capture_output=True, text=True, check=False,
                              timeout=60, cwd=work)
    said = tool(PACKAGE / "bulkley", "--help")
    expect(said.returncode == 0 and "scaling-model" in said.stdout, "--help of the tools")
    said = tool(PACKAGE / "bulkley", "mesure")
    expect(said.returncode == 1 and "there is no tool 'mesure'" in said.stderr and "measure" in said.stderr, "a tool's name")
    old = f"import runpy, sys; sys.version_info = (3, 9); sys.argv = ['x', %r]; runpy.run_path('{PACKAGE / 'bulkley'}', " \
        "run_name='__main__')"
    for name, words in (("measure", "measure: this needs Python 3.11 or newer\n"), ("report", "")):
        said = tool("-c", old % name)
        expect(said.returncode == 4 and said.stderr == words, f"{name} with an old Python: {said}")
    (work / "h5py.py").write_text("raise ImportError('none here')\n")
    question = f"import sys; sys.path[:0] = ['.', '{PACKAGE}']; import bulkley; print(bulkley.open_file('run/frame_000000.h5'))"
    said = tool("-c", question)
    expect(said.returncode == 1 and "frames and checkpoints need h5py" in said.stderr, "what is said without h5py")
    (work / "numpy.py").write_text("raise ImportError('no numpy here')\n")
    for name, words in (("measure", "measure: no numpy here\n"), ("report", "")):
        # In the working folder there is another numpy: only a tool that is told to looks there.
        expect(tool(PACKAGE / "bulkley", name, "--help").returncode == 0, f"{name} takes modules of the working folder")
        environment = {**os.environ, "PYTHONPATH": str(work)}
        said = subprocess.run([sys.executable, str(PACKAGE / "bulkley"), name, "--help"], capture_output=True, text=True,
                              check=False, timeout=60, env=environment)
        expect(said.returncode == 4 and said.stderr == words, f"{name} without numpy: {said}")


def check_version(program):
    said = subprocess.run([program.path, "--version"], capture_output=True, text=True, check=True).stdout
    declared = re.search(r"project\(bulkley VERSION (\S+)", (ROOT / "CMakeLists.txt").read_text()).group(1)
    if bulkley.__version__ != declared or declared not in said:
        fail(f"the package is of version {bulkley.__version__}, CMakeLists.txt of {declared}, the program says {said}")


def main():
    program, work = start(parse_arguments(__doc__))
    folder = make_run(program, work)
    run = bulkley.open_run(folder)
    check_version(program)
    check_history(folder, run)
    check_files(folder, run)
    check_selections(run)
    check_values_and_maps(run)
    check_faults(folder, work)
    check_run_that_goes_on(folder, work)
    check_pictures(run, folder, work)
    check_ended_run(run)
    check_thinning()
    check_tools(work)


if __name__ == "__main__":
    main()
