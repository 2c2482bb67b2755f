"""The page of `bulkley report`: one HTML file that needs nothing from outside.

    python3 -m bulkley report FOLDER <facts.json >page.html

The facts on standard input are what the program says of the run in words (drivers/program/report.cpp); history, pictures and
scene come from the folder. The page goes to standard output.
"""

import argparse
import base64
import datetime
import json
import math
import os
import pathlib
import string
import sys

from bulkley.report_curves import history_plots
from bulkley.report_drawing import N_COLORS, bars_svg, markup, plot_svg

MOST_SCENE_BYTES = 1_000_000
MOST_PICTURES, MOST_BYTES_EACH, MOST_BYTES = 12, 3_000_000, 12_000_000
PNG = b"\x89PNG\r\n\x1a\n"
LIMITERS_BEHIND = 2  # number of the plot that the shares of the limiters follow


def report_page(folder: str | os.PathLike, facts: dict) -> str:
    """The page about the run in `folder`."""
    folder = pathlib.Path(folder)
    end = facts["last_row_time"]
    history = history_plots(folder, math.nan if end is None else end, facts["limiters"])
    template = string.Template(pathlib.Path(__file__).with_name("report_template.html").read_text(encoding="utf-8"))
    return template.substitute(
        title=markup(facts["title"] or facts["path"]), heading=markup(facts["title"] or "A run without a title"),
        state=markup(facts["state"]), path=markup(facts["path"]), messages=progress_bar(facts["done"]) + messages(facts),
        summary="".join(f"<dt>{markup(name)}</dt><dd>{markup(text)}</dd>\n" for name, text in facts["summary"]),
        pictures=pictures(folder), rows=f"{history.n_rows:,} row".replace(",", " ") + ("" if history.n_rows == 1 else "s"),
        plots=plots(history) + costs(facts["phases"]), checkpoints=checkpoints(facts["checkpoints"]),
        frames=markup(facts["frames"]), versions=versions(facts), scene=scene(folder),
        written=datetime.datetime.now(datetime.timezone.utc).strftime("%Y-%m-%d %H:%M"), version=markup(facts["version"]))


def progress_bar(done: float | None) -> str:
    if done is None:
        return ""
    percent = f"{100.0 * done:.1f}"
    return f'<div class="done" title="{percent} % of the end time"><div style="width:{percent}%"></div></div>\n'


def messages(facts: dict) -> str:
    return "".join(f'<p class="message {markup(kind)}">{markup(text)}</p>\n' for kind, text in facts["messages"])


# --- plots ----------------------------------------------------------------------------------------------------------------

def plots(history) -> str:
    figures = []
    for number, plot in enumerate(history.plots):
        keys = "".join(f'<span class="key s{curve.color % N_COLORS}">{markup(curve.name)}</span> ' for curve in plot.curves)
        legend = f'<p class="legend">{keys}</p>\n' if len(plot.curves) > 1 or plot.dots and plot.curves else ""
        svg = plot_svg(plot)
        figures.append(figure(plot.title, plot.unit, legend + svg if svg else '<p class="none">no values yet</p>'))
        if number == LIMITERS_BEHIND and history.limiters:
            bars = [(name, share, 0.0) for name, share in history.limiters]
            title = "What limits the time step"
            figures.append(figure(title, "", bars_svg(title, bars, "%"), "Of the rows of history.csv."))
    return "".join(figures)


def costs(phases: list[dict]) -> str:
    if not phases:
        return ""
    title = "Time by phase of the step"
    bars = [(phase["name"], phase["mean"], phase["largest"]) for phase in phases]
    return figure(title, "", bars_svg(title, bars, "s"),
                  "Mean over the ranks, and the thin line to the slowest rank; of this part of the run.")


def figure(title: str, unit: str, content: str, note: str = "") -> str:
    behind = f' <span class="unit">{markup(unit)}</span>' if unit else ""
    below = f'<p class="note">{markup(note)}</p>\n' if note else ""
    return f"<figure>\n<figcaption>{markup(title)}{behind}</figcaption>\n{content}\n{below}</figure>\n"


# --- pictures -------------------------------------------------------------------------------------------------------------

def pictures(folder: pathlib.Path) -> str:
    found = pictures_in(folder)
    shown = embedded(folder, found)
    if not shown:
        return ""
    note = f'<p class="note">{len(shown)} of {len(found)} pictures in the folder.</p>\n' if len(shown) < len(found) else ""
    figures = "".join(f'<figure><img src="{url}" alt="{markup(name)}"><figcaption>{markup(name)}</figcaption></figure>\n'
                      for name, url in shown)
    return f'<h2>Pictures</h2>\n{note}<div class="pictures">\n{figures}</div>\n'


def pictures_in(folder: pathlib.Path) -> list[str]:
    """Names of the PNG files in the folder and in the folders in it, in alphabetical order."""
    found = [path for pattern in ("*.png", "*/*.png") for path in folder.glob(pattern) if path.is_file()]
    return sorted(str(path.relative_to(folder)) for path in found)


def embedded(folder: pathlib.Path, names: list[str]) -> list[tuple[str, str]]:
    """Names and data URLs of at most twelve, evenly from all, the last among them; what is too large or no PNG is left
    out."""
    n, total, shown = min(len(names), MOST_PICTURES), 0, []
    for k in range(n):
        name = names[(k + 1) * len(names) // n - 1]
        content = png_bytes(folder / name)
        if content and total + len(content) <= MOST_BYTES:
            total += len(content)
            shown.append((name, "data:image/png;base64," + base64.b64encode(content).decode()))
    return shown


def png_bytes(path: pathlib.Path) -> bytes:
    """Empty if it is too large, cannot be read or is no PNG."""
    try:
        content = path.read_bytes() if path.stat().st_size <= MOST_BYTES_EACH else b""
    except OSError:
        return b""
    return content if content.startswith(PNG) else b""


# --- texts ----------------------------------------------------------------------------------------------------------------

def checkpoints(files: list[list[str]]) -> str:
    if not files:
        return "<p>There is no checkpoint.</p>\n"
    rows = "".join("<tr>" + "".join(f"<td>{markup(cell)}</td>" for cell in file) + "</tr>\n" for file in files)
    head = "<tr><th>checkpoint</th><th>step</th><th>size</th><th>written</th></tr>\n"
    return f'<div class="scroll"><table>\n{head}{rows}</table></div>\n'


def versions(facts: dict) -> str:
    parts = (("Versions", facts["program"]), ("To continue", facts["continuation"]))
    return "".join(f"<h2>{title}</h2>\n<pre>{markup(text)}</pre>\n" for title, text in parts if text)


def scene(folder: pathlib.Path) -> str:
    try:
        content = (folder / "scene.toml").read_bytes()
    except OSError:
        return ""
    if not content:
        return ""
    cut = len(content) > MOST_SCENE_BYTES
    if cut:
        content = content[:content.rfind(b"\n", 0, MOST_SCENE_BYTES + 1) + 1]
    note = '<p class="note">Cut here; the file has it all.</p>\n' if cut else ""
    text = markup(content.decode("utf-8", errors="replace"))
    return (f"<h2>Scene</h2>\n<details><summary>every key in effect (scene.toml)</summary>\n<pre>{text}</pre>\n{note}"
            "</details>\n")


def main() -> None:
    """Reads the facts, writes the page."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", metavar="FOLDER", help="output folder of a run")
    folder = parser.parse_args().folder
    facts = json.loads(sys.stdin.buffer.read().decode("utf-8"))
    sys.stdout.buffer.write(report_page(folder, facts).encode("utf-8", errors="replace"))


if __name__ == "__main__":
    main()
