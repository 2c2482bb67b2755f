#!/usr/bin/env python3
"""Every test that ctest knows has the label of exactly one tier. Usage: tiers_test.py CTEST BUILD_FOLDER"""

import json
import subprocess
import sys

TIERS = {"fast", "system", "packaging", "slow", "perf"}


def labels_of(test):
    for entry in test.get("properties", []):
        if entry["name"] == "LABELS":
            return entry["value"]
    return []


def main():
    ctest, build = sys.argv[1:]
    listed = subprocess.run([ctest, "--test-dir", build, "--show-only=json-v1"], check=True, capture_output=True, text=True)
    tests = json.loads(listed.stdout)["tests"]
    faults = []
    for test in tests:
        tiers = sorted(TIERS.intersection(labels_of(test)))
        if len(tiers) != 1:
            faults.append(f"{test['name']}: its tiers are {tiers}; there must be one of {sorted(TIERS)}")
    print("\n".join(faults))
    print(f"{len(tests)} tests, {len(faults)} faults")
    return 1 if faults or not tests else 0


if __name__ == "__main__":
    sys.exit(main())
