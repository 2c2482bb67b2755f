"""Where the program, its scripts and its launcher are: of a source tree, of an installed prefix, or on the PATH."""

import os
import pathlib
import shutil

from bulkley.faults import RunError

PACKAGE = pathlib.Path(__file__).resolve().parent
BUILT = PACKAGE.parents[2] / "build/bulkley"
# Folders next to each other, by their paths in a source tree and below share/bulkley of an installed one.
SHARED = {"paraview": "drivers/paraview", "jobs": "cluster/jobs"}


def find_program(program: str | os.PathLike | None = None) -> str:
    """Path of the program: `program`; else that of the variable BULKLEY, of the source tree's `build`, of the PATH. Raises
    RunError."""
    given = program or os.environ.get("BULKLEY") or (BUILT if BUILT.is_file() else "bulkley")
    found = shutil.which(os.fspath(given))
    if found is None:
        raise RunError(
            f"there is no program '{given}': build it, put it on the PATH, or set BULKLEY or 'program' to its path")
    return os.path.abspath(found)


def find_shared(name: str, file: str) -> pathlib.Path | None:
    """A file of the folder `name` of SHARED; of the environment's BULKLEY_SCRIPTS or BULKLEY_SHARE, of this package's source
    tree or prefix, or of the program's; None if it is nowhere."""
    roots = [PACKAGE.parents[2]]
    folders = [PACKAGE.parents[1] / name]
    if name == "jobs" and "BULKLEY_SCRIPTS" in os.environ:
        folders.insert(0, pathlib.Path(os.environ["BULKLEY_SCRIPTS"]))
    if "BULKLEY_SHARE" in os.environ:
        folders.insert(0, pathlib.Path(os.environ["BULKLEY_SHARE"]) / name)
    try:
        prefix = pathlib.Path(find_program()).resolve().parents[1]
        roots.append(prefix)
        folders.append(prefix / "share/bulkley" / name)
    except RunError:
        pass
    for folder in [*folders, *(root / SHARED[name] for root in roots)]:
        if (folder / file).is_file():
            return folder / file
    return None
