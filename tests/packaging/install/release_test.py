"""The source archive: complete, reproducible, with one version everywhere; it configures and knows its commit."""

import argparse
import pathlib
import shutil
import subprocess
import sys
import tarfile


def fail(text):
    sys.exit("FAILED: " + text)


def run(*command, code=0):
    outcome = subprocess.run([str(word) for word in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                             check=False)
    if outcome.returncode != code:
        fail(f"{' '.join(str(word) for word in command)}: exit code {outcome.returncode} instead of {code}\n{outcome.stdout}")
    return outcome.stdout


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("cmake", "compiler", "c-compiler", "source", "work"):
        parser.add_argument("--" + name, required=True)
    arguments = parser.parse_args()
    source, work = pathlib.Path(arguments.source), pathlib.Path(arguments.work)
    if not (source / ".git").exists():
        print("SKIPPED: archives are made from a git clone, and this is none")
        return
    shutil.rmtree(work, ignore_errors=True)
    (work / "again").mkdir(parents=True)
    script = source / "cluster/release.sh"
    archive = pathlib.Path(run(script, "--snapshot", work).splitlines()[-1])
    again = pathlib.Path(run(script, "--snapshot", work / "again").splitlines()[-1])
    if archive.read_bytes() != again.read_bytes():
        fail("two archives of one commit differ")
    run("sh", "-c", f"cd '{work}' && sha256sum --check --quiet *.sha256")
    run(script, "--nonsense", code=2)

    with tarfile.open(archive) as tar:
        names = {pathlib.PurePosixPath(member.name) for member in tar.getmembers() if member.isfile()}
        tar.extractall(work)
    top = work / archive.name.removesuffix(".tar.gz")
    tracked = run("git", "-C", source, "-c", "core.quotePath=off", "ls-tree", "-r", "--name-only", "HEAD").splitlines()
    missing = [name for name in tracked if pathlib.PurePosixPath(top.name) / name not in names]
    if missing or len(names) != len(tracked):
        fail(f"the archive has {len(names)} files, the commit {len(tracked)}; missing: {missing[:5]}")

    commit = run("git", "-C", source, "rev-parse", "HEAD").strip()
    build = work / "build"
    run(arguments.cmake, "-S", top, "-B", build, "-DBULKLEY_TESTS=OFF", f"-DCMAKE_CXX_COMPILER={arguments.compiler}",
        f"-DCMAKE_C_COMPILER={arguments.c_compiler}")
    generated = (build / "git_commit.cpp").read_text()
    told = next(line for line in generated.splitlines() if "git_commit =" in line).split('"')[1]
    if len(told) < 7 or not commit.startswith(told):
        fail(f"the archive of {commit} calls itself {told}")
    print(f"{archive.name}: {len(names)} files, {archive.stat().st_size / 1e6:.1f} MB, commit {told}")
    shutil.rmtree(work)


if __name__ == "__main__":
    main()
