#!/usr/bin/env python3
"""Rules of docs/architecture.md that a compiler does not enforce. Usage: check_style.py ROOT

Prints one line per fault, "file:line: sentence", and exits 1 if there is any.
"""

import pathlib
import re
import sys

# --- rule 1: a file includes only its own module and modules before it ---------------------------------------------------

# The folders of src in the order of docs/architecture.md; the library without MPI, PETSc and HDF5 ends with `scene`.
CORE_MODULES = ["base", "config", "geometry", "magnetics", "grid", "particle", "material", "kernel", "stepping", "balance", "rheometer",
                "scene"]
MODULES = CORE_MODULES + ["parallel", "distribution", "field", "magnetostatics", "integrator", "rebalance", "io", "simulation", "drivers"]
PARALLEL_HEADERS = re.compile(r"^(mpi\.h|petsc\w*\.h|hdf5\w*\.h|H5\w*\.h)$")

# --- rule 2: every call of MPI, PETSc or HDF5 is checked -----------------------------------------------------------------
# MPI and PETSc: inside the checking macro. HDF5: its result must at least be used, because a reader turns failures into
# sentences of its own; a call that is a statement by itself drops it.

CALL = re.compile(r"\b(MPI_[A-Z]\w*|Petsc[A-Z]\w*|DM[A-Z]\w*|Vec[A-Z]\w*|Mat[A-Z]\w*|KSP[A-Z]\w*|PC[A-Z]\w*|"
                  r"IS[A-Z][a-z]\w*|AO[A-Z][a-z]\w*|H5[A-Z]\w*)\s*\(")
CHECKING_MACRO = re.compile(r"\bBULKLEY_(MPI|PETSC|HDF5)\w*\s*$")
STATEMENT_START = re.compile(r"(^|[;{})]|\belse)\s*\Z")  # also after "(void)" and "if (...)"
# Calls without an error to check, and names that only look like calls.
NO_ERROR_TO_CHECK = {
    "MPI_Wtime": "returns the time",
    "MPI_Abort": "does not return",
    "PetscHandle": "a type of ours",
    "PetscErrorCode": "a type, in the signature of a function pointer",
    "VecHandle": "a type of ours",
    "PetscErrorsThrow": "a type of ours",
    "PetscPotential": "a type of ours",
    "PetscSolver": "a type of ours",
    "H5Eset_auto2": "sets up HDF5's own error reporting",
    "H5Ewalk2": "reads the stack of errors",
}
# The code that reports a failed call and ends all ranks cannot check its own calls that way. (file, name): why.
# An exception that nothing needs is a fault.
SITE_EXCEPTIONS = {
    ("src/parallel/comm.cpp", "MPI_Error_string"): "part of reporting a failed call",
    ("src/parallel/comm.cpp", "MPI_Initialized"): "part of ending all ranks",
    ("src/parallel/comm.cpp", "MPI_Finalized"): "part of ending all ranks",
    ("src/parallel/comm.cpp", "MPI_Comm_rank"): "part of ending all ranks",
    ("src/parallel/comm.cpp", "PETSC_COMM_WORLD"): "an abort must reach all ranks, whatever communicator is at hand",
    ("src/parallel/petsc.cpp", "PetscErrorMessage"): "part of reporting a failed call",
    ("drivers/program/version.cpp", "PetscGetVersion"): "compared by hand: a missing version text is no reason to end",
    ("drivers/program/version.cpp", "MPI_Get_library_version"): "compared by hand: a missing version text is no reason to end",
    ("drivers/program/program.cpp", "PetscInitialize"): "compared by hand: the macro's abort needs an initialised PETSc",
}

# --- the other rules ------------------------------------------------------------------------------------------------------

WORLD = re.compile(r"\b(MPI_COMM_WORLD|PETSC_COMM_WORLD)\b")
USING_NAMESPACE = re.compile(r"^using\s+namespace\b")  # not indented: at namespace scope; within a function it does no harm
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
LARGEST_FILE = 500
# Paths of one person's machine.
MACHINE_PATHS = re.compile(r"(?<![\w.])/(work|root|tmp/build_|home/[a-z])")
TEXT_FILES = {".hpp", ".cpp", ".h", ".c", ".py", ".sh", ".cmake", ".txt", ".md", ".toml", ".json", ".cff", ".in"}
FOLDERS = ["include", "src", "drivers", "tests", "cluster", "docs", ".ci", ".github"]

# --- the words of docs/glossary.md -----------------------------------------------------------------------------------------

GLOSSARY = pathlib.Path("docs/glossary.md")  # lists the retired words itself
HISTORY = pathlib.Path("CHANGELOG.md")  # what was said of past versions stays
WORD = re.compile(r"[A-Z]?[a-z]+")  # also the words of snake_case and CamelCase names
RETIRED_ROW = re.compile(r"^\| ([a-z ,]+) \| ([^|]+) \|$")
# Where retired words are still to be replaced: (file or folder, word). An exception that nothing needs is a fault.
WORD_EXCEPTIONS = set()


def without_comments(text):
    """`text` with comments and the contents of strings blanked out, line breaks kept."""
    comment, raw = r"//[^\n]*|/\*.*?\*/", r'R"\(.*?\)"'
    string, character = r'"(?:\\.|[^"\\\n])*"', r"(?<![0-9a-fA-F])'(?:\\.|[^'\\\n])'"  # not the ' between digits
    pattern = re.compile("|".join((comment, raw, string, character)), re.DOTALL)
    return pattern.sub(lambda match: re.sub(r"[^\n]", " ", match.group()), text)


def line_of(text, position):
    return text.count("\n", 0, position) + 1


def module_of(path):
    """Module of a source file given relative to the root: drivers, or its folder below src or include/bulkley."""
    parts = path.parts
    if parts[0] == "drivers":
        return "drivers"
    return header_module("/".join(parts[2:] if parts[0] == "include" else parts[1:]))


def header_module(name):
    """Module of a header given below src or include/bulkley. bulkley/program.hpp is the face of drivers/."""
    folder = name.split("/")[0]
    return "drivers" if folder in ("program.hpp", "program", "bench") else folder


def includes(text):
    for number, line in enumerate(text.splitlines(), 1):
        match = INCLUDE.match(line)
        if match:
            yield number, match.group(1)


def is_excepted(path, name, used_exceptions):
    used_exceptions.add((path.as_posix(), name))
    return (path.as_posix(), name) in SITE_EXCEPTIONS


def check_modules(path, text):
    module = module_of(path)
    if module not in MODULES:
        yield 1, f"is in no module of the list {', '.join(MODULES)}"
        return
    for line, header in includes(text):
        if PARALLEL_HEADERS.match(header) and module in CORE_MODULES:
            yield line, f"module '{module}' is built without MPI, PETSc and HDF5, and includes {header}"
        if header == "bulkley/version.hpp" or "/" not in header or not header.endswith(".hpp"):
            continue
        is_public = header.startswith("bulkley/")
        if path.parts[0] == "include" and not is_public and header_module(header) in MODULES:
            yield line, f"a public header includes the private {header}"
        other = header_module(header.removeprefix("bulkley/"))
        if other not in MODULES:
            if is_public:
                yield line, f"includes {header}, which is in no module"
        elif MODULES.index(other) > MODULES.index(module):
            yield line, f"module '{module}' includes {header} of the later module '{other}'"


def check_bare_calls(path, text, used_exceptions):
    code = without_comments(text)
    code = re.sub(r"^[ \t]*#[ \t]*define[^\n]*", lambda m: " " * len(m.group()), code, flags=re.MULTILINE)
    for match in CALL.finditer(code):
        name = match.group(1)
        if name in NO_ERROR_TO_CHECK or inside_checking_macro(code, match.start()):
            continue
        if name.startswith("H5"):
            if STATEMENT_START.search(code, max(0, match.start() - 200), match.start()):
                yield line_of(code, match.start()), f"the result of {name} is dropped"
        elif not is_excepted(path, name, used_exceptions):
            yield line_of(code, match.start()), f"{name} is called outside a checking macro such as BULKLEY_MPI(...)"


def inside_checking_macro(code, position):
    """Walks outwards through the parentheses that are open at `position`, up to the statement's start."""
    depth = 0
    for at in range(position - 1, -1, -1):
        character = code[at]
        if character == ")":
            depth += 1
        elif character == "(":
            if depth == 0 and CHECKING_MACRO.search(code, max(0, at - 40), at):
                return True
            depth = max(0, depth - 1)
        elif character in ";{}" and depth == 0:
            return False
    return False


def check_world(path, text, used_exceptions):
    if path.parts[0] in ("drivers", "tests", "docs"):  # docs: examples of drivers
        return
    for number, line in enumerate(without_comments(text).splitlines(), 1):
        match = WORLD.search(line)
        if match and not is_excepted(path, match.group(), used_exceptions):
            yield number, "the world communicator is for drivers and tests only; take a Comm"


def check_header(text):
    first_code = next((line.strip() for line in text.splitlines() if line.strip() and not line.startswith("//")), "")
    if first_code != "#pragma once":
        yield 1, "a header begins with #pragma once"
    for number, line in enumerate(without_comments(text).splitlines(), 1):
        if USING_NAMESPACE.match(line):
            yield number, "no 'using namespace' in a header outside functions"


def check_test_namespace(path, text):
    """Test files are compiled together; what they call alike must not meet."""
    if path.parts[:2] not in (("tests", "unit"), ("tests", "mpi")) or not path.stem.endswith("_test"):
        return
    name = f"namespace [\\w:]+::{path.stem} {{"
    if not re.search(f"^{name}$", text, re.MULTILINE):
        yield 1, f"a test file's namespace ends with its name, as in 'namespace bulkley::{path.stem}'"


def check_text(text):
    lines = text.splitlines()
    for number, line in enumerate(lines, 1):
        if MACHINE_PATHS.search(line):
            yield number, "names a path of one machine"


def retired_words(root):
    """Word -> term to use, from the table under "Retired words" of the glossary."""
    glossary = root / GLOSSARY
    lines = glossary.read_text(encoding="utf-8").splitlines() if glossary.exists() else []
    words = {}
    for line in lines[lines.index("## Retired words") :] if "## Retired words" in lines else []:
        row = RETIRED_ROW.match(line)
        if row:
            words.update({word: row.group(2) for word in row.group(1).split(", ")})
        elif words and not line.startswith("|"):
            break  # the table has ended
    return words


def check_words(path, text, words, used_exceptions):
    for number, line in enumerate(text.splitlines(), 1):
        for match in WORD.finditer(line):
            word = match.group().lower()
            if word not in words:
                continue
            exceptions = {(place, word) for place in map(str, (path, *path.parents))} & WORD_EXCEPTIONS
            used_exceptions |= exceptions
            if not exceptions:
                yield number, f"'{word}' is a retired word ({GLOSSARY}): {words[word]}"


def text_files(root):
    for folder in FOLDERS:
        yield from (p for p in sorted((root / folder).rglob("*")) if p.is_file() and "__pycache__" not in p.parts)
    yield from (p for p in sorted(root.iterdir()) if p.is_file() and p.name != ".git")  # a file in a further worktree


def check_tree(root):
    """All faults of the tree below `root` as (path, line, sentence)."""
    used_exceptions, used_word_exceptions = set(), set()
    words = retired_words(root)
    own_folder = pathlib.Path("tests/style")  # its self-test is made of faults
    for file in text_files(root):
        path = file.relative_to(root)
        if path.suffix not in TEXT_FILES and path.suffix:
            continue
        if own_folder in path.parents:
            continue
        text = file.read_text(encoding="utf-8", errors="replace")
        faults = list(check_text(text))
        if path not in (GLOSSARY, HISTORY):
            faults += check_words(path, text, words, used_word_exceptions)
        if path.suffix in (".hpp", ".cpp"):
            if len(text.splitlines()) > LARGEST_FILE:
                faults.append((LARGEST_FILE + 1, f"more than {LARGEST_FILE} lines: split the file"))
            faults += check_world(path, text, used_exceptions)
            if path.suffix == ".hpp":
                faults += check_header(text)
            faults += check_test_namespace(path, text)
            if path.parts[0] in ("include", "src", "drivers"):
                faults += check_modules(path, text)
                faults += check_bare_calls(path, text, used_exceptions)
        for line, sentence in faults:
            yield path, line, sentence
    for name, other in sorted(set(SITE_EXCEPTIONS) - used_exceptions):
        yield own_folder / "check_style.py", 1, f"the exception for {other} in {name} is not needed any more"
    for place, word in sorted(WORD_EXCEPTIONS - used_word_exceptions):
        yield own_folder / "check_style.py", 1, f"the exception for '{word}' in {place} is not needed any more"


def main():
    if len(sys.argv) != 2:
        sys.exit("usage: check_style.py ROOT")
    root = pathlib.Path(sys.argv[1]).resolve()
    faults = list(check_tree(root))
    for path, line, sentence in faults:
        print(f"{path}:{line}: {sentence}")
    print(f"{len(faults)} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
