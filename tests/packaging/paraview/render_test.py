"""Output of render.py and open_run.py for a sample run, checked by pixels. Usage: render_test.py PVPYTHON SCRIPTS RUN FOLDER

The sample: a ball that falls, colliders "stone" (rests) and "paddle" (turns as it rises), three frames with particles.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import unittest

import numpy
from PIL import Image

PVPYTHON, SCRIPTS, RUN, FOLDER = sys.argv[1], *map(pathlib.Path, sys.argv[2:5])
SMALL = ["--size", "320x240", "--set", "light.samples=6"]
# Plain colours: no light, no shade, no words, so that pixels can be counted.
PLAIN = [f"--set={key}" for key in ("light.ambient=1.0", "light.occlusion=false", "picture.title=false", "picture.time=false",
                                    "picture.legend=false", "floor.show=false", "particles.field=material",
                                    'materials.colors={cream="#00ff00",pie="#00ff00"}', 'colliders.color="#ff0000"')]


def render(*arguments, interpreter=PVPYTHON):
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    return subprocess.run([interpreter, str(SCRIPTS / "render.py"), "--run", str(RUN), *map(str, arguments)],
                          capture_output=True, text=True, timeout=200, env=environment)


def drawn(name, *arguments):
    """The picture as numbers; a list of them if `name` is a folder's."""
    path = FOLDER / name
    result = render("--output", path, *SMALL, *arguments, interpreter=sys.executable)  # which starts pvpython once, not twice
    if result.returncode != 0:
        raise AssertionError(result.stdout + result.stderr)
    pictures = [numpy.asarray(Image.open(line).convert("RGB")).astype(int) for line in result.stdout.split()]
    return pictures[0] if path.suffix else pictures


def share(picture, channel):
    """Part of the pixels in which one channel outdoes both others clearly."""
    others = [c for c in range(3) if c != channel]
    return float(numpy.mean(picture[:, :, channel] - picture[:, :, others].max(axis=2) > 60))


def middle(picture, channel):
    """Mean row and column of those pixels, as parts of the picture."""
    others = [c for c in range(3) if c != channel]
    rows, columns = numpy.nonzero(picture[:, :, channel] - picture[:, :, others].max(axis=2) > 60)
    return rows.mean() / picture.shape[0], columns.mean() / picture.shape[1]


class Faults(unittest.TestCase):
    """Each is one sentence and exit code 2, before ParaView is even looked for."""

    def expect(self, sentence, *arguments):
        result = render(*arguments, interpreter=sys.executable)
        self.assertEqual(result.returncode, 2, result.stderr)
        self.assertIn(sentence, result.stderr)
        self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)

    def look(self, text):
        path = FOLDER / "faulty.toml"
        path.write_text(text)
        return ["--output", FOLDER / "faulty.png", "--look", path]

    def test_look_files(self):
        self.expect("there is no key 'camera.zom'; did you mean 'camera.zoom'?", *self.look("[camera]\nzom = 2\n"))
        self.expect("there is no table 'kamera'; did you mean 'camera'?", *self.look("[kamera]\nzoom = 2\n"))
        self.expect("camera.zoom is -1 and must be a number above 0", *self.look("[camera]\nzoom = -1\n"))
        self.expect("materials.colors is {'cream': 'red'}", *self.look('[materials]\ncolors = { cream = "red" }\n'))
        self.expect("is not TOML", *self.look("[camera\n"))
        self.expect("go together", *self.look("[crop]\nlower = [0, 0, 0]\n"))
        self.expect("cannot be read", "--output", FOLDER / "x.png", "--look", FOLDER / "none.toml")

    def test_command_line(self):
        png = ["--output", FOLDER / "faulty.png"]
        self.expect("one of --output, --strip and --animation")
        self.expect("is not KEY=VALUE", *png, "--set", "camera.zoom")
        self.expect("--frame is '0,9' and must be", *png, "--frame", "0,9")
        self.expect("--field is 'speed'", *png, "--field", "speed")
        self.expect("must end in .mp4, .gif or .webp", "--animation", FOLDER / "film.avi")
        self.expect("--largest is 0.5 and must be at least 1", "--animation", FOLDER / "film.gif", "--largest", "0.5")
        self.expect("particles.colormap is ['#00ff00'] and must be", *png, "--set", 'particles.colormap=["#00ff00"]')
        self.expect("must end in .png", "--strip", FOLDER / "strip.jpg")
        if not shutil.which("ffmpeg"):
            self.expect("an MP4 needs ffmpeg (Debian: apt-get install ffmpeg)", "--animation", FOLDER / "film.mp4")


class Pictures(unittest.TestCase):
    def test_material_and_colliders_have_their_colours(self):
        spheres = drawn("spheres.png", "--frame", "0", *PLAIN)
        surface = drawn("surface.png", "--frame", "0", "--surface", "--set", "surface.gloss=0", *PLAIN)
        hidden = drawn("hidden.png", "--frame", "0", *PLAIN, "--set", "colliders.show=false")
        self.assertGreater(share(spheres, 1), 0.01)
        # The same ball, to within the rim of its spheres.
        self.assertAlmostEqual(share(surface, 1) / share(spheres, 1), 1.0, delta=0.15)
        self.assertGreater(share(spheres, 0), 0.01)
        self.assertEqual(share(hidden, 0), 0.0)
        self.assertGreater(share(hidden, 1), 0.01)

    def test_colliders_move_with_time(self):
        only = ["--set", 'colliders.hidden=["stone"]', *PLAIN]
        before, after = (middle(picture, 0) for picture in drawn("moving", "--frame", "0,2", *only))
        self.assertLess(after[0], before[0] - 0.03, "the paddle rises")
        self.assertAlmostEqual(after[1], before[1], delta=0.03)

    def test_shadows_darken_the_floor(self):
        plain = ["--frame", "0", "--set", "floor.grid=false", "--set", "light.occlusion=false"]
        with_shadow, without = drawn("shadow.png", *plain), drawn("no_shadow.png", *plain, "--set", "light.shadows=false")
        darker = without.sum(axis=2) - with_shadow.sum(axis=2) > 40
        self.assertGreater(darker.mean(), 0.01)
        self.assertLess(darker.mean(), 0.3)

    def test_colormap_is_a_list_of_colours_or_a_preset_that_is_known(self):
        shades = ["--frame", "0", *(words for words in PLAIN if "particles.field" not in words), "--field", "volume_ratio"]
        low, high = 'particles.colormap=["#00ff00", "#0000ff"]', "particles.range=[{}]"
        self.assertGreater(share(drawn("low.png", *shades, "--set", low, "--set", high.format("5.0, 6.0")), 1), 0.01)
        self.assertGreater(share(drawn("high.png", *shades, "--set", low, "--set", high.format("-6.0, -5.0")), 2), 0.01)
        result = render("--output", FOLDER / "unknown.png", "--field", "volume_ratio", "--colormap", "Lajolla")
        self.assertEqual(result.returncode, 2)
        self.assertIn("particles.colormap is 'Lajolla', which ParaView does not know", result.stderr)

    def test_crop_leaves_material_out(self):
        look = FOLDER / "crop.toml"
        look.write_text("[crop]\nlower = [0.0, 0.0, 0.0]\nupper = [0.5, 0.8, 0.6]\n[camera]\ndirection = [0, -1, 0]\n")
        half = drawn("crop.png", "--frame", "0", *PLAIN, "--look", look)
        columns = numpy.nonzero((half[:, :, 1] - half[:, :, 0] > 60).any(axis=0))[0]
        rows = numpy.nonzero((half[:, :, 1] - half[:, :, 0] > 60).any(axis=1))[0]
        self.assertAlmostEqual(numpy.ptp(columns) / numpy.ptp(rows), 0.5, delta=0.1)  # half a ball, seen from the front


class Sequences(unittest.TestCase):
    def test_strip_is_small(self):
        path = FOLDER / "strip.png"
        result = render("--strip", path, "--frame", "0,1,2,0", "--set", "light.samples=6")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertLess(path.stat().st_size, 300_000)
        strip = numpy.asarray(Image.open(path).convert("RGB")).astype(int)
        tiles = [half for row in numpy.array_split(strip, 2) for half in numpy.array_split(row, 2, axis=1)]
        self.assertLess(numpy.abs(tiles[0] - tiles[3]).mean(), 1.0, "the same frame")
        for tile in tiles:
            self.assertGreater(numpy.mean(numpy.abs(tile - tile[-1, 0]).sum(axis=2) > 90), 0.02)
        self.assertGreater(numpy.mean(numpy.abs(tiles[0] - tiles[2]).sum(axis=2) > 90), 0.02, "another one")

    def test_strip_has_its_legend_once(self):
        path = FOLDER / "legend.png"
        result = render("--strip", path, "--frame", "0,0", "--field", "volume_ratio", "--size", "320x240", "--no-floor",
                        *[f"--set={key}" for key in ("picture.legend=true", "colliders.show=false", "light.samples=6")])
        self.assertEqual(result.returncode, 0, result.stderr)
        first, second = numpy.array_split(numpy.asarray(Image.open(path).convert("RGB")).astype(int), 2, axis=1)
        dark = [numpy.mean(part[:, int(0.86 * part.shape[1]):].sum(axis=2) < 500) for part in (first, second)]
        self.assertGreater(dark[0], 0.005)
        self.assertLess(dark[1], 0.2 * dark[0])

    def test_animation(self):
        path = FOLDER / "film.gif"
        result = render("--animation", path, *SMALL)
        self.assertEqual(result.returncode, 0, result.stderr)
        with Image.open(path) as film:
            self.assertEqual(film.n_frames, 3)
        with Image.open(path) as film:
            width, most = film.width, path.stat().st_size / 2000
        for name in ("small.gif", "small.webp"):
            result = render("--animation", FOLDER / name, *SMALL, "--largest", f"{most:.3f}")
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertLessEqual((FOLDER / name).stat().st_size, 1000 * most)
            with Image.open(FOLDER / name) as film:
                self.assertEqual(film.n_frames, 3)
                self.assertTrue(film.width < width or name.endswith(".webp"), film.width)
        if shutil.which("ffmpeg"):
            path = FOLDER / "film.mp4"
            self.assertEqual(render("--animation", path, *SMALL).returncode, 0)
            self.assertGreater(path.stat().st_size, 1000)


class Window(unittest.TestCase):
    def test_state_opens_with_both_series(self):
        state, picture = FOLDER / "run.pvsm", FOLDER / "state.png"
        subprocess.run([PVPYTHON, str(SCRIPTS / "open_run.py"), "--run", str(RUN), "--state", str(state)], check=True, timeout=200)
        load = FOLDER / "load_state.py"
        load.write_text(f"""import sys
sys.path.insert(0, {str(SCRIPTS)!r})
from rendering.display import leave, restart_under_xvfb
restart_under_xvfb((320, 240))
from paraview import simple
simple.LoadState({str(state)!r})
print(sorted(name for name, _ in simple.GetSources()), len(simple.GetAnimationScene().TimeKeeper.TimestepValues))
simple.SaveScreenshot({str(picture)!r}, simple.GetActiveView(), ImageResolution=[320, 240])
leave(0)
""")
        result = subprocess.run([PVPYTHON, str(load)], capture_output=True, text=True, timeout=200)
        self.assertIn("['colliders.xdmf', 'frames.xdmf']", result.stdout, result.stderr)
        pixels = numpy.asarray(Image.open(picture).convert("RGB")).astype(int)
        self.assertGreater(numpy.mean(pixels.min(axis=2) < 200), 0.02)


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    unittest.main(argv=sys.argv[:1])
