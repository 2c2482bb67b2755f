#!/usr/bin/env python3
"""A disk that fails while a run writes to it: full, broken, gone, read-only, or without an answer.

Every case must end in one sentence with the file and the newest whole checkpoint, exit code 3, before the time limit, with no
process killed by a signal; what had been written before must be whole, and a run continued from it must give the bits of a run
that nothing happened to. Faults come from storage_shim.c (no root needed) and, where they can be mounted, from small disks.
"""

import json
import os
import pathlib
import re
import shutil
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("base.toml")
STEPS = 12
RUN = ["run", str(SCENE), "--max-steps", str(STEPS), "--quiet", "--set", "checkpoint.steps=4",
       "--set", "output.frame_interval=0.00005", "--set", "output.history_interval=1"]
LAST = f"checkpoint_{STEPS:09d}.h5"
WRITES = "write,writev,pwrite,pwritev"
LIMIT = 30.0  # s; a run that takes longer counts as hanging
KILLED = re.compile(r"signal|Segmentation|SIGSEGV|core dumped|terminate called", re.IGNORECASE)


@dataclass
class Fault:
    name: str
    path: str  # part of the path, within the folder of the run, of the files that fail
    calls: str
    kind: str
    sentence: str = ""  # regular expression; default: the file
    at: int = 1
    times: int = 10**9
    rank: int = -1
    ranks: int = 1
    may_succeed: bool = False  # exit code 0 is right, too, if the bits are
    arguments: list = field(default_factory=list)
    short: bool = True  # runs without --all

    def environment(self, shim):
        values = {"LD_PRELOAD": shim, "FAULT_PATH": f"{self.name}/{self.path}", "FAULT_CALLS": self.calls, "FAULT_KIND": self.kind,
                  "FAULT_AT": str(self.at), "FAULT_TIMES": str(self.times)}
        return values | ({"FAULT_RANK": str(self.rank)} if self.rank >= 0 else {})


def faults():
    second = "checkpoint_000000008"
    cases = [
        Fault("checkpoint_full", f"{second}.h5.tmp", WRITES, "ENOSPC"),
        Fault("checkpoint_full_3", f"{second}.h5.tmp", WRITES, "ENOSPC", ranks=3),
        Fault("checkpoint_full_on_rank_2", f"{second}.h5.tmp", WRITES, "ENOSPC", rank=2, ranks=3),
        Fault("first_checkpoint_broken", "checkpoint_000000004.h5.tmp", WRITES, "EIO", short=False),
        Fault("checkpoint_no_room", f"{second}.h5.tmp", "fallocate", "ENOSPC", sentence=r"no room for .* MB"),
        Fault("checkpoint_no_room_again", f"{second}.h5.tmp", "fallocate", "ENOSPC", at=2, sentence=r"no room for .* MB",
              short=False),
        Fault("checkpoint_short", f"{second}.h5.tmp", WRITES, "short", may_succeed=True),
        Fault("checkpoint_short_on_rank_1", f"{second}.h5.tmp", WRITES, "short", rank=1, ranks=2, may_succeed=True,
              short=False),
        Fault("checkpoint_flush", f"{second}.h5.tmp", "fsync", "EIO"),
        Fault("checkpoint_flush_on_rank_1", f"{second}.h5.tmp", "fsync", "EIO", rank=1, ranks=2, short=False),
        Fault("checkpoint_rename", f"{second}.h5.tmp", "rename", "EIO"),
        Fault("checkpoint_cut", f"{second}.h5.tmp", "ftruncate", "EIO", may_succeed=True),
        Fault("checkpoint_sidecar", f"{second}.xdmf", "write", "ENOSPC"),
        Fault("frame_full", "frame_000001.h5.tmp", WRITES, "ENOSPC"),
        Fault("frame_full_on_rank_1", "frame_000002.h5.tmp", WRITES, "ENOSPC", rank=1, ranks=2),
        Fault("compressed_frame_full_on_rank_1", "frame_000002.h5.tmp", WRITES, "ENOSPC", rank=1, ranks=2,
              arguments=["--set", "output.compression=1"]),
        Fault("compressed_frame_full", "frame_000002.h5.packed.tmp", WRITES, "ENOSPC", sentence=r"frame_000002\.h5",
              arguments=["--set", "output.compression=1"]),
        Fault("compressed_frame_renamed", "frame_000002.h5.packed.tmp", "rename", "EIO", sentence=r"frame_000002\.h5",
              arguments=["--set", "output.compression=1"], short=False),
        Fault("frame_flush", "frame_000002.h5.tmp", "fsync", "EIO"),
        Fault("frame_rename", "frame_000002.h5.tmp", "rename", "EIO", short=False),
        Fault("series_full", "frames.xdmf.tmp", WRITES, "ENOSPC"),
        Fault("growing_series_full", "frames.xdmf.next", WRITES, "ENOSPC", at=2),
        Fault("growing_series_short", "frames.xdmf.next", WRITES, "short", may_succeed=True, short=False),
        Fault("growing_series_renamed", "frames.xdmf.next", "rename", "EIO", sentence=r"frames\.xdmf"),
        Fault("history_full", "history.csv", "write", "ENOSPC", at=8),
        Fault("history_full_2", "history.csv", "write", "ENOSPC", at=8, ranks=2, short=False),
        Fault("history_short_once", "history.csv", "write", "short", at=8, times=1, may_succeed=True),
        Fault("history_short_for_ever", "history.csv", "write", "short", at=8, may_succeed=True, short=False),
        Fault("history_flush", "history.csv", "fsync", "EIO", at=3),
        Fault("status_full", "status.json", "write", "ENOSPC", at=2),
        Fault("status_flush", "status.json", "fsync", "EIO", at=2, short=False),
        Fault("read_only", "", "open,rename", "EROFS", sentence="scene.toml.*Read-only"),
        Fault("read_only_later", "", "open,rename", "EROFS", at=40, sentence="Read-only|read_only_later"),
        Fault("checkpoint_hangs", f"{second}.h5.tmp", WRITES, "hang", sentence="has taken longer than 2 s",
              arguments=["--set", "checkpoint.timeout=2"]),
        Fault("checkpoint_hangs_on_rank_2", f"{second}.h5.tmp", WRITES, "hang", rank=2, ranks=3,
              sentence="has taken longer than 2 s", arguments=["--set", "checkpoint.timeout=2"]),
        Fault("frame_hangs", "frame_000002.h5.tmp", "fsync", "hang", ranks=2, sentence="has taken longer than 2 s",
              arguments=["--set", "checkpoint.timeout=2"]),
        Fault("history_hangs", "history.csv", "fsync", "hang", at=3, sentence="has taken longer than 2 s",
              arguments=["--set", "checkpoint.timeout=2"], short=False),
        # The status, too: its state must be there before its flush, for who waits for that may be killed meanwhile.
        Fault("every_flush_hangs", "", "fsync,fdatasync", "hang", at=21, sentence="has taken longer than 2 s",
              arguments=["--set", "checkpoint.timeout=2", "--set", "time.step_timeout=2"]),
    ]
    # Every call in turn: data, metadata, and all that comes after.
    for at in range(1, 41):
        for ranks in (1, 3):
            cases.append(Fault(f"every_write_{at}_{ranks}", f"{second}.h5.tmp", WRITES, "ENOSPC", at=at, ranks=ranks,
                               may_succeed=True, short=at == 20 and ranks == 1))
        cases.append(Fault(f"one_write_{at}", f"{second}.h5.tmp", WRITES, "EIO", at=at, times=1, may_succeed=True,
                           short=False))
        cases.append(Fault(f"every_flush_{at}", "", "fsync,fdatasync", "EIO", at=at, may_succeed=True,
                           short=at == 21, sentence="Input/output error"))
        cases.append(Fault(f"every_rename_{at}", "", "rename", "EIO", at=at, may_succeed=True,
                           short=at == 10, sentence="Input/output error"))
    return cases


class Bench:
    """Runs a case and checks the remaining files."""

    def __init__(self, program, work, shim):
        self.program, self.work, self.shim = program, work, shim
        self.n_failed = self.n_passed = 0
        self.slowest = 0.0
        run = program.run([*RUN, "--out", "whole"], 1, work, 60)
        if run.code != 0:
            fail("the run that nothing happens to failed", run)

    def newest(self, folder):
        names = sorted(path.name for path in folder.glob("checkpoint_*.h5"))
        return names[-1] if names else None

    def judge(self, name, folder, outcome, sentence, may_succeed=False):
        """Faults of one failed run: how it ended and what it left in `folder`."""
        if outcome.code is None:
            fail(f"{name}: hung for {LIMIT:.0f} s", outcome)
        self.slowest = max(self.slowest, outcome.seconds)
        if outcome.code == 0 and may_succeed:
            self.n_passed += 1
            return
        if outcome.code != 3:
            fail(f"{name}: exit code {outcome.code} instead of 3", outcome)
        if KILLED.search(outcome.text):
            fail(f"{name}: a process was killed by a signal", outcome)
        lines = [line for line in outcome.text.splitlines() if line.startswith("bulkley: ")]
        if not lines or not any(re.search(sentence, line) for line in lines):
            fail(f"{name}: no sentence like '{sentence}'", outcome)
        said = re.search(r"the last good checkpoint is \S*(checkpoint_\d+\.h5)", lines[0])
        if said is None and "no checkpoint yet" not in lines[0] and folder.exists() and self.newest(folder):
            fail(f"{name}: does not name the newest whole checkpoint", outcome)
        if said and folder.exists():
            info = self.program.run(["info", said.group(1)], 1, folder, 30)
            if info.code != 0:
                fail(f"{name}: {said.group(1)} is not whole", info)
        self.n_failed += 1

    def continue_and_compare(self, name, out, ranks=1):
        """What is left must lead to the bits of the whole run."""
        folder = self.work / out
        more = ["--restart"] if folder.exists() and self.newest(folder) else ["--overwrite"]
        run = self.program.run([*RUN, "--out", out, *more], ranks, self.work, 60)
        if run.code != 0 or "passed over" in run.text:
            fail(f"{name}: cannot be continued", run)
        compare = self.program.run(["compare", f"whole/{LAST}", f"{out}/{LAST}"], 1, self.work, 60)
        if compare.code != 0:
            fail(f"{name}: the continued run gives other bits", compare)
        steps = [line.split(",")[0] for line in (folder / "history.csv").read_text(encoding="utf-8").splitlines()]
        if steps[1:] != [str(step) for step in range(STEPS + 1)]:
            fail(f"{name}: history.csv of the continued run has the steps {steps}")
        left = [path.name for path in folder.iterdir() if path.name.endswith(".tmp")]
        if left:
            fail(f"{name}: left over are {left}")
        shutil.rmtree(folder)

    def run(self, case):
        arguments = [*RUN, "--out", case.name, *case.arguments]
        folder = self.work / case.name
        folder.mkdir()  # so that the fault comes when files are written
        outcome = self.program.run(arguments, case.ranks, self.work, LIMIT, case.environment(self.shim))
        self.judge(case.name, folder, outcome, case.sentence or re.escape(case.path.removesuffix(".tmp")), case.may_succeed)
        if case.kind == "hang":
            status = json.loads((folder / "status.json").read_text(encoding="utf-8"))
            if status["state"] != "failed" or status.get("unresponsive") is not True:
                fail(f"{case.name}: status.json says {status}", outcome)
        print(f"{case.name}: exit {outcome.code} after {outcome.seconds:.1f} s", flush=True)
        self.continue_and_compare(case.name, case.name, 2 if case.ranks > 1 else 1)


def when_there(path, work, limit=20.0):
    """Calls `work` as soon as `path` exists; a thread to join."""
    def wait():
        end = time.monotonic() + limit
        while not path.exists() and time.monotonic() < end:
            time.sleep(0.002)
        work()
    thread = threading.Thread(target=wait)
    thread.start()
    return thread


def folder_removed(bench):
    folder = bench.work / "removed"
    thread = when_there(folder / "checkpoint_000000004.h5", lambda: folder.rename(bench.work / "gone"))  # at one blow
    long_run = [part if part != str(STEPS) else "100000" for part in RUN]
    outcome = bench.program.run([*long_run, "--out", "removed"], 2, bench.work, LIMIT)
    thread.join()
    bench.judge("folder_removed", folder, outcome, r"removed(/\S+)?': (No such file|there is no such file)")
    print(f"folder_removed: exit {outcome.code} after {outcome.seconds:.1f} s")
    shutil.rmtree(bench.work / "gone")


def mounted(folder, options):
    folder.mkdir(exist_ok=True)
    return subprocess.run(["mount", "-t", "tmpfs", "-o", options, "tmpfs", str(folder)], capture_output=True,
                          check=False).returncode == 0


def small_disks(bench, every):
    """Disks of every size from one that takes nothing to one that takes all."""
    disk = bench.work / "disk"
    for ranks in (1, 3):
        for kilobytes in ((1400, 2600) if not every else range(200, 4200, 200)):
            if not mounted(disk, f"size={kilobytes}k"):
                print("small disks: skipped, this user cannot mount one")
                return
            try:
                outcome = bench.program.run([*RUN, "--out", "disk/out"], ranks, bench.work, LIMIT)
                name = f"disk_of_{kilobytes}_kB on {ranks} ranks"
                bench.judge(name, disk / "out", outcome, r"disk/out", may_succeed=True)
                print(f"{name}: exit {outcome.code} after {outcome.seconds:.1f} s", flush=True)
                shutil.rmtree(bench.work / "after_disk", ignore_errors=True)
                if (disk / "out").exists():
                    shutil.copytree(disk / "out", bench.work / "after_disk")
            finally:
                subprocess.run(["umount", str(disk)], check=True)
            if outcome.code != 0 and (bench.work / "after_disk").exists():
                bench.continue_and_compare(name, "after_disk")


def read_only_disk(bench):
    disk = bench.work / "disk"
    if not mounted(disk, "size=10m"):
        return
    try:
        (disk / "out").mkdir()
        subprocess.run(["mount", "-o", "remount,ro", str(disk)], check=True)
        outcome = bench.program.run([*RUN, "--out", "disk/out"], 2, bench.work, LIMIT)
        bench.judge("read_only_disk", disk / "out", outcome, "disk/out.*Read-only file system")
        print(f"read_only_disk: exit {outcome.code} after {outcome.seconds:.1f} s")
    finally:
        subprocess.run(["umount", str(disk)], check=True)


def main():
    def add(parser):
        parser.add_argument("--shim", required=True, help="the library made of storage_shim.c")
        parser.add_argument("--all", action="store_true", help="every case, not the short list")
        parser.add_argument("names", nargs="*", help="cases to run; default all")
    arguments = parse_arguments(__doc__, add)
    program, work = start(arguments)
    bench = Bench(program, work, os.path.abspath(arguments.shim))
    chosen = [case for case in faults()
              if (case.name in arguments.names if arguments.names else arguments.all or case.short)]
    with ThreadPoolExecutor(2) as pool:  # most of the time goes into starting and ending processes
        list(pool.map(bench.run, chosen))
    if not arguments.names:
        folder_removed(bench)
        small_disks(bench, arguments.all)
        read_only_disk(bench)
    elif "disks" in arguments.names:
        small_disks(bench, arguments.all)
        read_only_disk(bench)
    elif "removed" in arguments.names:
        folder_removed(bench)
    print(f"{bench.n_failed} faults ended in a sentence and exit code 3, {bench.n_passed} did no harm; the slowest took "
          f"{bench.slowest:.1f} s")


if __name__ == "__main__":
    main()
