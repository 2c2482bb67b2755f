#!/usr/bin/env python3
"""Meshes as bodies and colliders: each file format gives the same particles, a run gives the same bits on 1, 2 and 3
ranks, and it goes on from a checkpoint by the scene in its output folder, without the mesh of its body."""

import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
import mesh_files  # noqa: E402
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENE = """
title = "a torus falls onto a hare"

[domain]
lower = [0.0, 0.0, 0.0]
upper = [0.64, 0.48, 0.48]
cell_size = 0.02

[time]
end = 1.0

[materials.rubber]
law = "neo_hookean"
density = 1000.0
bulk_modulus = 1.0e5
shear_modulus = 3.0e4

[[bodies]]
name = "torus"
material = "rubber"
velocity = [0.0, 0.0, -3.0]

[bodies.shape]
type = "mesh"
file = "files/torus.obj"
size = 0.3
center = [0.3, 0.22, 0.36]
rotation = { angle = 20, axis = [1, 0, 0], origin = [0.3, 0.22, 0.36] }

[[colliders]]
name = "hare"
shape = { type = "mesh", file = "builtin:hare", up = "y", size = 0.5, center = [0.32, 0.24, 0.04] }
contact = "separating"
friction = 0.3
"""
STEPS = 80
WRITERS = {"obj": mesh_files.write_obj, "ascii.stl": mesh_files.write_stl_ascii, "binary.stl": mesh_files.write_stl_binary,
           "ascii.ply": mesh_files.write_ply_ascii, "binary.ply": mesh_files.write_ply_binary}


class Test:
    def __init__(self, program, work):
        self.program = program
        self.work = work
        (work / "files").mkdir(parents=True, exist_ok=True)
        (work / "scene.toml").write_text(SCENE, encoding="utf-8")

    def run(self, scene, out, ranks, *more, steps=STEPS):
        outcome = self.program.run(["run", scene, "--out", out, "--max-steps", str(steps), *more], ranks, self.work, 200)
        if outcome.code != 0:
            fail(f"the run in {out} on {ranks} ranks ended with {outcome.code}", outcome)
        return outcome.text

    def expect_identical(self, one, other, what, step=STEPS):
        files = [f"{folder}/checkpoint_{step:09d}.h5" for folder in (one, other)]
        compare = self.program.run(["compare", *files], 1, self.work, 60)
        if compare.code != 0 or "identical" not in compare.text:
            fail(f"{what}: different", compare)
        print(f"{what}: identical")


def main():
    test = Test(*start(parse_arguments(__doc__)))
    for name, write in WRITERS.items():
        write(test.work / "files" / f"torus.{name}", *mesh_files.torus())
        test.run("scene.toml", name, 1, "--set", f"bodies.0.shape.file=files/torus.{name}", steps=1)
        test.expect_identical("obj", name, f"particles from torus.{name}", 1)

    check = test.program.run(["check", "scene.toml"], 1, test.work, 60)
    ratio = re.search(r"1920 triangles, closed, 1 component(?s:.*?)ratio ([0-9.]+)", check.text)
    if check.code != 0 or not ratio or abs(float(ratio[1]) - 1.0) > 0.05 or "collider 'hare'" not in check.text:
        fail("check does not say what it must of the meshes", check)

    test.run("scene.toml", "one", 1)
    for ranks in (2, 3):
        test.run("scene.toml", f"r{ranks}", ranks)
        test.expect_identical("one", f"r{ranks}", f"{ranks} ranks")

    # The effective scene names the files by absolute paths; a restart reads no mesh of a body.
    test.run("scene.toml", "parted", 2, steps=STEPS // 2)
    (test.work / "files" / "torus.obj").rename(test.work / "files" / "gone.obj")
    test.run("parted/scene.toml", "parted", 3, "--restart")
    test.expect_identical("one", "parted", "restarted without the body's mesh")


if __name__ == "__main__":
    main()
