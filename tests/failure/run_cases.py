#!/usr/bin/env python3
"""Runs the failure cases of cases.py, mesh_cases.py and input_cases.py through the real program: expected exit code and
sentence, before the time limit."""

import pathlib
import re
import resource
import shutil
import sys
from concurrent.futures import ThreadPoolExecutor

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import Program, parse_arguments  # noqa: E402
import cases  # noqa: E402
import input_cases  # noqa: E402
import mesh_cases  # noqa: E402

CASES = cases.CASES + mesh_cases.MESH_CASES + input_cases.INPUT_CASES
MOST_MEMORY = 1 << 20  # KiB; none of the inputs is large

BASE = pathlib.Path(__file__).resolve().with_name("base.toml")


def edited_scene(case):
    text = BASE.read_text(encoding="utf-8")
    for old, new in case.replace.items():
        assert text.count(old) == 1, f"{case.name}: '{old}' stands {text.count(old)} times in base.toml"
        text = text.replace(old, new)
    return text + case.append


def fault_of(case, ranks, program, folder):
    """What is wrong with the outcome of `case` on `ranks` ranks; None if all is as expected."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    scene = folder / "scene.toml"
    scene.write_text(edited_scene(case), encoding="utf-8")
    if case.prepare:
        try:
            case.prepare(folder, program, "scene.toml")
        except AssertionError as error:
            return f"{case.name} on {ranks} ranks: cannot be prepared: {error}"
    arguments = [argument.format(scene="scene.toml") for argument in case.arguments]
    outcome = program.run(arguments, ranks, folder, case.limit)
    print(f"{case.name} on {ranks} ranks: exit {outcome.code} after {outcome.seconds:.1f} s")
    if outcome.code is None:
        fault = f"hung for {case.limit:.0f} s"
    elif outcome.code != case.code:
        fault = f"exit code {outcome.code} instead of {case.code}"
    elif not re.search(case.sentence, outcome.text):
        fault = f"no sentence like '{case.sentence}'"
    elif sum(bool(re.search(case.sentence, line)) for line in outcome.text.splitlines()) > 1:
        fault = "the sentence is printed more than once"
    else:
        return None
    return f"{case.name} on {ranks} ranks: {fault}\n{outcome.text}"


def main():
    arguments = parse_arguments(__doc__, lambda p: p.add_argument("names", nargs="*", help="cases to run; default all"))
    program = Program(arguments.program, arguments.mpiexec)
    unknown = set(arguments.names) - {case.name for case in CASES}
    if unknown:
        sys.exit(f"no such case: {', '.join(sorted(unknown))}")
    chosen = [(case, ranks) for case in CASES if not arguments.names or case.name in arguments.names for ranks in case.ranks]
    with ThreadPoolExecutor(2) as pool:  # most of the time goes into starting and ending processes
        faults = list(pool.map(
            lambda one: fault_of(*one, program, pathlib.Path(arguments.work) / f"{one[0].name}.{one[1]}"), chosen))
    faults = [fault for fault in faults if fault]
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    print(f"at most {memory >> 10} MiB of memory in a process")
    if memory > MOST_MEMORY:
        faults.append(f"a case took {memory >> 10} MiB of memory")
    for fault in faults:
        print(f"FAILED: {fault}")
    sys.exit(1 if faults else 0)


if __name__ == "__main__":
    main()
