#!/usr/bin/env python3
"""A poster of one page (A3, PDF) from the pictures and the numbers of docs/: docs/gallery/poster.py [FILE.pdf]

By default out/poster.pdf. Numbers come from the tables of docs/performance.md, verification.md and validation.md as they are; a row
that is not there any more is an error. Needs matplotlib. Run from anywhere; nothing has to be built.
"""

import pathlib
import re
import sys
import textwrap

import matplotlib

matplotlib.use("pdf")
from matplotlib import image  # noqa: E402
from matplotlib.figure import Figure  # noqa: E402
from matplotlib.patches import Rectangle  # noqa: E402

ROOT = pathlib.Path(__file__).resolve().parents[2]
WIDTH, HEIGHT = 297.0, 420.0  # mm
MARGIN = 14.0
DARK, RED, CREAM, GREY = "#26323d", "#b3361f", "#fff3d6", "#5a5f6b"
POINT = 0.3528  # mm
CAPTION = 10.0  # points


def cell(page, row, column):
    """A cell of the first table row of docs/PAGE that begins with `row`."""
    for line in (ROOT / "docs" / page).read_text(encoding="utf-8").splitlines():
        cells = [text.strip() for text in line.strip("|").split("|")]
        if line.startswith("|") and cells[0].startswith(row):
            return cells[column]
    sys.exit(f"poster.py: docs/{page} has no row that begins with '{row}'")


def judged(page):
    """How many rows of its first tables a page calls passed, and how many rows it judges."""
    text = (ROOT / "docs" / page).read_text(encoding="utf-8")
    passed = len(re.findall(r"\| passed \|$", text, re.MULTILINE))
    missed = len(re.findall(r"\| \*\*(?:missed|FAILED)\*\* \|$", text, re.MULTILINE))  # validation says the one, verification the other
    if passed == 0:
        sys.exit(f"poster.py: docs/{page} has no row that passed")
    return passed, passed + missed


def version():
    return re.search(r"project\(bulkley VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8"))[1]


class Poster:
    """Places are millimetres from the upper left corner."""

    def __init__(self):
        self.figure = Figure(figsize=(WIDTH / 25.4, HEIGHT / 25.4), facecolor="white")

    def band(self, top, height, color):
        self.figure.add_artist(Rectangle((0.0, 1.0 - (top + height) / HEIGHT), 1.0, height / HEIGHT, color=color, linewidth=0,
                                         transform=self.figure.transFigure))

    def text(self, x, y, words, size, **style):
        """`y`: of the upper edge. Returns where the text ends."""
        self.figure.text(x / WIDTH, 1.0 - y / HEIGHT, words, fontsize=size, va="top", linespacing=1.35, **style)
        return y + size * POINT * 1.6 * (words.count("\n") + 1)

    def paragraph(self, x, y, width, title, words, size=12.5):
        y = self.text(x, y, title, 16, color=RED, weight="bold")
        letters = int(width / (size * POINT * 0.54))
        return self.text(x, y + 1.0, textwrap.fill(words, letters), size, color=DARK)

    def row(self, y, gap, *pictures):
        """Pictures, each (file of docs/, caption), of one height across the page. Returns where the longest caption ends."""
        pixels = [image.imread(ROOT / "docs" / name) for name, _ in pictures]
        ratios = [picture.shape[1] / picture.shape[0] for picture in pixels]
        height = (WIDTH - 2 * MARGIN - gap * (len(pictures) - 1)) / sum(ratios)
        x, end = MARGIN, y
        for picture, ratio, (_, caption) in zip(pixels, ratios, pictures):
            width = height * ratio
            axes = self.figure.add_axes((x / WIDTH, 1.0 - (y + height) / HEIGHT, width / WIDTH, height / HEIGHT))
            axes.imshow(picture, interpolation="antialiased")
            axes.set_axis_off()
            words = textwrap.fill(caption, int(width / (CAPTION * POINT * 0.52)))
            end = max(end, self.text(x, y + height + 1.5, words, CAPTION, color=GREY))
            x += width + gap
        return end


def draw(path):
    poster = Poster()
    inner = WIDTH - 2 * MARGIN
    gap = 8.0
    third = (inner - 2 * gap) / 3
    poster.band(0, 36, DARK)
    poster.text(MARGIN, 7, "Bulkley", 50, color=CREAM, weight="bold")
    poster.text(MARGIN + 92, 9.5, "How creams, pastes, suspensions and soft solids\nflow, bounce and settle", 19, color="white")
    y = poster.row(41, gap, ("pictures/first_splash.png",
                             "A ball of cream falls into a layer of cream, coloured by speed. The yield stress of 18 Pa holds up a crown that water "
                             "would let run out. True bulk modulus, 2e9 Pa; under a minute on two cores."))
    passed, judged_rows = judged("verification.md")
    near, compared = judged("validation.md")
    begin = y + 4
    ends = [
        poster.paragraph(MARGIN, begin, third, "What it computes",
                         "The Material Point Method in three dimensions: Herschel-Bulkley fluids (yield stress, shear thinning or thickening, "
                         "thixotropy), Newtonian and viscoelastic fluids, elastic and viscoelastic solids, sand and snow side by side; "
                         "magnetic fluids; tools, nozzles and bodies that move."),
        poster.paragraph(MARGIN + third + gap, begin, third, "How",
                         "An implicit pressure takes the true bulk modulus at the time step of the flow. The same bits on any number of MPI ranks "
                         f"and through restarts. {cell('performance.md', 'Herschel-Bulkley, cream', 3)} ns a particle and step for cream on one core; "
                         f"two ranks are {cell('performance.md', 'throughput of two ranks', 2)} times as fast as one."),
        poster.paragraph(MARGIN + 2 * (third + gap), begin, third, "How close",
                         f"Against exact solutions {passed} of {judged_rows} quantities are within their bounds; against experiments, with "
                         f"tolerances that were fixed before the runs and nothing adjusted, {near} of {compared}. The pages list every miss."),
    ]
    y = max(ends) + 4
    y = poster.row(y, gap, ("gallery/figure_1_real.png", "A hare of oobleck jumps, and melts."),
                   ("pictures/stirred_bowl.png", "A paddle stirs cream and jam in a bowl of glass.")) + 3
    y = poster.row(y, gap, ("pictures/magnet_lifts_puddle.png", "A magnet lifts a puddle of ferro-oobleck."),
                   ("pictures/print_cylinder.png", "A print head lays paste."),
                   ("gallery/figure_6_real.png", "A dragon of oobleck lands, and melts."))
    poster.band(HEIGHT - 27, 27, DARK)
    poster.text(MARGIN, HEIGHT - 21, "cluster/quickstart.sh", 17, color=CREAM, family="monospace", weight="bold")
    poster.text(MARGIN, HEIGHT - 12, "from a bare Debian 12 to the six pictures above", 11, color="white")
    poster.text(MARGIN + 130, HEIGHT - 21, f"Bulkley {version()}, C++20 and MPI, Python package, BSD-3-Clause\nEvery number is on a page of docs/, with "
                "the command that makes it.", 11, color="white")
    if y > HEIGHT - 28:
        sys.exit(f"poster.py: the page is {y - HEIGHT + 28:.0f} mm too short for what is on it")
    path.parent.mkdir(parents=True, exist_ok=True)
    poster.figure.savefig(path, dpi=220, metadata={"Title": "Bulkley", "CreationDate": None})
    print(path)


def main():
    arguments = sys.argv[1:]
    if arguments in (["-h"], ["--help"]):
        print(__doc__.strip())
        return
    if len(arguments) > 1 or any(not word.endswith(".pdf") for word in arguments):
        sys.exit("poster.py: give nothing, or one name that ends in .pdf")
    draw(pathlib.Path(arguments[0]) if arguments else ROOT / "out/poster.pdf")


if __name__ == "__main__":
    main()
