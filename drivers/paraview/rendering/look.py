"""What a picture looks like: looks/default.toml, a look file over it, the command line over both."""

import difflib
import math
import pathlib
import tomllib

from rendering.faults import fail

DEFAULTS = pathlib.Path(__file__).resolve().parent.parent / "looks" / "default.toml"
DIRECTIONS = {"corner": (0.55, -1.0, 0.38), "front": (0, -1, 0), "side": (1, 0, 0), "top": (0, 0, 1)}
# ParaView's own sphere shader draws edges black, and many small black edges look like dirt.
SPHERE_SHADER = """//VTK::Color::Impl
float distance2 = dot(offsetVCVSOutput.xy, offsetVCVSOutput.xy);
if (distance2 > 1.0) discard;
float shade = 0.80 + 0.20 * sqrt(1.0 - distance2);
ambientColor *= shade;
diffuseColor *= shade;
"""


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and math.isfinite(value)


def numbers(count):
    return lambda value: isinstance(value, list) and len(value) == count and all(is_number(v) for v in value)


def direction(value):
    return numbers(3)(value) and any(value)


def color(value):
    return (isinstance(value, str) and len(value) == 7 and value[0] == "#"
            and all(c in "0123456789abcdefABCDEF" for c in value[1:]))


def either(words, rule):
    return lambda value: value in words if isinstance(value, str) else rule(value)


def table_of(rule):
    return lambda value: isinstance(value, dict) and all(rule(v) for v in value.values())


def at_least(bound, largest=math.inf):
    return lambda value: is_number(value) and bound <= value <= largest


def above_zero(value):
    return is_number(value) and value > 0


def whole(bound):
    return lambda value: isinstance(value, int) and not isinstance(value, bool) and value >= bound


def text(value):
    return isinstance(value, str) and value != ""


def truth(value):
    return isinstance(value, bool)


# The allowed values of each key, and their description in messages.
RULES = {
    "picture.size": (lambda v: numbers(2)(v) and all(isinstance(n, int) and 16 <= n <= 16384 for n in v),
                     "two whole numbers from 16 to 16384"),
    "picture.background": (lambda v: isinstance(v, list) and len(v) in (1, 2) and all(map(color, v)),
                           'a list of one or two colours "#rrggbb"'),
    "picture.text_color": (color, 'a colour "#rrggbb"'),
    "picture.title": (truth, "true or false"),
    "picture.time": (truth, "true or false"),
    "picture.text_scale": (above_zero, "a number above 0"),
    "picture.legend": (truth, "true or false"),
    "particles.representation": (lambda v: v in ("spheres", "surface"), '"spheres" or "surface"'),
    "particles.field": (text, "the name of a field"),
    "particles.component": (either(("magnitude",), whole(0)), '"magnitude" or the number of a component, from 0'),
    "particles.range": (either(("auto",), lambda v: numbers(2)(v) and v[0] < v[1]), '"auto" or two numbers, low and high'),
    "particles.colormap": (lambda v: text(v) or isinstance(v, list) and len(v) >= 2 and all(map(color, v)),
                           'the name of a ParaView preset, or a list of two or more colours "#rrggbb"'),
    "particles.radius": (above_zero, "a number above 0"),
    "surface.spacing": (at_least(0.25), "a number of at least 0.25"),
    "surface.smoothing": (at_least(0), "a number of at least 0"),
    "surface.passes": (whole(0), "a whole number"),
    "surface.gloss": (at_least(0, 1), "a number from 0 to 1"),
    "materials.palette": (lambda v: isinstance(v, list) and v and all(map(color, v)), 'a list of colours "#rrggbb"'),
    "materials.colors": (table_of(color), 'a table of names with colours "#rrggbb"'),
    "colliders.show": (truth, "true or false"),
    "colliders.color": (color, 'a colour "#rrggbb"'),
    "colliders.colors": (table_of(color), 'a table of names with colours "#rrggbb"'),
    "colliders.opacity": (at_least(0, 1), "a number from 0 to 1"),
    "colliders.opacities": (table_of(at_least(0, 1)), "a table of names with numbers from 0 to 1"),
    "colliders.hidden": (lambda v: isinstance(v, list) and all(map(text, v)), "a list of names"),
    "floor.show": (truth, "true or false"),
    "floor.color": (color, 'a colour "#rrggbb"'),
    "floor.grid": (truth, "true or false"),
    "floor.outline": (truth, "true or false"),
    "floor.margin": (at_least(0), "a number of at least 0"),
    "camera.fit": (lambda v: v in ("domain", "material"), '"domain" or "material"'),
    "camera.direction": (either(("auto", *DIRECTIONS), direction),
                         "auto, corner, front, side, top, or three numbers that are not all 0"),
    "camera.zoom": (above_zero, "a number above 0"),
    "camera.focus": (either(("auto",), numbers(3)), '"auto" or three numbers'),
    "camera.position": (either(("auto",), numbers(3)), '"auto" or three numbers'),
    "camera.up": (either(("auto",), direction), '"auto" or three numbers that are not all 0'),
    "camera.angle": (lambda v: is_number(v) and 0 < v < 170, "a number above 0 and below 170"),
    "light.direction": (either(("auto",), direction), '"auto" or three numbers that are not all 0'),
    "light.ambient": (at_least(0, 1), "a number from 0 to 1"),
    "light.shadows": (truth, "true or false"),
    "light.softness": (at_least(0, 45), "a number from 0 to 45"),
    "light.samples": (whole(1), "a whole number of at least 1"),
    "light.occlusion": (truth, "true or false"),
    "field_lines.show": (truth, "true or false"),
    "field_lines.count": (lambda v: whole(1)(v) and v <= 100, "a whole number from 1 to 100"),
    "field_lines.plane": (either(("auto",), lambda v: numbers(2)(v) and v[0] in (0, 1, 2)),
                          '"auto" or [axis, place], the axis 0, 1 or 2'),
    "field_lines.color": (color, 'a colour "#rrggbb"'),
    "field_lines.width": (above_zero, "a number above 0"),
    "crop.lower": (either(("none",), numbers(3)), '"none" or three numbers'),
    "crop.upper": (either(("none",), numbers(3)), '"none" or three numbers'),
}
SECTIONS = {key.split(".")[0] for key in RULES}


class Look:
    """The values by "section.key"."""

    def __init__(self):
        self.values = {}
        self.read(DEFAULTS)
        self.chosen = set()  # keys that a look file or the command line has set

    def __getitem__(self, key):
        return self.values[key]

    def read(self, path):
        try:
            tables = tomllib.loads(path.read_text(encoding="utf-8"))
        except OSError as error:
            fail(f"'{path}' cannot be read: {error.strerror}")
        except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
            fail(f"'{path}' is not TOML: {error}")
        for section, table in tables.items():
            if section not in SECTIONS:
                fail(f"{path}: there is no table '{section}'{nearest(section, SECTIONS)}")
            if not isinstance(table, dict):
                fail(f"{path}: '{section}' is a table, not a value")
            for name, value in table.items():
                self.put(f"{section}.{name}", value, f"{path}: ")

    def put(self, key, value, where):
        if key not in RULES:
            fail(f"{where}there is no key '{key}'{nearest(key, RULES)}")
        rule, meaning = RULES[key]
        if not rule(value):
            fail(f"{where}{key} is {value!r} and must be {meaning}")
        self.values[key] = value
        if hasattr(self, "chosen"):
            self.chosen.add(key)

    def set_text(self, assignment):
        """"section.key=value", as TOML or, failing that, as text."""
        key, equals, value = assignment.partition("=")
        if not equals:
            fail(f"--set {assignment}: is not KEY=VALUE")
        try:
            value = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            pass
        self.put(key.strip(), value, f"--set {assignment}: ")

    def check_together(self):
        lower, upper = self["crop.lower"], self["crop.upper"]
        if (lower == "none") != (upper == "none"):
            fail("crop.lower and crop.upper go together")
        if lower != "none" and not all(l < u for l, u in zip(lower, upper)):
            fail(f"crop.lower is {lower} and must be below crop.upper {upper} along every axis")

    def crop(self):
        return None if self["crop.lower"] == "none" else (self["crop.lower"], self["crop.upper"])


def nearest(name, known):
    found = difflib.get_close_matches(name, known, 1)
    return f"; did you mean '{found[0]}'?" if found else ""


def rgb(text_color):
    """Red, green, blue from 0 to 1."""
    return tuple(int(text_color[i:i + 2], 16) / 255.0 for i in (1, 3, 5))
