#!/usr/bin/env pvpython
"""Checks that ParaView sees what a run has written.

    pvpython --force-offscreen-rendering drivers/paraview/check_output.py --run DIR [--particles N]

Opens frames.xdmf, and grid.xdmf, tiles.xdmf and colliders.xdmf (if there), and the newest checkpoint's sidecar with both of ParaView's XDMF
readers and compares points, cells, bounds, times, names, components and ranges of the fields with what the HDF5 files
themselves say (read by h5py); colliders also with the poses that the frames have. Needs no display. Exit code: 0 all agree; 1 something differs, one sentence each; 2 nothing to
check.
"""

import argparse
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

import h5py
import numpy
from paraview import simple

READERS = {
    "XDMFReader": lambda path: simple.XDMFReader(FileNames=[path]),
    "Xdmf3ReaderS": lambda path: simple.Xdmf3ReaderS(FileName=[path]),
}
TOLERANCE = 1e-6  # relative; ParaView may keep bounds of float32 points in float32


class Snapshot:
    """One time of a series, as in the HDF5 file."""

    def __init__(self, folder, element):
        self.time = float(element.find("Time").get("Value"))
        self.on_cells = element.get("Name") in ("tiles", "colliders")
        items = [item.text.strip() for item in element.iter("DataItem") if item.get("Format") == "HDF"]
        if element.get("Name") == "colliders":
            self.read_colliders(folder, *items)
            return
        self.file = folder / items[0].split(":")[0]
        with h5py.File(self.file, "r") as data:
            if abs(float(data.attrs["time"]) - self.time) > TOLERANCE * abs(self.time):
                raise ValueError(f"{self.file.name} is of time {data.attrs['time']}, the series says {self.time}")
            if self.on_cells:
                self.read_mesh(data["tiles"], "tile_size")
            elif element.get("Name") == "grid":
                self.read_mesh(data["grid"], "cell_size")
            else:
                self.read_particles(data)

    def read_particles(self, data):
        group = data["particles"]
        position = group["position"][:]
        self.n_points = self.n_cells = int(data.attrs["n_particles"])
        self.bounds = numpy.column_stack([position.min(axis=0), position.max(axis=0)]).ravel()
        self.fields = {name: ranges(array, self.n_points) for name, array in group.items()
                       if name not in ("position", "connectivity")}

    def read_colliders(self, folder, triangles, vertices, owner):
        triangles, vertices, owner = (read_item(folder, item) for item in (triangles, vertices, owner))
        self.n_points, self.n_cells = len(vertices), len(triangles)
        self.bounds = numpy.column_stack([vertices.min(axis=0), vertices.max(axis=0)]).ravel()
        self.fields = {"collider": ranges(owner, len(owner))}
        if not close(vertices, self.posed(folder, triangles, owner)):
            raise ValueError(f"colliders at time {self.time} are not where their poses put them")

    def posed(self, folder, triangles, owner):
        """The vertices by the poses in the frame of this time."""
        for path in folder.glob("frame_*.h5"):
            with h5py.File(path, "r") as data:
                if float(data.attrs["time"]) == self.time:
                    rotation, translation = data["colliders/rotation"][:], data["colliders/translation"][:]
                    break
        else:
            raise ValueError(f"there is no frame of time {self.time}, of which there are colliders")
        vertices = read_item(folder, "colliders.h5:/colliders/vertices").astype(float)
        of_vertex = numpy.zeros(len(vertices), int)
        of_vertex[triangles.ravel()] = numpy.repeat(owner, 3)
        return numpy.einsum("nij,nj->ni", rotation[of_vertex], vertices) + translation[of_vertex]

    def read_mesh(self, group, spacing):
        shape = numpy.array(next(iter(group.values())).shape[:3])
        cells = shape if self.on_cells else shape - 1
        self.n_points, self.n_cells = int(numpy.prod(cells + 1)), int(numpy.prod(cells))
        lower = numpy.array(group.attrs["origin"])
        self.bounds = numpy.column_stack([lower, lower + group.attrs[spacing] * cells[::-1]]).ravel()
        self.fields = {name: ranges(array, int(numpy.prod(shape))) for name, array in group.items()}


def read_item(folder, item):
    file, path = item.split(":")
    with h5py.File(folder / file, "r") as data:
        return data[path][:]


def ranges(array, n_values):
    """Smallest and largest value of each component, (components, 2)."""
    values = array[:].reshape(n_values, -1)
    return numpy.column_stack([values.min(axis=0), values.max(axis=0)]).astype(float)


def close(a, b):
    a, b = numpy.asarray(a, dtype=float), numpy.asarray(b, dtype=float)
    scale = numpy.abs(b).max(initial=0.0)
    return a.shape == b.shape and numpy.allclose(a, b, rtol=TOLERANCE, atol=TOLERANCE * scale)


def check(path, faults):
    """Compares every time of one XDMF file in both readers; returns the number of points of the last one."""
    try:
        snapshots = [Snapshot(path.parent, grid) for grid in ElementTree.parse(path).iter("Grid") if grid.find("Time") is not None]
    except ValueError as error:
        faults.append(f"{path.name}: {error}")
        return None
    for reader_name, make_reader in READERS.items():
        fault = lambda sentence: faults.append(f"{path.name}, {reader_name}: {sentence}")
        reader = make_reader(str(path.resolve()))
        reader.UpdatePipelineInformation()
        times = reader.TimestepValues if hasattr(reader.TimestepValues, "__len__") else [reader.TimestepValues]
        if not close(times, [snapshot.time for snapshot in snapshots]):
            fault(f"times are {list(times)} and should be {[snapshot.time for snapshot in snapshots]}")
            continue
        for snapshot in snapshots:
            reader.UpdatePipeline(snapshot.time)
            seen = reader.GetDataInformation()
            for what, found, expected in (("points", seen.GetNumberOfPoints(), snapshot.n_points),
                                          ("cells", seen.GetNumberOfCells(), snapshot.n_cells)):
                if found != expected:
                    fault(f"{found} {what} at time {snapshot.time}, should be {expected}")
            if not close(seen.GetBounds(), snapshot.bounds):
                fault(f"bounds at time {snapshot.time} are {seen.GetBounds()} and should be {tuple(snapshot.bounds)}")
            arrays = {array.Name: array for array in (reader.CellData if snapshot.on_cells else reader.PointData).values()}
            if set(arrays) != set(snapshot.fields):
                fault(f"fields at time {snapshot.time} are {sorted(arrays)} and should be {sorted(snapshot.fields)}")
            for name in set(arrays) & set(snapshot.fields):
                found = [arrays[name].GetRange(c) for c in range(arrays[name].GetNumberOfComponents())]
                if not close(found, snapshot.fields[name]):
                    expected = snapshot.fields[name].tolist()
                    fault(f"the range of {name} at time {snapshot.time} is {found} and should be {expected}")
        simple.Delete(reader)
    print(f"{path.name}: {len(snapshots)} snapshots, {snapshots[-1].n_points} points and {snapshots[-1].n_cells} cells in the last")
    return snapshots[-1].n_points


def main():
    parser = argparse.ArgumentParser(description="Checks that ParaView sees what a run has written.")
    parser.add_argument("--run", required=True, type=pathlib.Path, help="output folder of the run")
    parser.add_argument("--particles", type=int, help="number of particles there must be in the last frame and checkpoint")
    options = parser.parse_args()

    checkpoints = sorted(options.run.glob("checkpoint_*.xdmf"))
    meshes = [options.run / f"{name}.xdmf" for name in ("grid", "tiles", "colliders")]
    paths = [path for path in (options.run / "frames.xdmf", *meshes, *checkpoints[-1:]) if path.exists()]
    if not paths:
        print(f"check_output.py: there are no frames and no checkpoint in '{options.run}'", file=sys.stderr)
        return 2
    faults = []
    for path in paths:
        n_points = check(path, faults)
        if options.particles is not None and path not in meshes and n_points not in (options.particles, None):
            faults.append(f"{path.name}: {n_points} particles, should be {options.particles}")
    for sentence in faults:
        print(sentence, file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
