"""Installs, moves the prefix, and builds and runs docs/examples/own_material against it: a law and a driver from outside."""

import argparse
import csv
import os
import pathlib
import shutil
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from bulkley_program import Program  # noqa: E402

INSTALLED = ("bin/bulkley", "include/bulkley/simulation/stepper.hpp", "include/bulkley/version.hpp",
             "share/bulkley/scenes/cream_splash.toml", "share/bulkley/jobs/job_functions.sh", "share/bulkley/jobs/slurm/srun.sh",
             "share/bulkley/python/pyproject.toml", "share/bulkley/paraview/render.py", "share/bulkley/python/bulkley/__main__.py", "share/bulkley/python/bulkley/report_template.html",
             "share/man/man1/bulkley.1", "share/bash-completion/completions/bulkley", "share/zsh/site-functions/_bulkley")
EXAMPLE = "docs/examples/own_material"
LIMIT = 120.0  # s, for each run


def fail(text):
    sys.exit("FAILED: " + text)


def must(command, **more):
    outcome = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                             check=False, **more)
    if outcome.returncode != 0:
        fail(f"{' '.join(str(word) for word in command)}: exit code {outcome.returncode}\n{outcome.stdout}")
    return outcome.stdout


def install(arguments, work):
    first, moved = work / "first", work / "a folder" / "moved"
    must([arguments.cmake, "--install", arguments.build, "--prefix", first])
    moved.parent.mkdir()
    first.rename(moved)
    for name in INSTALLED:
        if not (moved / name).exists():
            fail(f"{name} is not installed")
    if not list(moved.glob("lib*/**/bulkleyConfig.cmake")):
        fail("bulkleyConfig.cmake is not installed")
    foreign = [path for path in moved.glob("lib*/**/*.cmake") if str(first) in path.read_text()
               or arguments.source in path.read_text()]
    if foreign:
        fail(f"{foreign[0]} names the folder of the build or of the first installation")
    return moved


def build_example(arguments, prefix, work):
    folder = work / "own_material"
    shutil.copytree(pathlib.Path(arguments.source) / EXAMPLE, folder)  # away from the sources
    must([arguments.cmake, "-S", folder, "-B", folder / "build", f"-DCMAKE_PREFIX_PATH={prefix}",
          f"-DCMAKE_CXX_COMPILER={arguments.compiler}", f"-DCMAKE_C_COMPILER={arguments.c_compiler}"])
    must([arguments.cmake, "--build", folder / "build", "--parallel", "2"])
    return folder


def carreau(rate):
    """Shear stress of docs/examples/own_material/shampoo.toml."""
    return (0.05 + (8.0 - 0.05) * (1.0 + (0.15 * rate) ** 2) ** (0.5 * (0.4 - 1.0))) * rate


def check_rheometer(program, folder):
    run = program.run(["rheometer", "shampoo.toml", "--material", "shampoo", "--rates", "0.01:100:9", "--out", "curve.csv"], 1,
                      folder, LIMIT)
    if run.code != 0:
        fail(f"the rheometer: {run.text}")
    with open(folder / "curve.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    rate = next(name for name in rows[0] if name.startswith("shear_rate"))
    stress = next(name for name in rows[0] if name.startswith("shear_stress"))
    worst = max(abs(float(row[stress]) / carreau(float(row[rate])) - 1.0) for row in rows)
    print(f"rheometer: {len(rows)} rates from {rows[0][rate]} to {rows[-1][rate]} 1/s, stress within {worst:.1e} of Carreau's")
    if len(rows) != 9 or worst > 1e-6:
        fail("the added law is not Carreau's")


def check_runs(program, folder):
    scene = ["run", "shampoo.toml", "--set", "time.end=0.1", "--quiet"]
    parts = {"one": (1, scene), "three": (3, scene), "part": (2, [*scene, "--max-steps", "60"])}
    for name, (ranks, command) in parts.items():
        run = program.run([*command, "--out", name], ranks, folder, LIMIT)
        if run.code != 0:
            fail(f"{name}: exit code {run.code}\n{run.text}")
    run = program.run([*scene, "--out", "part", "--restart"], 3, folder, LIMIT)
    if run.code != 0:
        fail(f"the restart: {run.text}")
    for other in ("three", "part"):
        outcome = program.run(["compare", "one", other], 1, folder, LIMIT)
        if outcome.code != 0:
            fail(f"one and {other} differ: {outcome.text}")
    print("a run with the added law: the same bits on 1 and 3 ranks, and on 2 then 3 through a restart")
    info = program.run(["info", "one"], 1, folder, LIMIT)
    if "added_law_variables" not in info.text:
        fail(f"the checkpoint does not hold the law's variables\n{info.text}")


def check_refusal(prefix, mpiexec, folder):
    """The program without the law says so."""
    plain = Program(str(prefix / "bin/bulkley"), mpiexec)
    run = plain.run(["check", "shampoo.toml"], 1, folder, LIMIT)
    if run.code != 2 or "carreau" not in run.text or "shampoo.toml:" not in run.text:
        fail(f"bulkley without the law: exit code {run.code}\n{run.text}")
    again = plain.run(["check", str(prefix / "share/bulkley/scenes/cream_splash.toml")], 1, folder, LIMIT)
    if again.code != 0:
        fail(f"the installed program: {again.text}")


def check_report(prefix, mpiexec, folder):
    """The page comes from the Python package of the installation: here from one whose template says something else."""
    template = prefix / "share/bulkley/python/bulkley/report_template.html"
    text = template.read_text(encoding="utf-8")
    template.write_text(text.replace("<h2>Summary</h2>", "<h2>Installed</h2>"), encoding="utf-8")
    plain = Program(str(prefix / "bin/bulkley"), mpiexec)
    scene = str(prefix / "share/bulkley/scenes/cream_splash.toml")
    run = plain.run(["run", scene, "--set", "domain.cell_size=0.025", "--max-steps", "5", "--out", "splash"], 1, folder, LIMIT)
    report = plain.run(["report", "splash"], 1, folder, LIMIT)
    if run.code != 0 or report.code != 0:
        fail(f"the report of the installed program: exit code {report.code}\n{run.text}{report.text}")
    if "<h2>Installed</h2>" not in (folder / "splash/report.html").read_text(encoding="utf-8"):
        fail("the installed program does not use the installed Python package")


def check_driver(folder, mpiexec):
    lines = set()
    for ranks in (1, 2):
        run = Program(str(folder / "build/until_rest"), mpiexec).run(["shampoo.toml"], ranks, folder, LIMIT)
        if run.code != 0 or not run.text.startswith(("at rest", "still moving")):
            fail(f"until_rest on {ranks} ranks: exit code {run.code}\n{run.text}")
        lines.add(run.text.splitlines()[0])
    print("until_rest:", *lines)
    if len(lines) != 1:
        fail("until_rest says something else on 2 ranks than on 1")
    wrong = Program(str(folder / "build/until_rest"), mpiexec).run(["missing.toml"], 2, folder, LIMIT)
    if wrong.code != 2 or "missing.toml" not in wrong.text:
        fail(f"until_rest without a scene: exit code {wrong.code}\n{wrong.text}")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("cmake", "build", "source", "compiler", "c-compiler", "mpiexec", "work"):
        parser.add_argument("--" + name, required=True)
    arguments = parser.parse_args()
    work = pathlib.Path(arguments.work)
    shutil.rmtree(work, ignore_errors=True)
    work.mkdir(parents=True)
    os.environ.pop("CMAKE_PREFIX_PATH", None)
    prefix = install(arguments, work)
    folder = build_example(arguments, prefix, work)
    own = Program(str(folder / "build/own_bulkley"), arguments.mpiexec)
    check_rheometer(own, folder)
    check_runs(own, folder)
    check_refusal(prefix, arguments.mpiexec, folder)
    check_report(prefix, arguments.mpiexec, folder)
    check_driver(folder, arguments.mpiexec)
    shutil.rmtree(work)


if __name__ == "__main__":
    main()
