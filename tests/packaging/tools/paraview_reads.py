"""ParaView reads what `bulkley convert` wrote. Usage: pvpython paraview_reads.py RUN VTU_FOLDER VTKHDF_FOLDER FILE.hdf

Every point and value must be that of the frames. A ParaView that cannot read VTK's XML files with appended data, not even those that it writes
(5.11 with libexpat 2.6, or with Debian 12's 2.5.0-1+deb12u2: issue 19258 of VTK), does not read our VTU files, which says nothing of them.
"""

import os
import pathlib
import sys

import h5py
import numpy
from paraview import servermanager, simple
from vtkmodules.util.numpy_support import vtk_to_numpy


def end(code, sentence):
    """At once: taking ParaView's pipelines down in order may not come to an end."""
    print(sentence, flush=True)
    os._exit(code)


def compare(what, data, frame):
    """What ParaView holds against a frame."""
    with h5py.File(frame, "r") as file:
        wanted = {name: array[...] for name, array in file["particles"].items() if name != "connectivity"}
    points = data.GetPointData()
    found = {points.GetArrayName(i): vtk_to_numpy(points.GetArray(i)) for i in range(points.GetNumberOfArrays())}
    found["position"] = vtk_to_numpy(data.GetPoints().GetData())
    n = len(wanted["position"])
    if data.GetNumberOfCells() != n or data.GetCellType(n - 1) != 1:
        end(1, f"{what}: {data.GetNumberOfCells()} cells, should be {n} vertices")
    if set(found) != set(wanted):
        end(1, f"{what}: fields {sorted(found)}, should be {sorted(wanted)}")
    for name, values in wanted.items():
        if not numpy.array_equal(found[name].reshape(n, -1), values.reshape(n, -1)):
            end(1, f"{what}: {name} differs")


def reads_appended_data(folder):
    """Whether this ParaView reads a file with appended data of its own."""
    file = str(folder / "own.vtp")
    writer = simple.XMLPolyDataWriter(Input=simple.Sphere(), FileName=file, DataMode="Appended", EncodeAppendedData=0)
    writer.UpdatePipeline()
    reader = simple.XMLPolyDataReader(FileName=[file])
    reader.UpdatePipeline()
    return servermanager.Fetch(reader).GetNumberOfPoints() > 0


def check_vtu(run, vtu):
    frames = sorted(run.glob("frame_*.h5"))
    series = simple.OpenDataFile(str(vtu / "frames.pvd"))
    times = []
    for frame in frames:
        with h5py.File(frame, "r") as file:
            times.append(float(file.attrs["time"]))
        series.UpdatePipeline(times[-1])
        compare(f"frames.pvd at {times[-1]} s", servermanager.Fetch(series), frame)
    if list(series.TimestepValues) != times:
        end(1, f"frames.pvd: times {list(series.TimestepValues)}, should be {times}")
    single = simple.OpenDataFile(str(vtu / "frame_000001.vtu"))
    compare("frame_000001.vtu", servermanager.Fetch(single), frames[1])


def main():
    run, vtu, vtkhdf, hdf = map(pathlib.Path, sys.argv[1:5])
    frames = sorted(run.glob("frame_*.h5"))
    reads_vtu = reads_appended_data(hdf.parent)
    if reads_vtu:
        check_vtu(run, vtu)
    reader = simple.VTKHDFReader(FileName=[str(vtkhdf / "frame_000001.vtkhdf")])
    compare("frame_000001.vtkhdf", servermanager.Fetch(reader), frames[1])
    by_name = simple.OpenDataFile(str(hdf))
    compare(hdf.name, servermanager.Fetch(by_name), frames[-1])
    end(0, "ParaView reads all of it" + ("" if reads_vtu else " but VTU files, for it does not read its own appended data"))


if __name__ == "__main__":
    main()
