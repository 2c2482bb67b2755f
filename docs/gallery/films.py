#!/usr/bin/env python3
"""Films of small scenes, and a page of them: runs each scene unless it has been run, and draws it with ParaView.

    docs/gallery/films.py [--ranks N] [--docs] [--draft] [--out FOLDER] [NAME]...

Films (GIF, below 2 MB each) and the page are NAME.gif and index.html in the folder, out/films of the repository by default. With --docs the
films of docs/gallery/films.md are drawn as well: WebP below 300 kB in docs/gallery/films. --draft: six pictures of the first tenth. A run
that has ended is not repeated: remove runs/NAME in the folder to have it again. Run from anywhere, after a build (cluster/quickstart.sh).
"""

import argparse
import html
import pathlib
import sys
import tomllib
from dataclasses import dataclass, field, replace

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "drivers/python"))
import bulkley  # noqa: E402

RATE = 15  # pictures a second
DOCS_KILOBYTES = 290
PAGE = """<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width"><title>Bulkley: films</title>
<style>
body {{ font: 16px/1.45 sans-serif; margin: 2rem auto; max-width: 1100px; padding: 0 1rem; color: #26262e; }}
main {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(420px, 1fr)); gap: 2rem; }}
figure {{ margin: 0; }} img {{ width: 100%; }} code {{ font-size: 13px; overflow-wrap: anywhere; color: #5a5f6b; }}
</style></head><body>
<h1>Bulkley: films</h1>
<p>Yield-stress fluids by the Material Point Method, each film from one command on two cores. Made by docs/gallery/films.py.</p>
<main>
{figures}</main></body></html>
"""


@dataclass(frozen=True)
class Film:
    name: str
    words: str
    scene: str  # in drivers/scenes
    look: str  # in drivers/paraview/looks
    sets: dict = field(default_factory=dict)

    def command(self):
        keys = "".join(f" --set {key}={value}" for key, value in self.sets.items())
        return f"mpirun -n 2 build/bulkley run {self.path().relative_to(ROOT)}{keys}"

    def path(self):
        return ROOT / f"drivers/scenes/{self.scene}.toml"

    def draft(self):
        scene = tomllib.loads(self.path().read_text(encoding="utf-8"))
        end = self.sets.get("time.end", scene["time"]["end"]) / 10.0
        return replace(self, sets={**self.sets, "time.end": end, "output.frame_interval": end / 5.0})


SMALL = {"domain.cell_size": 0.0125}
FILMS = [
    Film("first_splash", "A ball of cream throws up a crown, which its yield stress holds.", "first_splash", "first_splash"),
    Film("bouncing_hare", "A hare of a fluid that is elastic for as long as the floor touches it: it jumps, and lands on its ears.",
         "figure_1_oobleck_bunny", "figure_1",
         {**SMALL, "materials.fluid.preset": "bouncing_oobleck", "time.end": 0.8, "output.frame_interval": 0.02}),
    Film("colliding_balls", "Two balls of oobleck meet at 8 m/s and bounce apart.", "figure_8_colliding_balls", "figure_8",
         {**SMALL, "time.end": 0.3}),
    Film("colliding_pies", "Two balls of pie do the same, and become one sheet.", "figure_8_colliding_balls", "figure_8_pie",
         {**SMALL, "materials.fluid.preset": "pie", "time.end": 0.3}),
    Film("cut_ball", "A rod cuts a ball of oobleck, which has a bulk modulus of 2e9 Pa.", "figure_9_rod", "figure_9",
         {**SMALL, "time.integrator": "imex", "materials.fluid.bulk_modulus": 2e9, "time.end": 0.2}),
    Film("stirred_bowl", "A paddle stirs cream and jam.", "stirred_bowl", "stirred_bowl", {"output.frame_interval": 0.0125}),
    Film("magnet", "A magnet lifts a puddle of ferro-oobleck.", "magnet_lifts_puddle", "magnet_lifts_puddle",
         {"domain.cell_size": 0.004, "output.frame_interval": 0.04}),
]
IN_DOCS = ("first_splash", "bouncing_hare", "magnet")


def finished_run(film, ranks, out):
    folder = out / "runs" / film.name
    if folder.is_dir():
        run = bulkley.open_run(folder)
        if run.status["state"] == "finished":
            return run
    return bulkley.run(film.path(), ranks=ranks, out=folder, sets=film.sets, overwrite=True)


def page(films, out):
    figures = [f'<figure><img src="{film.name}.gif" alt="{html.escape(film.words)}"><figcaption>{html.escape(film.words)}<br>'
               f"<code>{html.escape(film.command())}</code></figcaption></figure>\n"
               for film in films if (out / f"{film.name}.gif").is_file()]
    return PAGE.format(figures="".join(figures))


def main():
    parser = argparse.ArgumentParser(description="Films of small scenes, and a page of them.")
    parser.add_argument("--ranks", type=int, default=2)
    parser.add_argument("--docs", action="store_true", help="draw those of docs/gallery/films.md as well")
    parser.add_argument("--draft", action="store_true", help="six pictures of the first tenth")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out/films", metavar="FOLDER")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"by default all: {', '.join(film.name for film in FILMS)}")
    options = parser.parse_args()
    unknown = set(options.names) - {film.name for film in FILMS}
    if unknown:
        parser.error(f"there is no film '{min(unknown)}'; there are {', '.join(film.name for film in FILMS)}")
    if options.draft and options.docs:
        parser.error("drafts are not for the docs: --draft or --docs")
    films = [film.draft() if options.draft else film for film in FILMS]
    options.out.mkdir(parents=True, exist_ok=True)
    for film in films:
        if options.names and film.name not in options.names:
            continue
        print(f"== {film.name}", flush=True)
        run = finished_run(film, options.ranks, options.out)
        look = ROOT / f"drivers/paraview/looks/{film.look}.toml"
        print(run.movie(options.out / f"{film.name}.gif", rate=RATE, look=look), flush=True)
        if options.docs and film.name in IN_DOCS:
            path = ROOT / f"docs/gallery/films/{film.name}.webp"
            print(run.movie(path, rate=RATE, look=look, largest=DOCS_KILOBYTES), flush=True)
    (options.out / "index.html").write_text(page(films, options.out), encoding="utf-8")
    print(options.out / "index.html")


if __name__ == "__main__":
    try:
        main()
    except (bulkley.DataError, bulkley.RunError) as fault:
        sys.exit(f"films.py: {fault}")
