#!/usr/bin/env python3
"""On numbers of ranks that the tiles of the grid do not make boxes for, and on more ranks than there are tiles, a run, its
frames, its checkpoints and its restarts work as on one rank, and give the same bits."""

import pathlib
import sys

import h5py

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

# 3 x 3 x 3 tiles; the transfer that exchanges most.
SCENE = [str(pathlib.Path(__file__).resolve().with_name("splash.toml")), "--set", "domain.cell_size=0.05",
         "--set", "transfer.scheme=moment_flip"]
STEPS, INTERRUPTION = 150, 60
REMAKE = ["--set", "partition.remake_interval=1"]
DECIDE = ["--set", "partition.decision_interval=5"]
# ranks and method of the whole run; ranks and method that continue its first part
CASES = ((5, "auto", DECIDE, 7, "hilbert"), (7, "metis", REMAKE, 30, "auto"), (30, "hilbert", REMAKE, 5, "metis"),
         (6, "bisection", REMAKE, 3, "bisection"))


def checkpoint(folder, step):
    return f"{folder}/checkpoint_{step:09d}.h5"


class Test:
    def __init__(self, program, work, scene):
        self.program = program
        self.work = work
        self.scene = scene

    def run(self, out, ranks, steps, *more):
        outcome = self.program.run(["run", *self.scene, "--out", out, "--max-steps", str(steps), "--set", "output.tiles=true",
                                    "--set", "output.grid=true",
                                    "--set", f"checkpoint.steps={INTERRUPTION}", "--set", "checkpoint.keep=9", *more],
                                   ranks, self.work, 200)
        if outcome.code != 0:
            fail(f"the run in {out} on {ranks} ranks ended with {outcome.code}", outcome)
        return outcome.text

    def expect_identical(self, one, other, what):
        compare = self.program.run(["compare", one, other], 1, self.work, 60)
        if compare.code != 0 or "identical" not in compare.text:
            fail(f"{what}: different", compare)
        print(f"{what}: identical")

    def expect_frames(self, out):
        frames = [{path.name for path in (self.work / folder).glob("frame_*.h5")} for folder in ("one", out)]
        if len(frames[0]) < 3 or frames[0] != frames[1]:
            fail(f"the frames in {out} are {sorted(frames[1])}, those of one rank {sorted(frames[0])}")
        for name in frames[0]:
            with h5py.File(self.work / "one" / name) as one, h5py.File(self.work / out / name) as other:
                for array in ("mass_density", "velocity"):
                    if not (one["grid"][array][...] == other["grid"][array][...]).all():
                        fail(f"grid/{array} of {out}/{name} is not that of one rank")
        print(f"{len(frames[0])} frames in {out}: the same nodes")


def main():
    def add(parser):
        parser.add_argument("--set", nargs="+", default=[], help="overrides")
        parser.add_argument("--cases", nargs="+", type=int, default=range(len(CASES)), help="places in CASES")

    arguments = parse_arguments(__doc__, add)
    test = Test(*start(arguments), SCENE + [word for override in arguments.set for word in ("--set", override)])
    if "1 ranks (1 x 1 x 1)" not in test.run("one", 1, STEPS):
        fail("one rank is not said to have a box")
    for ranks, method, settings, ranks_after, method_after in (CASES[place] for place in arguments.cases):
        out = f"r{ranks}"
        text = test.run(out, ranks, STEPS, "--set", f"partition.method={method}", *settings)
        if f"{ranks} ranks, output in" not in text:
            fail(f"{ranks} ranks: they have no boxes, but the start of the run does not say so:\n{text}")
        if settings is REMAKE and "\n0 new maps" in text:
            fail(f"no new map on {ranks} ranks ({method})")
        test.expect_identical(checkpoint("one", STEPS), checkpoint(out, STEPS), f"{ranks} ranks, {method}")
        test.expect_frames(out)

        parted = f"r{ranks}to{ranks_after}"
        test.run(parted, ranks, INTERRUPTION, "--set", f"partition.method={method}", *settings)
        test.run(parted, ranks_after, STEPS, "--restart", "--set", f"partition.method={method_after}", *DECIDE)
        test.expect_identical(checkpoint("one", STEPS), checkpoint(parted, STEPS),
                              f"{ranks} ranks, restarted on {ranks_after}")

        check = test.program.run(["check", *test.scene, "-n", str(ranks), "--set", f"partition.method={method}"], 1, test.work, 60)
        if check.code != 0 or f"ranks      {ranks}: at most" not in check.text:
            fail(f"check on {ranks} ranks", check)
        idle = "ranks start without particles" in check.text
        if idle != (ranks > 27):
            fail(f"check on {ranks} ranks must warn of idle ones where there are any", check)


if __name__ == "__main__":
    main()
