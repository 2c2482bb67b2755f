#!/usr/bin/env python3
"""docs/gallery/films.py, as a draft: a film of a run with its page; a run that has ended is not repeated; names that do not exist."""

import os
import pathlib
import subprocess
import sys

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

NAME = "first_splash"


def films(program, work, *words):
    """Exit code and what is printed."""
    command = [sys.executable, str(ROOT / "docs/gallery/films.py"), "--draft", "--out", str(work / "films"), *words]
    done = subprocess.run(command, env={**os.environ, "BULKLEY": program.path}, stdin=subprocess.DEVNULL, capture_output=True, text=True,
                          timeout=300)
    return done.returncode, done.stdout + done.stderr


def main():
    program, work = start(parse_arguments(__doc__))
    code, text = films(program, work, "no_such_film")
    if code != 2 or "there is no film 'no_such_film'; there are first_splash," not in text:
        fail(f"an unknown film: exit code {code}\n{text}")
    code, text = films(program, work, NAME)
    film = work / "films" / f"{NAME}.gif"
    if code != 0 or not film.is_file():
        fail(f"the film: exit code {code}\n{text}")
    with Image.open(film) as picture:
        if picture.n_frames != 6 or film.stat().st_size > 2e6:
            fail(f"the film has {picture.n_frames} pictures and {film.stat().st_size} bytes")
        first = list(picture.convert("RGB").getdata())
        picture.seek(5)
        if first == list(picture.convert("RGB").getdata()):
            fail("nothing moves in the film")
    page = (work / "films/index.html").read_text(encoding="utf-8")
    if page.count("<figure>") != 1 or f'src="{NAME}.gif"' not in page or "bulkley run drivers/scenes/first_splash.toml" not in page:
        fail(f"the page is\n{page}")
    status = work / "films/runs" / NAME / "status.json"
    before = status.stat().st_mtime_ns
    code, text = films(program, work, NAME)
    if code != 0 or status.stat().st_mtime_ns != before:
        fail(f"the run was repeated, or exit code {code}\n{text}")
    print(f"six pictures, {film.stat().st_size} bytes, and their page")


if __name__ == "__main__":
    main()
