"""G-code read into a path: lines and arcs of a print head with what it extrudes along each, in SI units.

    G0 G1 X Y Z E F     line; a move of E alone is a path of its own length        G4 P S      wait (ms, s)
    G2 G3 X Y Z I J R   arc in the x-y plane, or helix                             G20 G21     inches, millimetres
    G90 G91             X, Y, Z absolute or relative                               M82 M83     E absolute or relative
    G92 X Y Z E         the head stays, its coordinates are these from now on

Comments (`;`, brackets), line numbers N and checksums are ignored, the codes in IGNORED are counted; everything else is refused.
"""

import dataclasses
import math
import re

from bulkley.faults import DataError

IGNORED = frozenset("M0 M1 M17 M18 M84 M104 M105 M106 M107 M109 M110 M115 M117 M140 M190 M201 M203 M204 M205 M221 M900".split())
WORDS = {"G0": "XYZEF", "G1": "XYZEF", "G2": "XYZEFIJR", "G3": "XYZEFIJR", "G4": "PS", "G20": "", "G21": "", "G90": "",
         "G91": "", "G92": "XYZE", "M82": "", "M83": ""}
WORD = re.compile(r"\s*([A-Za-z])\s*([-+]?(?:\d+\.?\d*|\.\d+))")
INCH, MILLIMETRE = 0.0254, 1e-3
RADIUS_SLACK = 1e-3  # largest relative difference of an arc's radius at its start and its end
AXES = "XYZ"


@dataclasses.dataclass
class Element:
    """A line, an arc, a move of E alone or a wait. Lengths in m (of E alone: of filament, or of a cube root of volume)."""
    line: int                   # of the file
    start: tuple                # (x, y, z), m
    end: tuple
    e_start: float              # programmed volume, m^3
    e_end: float
    length: float = 0.0         # of the path, m
    feed: float = 0.0           # speed along it, m/s
    wait: float = 0.0           # s, where there is no path
    center: tuple = ()          # of an arc, (x, y)
    angle: float = 0.0          # that it turns by, radians; positive: counter-clockwise

    @property
    def moves(self):
        return self.start != self.end or self.angle != 0.0

    def point(self, s):
        """Position at the length s of the path."""
        part = s / self.length if self.length > 0.0 else 1.0
        if not self.angle:
            return tuple(a + part * (b - a) for a, b in zip(self.start, self.end))
        x, y = self.start[0] - self.center[0], self.start[1] - self.center[1]
        c, n = math.cos(part * self.angle), math.sin(part * self.angle)
        return (self.center[0] + c * x - n * y, self.center[1] + n * x + c * y,
                self.start[2] + part * (self.end[2] - self.start[2]))

    def direction(self, at_end):
        """Unit tangent at the start or the end; (0, 0, 0) of what does not move."""
        if not self.moves:
            return (0.0, 0.0, 0.0)
        if not self.angle:
            return tuple((b - a) / self.length for a, b in zip(self.start, self.end))
        x, y, _ = self.end if at_end else self.start
        rate = self.angle / self.length
        return (-rate * (y - self.center[1]), rate * (x - self.center[0]), (self.end[2] - self.start[2]) / self.length)

    @property
    def radius(self):
        return math.hypot(self.start[0] - self.center[0], self.start[1] - self.center[1]) if self.angle else math.inf


def split_words(text):
    """The words of a line without comments: [(letter, number)]. Raises ValueError with the reason."""
    text = re.sub(r"\([^()]*\)", " ", text.split(";", 1)[0])
    if "(" in text or ")" in text:
        raise ValueError("a bracket of a comment is not closed")
    text = re.sub(r"\*\s*\d+\s*$", "", text)
    words, place = [], 0
    while text[place:].strip():
        match = WORD.match(text, place)
        if not match:
            raise ValueError(f"'{text[place:].strip()}' is not a letter with a number")
        words.append((match[1].upper(), float(match[2])))
        place = match.end()
    return [word for word in words if word[0] != "N"]


class Reader:
    """State of the machine while its lines are read."""

    def __init__(self, section):
        """`section`: area of the filament, m^2; None if E is volume in mm^3."""
        self.section = section
        self.unit, self.relative, self.relative_e = MILLIMETRE, False, False
        self.position = [None, None, None]  # m, of the machine; None where no line has said it yet
        self.offset = [0.0, 0.0, 0.0]       # machine less programmed coordinates, m
        self.e, self.e_offset = 0.0, 0.0    # m^3
        self.feed = None                    # units of F as they stand, per second
        self.elements, self.ignored = [], {}
        self.fed = 0.0                      # sum of all E words, m^3, retractions subtracted
        self.line = 0

    def read(self, number, text):
        """Reads one line. Raises ValueError with the reason."""
        self.line = number
        words = split_words(text)
        if not words:
            return
        letter, code = words[0]
        if letter not in "GM":
            raise ValueError(f"it begins with {letter}, not with a G or M code")
        name = f"{letter}{code:g}"
        if name in IGNORED:
            self.ignored[name] = self.ignored.get(name, 0) + 1
            return
        if name not in WORDS:
            raise ValueError(f"{name} is not known")
        given = {}
        for word, value in words[1:]:
            if word in "GM":
                raise ValueError(f"it has a second code, {word}{value:g}")
            if word not in WORDS[name]:
                raise ValueError(f"{name} takes no {word}")
            if word in given:
                raise ValueError(f"it has {word} twice")
            given[word] = value
        self.execute(name, given)

    def execute(self, name, given):
        if name in ("G20", "G21"):
            self.unit = INCH if name == "G20" else MILLIMETRE
        elif name in ("G90", "G91"):
            self.relative = name == "G91"
        elif name in ("M82", "M83"):
            self.relative_e = name == "M83"
        elif name == "G92":
            self.rename(given)
        elif name == "G4":
            self.wait(given)
        else:
            self.move(name, given)

    def volume(self, e):
        """Volume of an amount E, m^3."""
        if self.section is not None:
            return e * self.unit * self.section
        if self.unit != MILLIMETRE:
            raise ValueError("E in cubic inches is not known: with volumes E is in mm^3 (G21)")
        return e * 1e-9

    def rename(self, given):
        if not given:
            raise ValueError("G92 needs X, Y, Z or E")
        for axis, letter in enumerate(AXES):
            if letter in given:
                value = given[letter] * self.unit
                if self.position[axis] is None:
                    self.position[axis] = value
                self.offset[axis] = self.position[axis] - value
        if "E" in given:
            self.e_offset = self.e - self.volume(given["E"])

    def wait(self, given):
        if len(given) != 1:
            raise ValueError("G4 needs either P or S")
        seconds = given["S"] if "S" in given else 1e-3 * given["P"]
        if seconds < 0.0:
            raise ValueError("G4 waits a negative time")
        if None not in self.position:
            place = tuple(self.position)
            self.elements.append(Element(self.line, place, place, self.e, self.e, wait=seconds))

    def target(self, given):
        end = list(self.position)
        for axis, letter in enumerate(AXES):
            if letter not in given:
                continue
            value = given[letter] * self.unit
            if not self.relative:
                end[axis] = value + self.offset[axis]
            elif end[axis] is None:
                raise ValueError(f"{letter} is relative, but no line has said where the head is")
            else:
                end[axis] += value
        return end

    def move(self, name, given):
        if "F" in given:
            if given["F"] <= 0.0:
                raise ValueError("F must be above 0")
            self.feed = given["F"] * self.unit / 60.0
        end, e_end = self.target(given), self.e
        if "E" in given:
            e_end = self.volume(given["E"]) + (self.e if self.relative_e else self.e_offset)
        if None in self.position:  # the head appears where the first moves take it
            if e_end != self.e:
                raise ValueError("it extrudes before X, Y and Z are known")
            if name in ("G2", "G3"):
                raise ValueError("an arc begins before X, Y and Z are known")
            self.position = end
            return
        element = Element(self.line, tuple(self.position), tuple(end), self.e, e_end)
        if name in ("G2", "G3"):
            self.shape_arc(element, name == "G3", given)
        flat = abs(element.angle) * element.radius if element.angle else math.dist(element.start[:2], element.end[:2])
        element.length = math.hypot(flat, element.end[2] - element.start[2])
        element.feed = self.feed or 0.0
        if not element.moves and e_end != self.e:  # E alone: F is a speed of the filament, or mm^3 a minute
            element.length = abs(e_end - self.e) / (self.section if self.section is not None else 1e-6)
        self.fed += e_end - self.e
        self.position, self.e = end, e_end
        if element.length > 0.0:
            if self.feed is None:
                raise ValueError("it moves before any F has been given")
            self.elements.append(element)

    def shape_arc(self, element, counter_clockwise, given):
        """Centre and angle of an arc from I and J or from R."""
        (x0, y0, _), (x1, y1, _) = element.start, element.end
        chord = math.hypot(x1 - x0, y1 - y0)
        if ("R" in given) == ("I" in given or "J" in given):
            raise ValueError("an arc needs either R or I and J")
        if "R" in given:
            radius = given["R"] * self.unit
            if chord == 0.0:
                raise ValueError("an arc with R cannot end where it begins: use I and J")
            if 2.0 * abs(radius) < chord * (1.0 - RADIUS_SLACK):
                raise ValueError("R is less than half the distance to the end")
            height = math.sqrt(max(radius * radius - 0.25 * chord * chord, 0.0)) / chord
            side = 1.0 if counter_clockwise == (radius > 0.0) else -1.0  # the centre lies left of the chord
            element.center = (0.5 * (x0 + x1) - side * height * (y1 - y0), 0.5 * (y0 + y1) + side * height * (x1 - x0))
        else:
            element.center = (x0 + given.get("I", 0.0) * self.unit, y0 + given.get("J", 0.0) * self.unit)
        radius = math.dist(element.center, (x0, y0))
        if radius == 0.0:
            raise ValueError("the arc's radius is 0")
        if abs(math.dist(element.center, (x1, y1)) - radius) > RADIUS_SLACK * radius:
            raise ValueError("the arc's end is not as far from its centre as its start")
        turn = math.atan2(y1 - element.center[1], x1 - element.center[0]) - math.atan2(y0 - element.center[1],
                                                                                         x0 - element.center[0])
        turn %= 2.0 * math.pi
        if chord == 0.0:
            turn = 2.0 * math.pi if counter_clockwise else 0.0
        element.angle = turn if counter_clockwise else turn - 2.0 * math.pi


def read_program(text, section, name="G-code"):
    """Reads a program: `text`, the area of the filament in m^2 (None: E is mm^3), `name` for messages. Returns the Reader,
    which holds the elements. Raises DataError with the line."""
    reader = Reader(section)
    for number, line in enumerate(text.splitlines(), 1):
        try:
            reader.read(number, line)
        except ValueError as reason:
            raise DataError(f"'{name}', line {number}: {reason}") from None
    if not reader.elements:
        raise DataError(f"'{name}' moves nothing")
    return reader
