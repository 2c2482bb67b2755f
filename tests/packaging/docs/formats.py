#!/usr/bin/env python3
"""docs/file-formats.md against the files of a run that writes everything there is: every dataset, attribute and column of
the files stands on the page, every dataset and column of the page in the files, and checksums are what the page says."""

import json
import pathlib
import re
import sys
import zlib

sys.dont_write_bytecode = True
ROOT = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(ROOT / "tests/support"))
import h5py  # noqa: E402
from bulkley_program import fail, parse_arguments, start  # noqa: E402

FIELDS = ["velocity", "affine_velocity", "left_cauchy_green", "volume_ratio", "kirchhoff_stress", "plastic_shear_rate",
          "plastic_dissipation", "mass", "reference_volume", "structure", "hardening", "plastic_volume_ratio",
          "viscous_left_cauchy_green", "cell_mean_stress", "viscous_stress", "magnetic_force", "magnetic_field", "magnetisation",
          "magnetic_field_strength", "material", "id", "pressure", "deviatoric_stress", "cauchy_stress", "density", "rank"]
SCENE = ["run", str(ROOT / "drivers/scenes/all_materials.toml"), "--out", "out", "--quiet", "--max-steps", "3",
         "--set", "domain.cell_size=0.05", "--set", "output.history_interval=1", "--set", "output.frame_interval=1e-5",
         "--set", "output.grid=true", "--set", "output.tiles=true", "--set", "output.magnetic_field=true", "--set", "output.fields=" + json.dumps(FIELDS),
         "--set", "time.integrator=imex", "--set", "time.viscosity=implicit", "--set", 'acceleration_field=["0","0","1"]',
         "--set", 'colliders=[{name="plate",velocity=[0,0,0.01],shape={type="box",lower=[0.1,0.1,0],upper=[0.3,0.3,0.1]}}]',
         "--set", 'materials.cream.magnetic={law="langevin",susceptibility=1,saturation=3e4,yield="tanh",yield_saturation=9,yield_field=1e4}',
         "--set", 'magnetics={sources=[{kind="uniform",field=["1e3","0","0"]}]}',
         "--set", 'output.front=[{name="tip",direction=[1,0,0]}]', "--set", 'output.gauge=[{name="patch",face="z_lower"}]']
BODIES = ["run", str(ROOT / "drivers/scenes/jet.toml"), "--out", "bodies", "--quiet", "--max-steps", "1",
          "--set", "domain.cell_size=0.025", "--set", "output.history_interval=1", "--set", "output.frame_interval=0",
          "--set", "boundaries.z_lower=sticky",  # and without imex, for layer_pressure
          "--set", 'rigid_bodies=[{name="weight",density=1e3,shape={type="sphere",center=[0.7,0.2,0.2],radius=0.06}}]']  # no imex
INFLOW = ["run", str(ROOT / "tests/system/inflow.toml"), "--out", "inflow", "--quiet", "--max-steps", "1"]
MEASURED = ("plate", "tip", "patch", "weight", "bar", "disc", "arm", "lump")  # names of columns


def names_in(files):
    """Names of datasets and attributes in HDF5 files, those of the controllers' state left out."""
    names = set()
    for path in files:
        with h5py.File(path) as file:
            names.update(file.attrs)

            def visit(name, item):
                if isinstance(item, h5py.Dataset):
                    names.add(name.rpartition("/")[2])
                if not name.startswith("state/"):
                    names.update(item.attrs)

            file.visititems(visit)
    return names


def wrong_checksums(files):
    for path in files:
        with h5py.File(path) as file:
            wrong = []

            def visit(name, item):
                if isinstance(item, h5py.Dataset) and zlib.crc32(item[()].tobytes()) != item.attrs["crc32"]:
                    wrong.append(f"{path.name}: {name}")

            file.visititems(visit)
            yield from wrong


def main():
    program, work = start(parse_arguments(__doc__))
    outcome = program.run(SCENE, 1, work, 120)
    if outcome.code != 0:
        fail("the run did not end", outcome)
    folder = work / "out"
    outcome = program.run(BODIES, 1, work, 120)
    if outcome.code != 0:
        fail("the run with a rigid body did not end", outcome)
    outcome = program.run(INFLOW, 1, work, 120)
    if outcome.code not in (0, 4):
        fail("the run with an inflow did not end", outcome)
    page = (ROOT / "docs/file-formats.md").read_text(encoding="utf-8")
    code = set(re.findall(r"`([^`]+)`", page))
    files = sorted(folder.glob("*.h5"))

    faults = [f"the page does not name '{name}', which the files have"
              for name in sorted(names_in(files) - code - {"about"})]
    # First columns of the tables of datasets: what they name must be in some file.
    tables = page[page.index("## Checkpoint"):page.index("## XDMF")]
    claimed = {name for row in re.findall(r"^\| (`.*?) \|", tables, re.MULTILINE) for name in re.findall(r"`(\w+)`", row)}
    faults += [f"the page names the dataset '{name}', which no file has" for name in sorted(claimed - names_in(files + sorted((work / "bodies").glob("*.h5"))))]

    columns = [column for run in (folder, work / "bodies", work / "inflow")
               for column in (run / "history.csv").read_text(encoding="utf-8").splitlines()[0].split(",")]
    expected = {re.sub(r"^NAME", own, name) for name in code for own in MEASURED}
    own = [re.sub(r"^wall_[xyz]_(lower|upper)", "wall_FACE", name) for name in columns
           if not re.match(r"\w+\.(force|torque)_", name)]
    faults += [f"the page does not name the column '{name}'" for name in own if name not in expected]
    history = page[page.index("## history.csv"):page.index("## status.json")]
    claimed = {name for row in re.findall(r"^\| (`.*?) \|", history, re.MULTILINE) for name in re.findall(r"`([^`]+)`", row)}
    faults += [f"the page names the column '{name}', which history.csv has not"
               for name in sorted(claimed)
               if not any(name.replace("NAME", own).replace("FACE", "z_lower") in columns for own in MEASURED)]
    faults += [f"the page does not name the key '{key}' of status.json"
               for key in json.loads((folder / "status.json").read_text(encoding="utf-8")) if key not in code]
    # Every file by its pattern.
    for path in folder.iterdir():
        pattern = re.sub(r"\d", "N", path.stem)
        if pattern + path.suffix not in code and not (pattern + ".h5" in code and path.suffix == ".xdmf"):
            faults.append(f"the page does not name the file {path.name}")
    faults += [f"the checksum of {name} is not zlib's" for name in wrong_checksums(files)]
    if faults:
        fail("\n".join(faults))
    print(f"{len(files)} HDF5 files, {len(columns)} columns: all as docs/file-formats.md says")


if __name__ == "__main__":
    main()
