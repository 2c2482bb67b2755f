"""The reference pages and shell completions in the repository are those that the program makes, and they work."""

import argparse
import pathlib
import shutil
import subprocess
import sys

KEPT = {"markdown": "docs/command-line.md", "man": "docs/bulkley.1", "bash": "cluster/packaging/completion/bulkley.bash",
        "zsh": "cluster/packaging/completion/_bulkley"}


def fail(text):
    sys.exit("FAILED: " + text)


def bash_offers(source, *words):
    """What bash would offer for the last of `words`."""
    script = (f'source "{source}/{KEPT["bash"]}"; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _bulkley; '
              'printf "%s\\n" "${COMPREPLY[@]}"')
    outcome = subprocess.run(["bash", "-c", script, "bash", *words], capture_output=True, text=True, check=True)
    return outcome.stdout.split()


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--program", required=True)
    parser.add_argument("--source", required=True)
    arguments = parser.parse_args()
    source = pathlib.Path(arguments.source)
    for form, name in KEPT.items():
        made = subprocess.run([arguments.program, "command-reference", "--format", form], capture_output=True, text=True,
                              check=True).stdout
        if made != (source / name).read_text():
            fail(f"{name} is out of date: bulkley command-reference --format {form} > {name}")

    if bash_offers(source, "bulkley", "rhe") != ["rheometer"]:
        fail("bash does not complete a subcommand")
    if bash_offers(source, "bulkley", "run", "--max-w") != ["--max-walltime"]:
        fail("bash does not complete an option")
    if bash_offers(source, "bulkley", "rheometer", "--mode", "osc") != ["oscillation"]:
        fail("bash does not complete the value of an option")
    if bash_offers(source, "bulkley", "run", "sc") != []:
        fail("bash is not left to complete names of files")
    for shell, name, check in (("zsh", KEPT["zsh"], ["-n"]), ("man", KEPT["man"], ["--warnings", "-l"])):
        if shutil.which(shell) is None:
            print(f"{shell} is not installed: {name} was not tried in it")
            continue
        outcome = subprocess.run([shell, *check, str(source / name)], capture_output=True, text=True, check=False)
        if outcome.returncode != 0 or outcome.stderr.strip():
            fail(f"{shell} says of {name}: {outcome.stderr}")
    print("4 pages and completions are up to date")


if __name__ == "__main__":
    main()
