#!/usr/bin/env python3
"""The diagram of docs/choose.md is what its script prints, and every key and value in it is in the reference of the scene file."""

import pathlib
import re
import subprocess
import sys
import xml.etree.ElementTree

ROOT = pathlib.Path(__file__).resolve().parents[3]
SCRIPT, PICTURE = ROOT / "docs/pictures/choose.py", ROOT / "docs/pictures/choose.svg"


def main():
    faults = []
    text = PICTURE.read_text(encoding="utf-8")
    if text != subprocess.run([sys.executable, SCRIPT], capture_output=True, text=True, check=True).stdout:
        faults.append("docs/pictures/choose.svg is out of date: python3 docs/pictures/choose.py > docs/pictures/choose.svg")
    reference = (ROOT / "docs/input.md").read_text(encoding="utf-8")
    keys = [element.text for element in xml.etree.ElementTree.fromstring(text).iter() if element.get("class") == "key"]
    for line in keys:
        key, value = re.fullmatch(r"(\w+) = (.+)", line).groups()
        if f"`{key}`" not in reference:
            faults.append(f"docs/input.md has no key '{key}'")
        if value.startswith('"') and f"`{value}`" not in reference and f"`{value[1:-1]}`" not in reference:
            faults.append(f"docs/input.md has no value {value} of '{key}'")
    for fault in faults:
        print(fault)
    print(f"{len(keys)} keys")
    sys.exit(1 if faults or not keys else 0)


if __name__ == "__main__":
    main()
