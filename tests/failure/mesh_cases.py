"""The failure cases of meshes: files that cannot be read or enclose nothing, and meshes of the wrong size."""

from cases import RUN, USAGE, Case
from mesh_files import CUBE_FACES, CUBE_VERTICES, write_obj, write_ply_ascii, write_ply_binary, write_stl_binary

BALL = 'shape = { type = "sphere", center = [0.08, 0.08, 0.05], radius = 0.03 }'
PLACE = "scene.toml:24:[0-9]+: mesh '/.*/"  # the key `file`, and a path that holds anywhere


def body(file, keys="size = 0.06, center = [0.08, 0.08, 0.05]"):
    return {BALL: f'shape = {{ type = "mesh", file = "{file}", {keys} }}'}


def text_file(name, text):
    return lambda folder, program, scene: (folder / name).write_text(text, encoding="utf-8")


def cube_file(name, write, vertices=CUBE_VERTICES, faces=CUBE_FACES):
    return lambda folder, program, scene: write(folder / name, vertices, faces)


def cut_off(name, write):
    def prepare(folder, program, scene):
        write(folder / name, CUBE_VERTICES, CUBE_FACES)
        data = (folder / name).read_bytes()
        (folder / name).write_bytes(data[: len(data) * 8 // 10])
    return prepare


def noise(folder, program, scene):
    (folder / "m.stl").write_bytes(bytes(range(7, 250)) * 9)


def unreadable(folder, program, scene):
    (folder / "m.obj").mkdir()


def moved(vertex, place):
    return [place if n == vertex else v for n, v in enumerate(CUBE_VERTICES)]


LINE = [(x, x, x) for x, y, z in CUBE_VERTICES]
COLLIDER = """
[[colliders]]
name = "sheet"
shape = { type = "mesh", file = "m.obj", scale = 0.01, center = [0.08, 0.08, 0.01] }
"""

MESH_CASES = [
    Case("mesh_missing", USAGE, PLACE + r"absent\.obj' does not exist", replace=body("absent.obj")),
    Case("mesh_is_a_folder", USAGE, PLACE + r"m\.obj' is a folder", replace=body("m.obj"), prepare=unreadable),
    Case("mesh_empty", USAGE, PLACE + r"m\.obj' is empty", replace=body("m.obj"), prepare=text_file("m.obj", "")),
    Case("mesh_of_words", USAGE, PLACE + r"m\.obj' cannot be read as a mesh", replace=body("m.obj"),
         prepare=text_file("m.obj", "not a mesh\n")),
    Case("mesh_of_noise", USAGE, PLACE + r"m\.stl' (cannot be read as a mesh|holds no triangle)", replace=body("m.stl"),
         prepare=noise),
    Case("mesh_wrong_extension", USAGE, PLACE + r"m\.txt' is none of the formats \.obj, \.stl and \.ply",
         replace=body("m.txt"), prepare=text_file("m.txt", "v 0 0 0\n")),
    Case("mesh_points_only", USAGE, PLACE + r"m\.obj' holds no triangle", replace=body("m.obj"),
         prepare=text_file("m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n")),
    Case("mesh_cut_off_ply", USAGE, PLACE + r"m\.ply' (cannot be read|holds only|has faces without vertices)",
         replace=body("m.ply"), prepare=cut_off("m.ply", write_ply_ascii)),
    Case("mesh_cut_off_binary_ply", USAGE, PLACE + r"m\.ply' (cannot be read|has faces without vertices|has a face)",
         replace=body("m.ply"), prepare=cut_off("m.ply", write_ply_binary)),
    Case("mesh_cut_off_stl", USAGE, PLACE + r"m\.stl' cannot be read as a mesh", replace=body("m.stl"),
         prepare=cut_off("m.stl", write_stl_binary)),
    Case("mesh_not_a_number", USAGE, PLACE + r"m\.ply' has 1 of 8 vertices with coordinates that are NaN or infinite",
         replace=body("m.ply"), prepare=cube_file("m.ply", write_ply_binary, moved(3, (0.0, float("nan"), 1.0)))),
    Case("mesh_infinite", USAGE, PLACE + r"m\.ply' has 1 of 8 vertices with coordinates that are NaN or infinite",
         replace=body("m.ply"), prepare=cube_file("m.ply", write_ply_binary, moved(3, (0.0, float("inf"), 1.0)))),
    Case("mesh_index_out_of_range", USAGE, PLACE + r"m\.ply' has a face with vertex 8, but only 8 vertices",
         replace=body("m.ply"), prepare=cube_file("m.ply", write_ply_ascii, faces=[*CUBE_FACES[1:], (0, 1, 8)])),
    Case("mesh_without_area", USAGE, PLACE + r"m\.obj' has 12 triangles, none of which has an area", replace=body("m.obj"),
         prepare=cube_file("m.obj", write_obj, LINE)),
    Case("mesh_flat", USAGE, PLACE + r"m\.obj' encloses nothing", replace=body("m.obj"),
         prepare=cube_file("m.obj", write_obj, faces=CUBE_FACES[4:5])),
    Case("mesh_flat_collider", USAGE, r"scene\.toml:\d+:\d+: mesh '/.*/m\.obj' encloses nothing", append=COLLIDER,
         prepare=cube_file("m.obj", write_obj, faces=CUBE_FACES[4:5])),
    Case("mesh_unknown_figure", USAGE, r"'builtin:cat' is no figure of the program; there are: builtin:hare, builtin:dragon",
         replace=body("builtin:cat")),
    Case("mesh_scale_and_size", USAGE, r"scene\.toml:24:\d+: .*scale",
         replace=body("builtin:hare", "size = 0.06, scale = 2")),
    Case("mesh_in_other_units", USAGE, r"body 'ball' reaches .* outside the domain .*its mesh is 6 m large.*'scale'",
         replace=body("builtin:hare", "size = 6")),
    Case("mesh_in_other_units_turned", USAGE, r"body 'ball' reaches .* outside .*its mesh is 6 m large.*'scale'",
         replace=body("builtin:hare", "size = 6, rotation = { angle = 30 }")),
    Case("mesh_of_too_many_particles", USAGE, r"body 'ball' would be filled with some \S+ particles; its mesh is 6e\+04 m",
         replace=body("builtin:hare", "size = 6e4")),
    Case("mesh_too_small", USAGE, r"body 'ball' is too small to hold a particle.*its mesh is 0\.0001 m large.*'scale'",
         replace=body("builtin:hare", "size = 1e-4, center = [0.08, 0.08, 0.05]")),
    Case("mesh_check", USAGE, PLACE + r"absent\.obj' does not exist", replace=body("absent.obj"),
         arguments=["check", "{scene}"]),
    Case("mesh_restart_without_collider", USAGE, r"m\.obj' does not exist", append=COLLIDER,
         arguments=[*RUN, "--restart"]),
]
