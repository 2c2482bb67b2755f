"""Closed surfaces of triangles that tools are put together from, and the files they are written to."""

import collections
import pathlib

import numpy as np

from bulkley.faults import DataError


class Surface:
    """Polygons that share vertices: points that agree to a billionth of a metre are one. Outward normals by the right hand."""

    def __init__(self):
        self.points, self.numbers, self.triangles = [], {}, []

    def vertex(self, point):
        key = tuple(round(float(v) * 1e9) for v in point)
        if key not in self.numbers:
            self.numbers[key] = len(self.points)
            self.points.append(tuple(float(v) for v in point))
        return self.numbers[key]

    def polygon(self, points):
        """A convex polygon, as a fan from its first point; corners that coincide make no triangle."""
        corners = [self.vertex(point) for point in points]
        for a, b in zip(corners[1:], corners[2:]):
            if len({corners[0], a, b}) == 3:
                self.triangles.append((corners[0], a, b))

    def strip(self, left, right):
        """The surface between two lines of points that run the same way, the normal towards the viewer who sees `left` on the
        left and the lines going up; the triangle that ends earlier by its share of the line comes first."""
        i, j = 0, 0
        while i + 1 < len(left) or j + 1 < len(right):
            if j + 1 == len(right) or (i + 1 < len(left) and (i + 1) * (len(right) - 1) <= (j + 1) * (len(left) - 1)):
                self.polygon((left[i], right[j], left[i + 1]))
                i += 1
            else:
                self.polygon((left[i], right[j], right[j + 1]))
                j += 1

    def arrays(self):
        """Vertices (n, 3) in m and triangles (m, 3)."""
        return np.array(self.points), np.array(self.triangles)


def volume(points, triangles):
    """By the divergence theorem, m^3; positive if normals point outwards."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0


def faults(triangles):
    """Directed edges that do not occur exactly once with exactly one in the other direction: none in a closed manifold."""
    edges = collections.Counter((int(t[k]), int(t[(k + 1) % 3])) for t in triangles for k in range(3))
    return [edge for edge, count in edges.items() if count != 1 or edges[edge[1], edge[0]] != 1]


def genus(points, triangles):
    """Number of handles of one closed surface, by Euler's formula."""
    return (2 - (len(points) - 3 * len(triangles) // 2 + len(triangles))) // 2


def write(file, points, triangles):
    """Writes an STL (binary), OBJ or PLY file by its suffix. Raises DataError."""
    file = pathlib.Path(file)
    corners = points[triangles].astype("<f4")
    lines = [" ".join(f"{v:.9g}" for v in point) for point in points]
    suffix = file.suffix.lower()
    if suffix == ".stl":
        rows = np.zeros(len(triangles), dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("rest", "<u2")])
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        rows["normal"] = normals / np.maximum(np.linalg.norm(normals, axis=1), 1e-30)[:, None]
        rows["corners"] = corners
        data = b"bulkley tool-mesh".ljust(80) + np.uint32(len(triangles)).tobytes() + rows.tobytes()
    elif suffix == ".obj":
        data = "".join([f"v {line}\n" for line in lines] + ["f {} {} {}\n".format(*(t + 1)) for t in triangles]).encode()
    elif suffix == ".ply":
        head = (f"ply\nformat ascii 1.0\nelement vertex {len(points)}\nproperty double x\nproperty double y\nproperty double z\n"
                f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n")
        data = (head + "".join([f"{line}\n" for line in lines] + ["3 {} {} {}\n".format(*t) for t in triangles])).encode()
    else:
        raise DataError(f"'{file}' ends in '{file.suffix}': give .stl, .obj or .ply")
    try:
        file.write_bytes(data)
    except OSError as error:
        raise DataError(f"cannot write '{file}': {error}") from None
