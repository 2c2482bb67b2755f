#!/usr/bin/env python3
"""Pictures of a run from Python: plot, movie and view draw what the files hold; who draws where ParaView, k3d or matplotlib
are missing, and the sentences where nobody can."""

import os
import pathlib
import sys
import types

import numpy as np

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "tests/support"), str(ROOT / "drivers/python")]
import matplotlib  # noqa: E402

matplotlib.use("Agg")
import bulkley  # noqa: E402
from bulkley import plot  # noqa: E402
from bulkley.places import find_shared  # noqa: E402
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from small_scene import small_scene  # noqa: E402


def expect(condition, sentence):
    if not condition:
        fail(sentence)


def refuses(work, *words):
    try:
        work()
    except bulkley.DataError as error:
        if "\n" in str(error) or not all(word in str(error) for word in words):
            fail(f"the sentence must hold {words}: {error}")
    else:
        fail(f"nothing is said about {words}")


class Without:
    """Modules that cannot be imported, and an empty PATH."""

    def __init__(self, *modules, path=None):
        self.modules, self.path = modules, path

    def __enter__(self):
        self.kept = {name: sys.modules.get(name) for name in self.modules}
        sys.modules.update(dict.fromkeys(self.modules))
        self.kept_path = os.environ["PATH"]
        os.environ["PATH"] = self.path if self.path is not None else self.kept_path

    def __exit__(self, *_):
        for name, module in self.kept.items():
            if module is None:
                del sys.modules[name]
            else:
                sys.modules[name] = module
        os.environ["PATH"] = self.kept_path


def check_plot(run):
    figure = run.plot()
    axes = {place.get_title().split(" [")[0]: place for place in figure.axes if place.axison}
    for name, column in (("Largest speed", "max_speed"), ("Reach: reach", "reach.reach")):
        same = [np.array_equal(line.get_ydata(), run.history[column]) for line in axes[name].lines]
        expect(same == [True], f"the curve of {name}")
    expect(len(axes["Force on sensor"].lines) == 3 and len(axes["Energies"].get_legend().get_texts()) == 4, "several curves")
    line = run.plot("kinetic_energy").lines[0]
    expect(np.array_equal(line.get_ydata(), run.history["kinetic_energy"]), "one column")
    refuses(lambda: run.plot("kinetic"), "no column 'kinetic'")
    refuses(lambda: plot.plot_sheets("."), "'.'", "history.csv")
    with Without("matplotlib"):
        refuses(run.plot, "matplotlib", "not installed")


def check_tables(run):
    """numpy arrays as data frames, and the sentence where there is no pandas."""
    checkpoint = run.checkpoints[-1]
    try:
        import pandas  # noqa: F401
        expect(np.array_equal(checkpoint.to_pandas(["velocity"])[
               "velocity_z"], checkpoint["velocity"][:, 2]), "a checkpoint")
    except ImportError:
        pass
    with Without("pandas"):
        for has_table in (run.history, run.frames[0], checkpoint):
            refuses(has_table.to_pandas, "pandas, which is not installed")


def check_particles(run):
    frame = run.frames[1]
    axes = plot.plot_particles(frame, component="z")
    x, y, z = axes.collections[0]._offsets3d
    order = np.argsort(frame.ids)
    drawn = np.stack([x, y, z], axis=1)
    expect(np.array_equal(np.sort(drawn, axis=0), np.sort(frame.positions[order], axis=0)), "the dots")
    expect(sorted(axes.collections[0].get_array()) == sorted(frame["velocity"][:, 2].astype(float)), "the colours")
    expect(axes.get_xlim() == (0.0, 0.2) and axes.get_zlim() == (0.0, 0.15), "the domain")
    kept = plot.thinned(frame, 100)
    expect(50 < kept.sum() < 200 and plot.thinned(frame, frame.n_particles).all(), "thinned")
    refuses(lambda: plot.plot_particles(frame, "pressure"), "/particles/pressure")


def frames_of(path):
    from PIL import Image
    with Image.open(path) as film:
        return film.n_frames, film.info.get("duration")


def check_movie(run, work):
    empty = str(work)
    with Without(path=empty):
        film = run.movie(rate=10, field="velocity", component="z")
        expect(film == run.folder / "movie.gif" and frames_of(film) == (5, 100), f"a film by matplotlib: {frames_of(film)}")
        refuses(lambda: run.movie(by="paraview"), "pvpython")
        refuses(lambda: run.movie("film.mp4"), "'film.mp4' needs ffmpeg")
        refuses(lambda: run.movie(look="a.toml"), "'look'", "ParaView")
        with Without("matplotlib"):
            refuses(run.movie, "ParaView", "matplotlib", "neither is installed")
    refuses(lambda: run.movie("film.avi"), "film.avi", ".gif, .mp4 or .webp")
    for rate in (0.0, 51.0):
        refuses(lambda: run.movie(rate=rate), "'rate' is", "50")
    refuses(lambda: run.movie(by="blender"), "'blender'", "'paraview' or 'matplotlib'")
    bare = bulkley.run(small_scene(), out="bare", sets={"output.frame_interval": 0}, max_steps=2)
    refuses(bare.movie, "no frames", "output.frame_interval")
    refuses(bare.view, "no frames", "output.frame_interval")
    pvpython = work / "tools/pvpython"
    pvpython.parent.mkdir()
    pvpython.write_text('#!/bin/sh\necho "$@" >words\n[ "$7" != nope ] || { echo "render.py: no field nope" >&2; exit 2; }\n'
                        'touch "$5"\n', encoding="utf-8")
    pvpython.chmod(0o755)
    with Without(path=f"{pvpython.parent}:/bin:/usr/bin"):
        expect(run.movie("by.gif", field="velocity", rate=5) == pathlib.Path("by.gif"), "a film by ParaView")
        words = pathlib.Path("words").read_text(encoding="utf-8").split()
        expect(words == [str(find_shared("paraview", "render.py")), "--run", "run", "--animation", "by.gif", "--field", "velocity",
                         "--rate", "5", "--largest", "2000"], f"the command of ParaView: {words}")
        refuses(lambda: run.movie("no.gif", field="nope"), "ParaView did not draw 'no.gif': no field nope")


def stand_in():
    """A module in place of k3d that records what it is given."""
    k3d = types.ModuleType("k3d")
    k3d.matplotlib_color_maps = types.SimpleNamespace(Viridis=[0.0])
    k3d.points = lambda positions, **settings: types.SimpleNamespace(positions=positions, **settings)

    class Plot(list):
        def __iadd__(self, other):
            self.append(other)
            return self
    k3d.plot = lambda **settings: Plot()
    return k3d


def check_view(run):
    frame = run.frames[-1]
    speed = bulkley.values_of(frame, "velocity", "magnitude")
    with Without("k3d"):
        figure = run.view()
        expect(len([place for place in figure.axes if place.name == "3d"]) == 4, "four pictures of five frames")
        expect(len(bulkley.view(frame).axes) == 2, "one picture and its scale")
        refuses(lambda: run.view(by="k3d"), "k3d, which is not installed", "by='matplotlib'")
        refuses(lambda: run.view(by="x"), "'by' is 'x'")
    kept = sys.modules.get("k3d")
    sys.modules["k3d"] = stand_in()
    one, = bulkley.view(frame)
    expect(np.array_equal(one.positions, frame.positions.astype(np.float32))
           and np.allclose(one.attribute, speed), "one frame")
    expect(np.allclose(one.color_range, np.percentile(speed, (1, 99))), "the range of the colours")
    several, = run.view()
    expect(list(several.positions) == ["0", "0.005", "0.01", "0.015", "0.02"] and np.allclose(several.attribute["0.02"], speed),
           f"all frames: {list(several.positions)}")
    expect(bulkley.view(frame, by="matplotlib").axes, "pictures although k3d is there")
    del sys.modules["k3d"]
    if kept is not None:
        sys.modules["k3d"] = kept
    try:
        import k3d
        expect(isinstance(run.view(), k3d.Plot), "a view of the real k3d")
    except ImportError:
        print("k3d is not installed: what it is given was checked, not what it draws")


def main():
    arguments = parse_arguments(__doc__, lambda parser: parser.add_argument(
        "--pvpython", help="draw a film with it, and nothing else"))
    program, work = start(arguments)
    work = work.resolve()
    os.environ["BULKLEY"] = str(pathlib.Path(program.path).resolve())
    os.chdir(work)
    run = bulkley.run(small_scene(), out="run")
    if arguments.pvpython:
        os.environ["PATH"] = f"{pathlib.Path(arguments.pvpython).parent}:{os.environ['PATH']}"
        expect(frames_of(run.movie("real.gif", rate=10, by="paraview"))[0] == 5, "a film by ParaView")
        return
    check_plot(run)
    check_tables(run)
    check_particles(run)
    check_movie(run, work)
    check_view(run)
    print("pictures from Python: plot, movie, view")


if __name__ == "__main__":
    main()
