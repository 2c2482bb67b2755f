"""Small meshes and the files that hold them, for tests."""

import math
import struct

CUBE_VERTICES = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
CUBE_FACES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def single(value):
    """The nearest number of single precision: what binary files hold."""
    return struct.unpack("<f", struct.pack("<f", value))[0]


def torus(around=40, across=24, radius=1.0, thickness=0.4):
    """Vertices and quadrilaterals."""
    vertices = []
    for i in range(around):
        for j in range(across):
            a, b = 2 * math.pi * i / around, 2 * math.pi * j / across
            ring = radius + thickness * math.cos(b)
            vertices.append(tuple(single(x) for x in (ring * math.cos(a), ring * math.sin(a), thickness * math.sin(b))))
    faces = [(i * across + j, (i + 1) % around * across + j, (i + 1) % around * across + (j + 1) % across,
              i * across + (j + 1) % across) for i in range(around) for j in range(across)]
    return vertices, faces


def triangles_of(faces):
    return [(face[0], face[n], face[n + 1]) for face in faces for n in range(1, len(face) - 1)]


def line(values):
    return " ".join(repr(value) for value in values)


def write_obj(path, vertices, faces):
    lines = [f"v {line(v)}" for v in vertices] + ["f " + " ".join(str(n + 1) for n in face) for face in faces]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")


def write_stl_ascii(path, vertices, faces):
    lines = ["solid mesh"]
    for triangle in triangles_of(faces):
        corners = [f"vertex {line(vertices[n])}" for n in triangle]
        lines += ["facet normal 0 0 0", "outer loop", *corners, "endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid mesh"]) + "\n", encoding="utf-8")


def write_stl_binary(path, vertices, faces):
    triangles = triangles_of(faces)
    data = b"binary".ljust(80, b"\0") + struct.pack("<I", len(triangles))
    for triangle in triangles:
        data += struct.pack("<12f", 0, 0, 0, *[x for n in triangle for x in vertices[n]]) + b"\0\0"
    path.write_bytes(data)


def ply_header(kind, vertices, faces):
    properties = "".join(f"property float {axis}\n" for axis in "xyz")
    return (f"ply\nformat {kind} 1.0\nelement vertex {len(vertices)}\n{properties}element face {len(faces)}\n"
            "property list uchar int vertex_indices\nend_header\n")


def write_ply_ascii(path, vertices, faces):
    lines = [line(v) for v in vertices] + [line((len(face), *face)) for face in faces]
    path.write_text(ply_header("ascii", vertices, faces) + "\n".join(lines) + "\n", encoding="utf-8")


def write_ply_binary(path, vertices, faces):
    data = b"".join(struct.pack("<3f", *v) for v in vertices)
    data += b"".join(struct.pack(f"<B{len(face)}i", len(face), *face) for face in faces)
    path.write_bytes(ply_header("binary_little_endian", vertices, faces).encode() + data)
