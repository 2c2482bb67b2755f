#!/usr/bin/env python3
"""`bulkley convert`: the same bytes on any number of ranks, the contents of the files as h5py sees the originals,
selections, refusals, a full disk, and ParaView reading what was written."""

import csv
import pathlib
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ElementTree

import h5py
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
from bulkley_program import fail, parse_arguments, start  # noqa: E402
from sample_run import chosen_by_id, expect, make_run, truth  # noqa: E402

FORMATS = ("vtu", "vtkhdf", "csv")
VTK_TYPES = {"Float32": "<f4", "Float64": "<f8", "Int32": "<i4", "Int64": "<i8", "UInt8": "u1"}
SUFFIXES = {1: [""], 3: ["_x", "_y", "_z"], 6: ["_xx", "_yy", "_zz", "_xy", "_yz", "_xz"],
            9: [f"_{a}{b}" for a in "xyz" for b in "xyz"]}


class Test:
    def __init__(self, program, work):
        self.program, self.work = program, work

    def convert(self, *arguments, ranks=1, code=0):
        outcome = self.program.run(["convert", *map(str, arguments)], ranks, self.work, 60)
        if outcome.code != code:
            fail(f"'bulkley convert {' '.join(map(str, arguments))}' ended with {outcome.code}, not {code}", outcome)
        return outcome.text

    def refuses(self, *arguments, words, code=2, ranks=1):
        text = self.convert(*arguments, code=code, ranks=ranks)
        lines = [line for line in text.splitlines() if line.strip()]
        if not all(word in lines[0] for word in words) or (ranks == 1 and len(lines) != 1):
            fail(f"'bulkley convert {' '.join(map(str, arguments))}' must say one sentence with {words}:\n{text}")


# --- readers of our own -----------------------------------------------------------------------------------------

def read_vtu(path):
    """Points, fields, cells, and the time."""
    data = path.read_bytes()
    begin = data.index(b"   _", data.index(b"<AppendedData")) + 4
    root = ElementTree.fromstring(data[:begin] + data[data.rindex(b"\n  </AppendedData>"):])
    piece = root.find("UnstructuredGrid/Piece")

    def array(element):
        at = begin + int(element.get("offset"))
        size = int(np.frombuffer(data, "<u8", 1, at)[0])
        values = np.frombuffer(data[at + 8:at + 8 + size], VTK_TYPES[element.get("type")])
        n = int(element.get("NumberOfComponents"))
        return values.reshape(-1, n) if n > 1 else values

    sections = {name: {e.get("Name"): array(e) for e in piece.find(name)} for name in ("Points", "Cells", "PointData")}
    if len(sections["Points"]["position"]) != int(piece.get("NumberOfPoints")):
        fail(f"{path}: NumberOfPoints is not that of the points")
    time = float(root.find("UnstructuredGrid/FieldData/DataArray[@Name='TimeValue']").text)
    return sections["Points"]["position"], sections["PointData"], sections["Cells"], time


def read_vtkhdf(path):
    with h5py.File(path) as file:
        group = file["VTKHDF"]
        expect(group.attrs["Type"] == b"UnstructuredGrid" and list(group.attrs["Version"]) == [1, 0], f"{path}: attributes")
        cells = {"connectivity": group["Connectivity"][...], "offsets": group["Offsets"][1:], "types": group["Types"][...]}
        expect(group["Offsets"][0] == 0, f"{path}: Offsets")
        n = len(group["Points"])
        expect([group[f"NumberOf{what}"][...].tolist() for what in ("Points", "Cells", "ConnectivityIds")] == [[n]] * 3,
               f"{path}: counts")
        fields = {name: array[...] for name, array in group["PointData"].items()} if "PointData" in group else {}
        return group["Points"][...], fields, cells, group["FieldData/TimeValue"][0]


def read_csv(path, arrays):
    """Points and fields with the shapes and types of `arrays`; units are looked at elsewhere."""
    with open(path, newline="", encoding="utf-8") as stream:
        header, *rows = csv.reader(stream)
    columns = dict(zip([name.split(" [")[0] for name in header], zip(*rows) if rows else [[] for _ in header]))
    fields = {}
    for name, array in arrays.items():
        suffixes = SUFFIXES[int(np.prod(array.shape[1:]))]
        if name + suffixes[0] in columns:
            integer = np.issubdtype(array.dtype, np.integer)
            fields[name] = np.column_stack([[int(v) if integer else array.dtype.type(v) for v in columns[name + suffix]]
                                            for suffix in suffixes])
    return fields.pop("position"), fields, len(columns)


# --- contents ---------------------------------------------------------------------------------------------------

def equal(found, wanted, what):
    """The same bits for rows of any shape."""
    wanted = wanted.reshape(len(wanted), int(np.prod(wanted.shape[1:])))
    found = np.asarray(found).reshape(len(found), -1) if len(found) else np.empty(wanted.shape, wanted.dtype)
    if found.shape != wanted.shape or not np.array_equal(found, wanted):
        fail(f"{what}: other values than in the original")


def check_file(path, original, chosen=None, fields=None):
    """One converted file against what h5py reads."""
    arrays, time = truth(original)
    chosen = np.ones(len(arrays["position"]), bool) if chosen is None else chosen
    wanted = {name: array[chosen] for name, array in arrays.items() if name == "position" or not fields or name in fields}
    if path.suffix == ".csv":
        points, found, n_columns = read_csv(path, arrays)
        expect(n_columns == sum(int(np.prod(array.shape[1:])) for array in wanted.values()), f"{path}: columns")
    else:
        points, found, cells, found_time = (read_vtu if path.suffix == ".vtu" else read_vtkhdf)(path)
        expect(found_time == time, f"{path}: time {found_time}, should be {time}")
        n = int(chosen.sum())
        expect(np.array_equal(cells["connectivity"], np.arange(n)) and np.array_equal(cells["offsets"], np.arange(n) + 1)
               and np.array_equal(cells["types"], np.ones(n)), f"{path}: cells are not one vertex a particle")
        for name, values in found.items():
            expect(values.dtype == arrays[name].dtype, f"{path}: {name} is {values.dtype}")
    equal(points, wanted.pop("position"), f"{path}, position")
    expect(set(found) == set(wanted), f"{path}: fields {sorted(found)}, should be {sorted(wanted)}")
    for name, values in wanted.items():
        equal(found[name], values, f"{path}, {name}")


def check_ranks_and_content(test, run):
    """All frames and all formats on 1, 2 and 3 ranks."""
    for form in FORMATS:
        bytes_of = []
        for ranks in (1, 2, 3):
            folder = test.work / f"{form}{ranks}"
            test.convert(run, "--to", form, "--out", folder, ranks=ranks)
            bytes_of.append({path.name: path.read_bytes() for path in sorted(folder.iterdir())})
        expect(bytes_of[0] == bytes_of[1] == bytes_of[2], f"{form}: other bytes on other numbers of ranks")
        names = [f"frame_{n:06}.{form}" for n in range(3)] + (["frames.pvd"] if form == "vtu" else [])
        expect(sorted(bytes_of[0]) == names, f"{form}: the files are {sorted(bytes_of[0])}")
        for n in range(3):
            check_file(test.work / f"{form}1" / names[n], run / f"frame_{n:06}.h5")
    header = (test.work / "csv1/frame_000000.csv").read_text().splitlines()[0]
    expect(header.startswith("id,position_x [m],position_y [m],position_z [m],cauchy_stress_xx [Pa],cauchy_stress_xy [Pa],"),
           f"the header is {header}")
    times = [float(e.get("timestep")) for e in ElementTree.parse(test.work / "vtu1/frames.pvd").iter("DataSet")]
    expect(times == [truth(run / f"frame_{n:06}.h5")[1] for n in range(3)], f"frames.pvd has times {times}")


def check_selections(test, run):
    frame = run / "frame_000001.h5"
    arrays, _ = truth(frame)
    position = arrays["position"].astype(float)
    box = (position[:, 0] >= 0.1) & (position[:, 2] >= 0.04) & (position[:, 2] < 0.06)
    third = chosen_by_id(arrays["id"], 3)
    expect(50 < (box & third).sum() < box.sum() / 2 < 0.4 * len(box), "the selection tells nothing")
    for form in FORMATS:
        out = test.work / f"part.{form}"
        text = test.convert(frame, "--to", form, "--out", out, "--region", "0.1:,:,0.04:0.06", "--every", 3,
                            "--fields", "velocity,position,id", ranks=3)
        expect(f"{(box & third).sum()} of {len(box)} particles" in text, f"the counts are not told: {text}")
        check_file(out, frame, box & third, ["velocity", "id"])
        test.convert(frame, "--to", form, "--out", out, "--region", "-2:-1,:,:", "--fields", "velocity",
                     ranks=2 if form == "vtkhdf" else 1)
        check_file(out, frame, np.zeros(len(box), bool), ["velocity"])
        checkpoint = next(run.glob("checkpoint_*.h5"))
        test.convert(checkpoint, "--to", form, "--out", out, "--every", 2, "--fields", "left_cauchy_green,affine_velocity")
        check_file(out, checkpoint, chosen_by_id(truth(checkpoint)[0]["id"], 2), ["left_cauchy_green", "affine_velocity"])
    # The same particles at every time.
    folder = test.work / "tracers"
    test.convert(run, "--to", "csv", "--out", folder, "--every", 5, "--fields", "id")
    ids = [sorted(np.loadtxt(path, delimiter=",", skiprows=1)[:, 0]) for path in sorted(folder.iterdir())]
    expect(len(ids) == 3 and ids[0] == ids[1] == ids[2], "--every takes other particles at other times")
    share = len(ids[0]) / len(position)
    expect(0.15 < share < 0.25, f"--every 5 takes {share:.3f} of the particles")
    for frames, wanted in (("last", [2]), ("0,2", [0, 2]), ("1:", [1, 2]), (":2", [0, 1]), ("0:9:2", [0, 2])):
        shutil.rmtree(folder)
        test.convert(run, "--to", "csv", "--out", folder, "--fields", "id", "--frames", frames)
        found = [int(path.stem[6:]) for path in sorted(folder.iterdir())]
        expect(found == wanted, f"--frames {frames} takes {found}")


def check_refusals(test, run):
    frame, to = run / "frame_000001.h5", ["--to", "csv", "--out", test.work / "x.csv"]
    test.refuses(frame, *to, "--fields", "velocty", words=["has no field 'velocty'", "did you mean 'velocity'?"])
    test.refuses(frame, *to, "--fields", "velocity,,id", words=["--fields:"])
    test.refuses(frame, *to, "--fields", "velocity,velocity", words=["named twice"])
    test.refuses(frame, *to, "--region", "0:1", words=["--region: '0:1' must be x0:x1,y0:y1,z0:z1"])
    test.refuses(frame, *to, "--region", "0:1,:,0:a", words=["--region: 'a' is not a number"])
    test.refuses(frame, *to, "--region", "0:1,:,1", words=["--region: '1' must be lower:upper"])
    test.refuses(frame, *to, "--region", "1:0,:,:", words=["--region: 1 must be below 0"])
    test.refuses(run / "frame_000009.h5", *to, words=["no such file or folder"])
    test.refuses(frame, "--to", "vtk", "--out", "x", words=["--to: there is no format 'vtk'", "did you mean 'vtu'?"])
    test.refuses(frame, "--to", "vtu", "--out", "x.csv", words=["--out: 'x.csv' does not end in .vtu"])
    test.refuses(run, *to, words=["is one file, and 3 are to be converted"])
    test.refuses(run, run, "--to", "csv", "--out", "twice", words=["two of the inputs would become"])
    test.refuses(frame, *to, "--frames", "0", words=["--frames is for the folder of a run"])
    for frames in ("a", "1:0", "0,,1", "0:1:0", "-1"):
        test.refuses(run, "--to", "csv", "--out", "f", "--frames", frames, words=[f"--frames: '{frames}' must be"])
    test.refuses(run, "--to", "csv", "--out", "f", "--frames", "7", words=["has no frame 7; it has 0 to 2"])
    test.refuses(run, "--to", "csv", "--out", "f", "--frames", "5:9", words=["takes none of the frames"])
    (test.work / "empty").mkdir()
    test.refuses("empty", *to, words=["holds no frames"])
    with h5py.File(test.work / "foreign.h5", "w") as file:
        file["x"] = 1
    test.refuses("foreign.h5", *to, words=["is neither a frame nor a checkpoint"])
    (test.work / "text.h5").write_text("no HDF5")
    test.refuses("text.h5", *to, words=["it is not an HDF5 file"], code=3)
    shutil.copy(frame, test.work / "no_ids.h5")
    with h5py.File(test.work / "no_ids.h5", "r+") as file:
        del file["particles/id"]
    test.refuses("no_ids.h5", *to, "--every", 2, words=["does not contain the ids of its particles", "output.fields"])
    shutil.copy(next(run.glob("checkpoint_*.h5")), test.work / "damaged.h5")
    with h5py.File(test.work / "damaged.h5", "r+") as file:
        file["particles/velocity"][7, 1] += 1.0
    test.refuses("damaged.h5", *to, words=["/particles/velocity is damaged"], code=3, ranks=3)
    expect(not list(test.work.glob("x.csv*")), "a refused conversion leaves a file")


def check_full_disk(test, run, shim):
    """One rank of two finds the disk full; and the root finds no room."""
    if not shim:
        print("a full disk is not tried: the library that feigns it is not built")
        return
    for form, fault in (("vtu", "pwrite"), ("vtkhdf", "pwrite"), ("csv", "pwrite"), ("vtu", "fallocate")):
        out = test.work / f"full.{form}"
        out.write_text("before")
        environment = {"LD_PRELOAD": shim, "FAULT_PATH": f"full.{form}", "FAULT_CALLS": fault, "FAULT_KIND": "ENOSPC",
                       "FAULT_RANK": "1" if fault == "pwrite" else "0"}
        outcome = test.program.run(["convert", str(run / "frame_000001.h5"), "--to", form, "--out", out.name], 2, test.work, 60,
                                   environment)
        sentence = outcome.text.splitlines()[0]
        if outcome.code != 3 or "cannot write" not in sentence or out.name not in sentence or "No space" not in sentence:
            fail(f"--to {form} on a full disk: exit code {outcome.code}", outcome)
        left = list(test.work.glob(f"full.{form}.*"))
        expect(out.read_text() == "before" and not left, f"{form}: the disk is not as it was")


def check_paraview(test, run, pvpython):
    if not shutil.which(pvpython):
        print("pvpython was not found: ParaView does not read the files")
        return
    test.convert(run, "--to", "vtkhdf", "--out", "in_paraview.hdf", "--frames", "last")
    script = pathlib.Path(__file__).resolve().with_name("paraview_reads.py")
    result = subprocess.run([pvpython, "--force-offscreen-rendering", str(script), str(run), str(test.work / "vtu2"),
                             str(test.work / "vtkhdf3"), str(test.work / "in_paraview.hdf")], capture_output=True, text=True,
                            stdin=subprocess.DEVNULL, timeout=120, check=False)
    if result.returncode != 0:
        fail(f"ParaView reads something else: {result.stdout}{result.stderr}")
    print(result.stdout.strip())


def main():
    def add(parser):
        parser.add_argument("--pvpython", default="")
        parser.add_argument("--shim", default="", help="the library of tests/failure/storage_shim.c")
    arguments = parse_arguments(__doc__, add)
    program, work = start(arguments)
    test = Test(program, work)
    run = make_run(program, work, "output.compression=1")
    check_ranks_and_content(test, run)
    check_selections(test, run)
    check_refusals(test, run)
    check_full_disk(test, run, arguments.shim)
    check_paraview(test, run, arguments.pvpython)


if __name__ == "__main__":
    main()
