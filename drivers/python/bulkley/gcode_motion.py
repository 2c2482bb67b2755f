"""Key frames (t, x, y, z, e) of a print head that follows a path with bounded acceleration.

Along each line or arc the speed rises and falls evenly (a trapezoid); it is at most the feed and, on arcs, sqrt(acceleration radius).
Where two pieces meet, the velocity jumps by at most the corner speed. e follows the length of the path, so that the bead's
section de/dl stays constant through ramps; where filament has been drawn back e waits until it has come forward again:
e(t) = max of the programmed e up to t.
"""

import dataclasses
import math

import numpy as np


@dataclasses.dataclass
class Motion:
    """What the head does. `frames`: (n, 5), columns t [s], x, y, z [m], e [m^3]; between rows everything is linear."""
    frames: np.ndarray
    speed: float        # the largest, m/s
    flow: float         # the largest, m^3/s
    layers: int         # heights at which it extrudes while it moves


def corner_speed(before, after, jerk, acceleration):
    """Speed at which the head passes from one element to the next, m/s."""
    if not (before.moves and after.moves):
        return 0.0
    turn = math.dist(before.direction(True), after.direction(False))
    bound = min(peak(before, acceleration), peak(after, acceleration))
    return bound if turn * bound <= jerk else jerk / turn


def peak(element, acceleration):
    """The largest speed on an element by itself."""
    return min(element.feed, math.sqrt(acceleration * element.radius)) if element.angle else element.feed


def end_speeds(elements, acceleration, jerk):
    """Speeds at the ends of elements, (n + 1,): first those of corners, then what can be reached forwards and braked to."""
    speeds = [0.0, *(corner_speed(a, b, jerk, acceleration) for a, b in zip(elements, elements[1:])), 0.0]
    for order in (range(len(elements)), reversed(range(len(elements)))):
        for k in order:
            reach = 2.0 * acceleration * elements[k].length
            speeds[k + 1] = min(speeds[k + 1], math.sqrt(speeds[k] ** 2 + reach))
            speeds[k] = min(speeds[k], math.sqrt(speeds[k + 1] ** 2 + reach))
    return speeds


def ramps(element, start, end, acceleration):
    """Phases of an element: [(duration, start speed, end speed)]."""
    fast = min(peak(element, acceleration), math.sqrt(acceleration * element.length + 0.5 * (start**2 + end**2)))
    fast = max(fast, start, end)
    up, down = (fast - start) / acceleration, (fast - end) / acceleration
    steady = element.length - 0.5 * up * (start + fast) - 0.5 * down * (fast + end)
    phases = [(up, start, fast), (max(steady, 0.0) / fast, fast, fast), (down, fast, end)]
    return [phase for phase in phases if phase[0] > 0.0]


def chord_length(element, tolerance):
    """Largest length of the path between key frames for which chords stay within the tolerance of an arc."""
    if not element.angle:
        return math.inf
    return element.radius * 2.0 * math.acos(max(1.0 - tolerance / element.radius, 0.0)) * element.length / (
        abs(element.angle) * element.radius)


def times_on(element, start, end, acceleration, tolerance, highest):
    """[(t, s)] of the key frames on an element, s along it, its end included. `highest`: e that has been reached before."""
    found, t, s = [], 0.0, 0.0
    wanted = []
    chord = chord_length(element, tolerance)
    if math.isfinite(chord):
        n = math.ceil(element.length / chord - 1e-9)
        wanted = [element.length * k / n for k in range(1, n)]
    if element.e_start < highest < element.e_end:  # drawn-back filament has come forward
        wanted.append(element.length * (highest - element.e_start) / (element.e_end - element.e_start))
    for duration, v0, v1 in ramps(element, start, end, acceleration):
        slope, length = (v1 - v0) / duration, 0.5 * duration * (v0 + v1)
        parts = max(1, math.ceil(duration * math.sqrt(abs(slope) / (8.0 * tolerance)) - 1e-9))
        stops = [duration * k / parts for k in range(1, parts + 1)]
        for at in wanted:
            if s < at < s + length:
                stops.append(2.0 * (at - s) / (v0 + math.sqrt(max(v0 * v0 + 2.0 * slope * (at - s), 0.0))))
        found += [(t + tau, s + tau * (v0 + 0.5 * slope * tau)) for tau in sorted(stops)]
        t, s = t + duration, s + length
    found[-1] = (found[-1][0], element.length)
    return found


def follow(elements, acceleration, jerk, tolerance):
    """The motion along elements of gcode_reader. `acceleration` m/s^2, `jerk`: velocity jump at corners, m/s; `tolerance`:
    how far linear motion between key frames may be from the path and its ramps, m."""
    speeds = end_speeds(elements, acceleration, jerk)
    highest = elements[0].e_start
    first = highest
    rows = [(0.0, *elements[0].start, 0.0)]
    fastest, flow, heights = 0.0, 0.0, set()
    for k, element in enumerate(elements):
        begin = rows[-1][0]
        if element.length == 0.0:
            if element.wait > 0.0:
                rows.append((begin + element.wait, *element.end, highest - first))
            continue
        section = (element.e_end - element.e_start) / element.length
        for t, s in times_on(element, speeds[k], speeds[k + 1], acceleration, tolerance, highest):
            if begin + t > rows[-1][0]:
                at = element.e_end if s == element.length else element.e_start + section * s
                rows.append((begin + t, *element.point(s), max(highest, at) - first))
        top = max(v for _, *pair in ramps(element, speeds[k], speeds[k + 1], acceleration) for v in pair)
        if element.moves:
            fastest = max(fastest, top)
        if element.e_end > highest:
            flow = max(flow, section * top)
            if element.moves:
                heights.add(round(element.end[2], 7))
        highest = max(highest, element.e_end)
    return Motion(np.array(rows), fastest, flow, len(heights))
