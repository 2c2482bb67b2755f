"""A study as a Slurm job array: the job script that Bulkley installs (cluster/jobs/slurm/study.sh), with a study's
settings."""

import os
import pathlib
import re
import shlex
import shutil
import subprocess
from collections.abc import Mapping, Sequence

from bulkley.faults import RunError
from bulkley.places import find_shared

# What the script sets by itself, or other arguments do.
TAKEN = {"array": "the cases", "ntasks": "'ranks'", "ntasks-per-node": "'ranks'", "output": "the script", "signal": "the script",
         "open-mode": "the script", "requeue": "the script"}


def write_job_script(folder: pathlib.Path, scene: pathlib.Path, lines: list[list[str]], numbers: Sequence[int], *, ranks: int,
                     parallel: int | None, options: list[str], slurm: Mapping, program: str) -> pathlib.Path | None:
    """Writes study.txt, `lines` of --set arguments, and study.sh, whose array are the lines `numbers`; None where there are
    none. Raises RunError."""
    directives = sbatch_options(slurm)
    if folder.absolute().as_posix().split() != [folder.absolute().as_posix()]:
        raise RunError(f"'{folder.absolute()}' has blanks, which a job script's options cannot have: give another 'folder'")
    for number in numbers:
        for word in lines[number - 1]:
            if word.split() != [word]:
                raise RunError(f"case {number}: '{word}' has blanks, which a job script's table cannot have")
    template, functions = find_shared("jobs", "slurm/study.sh"), find_shared("jobs", "job_functions.sh")
    if template is None or functions is None:
        raise RunError("there are no job scripts: set BULKLEY_SCRIPTS to the folder that holds job_functions.sh")
    (folder / "study.sh").unlink(missing_ok=True)
    if not numbers:
        return None
    directives |= {"ntasks": str(ranks), "array": array_of(numbers) + (f"%{parallel}" if parallel else ""),
                   "output": str((folder / "slurm_%a.log").absolute())}
    paths = {"scene": scene, "study": folder / "study.txt", "program": pathlib.Path(program)}
    settings = {name: shlex.quote(str(path.absolute())) for name, path in paths.items()}
    settings["folder"] = shlex.quote(str(folder.absolute())) + "/$SLURM_ARRAY_TASK_ID"
    text = template.read_text(encoding="utf-8").replace("#SBATCH --ntasks-per-node=16\n", "")
    for name, value in directives.items():
        text = with_line(text, rf"#SBATCH --{name}(=\S*)?", f"#SBATCH --{name}" + (f"={value}" if value else ""))
    for name, value in settings.items():
        text = with_line(text, rf"{name}=\S*", f"{name}={value}")
    text = with_line(text, r"options=\(\)", f"options=({shlex.join(options)})")
    text = with_line(text, r"# module load bulkley.*",
                     f"BULKLEY_SCRIPTS=${{BULKLEY_SCRIPTS:-{shlex.quote(str(functions.parent.absolute()))}}}")
    try:
        (folder / "study.txt").write_text("".join(" ".join(words) + "\n" for words in lines), encoding="utf-8")
        (folder / "study.sh").write_text(text, encoding="utf-8")
    except OSError as error:
        raise RunError(f"cannot write '{folder / 'study.sh'}': {error.strerror}") from None
    return folder / "study.sh"


def sbatch_options(slurm: Mapping) -> dict[str, str]:
    """Names as sbatch has them; "" for one without a value. Raises RunError."""
    if not isinstance(slurm, Mapping):
        raise RunError(f"'slurm' is {slurm!r} and must be a dictionary of options of sbatch, such as {{'time': '04:00:00'}}")
    found = {}
    for name, value in slurm.items():
        name, text = str(name).replace("_", "-"), "" if value is True else str(value)
        if not re.fullmatch(r"[a-z][a-z-]*", name) or text.split() != [text] * bool(text):
            raise RunError(f"slurm['{name}'] is {value!r}: an option of sbatch has a long name, and a value without blanks")
        if name in TAKEN:
            raise RunError(f"slurm['{name}'] cannot be given: it is set by {TAKEN[name]}")
        found[name] = text
    return found


def with_line(text: str, pattern: str, line: str) -> str:
    """`text` with `line` in place of what `pattern` matches at the start of a line, up to blanks; options of sbatch that the
    text has not are added before its first."""
    changed, n = re.subn(rf"^{pattern}(?=\s|$)", lambda _: line, text, count=1, flags=re.MULTILINE)
    if n == 1:
        return changed
    if not line.startswith("#SBATCH"):
        raise RunError(f"the job script of Bulkley has no line '{pattern}': BULKLEY_SCRIPTS is of another version")
    return text.replace("#SBATCH", f"{line}\n#SBATCH", 1)


def array_of(numbers: Sequence[int]) -> str:
    """Ascending numbers as sbatch takes them: 1-3,7."""
    ranges: list[list[int]] = []
    for number in sorted(numbers):
        if ranges and ranges[-1][1] == number - 1:
            ranges[-1][1] = number
        else:
            ranges.append([number, number])
    return ",".join(f"{first}-{last}" if last > first else str(first) for first, last in ranges)


def submit(script: str | os.PathLike) -> str:
    """The number of the job. Raises RunError with sbatch's sentence."""
    if shutil.which("sbatch") is None:
        raise RunError(f"there is no sbatch: submit '{script}' where Slurm is")
    outcome = subprocess.run(["sbatch", "--parsable", os.fspath(script)], stdin=subprocess.DEVNULL, capture_output=True, text=True,
                             check=False)
    if outcome.returncode != 0:
        raise RunError(f"sbatch did not take '{script}': {' '.join(outcome.stderr.split())}")
    return outcome.stdout.strip()
