"""Plots as SVG elements for a page. Their colours are the page's variables --c0 to --c8, --soft and --grid, so that they follow
its light and dark style."""

import io
import logging
import math
import re

import matplotlib
import numpy as np
from matplotlib import ticker
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.patches import PathPatch
from matplotlib.path import Path

from bulkley.report_curves import Curve, Plot

logging.getLogger("matplotlib").setLevel(logging.ERROR)  # what it says of its caches is of no use to readers

# Units of the view box, about pixels of a phone.
WIDTH, HEIGHT = 400.0, 250.0
LEFT, RIGHT, TOP, BOTTOM = 52.0, 20.0, 18.0, 34.0
FONT_SIZE = 11.5
LOG_AXIS_FROM = 30.0  # largest over smallest value
N_COLORS = 9
SUPERSCRIPTS = str.maketrans("-0123456789", "\u207b\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079")
# In place of the page's variables while matplotlib draws.
SOFT, GRID = "#fe0090", "#fe0091"
VARIABLES = {**{f"#fe000{k}": f"var(--c{k})" for k in range(N_COLORS)}, SOFT: "var(--soft)", GRID: "var(--grid)"}
STYLE = {"svg.fonttype": "none", "path.simplify": False, "font.size": FONT_SIZE, "text.color": SOFT, "axes.edgecolor": SOFT,
         "axes.labelcolor": SOFT, "xtick.labelcolor": SOFT, "ytick.labelcolor": SOFT, "axes.unicode_minus": True}


def color_of(number: int) -> str:
    return f"#fe000{number % N_COLORS}"


def power_of_ten(exponent: int) -> str:
    return "10" + str(exponent).translate(SUPERSCRIPTS)


class LinearLabels(ticker.ScalarFormatter):
    """Numbers as plain text, which follows the page's font; they share a power of ten where they would be long."""

    def __init__(self):
        super().__init__(useOffset=False, useMathText=False)
        self.set_powerlimits((-2, 4))

    def get_offset(self) -> str:
        return f"\u00d7 {power_of_ten(self.orderOfMagnitude)}" if self.orderOfMagnitude else ""


def log_label(value: float, _) -> str:
    exponent = math.floor(math.log10(value) + 1e-9)
    digit = round(value / 10.0**exponent)
    return power_of_ten(exponent) if digit == 1 else f"{digit}\u00b7{power_of_ten(exponent)}"


def plot_svg(plot: Plot) -> str:
    """An <svg> element; empty where no curve has a point. Each curve has its name and range as a <title>."""
    curves = [curve for curve in plot.curves if len(curve.x)]
    if not curves:
        return ""
    with matplotlib.rc_context(STYLE):
        figure, axes = new_figure(HEIGHT)
        axes.set_position([LEFT / WIDTH, BOTTOM / HEIGHT, 1 - (LEFT + RIGHT) / WIDTH, 1 - (TOP + BOTTOM) / HEIGHT])
        for k, curve in enumerate(curves):
            draw_curve(axes, curve, plot.dots, f"curve-{k}")
        set_axes(axes, plot, np.concatenate([curve.x for curve in curves]), np.concatenate([curve.y for curve in curves]))
        titles = {f"curve-{k}": f"{curve.name}: {curve.y.min():.3g} to {curve.y.max():.3g}" for k, curve in enumerate(curves)}
        return svg_of(figure, plot.title, titles)


def new_figure(height: float):
    figure = Figure(figsize=(WIDTH / 72, height / 72))
    FigureCanvasSVG(figure)
    return figure, figure.add_axes((0, 0, 1, 1))


def draw_curve(axes, curve: Curve, dots: bool, name: str) -> None:
    color = color_of(curve.color)
    if dots or len(curve.x) == 1:  # strokes without length and with round ends: one path, not an element a point
        points = np.repeat(np.stack([curve.x, curve.y], axis=1), 2, axis=0)
        path = Path(points, np.tile([Path.MOVETO, Path.LINETO], len(curve.x)))
        axes.add_patch(PathPatch(path, fill=False, edgecolor=color, linewidth=4.5, capstyle="round", clip_on=False, gid=name))
    else:
        axes.plot(curve.x, curve.y, color=color, linewidth=1.6, solid_joinstyle="round", solid_capstyle="round", clip_on=False,
                  gid=name)


def set_axes(axes, plot: Plot, x: np.ndarray, y: np.ndarray) -> None:
    """Limits, ticks and labels."""
    log = plot.may_be_log and y.min() > 0.0 and y.max() > LOG_AXIS_FROM * y.min()
    axes.set_xlim(*room_around(x.min(), x.max()))
    axes.xaxis.set_major_locator(ticker.MaxNLocator(5, steps=[1, 2, 5, 10]))
    axes.xaxis.set_major_formatter(LinearLabels())
    if log:
        axes.set_yscale("log")
        axes.set_ylim(y.min() / 1.12, y.max() * 1.12)
        few = math.log10(y.max() / y.min()) <= 2.5
        axes.yaxis.set_major_locator(ticker.LogLocator(subs=(1.0, 2.0, 5.0) if few else (1.0,), numticks=8))
        axes.yaxis.set_major_formatter(log_label)
        axes.yaxis.set_minor_locator(ticker.NullLocator())
    else:
        axes.set_ylim(*linear_limits(y.min(), y.max(), plot.from_zero))
        axes.yaxis.set_major_locator(ticker.MaxNLocator(5, steps=[1, 2, 5, 10]))
        axes.yaxis.set_major_formatter(LinearLabels())
        if axes.get_ylim()[0] < 0.0 < axes.get_ylim()[1]:
            axes.axhline(0.0, color=SOFT, linewidth=0.7, zorder=1, clip_on=False)
    labels = axes.xaxis.get_major_formatter()
    labels.set_locs(axes.xaxis.get_majorticklocs())
    axes.set_xlabel(", ".join(filter(None, ("time [s]", labels.get_offset()))), loc="right", labelpad=2)
    axes.xaxis.get_offset_text().set_visible(False)
    axes.yaxis.get_offset_text().set_color(SOFT)
    axes.tick_params(left=False, bottom=False, pad=4)
    axes.grid(color=GRID, linewidth=1.0, clip_on=False)
    axes.set_axisbelow(True)
    axes.spines[["top", "right"]].set_visible(False)
    axes.patch.set_visible(False)


def room_around(lower: float, upper: float) -> tuple[float, float]:
    """An interval that is not empty."""
    if upper > lower:
        return lower, upper
    room = 0.1 * abs(lower) or 1.0
    return lower - room, upper + room


def linear_limits(lower: float, upper: float, from_zero: bool) -> tuple[float, float]:
    """With a little air above and below, but not below zero where the axis begins there."""
    if from_zero:
        lower, upper = min(lower, 0.0), max(upper, 0.0)
        upper = 1.0 if upper == lower else upper
    lower, upper = room_around(lower, upper)
    air = 0.04 * (upper - lower)
    return lower if from_zero and lower == 0.0 else lower - air, upper if from_zero and upper == 0.0 else upper + air


def bars_svg(title: str, bars: list[tuple[str, float, float]], unit: str) -> str:
    """Horizontal bars as an <svg> element. `bars`: name, value, and the end of a thin line behind the bar, 0 for none."""
    row, names, room = 20.0, 108.0, 72.0
    largest = max((max(value, line) for _, value, line in bars), default=0.0)
    scale = (WIDTH - names - room) / largest if largest > 0.0 else 0.0
    height = row * len(bars) + 4.0
    with matplotlib.rc_context(STYLE):
        figure, axes = new_figure(height)
        axes.set(xlim=(0, WIDTH), ylim=(height, 0))
        axes.axis("off")
        for k, (name, value, line) in enumerate(bars):
            y = 12.0 + k * row
            axes.text(names - 6, y, escaped_dollars(name), ha="right", va="center")
            if line > 0.0:
                axes.plot([names, names + scale * line], [y, y], color=SOFT, linewidth=1.5, zorder=0, clip_on=False)
            axes.barh(y, max(scale * value, 0.5), left=names, height=12, color=color_of(0), clip_on=False)
            axes.text(names + scale * max(value, line) + 5, y, escaped_dollars(f"{value:.3g} {unit}"), va="center")
        return svg_of(figure, title, {})


def escaped_dollars(text: str) -> str:
    """No mathematics."""
    return text.replace("$", r"\$")


def svg_of(figure: Figure, title: str, curve_titles: dict[str, str]) -> str:
    """The figure as an element of an HTML page: without a prolog, metadata and names that other figures have, too."""
    stream = io.StringIO()
    figure.savefig(stream, format="svg", transparent=True)
    svg = stream.getvalue()
    svg = svg[svg.index("<svg"):].rstrip()
    view_box = re.search(r'viewBox="([^"]*)"', svg)[1]
    svg = re.sub(r"<svg[^>]*>", f'<svg viewBox="{view_box}" role="img" aria-label="{markup(title)}">', svg, count=1)
    svg = re.sub(r"<metadata>.*?</metadata>\s*|<!--.*?-->\s*", "", svg, flags=re.DOTALL)
    svg = re.sub(r"<defs>\s*<style[^>]*>.*?</style>\s*</defs>", "", svg, flags=re.DOTALL)
    for name, text in curve_titles.items():
        svg = svg.replace(f'<g id="{name}">', f'<g class="curve"><title>{markup(text)}</title>')
    svg = re.sub(r'<g id="[^"]*">', "<g>", svg)
    svg = re.sub(r' d="[^"]*"', lambda found: shorter_path(found[0]), svg)
    svg = re.sub(rf"font: {FONT_SIZE:g}px [^;\"]*;?\s*", "", svg)  # the page's font; the colours are its variables
    svg = re.sub("|".join(VARIABLES), lambda found: VARIABLES[found[0]], svg)
    return re.sub(r"\s*\n\s*", "\n", svg)


def shorter_path(path: str) -> str:
    """With two digits behind the point, and strokes without length as such."""
    path = re.sub(r"(\.\d\d)\d+", r"\1", path)
    return re.sub(r"M (\S+) (\S+)\s+L \1 \2\s", r"M \1 \2h0 ", path)


def markup(text: str) -> str:
    """Text of HTML and XML with nothing in it that could be read as markup, nor control characters."""
    replaced = {"<": "&lt;", ">": "&gt;", "&": "&amp;", '"': "&quot;", "'": "&#39;"}
    return "".join(replaced.get(c, " " if c < " " and c not in "\n\t" else c) for c in text)
