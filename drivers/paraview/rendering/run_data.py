"""What a run has written: its series and scene as text, and its frames as arrays. Scene and headers are read by the Python
package beside this folder; the series by hand, because ParaView opens what it names."""

import math
import pathlib
import sys
import xml.etree.ElementTree as ElementTree

from rendering.faults import fail

sys.path.append(str(pathlib.Path(__file__).resolve().parents[2] / "python"))
import bulkley  # noqa: E402


class Series:
    """Contents of frames.xdmf and scene.toml, read before ParaView opens a file (a missing file would end ParaView)."""

    def __init__(self, run):
        self.run = run
        self.path = run / "frames.xdmf"
        if not self.path.is_file():
            fail(f"there is no '{self.path}': the run has written no frames")
        grids = snapshots(self.path)
        self.times = [float(grid.find("Time").get("Value")) for grid in grids]
        self.files = [run / next(grid.iter("DataItem")).text.split(":")[0].strip() for grid in grids]
        self.fields = [attribute.get("Name") for attribute in grids[-1].iter("Attribute")]
        self.expect_files(self.path, self.files)
        self.colliders = run / "colliders.xdmf" if (run / "colliders.xdmf").is_file() else None
        if self.colliders:
            items = ElementTree.parse(self.colliders).iter("DataItem")
            self.expect_files(self.colliders, [run / item.text.split(":")[0].strip() for item in items])
        path = run / "magnetic_field.xdmf"
        self.magnetic_field = path if path.is_file() else None
        if self.magnetic_field:
            items = ElementTree.parse(path).iter("DataItem")
            self.expect_files(path, [run / item.text.split(":")[0].strip() for item in items if item.get("Format") == "HDF"])
        try:
            self.scene = bulkley.open_run(run).scene if (run / "scene.toml").is_file() else {}
        except bulkley.DataError as error:
            fail(str(error))

    @staticmethod
    def expect_files(series, files):
        missing = [file.name for file in files if not file.is_file()]
        if missing:
            fail(f"'{series}' names {missing[0]}, which is not there")

    def domain(self):
        """(lower, upper), or None without a scene."""
        domain = self.scene.get("domain", {})
        return (domain["lower"], domain["upper"]) if "lower" in domain and "upper" in domain else None

    def header(self, number, read, without):
        """`read(frame)` of a frame's header; `without` where h5py is not installed."""
        try:
            import h5py  # noqa: F401
        except ImportError:
            return without
        try:
            return read(bulkley.Frame(self.files[number], self.scene))
        except bulkley.DataError as error:
            fail(str(error))

    def largest_reference_volume(self, number):
        """m^3; 0 where it is not known."""
        return float(self.header(number, lambda frame: frame.attributes.get("largest_reference_volume", 0.0), 0.0))

    def unit(self, number, field):
        return self.header(number, lambda frame: frame.units.get(field, "1"), "1")

    def materials(self):
        return self.header(-1, lambda frame: frame.materials, [])

    def collider_names(self):
        names = self.header(-1, lambda frame: frame.colliders, [])
        return names or [collider["name"] for collider in self.scene.get("colliders", [])]


def snapshots(path):
    try:
        return [grid for grid in ElementTree.parse(path).iter("Grid") if grid.find("Time") is not None]
    except ElementTree.ParseError as error:
        fail(f"'{path}' is damaged: {error}")


class Particles:
    """The particles of one frame as arrays; those outside the window left out."""

    def __init__(self, data, series, number, crop):
        import numpy
        from vtkmodules.util.numpy_support import vtk_to_numpy

        points = data.GetPointData()
        fields = {points.GetArrayName(i): vtk_to_numpy(points.GetArray(i)) for i in range(points.GetNumberOfArrays())}
        self.position = vtk_to_numpy(data.GetPoints().GetData()).astype(numpy.float32)
        largest = series.largest_reference_volume(number)
        if not largest > 0.0:  # not recorded: as if the bounding box were full
            sides = numpy.maximum(numpy.ptp(self.position, axis=0), 1e-9)
            largest = float(numpy.prod(sides)) / max(len(self.position), 1)
        self.spacing = float(largest) ** (1.0 / 3.0)
        volume = fields.get("reference_volume", numpy.full(len(self.position), largest))
        self.volume = (volume * fields.get("volume_ratio", 1.0)).astype(numpy.float32)
        self.material = fields.get("material", numpy.zeros(len(self.position))).astype(int)
        self.fields = fields
        if crop is not None:
            self.keep(numpy.all((self.position >= crop[0]) & (self.position <= crop[1]), axis=1))

    def keep(self, chosen):
        self.position, self.volume, self.material = self.position[chosen], self.volume[chosen], self.material[chosen]
        self.fields = {name: values[chosen] for name, values in self.fields.items()}

    def scalars(self, field, component):
        """The numbers that are drawn."""
        import numpy

        values = self.fields[field].astype(float)
        if values.ndim == 1:
            return values
        if component == "magnitude":
            return numpy.linalg.norm(values, axis=1)
        if component >= values.shape[1]:
            fail(f"particles.component is {component}, but {field} has {values.shape[1]} components")
        return values[:, component]


class Reader:
    """Fetches frames through ParaView's XDMF reader."""

    def __init__(self, simple, series, look):
        self.simple, self.series, self.crop = simple, series, look.crop()
        self.particle_reader = simple.XDMFReader(FileNames=[str(series.path.resolve())])
        self.collider_reader = None
        if series.colliders and look["colliders.show"]:
            self.collider_reader = simple.XDMFReader(FileNames=[str(series.colliders.resolve())])

        self.magnetic_reader = None
        if look["field_lines.show"]:
            if not series.magnetic_field:
                fail("field_lines.show needs frames with the magnetic field: output.magnetic_field = true in the scene")
            self.magnetic_reader = simple.XDMFReader(FileNames=[str(series.magnetic_field.resolve())])

    def fetch(self, reader, number):
        from paraview import servermanager

        reader.UpdatePipeline(self.series.times[number])
        return servermanager.Fetch(reader)

    def particles(self, number):
        return Particles(self.fetch(self.particle_reader, number), self.series, number, self.crop)

    def colliders(self, number):
        """Vertices, triangles, and the collider of each triangle; None without."""
        if self.collider_reader is None:
            return None
        from vtkmodules.util.numpy_support import vtk_to_numpy

        data = self.fetch(self.collider_reader, number)
        cells = vtk_to_numpy(data.GetCells().GetConnectivityArray()).reshape(-1, 3)
        return vtk_to_numpy(data.GetPoints().GetData()), cells, vtk_to_numpy(data.GetCellData().GetArray("collider")).astype(int)


def color_range(reader, chosen, look, field):
    """(low, high) over all chosen frames, without the outermost hundredths."""
    import numpy

    if look["particles.range"] != "auto":
        return look["particles.range"]
    low, high = math.inf, -math.inf
    for number in chosen:
        values = reader.particles(number).scalars(field, look["particles.component"])
        values = values[numpy.isfinite(values)]
        if len(values):
            low, high = min(low, numpy.percentile(values, 1)), max(high, numpy.percentile(values, 99))
    if not low < high:  # one value everywhere
        low, high = (low - 0.5 * abs(low), low + 0.5 * abs(low)) if math.isfinite(low) and low != 0 else (0.0, 1.0)
    return low, high
