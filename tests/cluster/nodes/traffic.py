#!/usr/bin/env python3
"""What the program says that ranks send (halo_bytes_mean in history.csv) against the bytes that the interfaces of the hosts count, from
Ethernet's headers up. With one rank a host all that a rank sends leaves its host; with two, the part that `bulkley partition
--ranks-per-node 2` predicts. The interfaces may count no less, and more by what the program does not count: headers of Ethernet, IP,
TCP and MPI, the reduction of each step, and particles that change ranks."""

import csv

from runs import SCENE, LIMIT, Runs, enter, fail, hosts

FIRST, LAST = 10, 60  # steps: the runs differ by those in between, so that start and end of a run do not count
QUIET = ("partition.method=uniform", "output.frame_interval=0", "checkpoint.at_end=false")
MOST = 1.06  # of what the program says: seen 1.016 to 1.035
CASES = [("two hosts of a rank", [1, 1]), ("three hosts of a rank", [1, 1, 1]), ("two hosts of two ranks", [2, 2])]


class Traffic:
    def __init__(self, program, work, group):
        self.program, self.work, self.group, self.runs = program, work, group, Runs(program, work, group)

    def said(self, layout):
        """Bytes that all ranks send from step FIRST to LAST, from a run with a row of history for each step."""
        self.runs.run(layout, "said", LAST, *QUIET, "output.history_interval=1", "--overwrite")
        with open(self.work / "said" / "history.csv", newline="", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        counted = [float(row["halo_bytes_mean [B]"]) for row in rows if FIRST < int(row["step"]) <= LAST]
        if len(counted) != LAST - FIRST:
            fail(f"history.csv has {len(counted)} rows of {LAST - FIRST} steps")
        return sum(counted) * sum(layout)

    def counted(self, layout):
        """Bytes and frames that leave the hosts in those steps, from runs without such rows, which cost reductions."""
        totals = []
        for steps in (FIRST, LAST):
            before = self.group.sent_bytes()
            self.runs.run(layout, f"counted_{steps}", steps, *QUIET, f"output.history_interval={2 * LAST}", "--overwrite")
            totals.append([after - start for after, start in zip(self.group.sent_bytes(), before)])
        return (late - early for early, late in zip(*totals))

    def share_between_hosts(self, layout):
        n = sum(layout)
        if n == len(layout):
            return 1.0
        words = ["partition", str(SCENE), "-n", str(n), "--methods", "uniform", "--ranks-per-node", str(n // len(layout)), "--csv", "off.csv"]
        outcome = self.program.run(words, 1, self.work, LIMIT)
        if outcome.code != 0:
            fail("no prediction", outcome)
        with open(self.work / "off.csv", newline="", encoding="utf-8") as file:
            return float(next(csv.DictReader(file))["sent_off_node_fraction"])

    def compare(self, name, layout):
        said = self.said(layout) * self.share_between_hosts(layout)
        counted, frames = self.counted(layout)
        steps = LAST - FIRST
        print(f"{name}: the program says {said / steps / 1024:.1f} KiB a step between hosts; counted {counted / steps / 1024:.1f} in "
              f"{frames / steps:.1f} frames: {counted / said:.3f} times as much")
        if not said <= counted <= MOST * said:
            fail(f"{name}: the interfaces and the program do not agree")


def main():
    _, program, work = enter(__doc__)
    with hosts.Hosts(3, work, program.path, program.mpiexec) as group:
        traffic = Traffic(program, work, group)
        for name, layout in CASES:
            traffic.compare(name, layout)


if __name__ == "__main__":
    main()
