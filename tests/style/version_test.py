#!/usr/bin/env python3
"""CMakeLists.txt says which version this is; whatever must repeat it says the same, and no page does."""

import pathlib
import re
import sys

ONE_PLACE = "CMakeLists.txt", r"^project\(bulkley VERSION ([\d.]+)"
# Files that other programs read and that cannot ask CMake; of the changelogs the first heading.
REPEATED = {
    "CITATION.cff": r"^version: (\S+)$",
    "CHANGELOG.md": r"^## \[(\d[^\]]*)\]",
    "docs/bulkley.1": r"^\.TH BULKLEY 1 \"\" \"Bulkley (\S+)\"",
    "drivers/python/bulkley/_version.py": r"^__version__ = \"(.+)\"$",
    "cluster/packaging/spack/package.py": r"^ +version\(\"(.+)\"\)$",
    "cluster/packaging/easybuild/bulkley-*.eb": r"^version = '(.+)'$",
    "cluster/packaging/apptainer/bulkley.def": r"^ +VERSION=(.+)$",
    "cluster/packaging/container/Containerfile": r"^ARG VERSION=(.+)$",
    "cluster/packaging/debian/changelog": r"^bulkley \(([\d.]+)",
}
DATES = {"CITATION.cff": r"^date-released: \"(\S+)\"$", "CHANGELOG.md": r"^## \[[^\]]+\] - (\S+)$"}
ABOUT_VERSIONS = {"upgrade.md"}  # pages


def faults_of(root):
    version = re.search(ONE_PLACE[1], (root / ONE_PLACE[0]).read_text(encoding="utf-8"), re.MULTILINE)[1]
    for pattern, line in REPEATED.items():
        paths = list(root.glob(pattern))
        if len(paths) != 1:
            yield f"{pattern}: {len(paths)} files"
        for path in paths:
            found = re.search(line, path.read_text(encoding="utf-8"), re.MULTILINE)
            if not found or found[1] != version:
                yield f"{path.relative_to(root)}: {found[1] if found else 'no version'}, CMakeLists.txt says {version}"
    dates = [re.search(line, (root / path).read_text(encoding="utf-8"), re.MULTILINE) for path, line in DATES.items()]
    if None in dates or len({date[1] for date in dates}) != 1:
        yield f"{' and '.join(DATES)} have different dates"
    if not (root / f"cluster/packaging/easybuild/bulkley-{version}-foss-2024a.eb").exists():
        yield f"the file of the easyconfig is not named bulkley-{version}-foss-2024a.eb"
    for page in [root / "README.md", *(root / "docs").rglob("*.md")]:
        if page.name not in ABOUT_VERSIONS and re.search(rf"(?<![\d.]){re.escape(version)}(?![\d.])", page.read_text(encoding="utf-8")):
            yield f"{page.relative_to(root)}: names the version {version}; write VERSION"
    archives = re.compile(r"[Bb]ulkley[-/ ](\d+\.\d+\.\d+)")
    for page in (root / "docs").rglob("*.md"):
        for found in archives.finditer(page.read_text(encoding="utf-8")):
            yield f"{page.relative_to(root)}: names the version {found[1]}; write VERSION"


def main():
    faults = list(faults_of(pathlib.Path(sys.argv[1])))
    for fault in faults:
        print(fault)
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
