"""Writes a closed mesh of a tool: vane, helical ribbon, whisk or bowl, with its axis along z and its lowest point at z = 0.

    python3 -m bulkley tool-mesh vane --blades 4 --diameter 0.04 --height 0.08 --thickness 0.004 --out vane.stl

Lengths in m. With --cell-size a part that is thinner than two cells is refused, as a run would do without a word about
which. Meshes are closed, without self-intersections, with outward normals. Needs numpy. Exit code 2: bad input.
"""

import argparse
import math
import pathlib
import sys

import numpy as np

from bulkley.faults import DataError
from bulkley.solids import Surface, faults, genus, volume, write


def ring(radius, z, n, start=0.0):
    """n points on a circle, counter-clockwise."""
    angles = start + 2.0 * math.pi * np.arange(n) / n
    return [(radius * math.cos(a), radius * math.sin(a), z) for a in angles]


def wall(surface, points, low, high):
    """Vertical quadrilaterals between two heights along a line of points that has the solid on its left."""
    for (x, y, *_), (u, v, *_) in zip(points, points[1:]):
        surface.polygon(((x, y, low), (u, v, low), (u, v, high), (x, y, high)))


def flat(surface, points, z, up):
    """A horizontal convex polygon, given counter-clockwise, whose normal points up or down."""
    points = [(x, y, z) for x, y, *_ in points]
    surface.polygon(points if up else points[::-1])


def fan(surface, points, z, up):
    """The same from the axis, for a closed line around it."""
    for a, b in zip(points, points[1:] + points[:1]):
        flat(surface, [(0.0, 0.0), a, b], z, up)


def need(condition, sentence):
    if not condition:
        raise DataError(sentence)


def vane(o):
    """Blades on a shaft that goes on above them."""
    shaft = 0.5 * o.shaft
    need(o.blades >= 2, "a vane has at least 2 blades")
    half = math.asin(min(1.0, 0.5 * o.thickness / shaft))
    need(o.blades * half < math.pi * 0.98, f"{o.blades} blades {o.thickness:g} m thick do not fit around a shaft of {o.shaft:g} m")
    need(0.5 * o.diameter > shaft, "the vane must be wider than its shaft")
    surface, hub = Surface(), []
    between = max(1, round(o.segments / o.blades * (1.0 - half * o.blades / math.pi)))
    for k in range(o.blades):
        angle = 2.0 * math.pi * k / o.blades
        away, aside = np.array([math.cos(angle), math.sin(angle)]), np.array([-math.sin(angle), math.cos(angle)])
        roots = [shaft * math.cos(half) * away + side * 0.5 * o.thickness * aside for side in (-1.0, 1.0)]
        tips = [0.5 * o.diameter * away + side * 0.5 * o.thickness * aside for side in (-1.0, 1.0)]
        wall(surface, [roots[0], tips[0], tips[1], roots[1]], 0.0, o.height)
        blade = [roots[0], tips[0], tips[1], roots[1]]
        flat(surface, blade, 0.0, False)
        flat(surface, blade, o.height, True)
        arc = [roots[1]]
        span = 2.0 * (math.pi / o.blades - half)
        for i in range(1, between):
            a = angle + half + span * i / between
            arc.append((shaft * math.cos(a), shaft * math.sin(a)))
        following = 2.0 * math.pi * (k + 1) / o.blades - half
        wall(surface, [*arc, (shaft * math.cos(following), shaft * math.sin(following))], 0.0, o.height)
        hub += [roots[0], *arc]
    fan(surface, hub, 0.0, False)
    top = o.height + o.shaft_length
    if o.shaft_length > 0.0:
        wall(surface, hub + hub[:1], o.height, top)
    fan(surface, hub, top, True)
    return surface, o.thickness


def ribbon(o):
    """Helical ribbons around a shaft, each held by spokes as thick as itself."""
    shaft, inner, outer = 0.5 * o.shaft, 0.5 * o.diameter - o.width, 0.5 * o.diameter
    n = o.segments - o.segments % o.starts
    turns = (o.height - o.thickness) / o.pitch
    sectors = round(turns * n)
    need(inner > shaft, "the ribbon must be wider than its shaft and width leave")
    need(o.thickness * o.starts < 0.9 * o.pitch, f"{o.starts} ribbons {o.thickness:g} m thick do not fit into the pitch")
    broad = math.ceil(o.thickness / (2.0 * math.pi * shaft / n))  # sectors of a spoke, as wide at the shaft as it is thick
    most = sectors // (broad + 1)
    need(2 <= o.spokes <= most, f"a ribbon of {turns:.3g} turns takes 2 to {most} spokes")
    rise = o.pitch / n
    overlap = o.thickness + rise
    need(overlap * o.starts < o.pitch, "the ribbons touch each other: fewer starts or more segments")
    held = {round(k * (sectors - broad) / (o.spokes - 1)) + i for k in range(o.spokes) for i in range(broad)}
    surface, columns = Surface(), [[0.0] for _ in range(n)]
    bands = [[] for _ in range(n)]  # of every sector of the shaft: (z at its first, z at its second line) of spokes' undersides

    def point(radius, k, z):
        return (radius * math.cos(2.0 * math.pi * (k % n) / n), radius * math.sin(2.0 * math.pi * (k % n) / n), z)

    for start in range(o.starts):
        shift = start * n // o.starts
        for s in range(sectors):
            a, b, low, high = s + shift, s + shift + 1, s * rise, (s + 1) * rise
            cells = [(inner, outer)] + ([(shaft, inner)] if s in held else [])
            for r0, r1 in cells:
                bottom = (point(r0, a, low), point(r1, a, low), point(r1, b, high), point(r0, b, high))
                top = tuple((x, y, z + o.thickness) for x, y, z in bottom)
                surface.polygon(bottom[::-1])
                surface.polygon((top[1], top[2], top[3], top[0]))
                if r1 == outer:
                    surface.polygon((bottom[1], bottom[2], top[2], top[1]))
                    if s not in held:
                        surface.polygon((bottom[3], bottom[0], top[0], top[3]))
                spoke = r1 == inner
                if s == 0 or (spoke and s - 1 not in held):
                    surface.polygon((bottom[0], bottom[1], top[1], top[0]))
                if s == sectors - 1 or (spoke and s + 1 not in held):
                    surface.polygon((bottom[2], bottom[3], top[3], top[2]))
            if s in held:
                bands[a % n].append((low, high))
                columns[a % n] += [low, low + o.thickness]
                columns[b % n] += [high, high + o.thickness]
    total = o.height + o.shaft_length
    columns = [sorted({round(z, 12) for z in [*column, total]}) for column in columns]
    for i in range(n):
        j, edges = (i + 1) % n, [(0.0, 0.0)]
        for low, high in sorted(bands[i]):
            edges += [(low, high), (low + o.thickness, high + o.thickness)]
        edges.append((total, total))
        for (l0, r0), (l1, r1) in zip(edges[::2], edges[1::2]):
            left = [point(shaft, i, z) for z in columns[i] if l0 - 1e-11 <= z <= l1 + 1e-11]
            right = [point(shaft, j, z) for z in columns[j] if r0 - 1e-11 <= z <= r1 + 1e-11]
            surface.strip(left, right)
    fan(surface, ring(shaft, 0.0, n), 0.0, False)
    fan(surface, ring(shaft, 0.0, n), total, True)
    steepest = o.pitch / (2.0 * math.pi * shaft)  # of the spokes, where they leave the shaft
    return surface, min(o.thickness / math.hypot(1.0, steepest), o.width)


def wire_foot(o):
    """How far from the axis wires leave the handle."""
    return 0.5 * o.handle - 0.75 * o.thickness


def loop_curve(o, depth):
    """Half a loop of a whisk from the handle to its lowest point: (n, 2), distance from the axis and z below the handle."""
    t = np.linspace(0.0, 1.0, o.curve + 1)
    foot = wire_foot(o)
    fixed = foot * ((1.0 - t) ** 3 + 3.0 * (1.0 - t) ** 2 * t)
    low, high = 0.0, 4.0 * o.diameter
    for _ in range(80):  # the third point of the Bezier curve, for the width asked for
        middle = 0.5 * (low + high)
        wide = 2.0 * (fixed + 3.0 * (1.0 - t) * t * t * middle).max() + o.thickness
        low, high = (middle, high) if wide < o.diameter else (low, middle)
    r = fixed + 3.0 * (1.0 - t) * t * t * low
    z = -depth * (3.0 * (1.0 - t) ** 2 * t * 0.35 + 3.0 * (1.0 - t) * t * t + t**3)
    return np.stack([r, z], axis=1)


def tube(surface, line, aside, radius, n):
    """A tube along a line of points (m, 3) in a plane with the normal `aside`, from the top down and up again; its joints are
    mitred, its ends open and horizontal. Returns its first and last ring."""
    steps = np.diff(line, axis=0)
    steps /= np.linalg.norm(steps, axis=1)[:, None]
    rings, down = [], np.array([[0.0, 0.0, -1.0]])
    mitres = np.vstack([down, steps[:-1] + steps[1:], -down])
    for k, place in enumerate(line):
        across = np.cross(aside, mitres[k])
        across /= np.linalg.norm(across)
        across /= np.dot(across, np.cross(aside, steps[min(k, len(steps) - 1)]))
        angles = 2.0 * math.pi * np.arange(n) / n
        rings.append([tuple(place + radius * (math.cos(a) * across + math.sin(a) * aside)) for a in angles])
    for a, b in zip(rings, rings[1:]):
        for i in range(n):
            j = (i + 1) % n
            surface.polygon((a[i], a[j], b[j], b[i]))
    return rings[0], rings[-1]


def whisk(o):
    """Loops of wire below a handle. Each passes the axis at its own depth, a wire and a half apart."""
    need(o.loops >= 1, "a whisk has at least one loop")
    foot = wire_foot(o)
    half = math.pi / (2 * o.loops)
    need(foot * math.sin(half) > 0.6 * o.thickness or o.loops == 1 and foot > 0.6 * o.thickness,
         f"{2 * o.loops} ends of wires {o.thickness:g} m thick do not fit on a handle of {o.handle:g} m")
    depth = o.height - 0.5 * o.thickness
    need(depth - 1.5 * o.thickness * (o.loops - 1) > 0.5 * o.height, "the loops need a higher whisk or thinner wires")
    surface, lines, n, side, edge = Surface(), [], o.sides, 0.5 * o.handle, max(2, o.segments // (2 * o.loops))
    holes = {}
    for k in range(o.loops):
        angle = math.pi * k / o.loops
        away, aside = np.array([math.cos(angle), math.sin(angle), 0.0]), np.array([-math.sin(angle), math.cos(angle), 0.0])
        curve = loop_curve(o, depth - 1.5 * o.thickness * k)
        half_line = curve[:, :1] * away + curve[:, 1:] * np.array([0.0, 0.0, 1.0])
        other = -curve[:, :1] * away + curve[:, 1:] * np.array([0.0, 0.0, 1.0])
        line = np.vstack([half_line, other[-2::-1]])
        line[:, 2] += o.height
        lines.append(line)
        holes[k], holes[k + o.loops] = tube(surface, line, aside, 0.5 * o.thickness, n)
    for a in range(o.loops):
        for b in range(a):
            gap = np.linalg.norm(lines[a][:, None] - lines[b][None], axis=2).min()
            need(gap > 1.1 * o.thickness, f"wires touch each other: they pass at {gap:.3g} m, and are {o.thickness:g} m thick")
    rim = []
    for k in range(2 * o.loops):  # the handle's underside: a sector around every end of a wire
        middle = math.pi * k / o.loops
        arc = [(side * math.cos(a), side * math.sin(a), o.height) for a in middle + half * np.linspace(-1.0, 1.0, edge + 1)]
        rim += arc[:-1]
        center = np.array([foot * math.cos(middle), foot * math.sin(middle)])
        outline = [(0.0, 0.0, o.height), *arc]
        sort = [sorted(points, key=lambda p: math.atan2(p[1] - center[1], p[0] - center[0])) for points in (outline, holes[k])]
        first, second = (points + points[:1] for points in sort)
        annulus(surface, first, second, center)
    wall(surface, rim + rim[:1], o.height, o.height + o.handle_length)
    fan(surface, rim, o.height + o.handle_length, True)
    return surface, o.thickness


def annulus(surface, outer, inner, center):
    """The surface, facing down, between two closed lines in order of the angle around `center`."""
    def angle(points, k):
        value = math.atan2(points[k][1] - center[1], points[k][0] - center[0])
        return value + 2.0 * math.pi if k == len(points) - 1 else value
    i, j = 0, 0
    while i + 1 < len(outer) or j + 1 < len(inner):
        if j + 1 == len(inner) or (i + 1 < len(outer) and angle(outer, i + 1) <= angle(inner, j + 1)):
            surface.polygon((outer[i + 1], outer[i], inner[j]))
            i += 1
        else:
            surface.polygon((outer[i], inner[j], inner[j + 1]))
            j += 1


def bowl_profile(o):
    """Half of the section, from the axis below along the outside, over the rim to the axis above: (n, 2) of r, z. The outside
    is a quarter of an ellipse; below --foot it is cut flat."""
    outer, inner = 0.5 * o.diameter, 0.5 * o.diameter - o.thickness
    flat_part = min(0.5 * o.foot, 0.95 * outer)
    begin = math.asin(flat_part / outer)
    angles = np.linspace(begin, 0.5 * math.pi, o.curve + 1)
    below = o.height * (1.0 - np.cos(angles)) / math.cos(begin) - o.height * (1.0 / math.cos(begin) - 1.0)
    outside = np.stack([outer * np.sin(angles), below], axis=1)
    inside = np.stack([inner * np.sin(np.linspace(0.5 * math.pi, 0.0, o.curve + 1)),
                       o.height - (o.height - o.thickness) * np.cos(np.linspace(0.5 * math.pi, 0.0, o.curve + 1))], axis=1)
    inside[-1, 0] = 0.0
    start = [] if flat_part == 0.0 else [[0.0, 0.0]]
    return np.array([*start, *outside, *inside])


def bowl(o):
    """A solid of revolution: half an ellipsoid with a wall and a flat foot."""
    need(o.thickness < 0.4 * min(o.diameter, o.height), "the wall is too thick for the bowl")
    surface, profile = Surface(), bowl_profile(o)
    for (r0, z0), (r1, z1) in zip(profile, profile[1:]):
        a, b = ring(r0, z0, o.segments), ring(r1, z1, o.segments)
        for i in range(o.segments):
            j = (i + 1) % o.segments
            surface.polygon((a[i], a[j], b[j], b[i]))
    return surface, o.thickness


TOOLS = {"vane": vane, "ribbon": ribbon, "whisk": whisk, "bowl": bowl}
OPTIONS = {  # of each tool: name, default, meaning
    "vane": (("blades", 4, "number"), ("diameter", 0.04, ""), ("height", 0.08, "of the blades"), ("thickness", 0.004, "of blades"),
             ("shaft", 0.008, "its diameter"), ("shaft-length", 0.04, "above the blades"), ("segments", 48, "around the shaft")),
    "ribbon": (("starts", 1, "number of ribbons"), ("diameter", 0.08, ""), ("height", 0.1, "of the ribbon"),
               ("pitch", 0.08, "rise of a turn"), ("width", 0.012, "of the ribbon, towards the axis"),
               ("thickness", 0.008, "along the axis; less across, as it is inclined"), ("spokes", 4, "of each ribbon"),
               ("shaft", 0.02, "its diameter"),
               ("shaft-length", 0.04, "above the ribbon"), ("segments", 48, "of a turn")),
    "whisk": (("loops", 3, "number"), ("diameter", 0.08, "of the balloon"), ("height", 0.12, "of the balloon"),
              ("thickness", 0.005, "of the wires"), ("handle", 0.03, "its diameter"), ("handle-length", 0.06, ""),
              ("sides", 10, "of a wire's section"), ("curve", 32, "pieces of half a loop"), ("segments", 48, "around the handle")),
    "bowl": (("diameter", 0.2, "outside"), ("height", 0.1, "outside"), ("thickness", 0.008, "of the wall"),
             ("foot", 0.08, "diameter of the flat part below"), ("curve", 24, "pieces of the profile"), ("segments", 64, "around")),
}


def build(tool, options):
    """Vertices (n, 3) and triangles (m, 3) of a tool; `options`: a namespace of its numbers. Raises DataError."""
    for name, default, _ in OPTIONS[tool]:
        value = getattr(options, name.replace("-", "_"))
        least = 0.0 if name.endswith("length") or name == "foot" else math.ulp(0.0)
        need(math.isfinite(value) and value >= least, f"--{name} is {value:g} and must be above 0")
        if name in ("segments", "sides", "curve"):
            need(value >= 3, f"--{name} is {value} and must be at least 3")
    surface, thinnest = TOOLS[tool](options)
    if options.cell_size is not None:
        need(thinnest >= 2.0 * options.cell_size * (1.0 - 1e-9),
             f"the {tool} is {thinnest:.3g} m thick, and a collider must be two cells thick: {2.0 * options.cell_size:.3g} m")
    points, triangles = surface.arrays()
    assert not faults(triangles), f"{len(faults(triangles))} edges of the {tool} are not shared by two triangles"
    return points, triangles


def parse_arguments(words=None):
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    tools = parser.add_subparsers(dest="tool", required=True)
    for tool, options in OPTIONS.items():
        one = tools.add_parser(tool, help=TOOLS[tool].__doc__, description=TOOLS[tool].__doc__)
        for name, default, meaning in options:
            one.add_argument(f"--{name}", type=type(default), default=default, help=f"{meaning}; default: %(default)s".lstrip("; "))
        one.add_argument("--cell-size", type=float, help="of the run, to be refused what is too thin for it")
        one.add_argument("--out", type=pathlib.Path, required=True, metavar="FILE", help=".stl, .obj or .ply")
    return parser.parse_args(words)


def main():
    options = parse_arguments()
    try:
        points, triangles = build(options.tool, options)
        write(options.out, points, triangles)
    except DataError as error:
        print(f"tool-mesh: {error}", file=sys.stderr)
        sys.exit(2)
    print(f"{options.out}: {len(points)} vertices, {len(triangles)} triangles, volume {volume(points, triangles):.6g} m^3, "
          f"genus {genus(points, triangles)}")
