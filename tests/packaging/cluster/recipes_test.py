#!/usr/bin/env python3
"""The recipes in cluster/ agree with CMakeLists.txt: its version, every package it looks for, in a version that it takes,
its options, and where it installs things. No Spack, EasyBuild, Apptainer, podman, debhelper or Lmod is needed: stand-ins for these read them.
Usage: recipes_test.py ROOT"""

import pathlib
import re
import shutil
import subprocess
import sys
import types

BUILD_FILES = ("CMakeLists.txt", "cluster/packaging/cmake/BulkleyDependencies.cmake", "cluster/packaging/cmake/Install.cmake")

# What CMakeLists.txt looks for -> its name in Spack and in EasyBuild; None: part of the toolchain.
PACKAGES = {"PkgConfig": ("pkgconfig", "pkgconf"), "MPI": ("mpi", None), "PETSc": ("petsc", "PETSc"),
            "HDF5": ("hdf5", "HDF5"), "Eigen3": ("eigen", "Eigen"), "fmt": ("fmt", "fmt"),
            "tomlplusplus": ("tomlplusplus", "tomlplusplus"),
            "CLI11": ("cli11", "CLI11"), "nlohmann_json": ("nlohmann-json", "nlohmann_json"),
            "muparser": ("muparser", "muParser"), "ZLIB": ("zlib-api", "zlib"),
            "metis": ("metis", "METIS"), "cmake": ("cmake", "CMake")}
# And in Debian, where petsc-dev brings MPI and HDF5.
DEBIAN = {"PkgConfig": "pkg-config", "MPI": "petsc-dev", "PETSc": "petsc-dev", "HDF5": "petsc-dev", "Eigen3": "libeigen3-dev",
          "fmt": "libfmt-dev", "tomlplusplus": "libtomlplusplus-dev", "CLI11": "libcli11-dev",
          "nlohmann_json": "nlohmann-json3-dev", "muparser": "libmuparser-dev", "ZLIB": "zlib1g-dev", "metis": "libmetis-dev",
          "cmake": "cmake"}
PLACES = {"BULKLEY_SHARE": "share/bulkley", "BULKLEY_SCRIPTS": "share/bulkley/jobs"}
faults = []


def expect(holds, sentence):
    if not holds:
        faults.append(sentence)


def numbers(version):
    return tuple(int(word) for word in version.split("."))


def requirements(text):
    """Package -> least version, or none, as CMakeLists.txt asks for them."""
    found = dict(re.findall(r"^(cmake)_minimum_required\(VERSION ([\d.]+)", text, re.MULTILINE))
    for name, version in re.findall(r"^find_package\((\w+) ?([\d.]*)", text, re.MULTILINE):
        found[name] = version
    by_pkg_config = r"^pkg_check_modules\(\w+ REQUIRED IMPORTED_TARGET (\w+)(?:>=([\d.]+))?"
    for name, version in re.findall(by_pkg_config, text, re.MULTILINE):
        found[name] = version
    for name in re.findall(r"^ *find_library\(\w+ (\w+)", text, re.MULTILINE):
        found[name] = ""
    for name in set(found) - set(PACKAGES):
        sys.exit(f"CMakeLists.txt looks for {name}: add it to PACKAGES here, and to the recipes")
    return found


# --- Spack ------------------------------------------------------------------------------------------------------------

def read_spack(path):
    """The class in the recipe, and its dependencies as name -> spec, by a stand-in for what spack.package offers."""
    dependencies, versions = {}, []

    class Context:
        def __enter__(self):
            return self

        def __exit__(self, *_):
            return False

    def depends_on(spec, **_):
        dependencies[re.match(r"[\w-]+", spec).group()] = spec

    def decorator(*_, **__):
        return lambda function: function

    module = types.ModuleType("spack.package")
    offers = {"CMakePackage": type("CMakePackage", (), {"define": lambda self, key, value: f"-D{key}={value}"}),
              "depends_on": depends_on, "version": lambda text, **_: versions.append(text), "when": lambda _: Context(),
              "run_after": decorator, "on_package_attributes": decorator, "join_path": lambda *parts: "/".join(parts),
              **{name: lambda *_, **__: None for name in ("license", "variant", "conflicts", "Executable")}}
    module.__dict__.update(offers, __all__=list(offers))
    sys.modules["spack"], sys.modules["spack.package"] = types.ModuleType("spack"), module
    names = {}
    exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), names)
    return names["Bulkley"], dependencies, versions


def check_spack(path, version, required):
    recipe, dependencies, versions = read_spack(path)
    expect(versions == [version], f"{path}: versions {versions}, the project has {version}")
    for package, least in required.items():
        name = PACKAGES[package][0]
        expect(name in dependencies, f"{path}: does not depend on {name}, which CMakeLists.txt looks for")
        asked = re.search(r"@([\d.]+)", dependencies.get(name, ""))
        if least:
            expect(asked and numbers(asked.group(1)) >= numbers(least), f"{path}: takes {name} older than {least}")
    for name, words in (("petsc", ["~complex", "+mpi", "+hdf5"]), ("hdf5", ["+mpi"])):
        spec = dependencies.get(name, "").split()
        expect(all(word in spec for word in words), f"{path}: {name} must be {' '.join(words)}")
    expect(recipe().url_for_version(version).endswith(f"/bulkley-{version}.tar.gz"), f"{path}: another archive")
    return recipe().cmake_args()


# --- EasyBuild, Apptainer ---------------------------------------------------------------------------------------------

def check_easybuild(path, version, required):
    recipe = {}
    exec(compile(path.read_text(encoding="utf-8"), str(path), "exec"), recipe)
    chain = recipe["toolchain"]
    expect(recipe["version"] == version, f"{path}: version {recipe['version']}, the project has {version}")
    name = f"bulkley-{version}-{chain['name']}-{chain['version']}.eb"
    expect(path.name == name, f"{path}: EasyBuild wants the name {name}")
    found = dict([*recipe["builddependencies"], *recipe["dependencies"]])
    for package, least in required.items():
        name = PACKAGES[package][1]
        expect(name is None or name in found, f"{path}: does not depend on {name}, which CMakeLists.txt looks for")
        if least and name in found:
            expect(numbers(found[name]) >= numbers(least), f"{path}: {name} {found[name]} is older than {least}")
    for key, place in PLACES.items():
        expect(recipe["modextravars"].get(key) == f"%(installdir)s/{place}", f"{path}: {key} is not {place}")
    return recipe["configopts"].split()


def check_apptainer(path, version, root):
    text = path.read_text(encoding="utf-8")
    sections = dict(re.findall(r"^%(\w+)[^\n]*\n(.*?)(?=^%|\Z)", text, re.MULTILINE | re.DOTALL))
    expect(f"VERSION={version}\n" in sections["arguments"], f"{path}: another version than {version}")
    for name in ("post", "environment", "test", "runscript"):
        outcome = subprocess.run(["bash", "-n"], input=sections[name].replace("{{ VERSION }}", version), text=True,
                                 capture_output=True)
        expect(outcome.returncode == 0, f"{path}: %{name}: {outcome.stderr}")
    for script in re.findall(r"cluster/\w+\.sh", sections["post"]):
        expect((root / script).exists(), f"{path}: there is no {script}")
    for key, place in PLACES.items():
        expect(f"export {key}=/usr/local/{place}\n" in sections["environment"], f"{path}: {key} is not {place}")
    return re.findall(r"-D\w+=\w+", sections["post"])


# --- container --------------------------------------------------------------------------------------------------------

def check_container(path, version, root):
    text = path.read_text(encoding="utf-8")
    expect(f"ARG VERSION={version}\n" in text, f"{path}: another version than {version}")
    scripts = re.findall(r"cluster/[\w/]+\.sh", text)
    expect(len(scripts) > 2, f"{path}: no scripts that build the packages")
    for script in scripts:
        expect((root / script).exists(), f"{path}: there is no {script}")
    settings = (root / "cluster/environment.sh").read_text(encoding="utf-8")
    wanted = re.findall(r"\b(?:OMPI|OPENBLAS|OMP)_\w+=\w+", settings)
    expect(wanted, "cluster/environment.sh: no settings")
    for setting in wanted:
        expect(setting in text, f"{path}: does not set {setting}, as cluster/environment.sh does")


# --- Debian -----------------------------------------------------------------------------------------------------------

def read_control(path):
    """Paragraphs of debian/control, each as field -> text, by the package's name; the first one is "Source"."""
    paragraphs = {}
    for paragraph in path.read_text(encoding="utf-8").strip().split("\n\n"):
        fields = dict(re.findall(r"^([\w-]+):\s*(.*(?:\n[ \t].*)*)", paragraph, re.MULTILINE))
        paragraphs[fields.get("Package", "Source")] = fields
    return paragraphs


def relations(text):
    """Package -> least version, or none."""
    return dict(re.match(r"([\w.+${}:-]+)(?: \([>=]+ (?:\d+:)?([^)]+)\))?$", word.strip()).groups("") for word in text.split(","))


def check_debian(folder, version, required, needed_by_library, root):
    path = folder / "control"
    control = read_control(path)
    script = (root / "cluster/install_packages.sh").read_text(encoding="utf-8")
    lists = re.findall(r"^(?:program|debian)=\(([^)]*)\)", re.sub(r"#.*", "", script), re.MULTILINE)  # of --deb
    installed = set(" ".join(lists).split())
    builds, library = relations(control["Source"]["Build-Depends"]), relations(control["libbulkley-dev"]["Depends"])
    for name in {"build-essential", *(name.removesuffix("-compat") for name in builds)} - installed:
        expect(False, f"{path}: Build-Depends: {name}, which cluster/install_packages.sh does not install")
    for package, least in required.items():
        name = DEBIAN[package]
        expect(name in installed, f"cluster/install_packages.sh does not install {name}, for {package}")
        for field, found in (("Build-Depends", builds), *([("libbulkley-dev", library)] if package in needed_by_library else [])):
            expect(name in found, f"{path}: {field}: no {name}, which CMake looks for as {package}")
            if least and name in found:
                expect(found[name] and numbers(found[name]) >= numbers(least), f"{path}: {field}: {name} older than {least}")
    changes = (folder / "changelog").read_text(encoding="utf-8")
    expect(changes.startswith(f"bulkley ({version}-"), f"{folder / 'changelog'}: another version than {version}")
    licence = (root / "LICENSE").read_text(encoding="utf-8").split()
    words = (folder / "copyright").read_text(encoding="utf-8").replace("\n .\n", "\n\n").split()
    terms = licence[licence.index("Redistribution"):]
    expect(words[-len(terms):] == terms, f"{folder / 'copyright'}: other terms than LICENSE")
    return re.findall(r"-D\w+=\S+", (folder / "rules").read_text(encoding="utf-8"))


# --- module files -----------------------------------------------------------------------------------------------------

LUA = """
function pathJoin(a, b) return a .. "/" .. b end
function myModuleVersion() return "1" end
function whatis() end
function help() end
function prepend_path(name, value) print(name .. "=" .. value) end
function setenv(name, value) print(name .. "=" .. value) end
"""
TCL = """
proc module-info {args} { return bulkley/1 }
proc module-whatis {args} {}
proc conflict {args} {}
proc prepend-path {name value} { puts "$name=$value" }
proc setenv {name value} { puts "$name=$value" }
"""


def check_module(path, interpreters, prelude):
    interpreter = next(filter(None, map(shutil.which, interpreters)), None)
    if not interpreter:
        print(f"{path.name}: only looked through, for there is none of {', '.join(interpreters)}")
        text = path.read_text(encoding="utf-8")
        for key in PLACES:
            expect(len(re.findall(rf"^setenv\W+{key}\b", text, re.MULTILINE)) == 1, f"{path}: does not set {key}")
        return
    outcome = subprocess.run([interpreter, "-"] if "lua" in interpreter else [interpreter], capture_output=True, text=True,
                             input=prelude + path.read_text(encoding="utf-8"))
    said = dict(line.split("=", 1) for line in outcome.stdout.splitlines() if "=" in line)
    wanted = {key: f"/opt/bulkley/1/{place}" for key, place in {**PLACES, "PATH": "bin"}.items()}
    expect(not outcome.stderr and all(said.get(key) == value for key, value in wanted.items()), f"{path}: {outcome}")
    print(f"{path.name}: read by {interpreter}")


def main():
    root = pathlib.Path(sys.argv[1])
    cluster = root / "cluster" / "packaging"
    text = "".join((root / name).read_text(encoding="utf-8") for name in BUILD_FILES)
    version = re.search(r"project\(bulkley VERSION ([\d.]+)", text).group(1)
    required = requirements(text)
    arguments = check_spack(cluster / "spack" / "package.py", version, required)
    for recipe in (cluster / "easybuild").glob("*.eb"):
        arguments += check_easybuild(recipe, version, required)
    arguments += check_apptainer(cluster / "apptainer" / "bulkley.def", version, root)
    check_container(cluster / "container" / "Containerfile", version, root)
    library = set(requirements((cluster / "cmake" / "BulkleyDependencies.cmake").read_text(encoding="utf-8")))
    arguments += check_debian(cluster / "debian", version, required, library, root)
    for option in re.findall(r"-D(BULKLEY_\w+)=", " ".join(arguments)):
        expect(re.search(rf"^(?:option|set)\({option} ", text, re.MULTILINE), f"CMakeLists.txt has no option {option}, which a recipe sets")
    expect(re.search(r"install\([^)]*cluster/jobs/job_functions.sh[^)]*/bulkley/jobs\)", text),
           "cluster/packaging/cmake/Install.cmake does not install job_functions.sh")
    check_module(cluster / "modulefiles" / "bulkley.lua", ["lua", "lua5.4", "lua5.3"], LUA)
    check_module(cluster / "modulefiles" / "bulkley.tcl", ["tclsh", "tclsh8.6"], TCL)
    sys.exit("\n".join(faults) if faults else 0)


if __name__ == "__main__":
    main()
