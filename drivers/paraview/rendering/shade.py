"""Light and soft shadows, computed here and baked into colours.

Debian's ParaView has no ray tracing, and VTK's shadow maps are hard-edged and do not reach Point Gaussians. So the light is
sampled at a few points; for each of them a height map of everything, seen from there, tells what lies in shadow, and the mean
over the samples is soft: sharp where things touch, wider farther away, as shadows of a light that is no point are.
"""

import math

import numpy

MOST_PIXELS = 1500  # of a height map, along its longer side


def unit(vector):
    vector = numpy.asarray(vector, float)
    return vector / numpy.linalg.norm(vector)


def directions(toward, softness, samples):
    """Unit vectors towards points of a light `softness` degrees in radius: a sunflower's seeds."""
    toward = unit(toward)
    side = unit(numpy.cross(toward, (1.0, 0.0, 0.0) if abs(toward[0]) < 0.9 else (0.0, 1.0, 0.0)))
    other = numpy.cross(toward, side)
    if softness == 0.0:
        return [toward]
    golden = math.pi * (3.0 - math.sqrt(5.0))
    reach = math.tan(math.radians(softness))
    return [unit(toward + reach * math.sqrt((i + 0.5) / samples)
                 * (math.cos(i * golden) * side + math.sin(i * golden) * other)) for i in range(samples)]


def thinned(points, size):
    """One point for each cube of the given size that holds any."""
    if len(points) == 0:
        return points
    place = numpy.floor((points - points.min(axis=0)) / size).astype(numpy.int64)
    extent = place.max(axis=0) + 1
    key = (place[:, 0] * extent[1] + place[:, 1]) * extent[2] + place[:, 2]
    return points[numpy.unique(key, return_index=True)[1]]


class Light:
    """`toward`: direction to the light. `casters`: points that throw shadows, closer together than `spacing`."""

    def __init__(self, look, toward, casters, spacing):
        self.toward = unit(toward)
        self.ambient = look["light.ambient"]
        self.maps = []
        if not look["light.shadows"] or len(casters) == 0:
            return
        reach = float(numpy.ptp(casters, axis=0).max())
        self.pixel = max(1.3 * spacing, reach / MOST_PIXELS)
        self.bias = 2.5 * self.pixel
        casters = thinned(casters, self.pixel)
        self.maps = [HeightMap(casters, d, self.pixel) for d in directions(toward, look["light.softness"],
                                                                          look["light.samples"])]

    def visible(self, points, normals=None):
        """The part of the light that each point sees, 0 to 1. Points without normals throw no shadows themselves."""
        if not self.maps or len(points) == 0:
            return numpy.ones(len(points), numpy.float32)
        if normals is None:
            hidden = sum(height_map.hidden(points, 0.3 * self.bias) for height_map in self.maps)
        else:
            hidden = sum(height_map.hidden(points + normals * self.pixel, self.bias) for height_map in self.maps)
        return (1.0 - hidden / len(self.maps)).astype(numpy.float32)

    def brightness(self, points, normals, camera=None):
        """What colours are multiplied with, and the highlight that `camera` sees on a glossy surface (without it: 0)."""
        toward = normals @ self.toward
        # What faces away is dark by its direction already; a shadow of its own would only show the pixels of the map.
        seen = numpy.ones(len(points), numpy.float32)
        facing = toward > -0.1
        seen[facing] = self.visible(points[facing], normals[facing])
        in_shadow = (1.0 - seen) * numpy.clip((toward + 0.1) / 0.4, 0.0, 1.0)
        # Light that reaches a little around the edge, as in a bright room.
        direct = numpy.clip((toward + 0.4) / 1.4, 0.0, 1.0) * (1.0 - in_shadow)
        sky = 0.85 + 0.15 * normals[:, 2]
        factor = self.ambient * sky + (1.0 - self.ambient) * 1.08 * direct
        if camera is None:
            return factor, 0.0
        half = unit_rows(unit_rows(camera - points) + self.toward)
        return factor, numpy.clip(numpy.sum(half * normals, axis=1), 0.0, 1.0) ** 40 * seen * (toward > 0.0)


def unit_rows(vectors):
    return vectors / numpy.maximum(numpy.linalg.norm(vectors, axis=1, keepdims=True), 1e-30)


class HeightMap:
    """How near to the light the casters reach, seen along one direction."""

    def __init__(self, casters, toward, pixel):
        side = unit(numpy.cross(toward, (1.0, 0.0, 0.0) if abs(toward[0]) < 0.9 else (0.0, 1.0, 0.0)))
        self.axes = numpy.stack([side, numpy.cross(toward, side), toward], axis=1).astype(numpy.float32)
        self.pixel = pixel
        seen = casters.astype(numpy.float32) @ self.axes
        self.lower = seen[:, :2].min(axis=0) - 3 * pixel
        self.shape = tuple(((seen[:, :2].max(axis=0) - self.lower) / pixel).astype(int) + 4)
        at = ((seen[:, :2] - self.lower) / pixel).astype(numpy.int64)
        order = numpy.argsort(seen[:, 2])  # of those in one pixel the last one written, the nearest to the light, stays
        heights = numpy.full(self.shape, -1e30, numpy.float32)
        heights[at[order, 0], at[order, 1]] = seen[order, 2]
        self.heights = widened(heights)

    def hidden(self, points, bias):
        """1 for points in full shadow, less at the rim of the pixels around."""
        seen = points.astype(numpy.float32) @ self.axes
        place = (seen[:, :2] - self.lower) / self.pixel - 0.5
        inside = numpy.all((place >= 0) & (place < numpy.array(self.shape) - 1), axis=1)
        result = numpy.zeros(len(points), numpy.float32)
        place, height = place[inside], seen[inside, 2]
        base = place.astype(numpy.int64)
        d = place - base
        first = base[:, 0] * self.shape[1] + base[:, 1]
        flat = self.heights.ravel()
        total = numpy.zeros(len(place), numpy.float32)
        for i in range(2):
            for j in range(2):
                above = flat[first + i * self.shape[1] + j] - height
                total += (numpy.abs(1 - i - d[:, 0]) * numpy.abs(1 - j - d[:, 1])
                          * numpy.clip(above / bias - 0.6, 0.0, 1.0))
        result[inside] = total
        return result


def widened(heights):
    """Each pixel with the largest value of the three by three around it: no light between neighbouring casters."""
    for axis in range(2):
        ahead, behind = numpy.roll(heights, 1, axis), numpy.roll(heights, -1, axis)  # the rim is empty, so it may wrap
        heights = numpy.maximum(heights, numpy.maximum(ahead, behind))
    return heights


def bytes_of(colors):
    return (numpy.clip(colors, 0.0, 1.0) * 255.0 + 0.5).astype(numpy.uint8)
