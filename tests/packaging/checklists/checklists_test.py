#!/usr/bin/env python3
"""docs/checklists.md: does a law, a derived field and a face kind need the files that the page names, and no others?

Copies the sources, adds a toy of each in exactly the files of the page's numbered lists, builds the library without MPI there,
without optimisation, and runs a program that uses the three through a scene (toy_check.cpp).
"""

import argparse
import os
import re
import subprocess
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[2]


def files_of(page, section):
    """The files of the numbered list of a section, in order."""
    match = re.search(rf"^## {re.escape(section)}\n(.*?)(?=^## |\Z)", page, re.M | re.S)
    if not match:
        sys.exit(f"docs/checklists.md has no section '{section}'")
    return re.findall(r"^\d+\. `([^`]+)`:", match.group(1), re.M)


def insert(text, anchor, addition, before=False):
    """`addition` behind (or before) the first place of `anchor`."""
    if anchor not in text:
        sys.exit(f"the toy does not fit: '{anchor}' is not there any more")
    return text.replace(anchor, addition + anchor if before else anchor + addition, 1)


def toy_law_header(_):
    return (HERE / "toy_law.hpp").read_text(encoding="utf-8")


def toy_law_source(_):
    return (HERE / "toy_law.cpp").read_text(encoding="utf-8")


def toy_in_the_list(text):
    text = insert(text, '#include "material/laws/thixotropic.hpp"\n', '#include "material/laws/toy_law.hpp"\n')
    return insert(text, "AddedLaw>;", "ToyLaw, ", before=True)


def toy_field(text):
    text = insert(text, "constexpr DerivedField table[] = {", "void toy(const Place& at, double* out) { "
                  "out[0] = 2.0 * at.particles.mass(at.p); }\n\n", before=True)
    return insert(text, "constexpr DerivedField table[] = {\n", '    {"toy_field", "kg", "twice the mass", 1, false, toy},\n')


def toy_face(text):
    text = insert(text, "periodic, outflow, open", ", toy_face")
    return insert(text, ".crossing = Crossing::refused},\n", """\
    FaceBehaviour{.kind = FaceKind::toy_face,
                  .name = "toy_face",
                  .meaning = "a wall with friction that slides",
                  .contact = Contact::separating,
                  .behind = NodesBehind::free,
                  .crossing = Crossing::held,
                  .has_friction = true,
                  .has_velocity = true},
""")


TOYS = {
    "A law": {"src/material/laws/LAW.hpp": toy_law_header, "src/material/laws/LAW.cpp": toy_law_source,
              "src/material/material.hpp": toy_in_the_list},
    "A derived field": {"src/kernel/derived_fields.cpp": toy_field},
    "A face kind": {"src/grid/face.hpp": toy_face},
}


def tracked_files():
    """The files that git tracks or would track, without tests and pages, by name."""
    names = subprocess.run(["git", "ls-files", "--cached", "--others", "--exclude-standard", "-z", "CMakeLists.txt", "src", "include",
                            "drivers", "cluster", "README.md", "LICENSE", "CHANGELOG.md"],
                           cwd=ROOT, check=True, capture_output=True, text=True).stdout.split("\0")
    files = {name: (ROOT / name).read_bytes() for name in names if name and (ROOT / name).is_file()}
    if not files:
        sys.exit("git lists no files: this test needs a clone")
    return files


def add_toys(files):
    page = (ROOT / "docs/checklists.md").read_text(encoding="utf-8")
    for section, edits in TOYS.items():
        listed = files_of(page, section)
        if listed != list(edits):
            sys.exit(f"docs/checklists.md, '{section}' names {listed}; the toy needed {list(edits)}")
        for name, edit in edits.items():
            target = name.replace("LAW", "toy_law")
            files[target] = edit(files.get(target, b"").decode()).encode()


def write(files, folder):
    """The files and nothing else; unchanged ones stay as they are, so that a second run compiles little."""
    for old in [path for path in folder.rglob("*") if path.is_file() and path.relative_to(folder).as_posix() not in files]:
        old.unlink()
    for name, content in files.items():
        target = folder / name
        if not target.is_file() or target.read_bytes() != content:
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(content)


def cache_of(build):
    """What the existing build was configured with."""
    wanted = ("CMAKE_CXX_COMPILER", "CMAKE_C_COMPILER", "CMAKE_CXX_COMPILER_LAUNCHER", "CMAKE_PREFIX_PATH", "CMAKE_GENERATOR",
              "CMAKE_MAKE_PROGRAM")
    found = dict(re.findall(r"^(\w+):\w+=(.*)$", (build / "CMakeCache.txt").read_text(encoding="utf-8"), re.M))
    return {name: found[name] for name in wanted if found.get(name)}


def run(command):
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: exit code {done.returncode}\n{done.stdout[-6000:]}\n{done.stderr[-6000:]}")
    return done.stdout


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--build", type=Path, required=True)
    parser.add_argument("--work", type=Path, required=True)
    options = parser.parse_args()
    sources, build = options.work / "sources", options.work / "build"
    files = tracked_files()
    add_toys(files)
    # The program that uses the toys is built beside the library, by lines at the end of the copy's list.
    files["CMakeLists.txt"] += (f"\nadd_executable(toy_check {HERE / 'toy_check.cpp'})\n"
                                "target_link_libraries(toy_check PRIVATE bulkley_core)\n").encode()
    write(files, sources)
    cache = cache_of(options.build)
    generator = cache.pop("CMAKE_GENERATOR", "Ninja")
    run(["cmake", "-S", sources, "-B", build, "-G", generator, "-DCMAKE_BUILD_TYPE=None", "-DCMAKE_CXX_FLAGS=-O0",
         "-DBULKLEY_TESTS=OFF", "-DBULKLEY_NATIVE=OFF", *(f"-D{name}={value}" for name, value in cache.items())])
    run(["cmake", "--build", build, "--target", "toy_check", "--parallel", str(min(2, os.cpu_count() or 1))])
    print(run([build / "toy_check"]), end="")


if __name__ == "__main__":
    main()
