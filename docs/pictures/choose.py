#!/usr/bin/env python3
"""Prints the diagram of docs/choose.md as SVG: questions, answers, and the keys that follow.

    python3 docs/pictures/choose.py > docs/pictures/choose.svg

A test compares the file with what this prints, and looks the keys up in docs/input.md."""

import html

# A question; its answers, each with the lines of keys to write. Lines that begin with "#" are no keys.
ROWS = [
    (["What is it?", "(materials)"], [
        ("needs a push to flow:\ncream, paste, sauce, foam, mud", ['law = "herschel_bulkley"', "# yield_stress, consistency, flow_index"]),
        ("the same, and thins while it is sheared:\nketchup, drilling mud", ['law = "thixotropic_herschel_bulkley"']),
        ("flows at any stress: water, oil, honey", ['law = "newtonian"']),
        ("flows, and draws threads or climbs a rod", ['law = "oldroyd_b"']),
        ("springs back: rubber, jelly, gel", ['law = "neo_hookean"']),
        ("springs back and creeps: dough, foam rubber", ['law = "finite_viscoelastic"']),
        ("grains; snow", ['law = "drucker_prager"', 'law = "snow"']),
    ]),
    (["How stiff, how fast?", "U: fastest speed", "(time, materials)"], [
        ("fluid or paste: films, rigid bodies, impacts,\nor the true stiffness matters", ['integrator = "imex"', "bulk_modulus = 2e9"]),
        ("likewise, and very viscous:\nhoney, creeping flow", ['integrator = "imex"', 'viscosity = "implicit"']),
        ("fluid, thick everywhere, and imex is slower", ['integrator = "explicit"', "bulk_modulus = density * (10 U)^2"]),
        ("solid, sand, snow, a law of your own", ['integrator = "explicit"', "# its true moduli"]),
    ]),
    (["How thin is the", "thinnest thing", "that matters?", "h: film, gap, jet", "(domain, bodies)"], [
        ("a first look", ["cell_size = h / 4"]),
        ("5 to 10 % off will do", ["cell_size = h / 8", "# obstacles and tools: at least 2 cells"]),
        ("1 to 3 %, profiles, fronts, torques", ["cell_size = h / 16", "# and once with twice that: compare"]),
        ("material is drawn out to several\ntimes its length", ["particles_per_cell = 27"]),
    ]),
    (["What do you want", "to know?", "(output, transfer)"], [
        ("shape, reach, pictures", ["frame_interval = 0.01", "# a front: [[output.front]]"]),
        ("force or torque on a tool", ["# a collider, by name in history.csv"]),
        ("pressure on a patch of a wall", ["# a gauge: [[output.gauge]]"]),
        ("the same as before version 0.2", ['scheme = "apic"']),
    ]),
]

LEFT, MIDDLE, RIGHT, WIDTH = 10, 215, 585, 910  # px: where the columns begin, and the picture's width
LINE, PADDING, GAP, ROW_GAP = 17, 7, 7, 20
STYLE = """
text { font: 13px sans-serif; fill: #1d2733; }
.question { font-weight: bold; }
.key { font-family: monospace; font-size: 12.5px; }
.note { font-size: 12px; fill: #5a6675; }
rect { stroke: #8a97a6; fill: #fff; rx: 5px; }
rect.question { fill: #dce8f5; }
rect.keys { fill: #eef5ea; }
path { stroke: #8a97a6; fill: none; }
"""


def box(x, y, width, height, kind):
    return f'<rect class="{kind}" x="{x}" y="{y}" width="{width}" height="{height}"/>'


def lines_of_text(x, y, lines):
    """`lines`: pairs of class and text, the first with its middle LINE / 2 below y."""
    return [f'<text class="{kind}" x="{x}" y="{y + LINE * k + 13}" xml:space="preserve">{html.escape(text)}</text>'
            for k, (kind, text) in enumerate(lines)]


def height_of(n_lines):
    return n_lines * LINE + 2 * PADDING


def key_lines(keys):
    return [("note", key[2:]) if key.startswith("#") else ("key", key) for key in keys]


def svg():
    body, y = [], 10
    for question, answers in ROWS:
        heights = [max(height_of(len(keys)), height_of(answer.count("\n") + 1)) for answer, keys in answers]
        total = sum(heights) + GAP * (len(heights) - 1)
        asked = height_of(len(question))
        middle = y + total / 2
        body.append(box(LEFT, middle - asked / 2, 175, asked, "question"))
        body += lines_of_text(LEFT + 9, middle - asked / 2 + PADDING,
                              [("note" if line.startswith("(") else "question", line) for line in question])
        for (answer, keys), height in zip(answers, heights):
            at = y + height / 2
            body.append(f'<path d="M{LEFT + 175} {middle} H{MIDDLE - 14} V{at} H{MIDDLE}"/>')
            body.append(f'<path d="M{RIGHT - 35} {at} H{RIGHT - 2} m-7 -4 l7 4 l-7 4"/>')
            body.append(box(MIDDLE, y, RIGHT - 35 - MIDDLE, height, "answer"))
            text = [("answer", line) for line in answer.split("\n")]
            body += lines_of_text(MIDDLE + 9, at - LINE * len(text) / 2, text)
            body.append(box(RIGHT, y, WIDTH - RIGHT - 10, height, "keys"))
            body += lines_of_text(RIGHT + 9, at - LINE * len(keys) / 2, key_lines(keys))
            y += height + GAP
        y += ROW_GAP - GAP
    return "\n".join([f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {WIDTH} {y - 10}" role="img" '
                      'aria-label="From material, speed, size and question to the keys of a scene">',
                      f"<style>{STYLE}</style>", f'<rect width="{WIDTH}" height="{y - 10}" style="stroke: none; rx: 0"/>',
                      *body, "</svg>"])


if __name__ == "__main__":
    print(svg())
