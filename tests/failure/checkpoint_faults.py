#!/usr/bin/env python3
"""Damaged, wrong and foreign checkpoints: each is refused in one sentence with the file and the fault, or it holds what it should.

A checkpoint is truncated, gets flipped bits everywhere, and is changed with matching checksums. `bulkley info` judges them
all; restarts from some must fail alike, leave the checkpoint before untouched, say so in status.json, and fall back on it with
a warning where no file is named. A flip that goes unnoticed must be in bytes that nothing uses: `compare` says `identical`.
"""

import hashlib
import json
import pathlib
import random
import re
import shutil
import sys
import zlib

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from cases import header_crc  # noqa: E402

SCENE = pathlib.Path(__file__).resolve().with_name("base.toml")
STEPS = 12
FEW = ["--set", "bodies.ball.particles_per_cell=1"]
RUN = ["run", str(SCENE), "--max-steps", str(STEPS), "--quiet", "--set", "checkpoint.steps=4", *FEW]
LAST, BEFORE = f"checkpoint_{STEPS:09d}.h5", "checkpoint_000000008.h5"
LIMIT = 30.0  # s; a run that takes longer counts as hanging
KILLED = re.compile(r"signal|Segmentation|SIGSEGV|core dumped|terminate called|Abort", re.IGNORECASE)


# --- what is done to a checkpoint: functions of its path ------------------------------------------------------------------------

def set_values(name, change):
    """Values of a dataset changed by `change(array)`, with the checksum of what they are then."""
    def work(path):
        with h5py.File(path, "r+") as file:
            data = file["particles"][name]
            values = data[...]
            change(values)
            data[...] = values
            data.attrs["crc32"] = data.attrs["crc32"].dtype.type(zlib.crc32(values.tobytes()))
    return work


def replace_dataset(name, make):
    """A dataset replaced by `make(array)`, with its attributes and the right checksum."""
    def work(path):
        with h5py.File(path, "r+") as file:
            old = file["particles"][name]
            values, attributes = make(old[...]), dict(old.attrs)
            del file["particles"][name]
            new = file["particles"].create_dataset(name, data=values)
            new.attrs.update(attributes)
            new.attrs["crc32"] = attributes["crc32"].dtype.type(zlib.crc32(values.tobytes()))
    return work


def remove_dataset(name):
    def work(path):
        with h5py.File(path, "r+") as file:
            del file["particles"][name]
    return work


def change_header(change):
    """Attributes changed by `change(file)`, with the header's checksum right again."""
    def work(path):
        with h5py.File(path, "r+") as file:
            change(file)
            file.attrs["header_crc32"] = file.attrs["header_crc32"].dtype.type(header_crc(file))
    return work


def set_attribute(name, value, group="/"):
    def change(file):
        file[group].attrs[name] = file[group].attrs[name].dtype.type(value)
    return change


def remove_attribute(name, group="/"):
    def work(path):
        with h5py.File(path, "r+") as file:
            del file[group].attrs[name]
    return work


def set_at(row, value):
    def change(values):
        values.reshape(len(values), -1)[row, 0] = value
    return change


def same_id_twice(first, second):
    def change(ids):
        ids[second] = ids[first]
    return change


def remove_fingerprints(path):
    with h5py.File(path, "r+") as file:
        del file["state/fingerprints"]


def all_of(*changes):
    def work(path):
        for change in changes:
            change(path)
    return work


def become(data):
    return lambda path: path.write_bytes(data)


def folder(path):
    path.unlink()
    path.mkdir()


def dangling_link(path):
    path.unlink()
    path.symlink_to("nowhere")


def foreign(path):
    with h5py.File(path, "w") as file:
        file["x"] = [1.0, 2.0]


def other_scene(path):
    def change(file):
        text = file.attrs["scene"]
        text = text if isinstance(text, bytes) else text.encode()
        assert text.count(b"27.2") == 1
        file.attrs["scene"] = numpy.bytes_(text.replace(b"27.2", b"28.2"))
    change_header(change)(path)


NEW = "cannot read 'out/" + LAST.replace(".", r"\.") + "': "
# name, what is done, sentence
WRONG = [
    ("velocity_nan", set_values("velocity", set_at(50, float("nan"))), "velocity of the particle in row 50 is nan"),
    ("position_infinite", set_values("position", set_at(0, float("inf"))), "position of the particle in row 0 is inf"),
    ("strain_nan", set_values("left_cauchy_green", set_at(-1, float("nan"))), r"left_cauchy_green of the particle in row \d+ is nan"),
    ("volume_zero", set_values("reference_volume", set_at(3, 0.0)), "reference_volume of the particle in row 3 is 0 and must be greater than 0"),
    ("volume_negative", set_values("reference_volume", set_at(9, -1e-6)), "reference_volume of the particle in row 9"),
    ("volume_ratio_negative", set_values("volume_ratio", set_at(9, -1.0)), "volume_ratio of the particle in row 9"),
    ("id_twice", set_values("id", same_id_twice(10, 11)), r"the particle id \d+ occurs twice"),
    ("id_twice_far_apart", set_values("id", same_id_twice(0, -1)), r"the particle id \d+ occurs twice"),
    ("id_all_the_same", set_values("id", lambda ids: ids.fill(7)), "the particle id 7 occurs twice"),
    ("id_twice_of_an_older_version", all_of(set_values("id", same_id_twice(0, -1)), remove_fingerprints),
     r"the particle id \d+ occurs twice"),
    ("id_changed", set_values("id", set_at(10, 2**40)), "id is not what was written"),
    ("velocity_changed", set_values("velocity", set_at(10, 0.125)), "velocity is not what was written"),
    ("id_negative", set_values("id", set_at(20, -5)), "id of the particle in row 20 is -5 and must not be negative"),
    ("material_out_of_range", set_values("material", set_at(5, 1)), "material of the particle in row 5 is 1, .* 1 materials"),
    ("no_positions", remove_dataset("position"), "/particles/position is missing"),
    ("no_ids", remove_dataset("id"), "/particles/id is missing"),
    ("no_materials", remove_dataset("material"), "/particles/material is missing"),
    ("no_connectivity", remove_dataset("connectivity"), "/particles/connectivity is missing"),
    ("volume_float32", replace_dataset("reference_volume", lambda volume: volume.astype("<f4")), "/particles/reference_volume is float32"),
    ("volume_int16", replace_dataset("reference_volume", lambda volume: volume.astype("<i2")), "reference_volume has an element type that does not belong"),
    ("velocity_of_two", replace_dataset("velocity", lambda v: v[:, :2].copy()), "/particles/velocity is float64 .* should be"),
    ("velocity_flat", replace_dataset("velocity", lambda v: v.reshape(-1).copy()), "/particles/velocity is float64 .* should be"),
    ("velocity_short", replace_dataset("velocity", lambda v: v[:-1].copy()), "/particles/velocity is float64 .* should be"),
    ("velocity_scalar", replace_dataset("velocity", lambda v: v[0, 0]), "/particles/velocity is float64 .* should be"),
    ("no_step", remove_attribute("step"), "attribute 'step' of / is missing"),
    ("no_checksum", remove_attribute("crc32", "particles/reference_volume"), "attribute 'crc32' of /particles/reference_volume is missing"),
    ("no_header_checksum", remove_attribute("header_crc32"), "attribute 'header_crc32' of / is missing"),
    ("header_changed", lambda path: h5py.File(path, "r+").attrs.modify("time", 0.5), "its header is damaged"),
    ("too_many_particles", change_header(set_attribute("n_particles", 10**12)), "should be"),
    ("particles_negative", change_header(set_attribute("n_particles", -1)), ""),
    ("newer_format", change_header(set_attribute("format_version", 2)), "its format version is 2"),
    ("format_zero", change_header(set_attribute("format_version", 0)), "its format version is 0"),
    ("not_hdf5", become(b"not a checkpoint\n"), "it is not an HDF5 file"),
    ("empty", become(b""), "it is empty"),
    ("noise", become(bytes(random.Random(3).randrange(256) for _ in range(20000))), "it is not an HDF5 file"),
    ("folder", folder, "it is not a file"),
    ("dangling_link", dangling_link, "there is no such file"),
    ("foreign_hdf5", foreign, "it is an HDF5 file, but not"),
]
# `info` looks for a checkpoint in a folder, and may be given the name of one.
OTHER_FOR_INFO = {"folder": "holds no whole checkpoint", "dangling_link": "no such file or folder"}
# Refused by a restart alone: only the scene shows that they are wrong. name, what is done, sentence, exit code.
WRONG_FOR_THE_SCENE = [
    ("outside", all_of(set_values("position", set_at(8, 7.0)), remove_fingerprints), "holds particles outside the domain", 2),
    ("other_materials", change_header(lambda file: file.attrs.modify("materials", numpy.bytes_(b"honey"))), "honey.*fluid", 2),
    ("other_scene", other_scene, r"materials\.fluid\.eta: 28\.2 -> 27\.2; --changed-scene", 2),
    ("no_state", lambda path: change_header(lambda file: file["state/reals"].attrs.__delitem__("last_step"))(path),
     "does not hold 'last_step'", 3),
]
# Those that are restarted from, too, and those without naming a file, and on three ranks; the others are equal.
RESTARTED = {"velocity_nan", "id_twice", "id_twice_far_apart", "id_all_the_same", "material_out_of_range", "no_ids",
             "volume_float32", "newer_format", "empty", "folder", "noise", "too_many_particles"}
FALL_BACK = {"velocity_nan", "id_twice_far_apart", "empty", "too_many_particles"}


class Bench:
    def __init__(self, program, work):
        self.program, self.work = program, work
        self.out, self.file = work / "out", work / "out" / LAST
        self.figures = {"refused": 0, "unnoticed and identical": 0, "restarts refused": 0, "fallbacks": 0}
        self.slowest = 0.0
        run = program.run([*RUN, "--out", "whole"], 2, work, 60)
        if run.code != 0:
            fail("the run that is to be damaged failed", run)
        self.bytes = (work / "whole" / LAST).read_bytes()

    def fresh(self):
        if self.out.exists():
            shutil.rmtree(self.out)
        shutil.copytree(self.work / "whole", self.out)

    def call(self, name, arguments, ranks=1):
        outcome = self.program.run(arguments, ranks, self.work, LIMIT)
        if outcome.code is None:
            fail(f"{name}: {arguments[0]} hung on {ranks} ranks", outcome)
        if outcome.code < 0 or outcome.code > 4 or KILLED.search(outcome.text.replace("has been aborted", "")):
            fail(f"{name}: {arguments[0]} on {ranks} ranks was killed", outcome)
        self.slowest = max(self.slowest, outcome.seconds)
        return outcome

    def expect_refused(self, name, outcome, sentence, code=3):
        lines = [line for line in outcome.text.splitlines() if LAST in line and not line.startswith("warning: ")]
        if outcome.code != code or len(lines) != 1 or not re.search(sentence, lines[0]):
            fail(f"{name}: exit code {outcome.code} instead of {code}, or not one sentence like '{sentence}'", outcome)

    def info(self, name, sentence, code=3):
        """Whether `info` refused the file; if not, it must hold what it should."""
        outcome = self.call(name, ["info", f"out/{LAST}"])
        if outcome.code != 0:
            self.expect_refused(name, outcome, sentence, code)
            self.figures["refused"] += 1
            return True
        return False

    def flips_and_cuts(self, every):
        """One bit of every 512 bytes and some more anywhere; every length that is a multiple of 4096 bytes."""
        self.fresh()
        dice = random.Random(11)
        places = [min(begin + dice.randrange(512), len(self.bytes) - 1) for begin in range(0, len(self.bytes), 512)]
        places += range(0, 96)  # the signature of the file
        places += [dice.randrange(len(self.bytes)) for _ in range(60)]
        if not every:
            places = places[:: 8]
        for place in places:
            damaged = bytearray(self.bytes)
            damaged[place] ^= 1 << dice.randrange(8)
            self.file.write_bytes(damaged)
            if not self.info(f"flip_at_{place}", NEW):
                compare = self.call(f"flip_at_{place}", ["compare", f"whole/{LAST}", f"out/{LAST}"])
                if compare.code != 0 or "identical" not in compare.text:
                    fail(f"a flipped bit at {place} of {len(self.bytes)} went unnoticed and is not harmless", compare)
                self.figures["unnoticed and identical"] += 1
        lengths = list(range(0, len(self.bytes), 4096)) + [1, 8, 2047, len(self.bytes) - 1]
        for length in lengths if every else lengths[:: 3] + [len(self.bytes) - 1]:
            self.file.write_bytes(self.bytes[:length])
            if not self.info(f"cut_at_{length}", NEW):
                fail(f"a file of {length} of {len(self.bytes)} bytes is taken as whole")
        print(f"{len(self.bytes)} bytes, {len(places)} flips: {self.figures}", flush=True)

    def refused_restart(self, name, sentence, ranks, code=3):
        before = self.out / BEFORE
        held = hashlib.sha256(before.read_bytes()).digest()
        outcome = self.call(name, [*RUN, "--out", "out", "--restart", f"out/{LAST}"], ranks)
        self.expect_refused(name, outcome, sentence, code)
        if hashlib.sha256(before.read_bytes()).digest() != held:
            fail(f"{name}: the checkpoint before was touched")
        status = json.loads((self.out / "status.json").read_text(encoding="utf-8"))
        if code == 3 and (status["state"] != "failed" or LAST not in status["reason"]):
            fail(f"{name}: status.json says {status}")
        self.figures["restarts refused"] += 1

    def fall_back(self, name, sentence, ranks):
        """Without a file the checkpoint before is taken, and leads to the same end."""
        outcome = self.call(name, [*RUN, "--out", "out", "--restart"], ranks)
        if outcome.code != 0 or not re.search(f"warning: checkpoint skipped: .*{sentence}", outcome.text):
            fail(f"{name}: no warning, or the checkpoint before was not used", outcome)
        compare = self.call(name, ["compare", f"whole/{LAST}", f"out/{LAST}"])
        if compare.code != 0:
            fail(f"{name}: the checkpoint before leads to another end", compare)
        self.figures["fallbacks"] += 1

    def wrong(self, every):
        for name, work, sentence in WRONG:
            self.fresh()
            work(self.file)
            if name in OTHER_FOR_INFO:
                refused = self.info(name, OTHER_FOR_INFO[name], 2)
            else:
                refused = self.info(name, NEW + ".*" + sentence)
            if not refused:
                fail(f"{name}: is taken as whole")
            if name not in RESTARTED and not every:
                continue
            for ranks in (1, 3) if every or name in FALL_BACK else (1,):
                self.refused_restart(name, sentence, ranks)
            if name in FALL_BACK or every and name != "folder":  # which is never removed
                self.fall_back(name, sentence, 3 if name.startswith("id_twice") else 1)
        for name, work, sentence, code in WRONG_FOR_THE_SCENE:
            self.fresh()
            work(self.file)
            self.refused_restart(name, sentence, 2, code)
        print(f"{len(WRONG) + len(WRONG_FOR_THE_SCENE)} that are wrong: {self.figures}", flush=True)

    def changed_scenes(self):
        """What may change between the parts of a run, and what only with a flag."""
        self.fresh()
        restart = [*RUN, "--out", "out", "--restart", f"out/{BEFORE}"]
        harmless = ["time.end=0.02", "title=other", "output.progress_interval=1", "checkpoint.keep=5", "partition.method=hilbert"]
        outcome = self.call("harmless", restart + [part for change in harmless for part in ("--set", change)], 2)
        if outcome.code != 0 or "is not this one" in outcome.text:
            fail("a change of title, end, output, checkpoint or partition stops a restart", outcome)
        # Frames at other times than before: time and the numbers of the frames continue.
        self.fresh()
        frames = ["--set", "output.history_interval=1", "--set"]
        self.call("first_frames", [*RUN, "--out", "framed", *frames, "output.frame_interval=2e-5"])
        more = [part if part != str(STEPS) else "40" for part in RUN]
        for interval in ("1e-5", "1.1e-4"):
            outcome = self.call("other_frames", [*more, "--out", "framed", "--restart", *frames, f"output.frame_interval={interval}"])
            rows = (self.work / "framed" / "history.csv").read_text(encoding="utf-8").splitlines()[1:]
            times = [float(row.split(",")[1]) for row in rows]
            numbers = sorted(int(path.name[6:12]) for path in (self.work / "framed").glob("frame_*.h5"))
            if outcome.code != 0 or sorted(set(times)) != times or numbers != list(range(len(numbers))):
                fail(f"frames of {interval} s after others: time goes {times}, frames are {numbers}", outcome)
            more = [part if part != "40" else "80" for part in more]
        self.fresh()
        harmful = ["--set", "materials.fluid.eta=28", "--set", "gravity=[0,0,-1]"]
        outcome = self.call("harmful", [*restart, *harmful], 2)
        sentence = r"its scene is not this one: gravity: \[.*\] -> \[.*\]; materials\.fluid\.eta: 27\.2 -> 28.*--changed-scene"
        if outcome.code != 2 or not re.search(sentence, outcome.text):
            fail("a changed material does not stop a restart with the keys", outcome)
        outcome = self.call("allowed", [*restart, *harmful, "--changed-scene"], 2)
        if outcome.code != 0 or "warning: " not in outcome.text or "materials.fluid.eta" not in outcome.text:
            fail("--changed-scene does not allow a changed scene, or without a warning", outcome)
        if "eta = 28" not in (self.out / "scene.toml").read_text(encoding="utf-8"):
            fail("scene.toml of the continued run is not the scene in effect")

    def retention(self):
        """`keep` never removes the last whole checkpoint, though newer ones were damaged since."""
        self.fresh()
        self.file.write_bytes(self.bytes[:5000])
        more = [part if part != str(STEPS) else str(STEPS + 1) for part in RUN]
        outcome = self.call("retention", [*more, "--out", "out", "--restart", "--set", "checkpoint.keep=1"], 2)
        if outcome.code != 0:
            fail("retention: the run did not go on", outcome)
        names = sorted(path.name for path in self.out.glob("checkpoint_*.h5"))
        if names != [f"checkpoint_{STEPS + 1:09d}.h5"]:
            fail(f"retention: keep = 1 left {names}")
        if self.call("retention", ["info", f"out/{names[0]}"]).code != 0:
            fail("retention: what was kept is not whole")


def main():
    def add(parser):
        parser.add_argument("--all", action="store_true", help="every flip and cut, not a part of them")
    arguments = parse_arguments(__doc__, add)
    program, work = start(arguments)
    bench = Bench(program, work)
    bench.flips_and_cuts(arguments.all)
    bench.wrong(arguments.all)
    bench.changed_scenes()
    bench.retention()
    print(", ".join(f"{name}: {n}" for name, n in bench.figures.items()) + f"; the slowest call took {bench.slowest:.1f} s")


if __name__ == "__main__":
    main()
