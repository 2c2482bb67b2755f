"""Reads files of every format version that there has been, and continues from them: version_N holds the scene, a checkpoint and a
frame that a program of that version wrote, and `end.h5`, where that program ended. version_N_WHAT holds further files of that
version; `scene_of_then.toml`, where a folder has it, is the scene with the keys of then, `scene.toml` with those of today."""

import pathlib
import re
import sys

import h5py
import numpy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402

HERE = pathlib.Path(__file__).resolve().parent
LIMIT = 60.0  # s
OLD_KEYS = ("step", "initial_step", "largest_step", "smallest_step")

FLUID = 0            # of the scene's materials: a yield-stress fluid; its flow curve was one of the Kirchhoff stress then
STEPS_DIFFER = 5e-4  # of a field's largest value: all that the rest notices is that the fluid sets other steps
CARRIED = ("reference_volume", "material")
# What laws dissipate was booked in another way then, and a rate is the overstress to the power of 4.5 in this fluid.
LEFT_OUT = ("connectivity", "plastic_dissipation", "plastic_shear_rate")


def particles_of(file):
    with h5py.File(file) as data:
        group = data["particles"]
        order = numpy.argsort(group["id"][:])
        return {name: group[name][:][order] for name in group if name not in LEFT_OUT}


def largest_difference(one, other):
    """Relative to the largest value; of fields that this material does not have, which are zero, absolute."""
    return float(numpy.abs(one - other).max() / (numpy.abs(other).max() or 1.0))


def check_end(name, ended, expected):
    """The fluid ends where it did but for the factor J between the two stresses; the rest ends there."""
    # Stored by every material then, a stress only where strain does not tell it since 0.3; a mass is its material's density times a volume.
    gone = {"mass"} | ({"kirchhoff_stress"} - set(ended))
    expected = {field: values for field, values in expected.items() if field not in gone}
    if set(ended) != set(expected):
        fail(f"{name}: ends with other fields: {set(ended) ^ set(expected)}")
    moved = sorted(set(expected) - {"id", *CARRIED})
    for field in ("id", *CARRIED):
        if not numpy.array_equal(ended[field], expected[field]):
            fail(f"{name}: {field} is not what the program that wrote it had")
    fluid = expected["material"] == FLUID
    factor = float(numpy.abs(expected["volume_ratio"][fluid] - 1.0).max())
    largest = {}
    for what, chosen, tolerance in (("the fluid", fluid, factor), ("the rest", ~fluid, STEPS_DIFFER)):
        differences = {field: largest_difference(ended[field][chosen], expected[field][chosen]) for field in moved}
        for field, difference in differences.items():
            if not difference <= tolerance:
                fail(f"{name}: {field} of {what} differs by {difference:.2g}, more than {tolerance:.2g}")
        largest[what] = max(differences.values())
    return ", ".join(f"{what} within {difference:.1g}" for what, difference in largest.items())


def newest_version(source):
    header = (source / "src/io/checkpoint/checkpoint.hpp").read_text()
    return int(re.search(r"checkpoint_version = (\d+);", header).group(1))


def check_version(program, folder, work):
    name = folder.name
    checkpoint, frame = next(folder.glob("checkpoint_*.h5")), next(folder.glob("frame_*.h5"))
    for file in (checkpoint, frame):
        info = program.run(["info", str(file)], 1, work, LIMIT)
        if info.code != 0:
            fail(f"{name}: {file.name} cannot be read", info)
    for scene in sorted(folder.glob("scene*.toml")):
        continue_run(program, folder, scene, checkpoint, work)


def continue_run(program, folder, scene, checkpoint, work):
    name = f"{folder.name}.{scene.stem}"
    command = ["run", str(scene), "--out", name, "--restart", str(checkpoint)]
    # APIC was the default then, every particle kept its own volume, and yield-stress fluids sheared in whole cells on floors; none of it is
    # followed by another unasked.
    refused = program.run(command, 3, work, LIMIT)
    for change in ('transfer.scheme: "apic" -> "moment_flip"', 'transfer.dilation: "particle" -> "auto"'):  # three are named
        if refused.code != 2 or change not in refused.text:
            fail(f"{name}: continues with another transfer", refused)
    run = program.run([*command, "--set", "transfer.scheme=apic", "--set", "transfer.dilation=particle", "--set",
                       "transfer.thin_layers=false"], 3, work, LIMIT)
    if run.code != 0:
        fail(f"{name}: cannot be continued", run)
    # The keys of the scene file are warned about, once for all ranks; those of the scene in the checkpoint are not.
    n_renamed = sum(key in scene.read_text(encoding="utf-8").split() for key in OLD_KEYS)
    if run.text.count("is now called") != n_renamed:
        fail(f"{name}: {n_renamed} keys of its scene have old names, and as many warnings are expected", run)
    # Checkpoints of then hold no energy budget, which is said once and begins.
    if run.text.count("holds no energy budget") != 1:
        fail(f"{name}: one sentence about the energy budget is expected", run)
    within = check_end(name, particles_of(sorted((work / name).glob("checkpoint_*.h5"))[-1]),
                       particles_of(folder / "end.h5"))
    print(f"{name}: read, continued on 3 ranks, same end, {within}")


def main():
    arguments = parse_arguments(__doc__, lambda parser: parser.add_argument("--source", required=True))
    program, work = start(arguments)
    newest = newest_version(pathlib.Path(arguments.source))
    for version in range(1, newest + 1):
        if not (HERE / f"version_{version}").is_dir():
            sys.exit(f"FAILED: version_{version} is missing: the format has version {newest}; keep files of every version")
        for folder in sorted(HERE.glob(f"version_{version}*")):
            check_version(program, folder, work)


if __name__ == "__main__":
    main()
