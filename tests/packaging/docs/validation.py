"""Checks of a command without running it: programs, files, options, presets and labels exist."""

import json
import re
import subprocess
import sys

from blocks import without_variables


class Validator:
    def __init__(self, root, program):
        self.root = root
        self.program = program
        self.help = {}

    def fault(self, words, folder):
        """What is wrong with a command in `folder`, in a few words; None: nothing that can be seen."""
        words = without_variables(list(words))
        for symbol in ("&&", ";", "|"):
            if symbol in words:
                at = words.index(symbol)
                return self.fault(words[:at], folder) or self.fault(words[at + 1:], folder)
        if words[0] in ("mpirun", "mpiexec"):
            if len(words) < 4 or words[1] != "-n" or not words[2].isdigit():
                return "mpirun is not followed by -n and a number"
            words = words[3:]
        name, arguments = words[0], words[1:]
        if name in ("bulkley", "build/bulkley"):
            return self.bulkley_fault(arguments, folder)
        if name in ("pvpython", "pvbatch", "python3"):
            return self.script_fault(arguments[0], arguments[1:])
        if name == ".":
            return None if (self.root / arguments[0]).is_file() else f"there is no {arguments[0]}"
        if name == "paraview":
            scripts = [word.partition("=")[2] for word in arguments if word.startswith("--script=")]
            return next((f"there is no {script}" for script in scripts if not (self.root / script).is_file()), None)
        if name in ("cmake", "ctest"):
            return self.cmake_fault(arguments)
        if name == "apt-get":
            return self.package_fault(arguments)
        if "/" in name:
            return self.script_fault(name, arguments)
        return f"how to validate '{name}' is not known"

    def text_of_help(self, *command):
        """The help text of a command; empty if it fails."""
        if command not in self.help:
            outcome = subprocess.run([*command, "--help"], capture_output=True, text=True, timeout=60)
            self.help[command] = outcome.stdout if outcome.returncode == 0 else ""
        return self.help[command]

    def bulkley_fault(self, arguments, folder):
        if not arguments or arguments[0].startswith("-"):
            return unknown_option(arguments, self.text_of_help(self.program))
        text = self.text_of_help(self.program, arguments[0])
        if not text:
            return f"bulkley has no subcommand '{arguments[0]}'"
        fault = unknown_option(arguments, text)
        if fault or arguments[0] != "run":
            return fault
        check = [self.program, "check", arguments[1]]
        for key, value in zip(arguments, arguments[1:]):
            if key == "--set":
                check += ["--set", value]
        outcome = subprocess.run(check, cwd=folder, capture_output=True, text=True, timeout=120)
        return None if outcome.returncode == 0 else f"bulkley check refuses it: {outcome.stderr.strip()}"

    def script_fault(self, script, arguments):
        path = self.root / script
        if (path / "__main__.py").is_file():  # a package with tools: what the tool says of its options
            text = self.text_of_help(sys.executable, str(path), *arguments[:1])
            return unknown_option(arguments, text) if text else f"{script} has no tool {' '.join(arguments[:1])}"
        if not path.is_file():
            return f"there is no {script}"
        if not script.endswith(".py") and not path.stat().st_mode & 0o111:
            return f"{script} is not executable"
        sources = [path, path.with_suffix(".py")]
        text = "".join(source.read_text(encoding="utf-8") for source in sources if source.is_file())
        fault = unknown_option(arguments, text)
        if fault and script.endswith(".py"):  # options that are put together as the script runs
            fault = unknown_option(arguments, self.text_of_help(sys.executable, str(path)))
        return fault

    def cmake_fault(self, arguments):
        presets = json.loads((self.root / "CMakePresets.json").read_text(encoding="utf-8"))
        named = {preset["name"] for kind in ("configurePresets", "testPresets") for preset in presets[kind]}
        lists = (self.root / "CMakeLists.txt").read_text(encoding="utf-8")
        tests = "".join(path.read_text(encoding="utf-8") for pattern in ("CMakeLists.txt", "*_test.cpp")  # entries and suites
                        for path in (self.root / "tests").rglob(pattern))
        for key, value in zip(arguments, [*arguments[1:], ""]):
            if key == "--preset" and value not in named:
                return f"there is no preset '{value}'"
            if key in ("-L", "-R") and not any(word in tests for word in value.split("|")):
                return f"no test has to do with '{value}'"
            option = re.match(r"-D(BULKLEY_\w+)=", key)
            if option and option[1] not in lists:
                return f"CMakeLists.txt has no option {option[1]}"
        return None

    def package_fault(self, arguments):
        known = (self.root / "cluster/install_packages.sh").read_text(encoding="utf-8")
        return next((f"cluster/install_packages.sh has no package {word}" for word in arguments
                     if word not in ("install", "update") and not word.startswith("-") and word not in known), None)


def unknown_option(arguments, text):
    """The first option of a command line that a program's help or source does not hold."""
    for word in arguments:
        if word == "--":
            return None
        option = re.match(r"--?[a-z][a-z-]*", word)
        if option and not re.search(re.escape(option[0]) + r"(?![a-z-])", text):
            return f"no option {option[0]}"
    return None
