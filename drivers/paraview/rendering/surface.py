"""Smooth surfaces around particles: their volume on a lattice, a contour of it, and normals."""

import numpy
from vtkmodules.util.numpy_support import numpy_to_vtk, vtk_to_numpy
from vtkmodules.vtkCommonDataModel import vtkImageData
from vtkmodules.vtkFiltersCore import vtkFlyingEdges3D, vtkPolyDataNormals, vtkWindowedSincPolyDataFilter
from vtkmodules.vtkImagingGeneral import vtkImageGaussianSmooth

MOST_NODES = 40e6  # of a lattice: 160 MB for each field on it
LEVELS = (0.3, 0.6)  # a contour outside of these would swallow gaps or lose what is there
# What is thinner than the lattice (sheets, threads, drops) fills it nowhere and would be lost: its particles count for more,
# until the contour encloses them with a margin.
SPARE, MOST_FACTOR = 2.0, 10.0
CHUNK = 200_000  # particles summed at a time, so that their 27 weights each fit into the cache or nearly


class Lattice:
    """Nodes around particles; sums over particles with quadratic B-splines, and values between nodes."""

    def __init__(self, position, spacing):
        margin = 4
        lower, upper = position.min(axis=0).astype(float), position.max(axis=0).astype(float)
        while numpy.prod((upper - lower) / spacing + 2 * margin + 1) > MOST_NODES:
            spacing *= 1.1
        self.spacing = spacing
        self.origin = lower - margin * spacing
        self.shape = (numpy.ceil((upper - lower) / spacing).astype(int) + 2 * margin + 1)

    def sum(self, position, amounts):
        """At each node the amounts of the particles, weighted."""
        nx, ny, nz = self.shape
        total = numpy.zeros(nx * ny * nz, numpy.float32)
        for start in range(0, len(position), CHUNK):
            part = slice(start, start + CHUNK)
            place = (position[part] - self.origin) / self.spacing
            base = numpy.floor(place - 0.5).astype(numpy.int64)
            d = place - base
            weights = [0.5 * (1.5 - d) ** 2, 0.75 - (d - 1.0) ** 2, 0.5 * (d - 0.5) ** 2]
            first = (base[:, 0] * ny + base[:, 1]) * nz + base[:, 2]
            low = first.min()
            span = first.max() - low + 2 * (ny * nz + nz + 1) + 1
            at = numpy.concatenate([first - low + (i * ny + j) * nz + k for i in range(3) for j in range(3) for k in range(3)])
            share = numpy.concatenate([weights[i][:, 0] * weights[j][:, 1] * weights[k][:, 2] * amounts[part]
                                       for i in range(3) for j in range(3) for k in range(3)])
            total[low:low + span] += numpy.bincount(at, share, minlength=span)
        return total.reshape(self.shape)

    def at(self, field, points):
        """Values between nodes, linear."""
        place = numpy.clip((points - self.origin) / self.spacing, 0.0, self.shape - 1.001)
        base = place.astype(numpy.int64)
        d = (place - base).astype(numpy.float32)
        ny, nz = self.shape[1:]
        first = (base[:, 0] * ny + base[:, 1]) * nz + base[:, 2]
        flat = field.ravel()
        value = numpy.zeros(len(points), numpy.float32)
        for i in range(2):
            for j in range(2):
                for k in range(2):
                    weight = numpy.abs(1 - i - d[:, 0]) * numpy.abs(1 - j - d[:, 1]) * numpy.abs(1 - k - d[:, 2])
                    value += weight * flat[first + (i * ny + j) * nz + k]
        return value

    def gradient(self, field, points):
        step = numpy.eye(3) * self.spacing
        return numpy.stack([self.at(field, points + step[a]) - self.at(field, points - step[a]) for a in range(3)], axis=1)

    def image(self, field):
        """As VTK has it: x is numbered fastest, so axes are handed over in reverse and points turned back afterwards."""
        image = vtkImageData()
        image.SetDimensions(*(int(n) for n in self.shape[::-1]))
        image.GetPointData().SetScalars(numpy_to_vtk(field.ravel(), deep=False))
        return image

    def blurred(self, field, width):
        """`width`: standard deviation in nodes."""
        if width <= 0.0:
            return field
        blur = vtkImageGaussianSmooth()
        blur.SetInputData(self.image(field))
        blur.SetStandardDeviation(width)
        blur.SetRadiusFactor(2.0)
        blur.Update()
        return vtk_to_numpy(blur.GetOutput().GetPointData().GetScalars()).reshape(self.shape)


def filled_volume(lattice, position, volume, smoothing):
    """The part of the space around each node that is full, 0 to about 1."""
    filled = lattice.sum(position, volume) * numpy.float32(lattice.spacing ** -3)
    return lattice.blurred(filled, smoothing)


def level_that_keeps(volume, filled, node_volume):
    """The contour with that much volume inside, as far as it is one that makes sense."""
    n_inside = int(round(volume / node_volume))
    values = filled[filled > LEVELS[0]]
    if n_inside >= len(values):
        return LEVELS[0]
    return float(numpy.clip(numpy.partition(values, len(values) - n_inside)[len(values) - n_inside], *LEVELS))


def strengthened(lattice, position, volume, filled, level, smoothing):
    """The volume on the lattice again, with that of thin parts increased."""
    at_particles = lattice.at(filled, position)
    factor = numpy.clip(SPARE * level / numpy.maximum(at_particles, 1e-6), 1.0, MOST_FACTOR)
    if factor.max() == 1.0:
        return filled
    return filled_volume(lattice, position, volume * factor, smoothing)


class Surface:
    """Points, triangles and normals (outwards) of the contour; `lattice` to find values on it."""

    def __init__(self, particles, chosen, look):
        position, volume = particles.position[chosen], particles.volume[chosen]
        self.lattice = Lattice(position, particles.spacing * look["surface.spacing"])
        smoothing = look["surface.smoothing"] * particles.spacing / self.lattice.spacing
        filled = filled_volume(self.lattice, position, volume, smoothing)
        level = level_that_keeps(float(volume.sum()), filled, self.lattice.spacing ** 3)
        filled = strengthened(self.lattice, position, volume, filled, level, smoothing)
        contour = vtkFlyingEdges3D()
        contour.SetInputData(self.lattice.image(filled))
        contour.SetValue(0, level)
        contour.ComputeNormalsOff()
        contour.ComputeScalarsOff()
        smooth = vtkWindowedSincPolyDataFilter()
        smooth.SetInputConnection(contour.GetOutputPort())
        smooth.SetNumberOfIterations(look["surface.passes"])
        smooth.SetPassBand(0.05)
        smooth.NormalizeCoordinatesOn()
        normals = vtkPolyDataNormals()
        normals.SetInputConnection(smooth.GetOutputPort() if look["surface.passes"] else contour.GetOutputPort())
        normals.SplittingOff()
        normals.ConsistencyOff()
        normals.Update()
        mesh = normals.GetOutput()
        if mesh.GetNumberOfPoints() == 0:
            self.points, self.triangles = numpy.zeros((0, 3), numpy.float32), numpy.zeros((0, 3), int)
            self.normals = self.points
            return
        # Axes back in order; that mirrors the surface, so its triangles turn round.
        self.points = (vtk_to_numpy(mesh.GetPoints().GetData())[:, ::-1] * self.lattice.spacing
                       + self.lattice.origin).astype(numpy.float32)
        self.triangles = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)[:, ::-1]
        self.normals = vtk_to_numpy(mesh.GetPointData().GetNormals())[:, ::-1]
        downhill = -self.lattice.gradient(filled, self.points)
        if numpy.sum(downhill * self.normals) < 0.0:
            self.normals = -self.normals

    def values(self, particles, chosen, scalars):
        """Scalars of the particles on the surface's points, weighted by volume."""
        position = particles.position[chosen]
        volume = particles.volume[chosen].astype(float)
        finite = numpy.where(numpy.isfinite(scalars[chosen]), scalars[chosen], 0.0)
        total = self.lattice.at(self.lattice.sum(position, volume), self.points)
        return self.lattice.at(self.lattice.sum(position, volume * finite), self.points) / numpy.maximum(total, 1e-30)


def particle_normals(particles, camera):
    """Outward normals of the material at its particles; of no length where the surroundings are even.

    Visible surfaces face the camera: where the other side of a thin sheet dominates, the normal is reversed.
    """
    lattice = Lattice(particles.position, 2.0 * particles.spacing)
    filled = filled_volume(lattice, particles.position, particles.volume, 1.0)
    downhill = -lattice.gradient(filled, particles.position)
    length = numpy.linalg.norm(downhill, axis=1, keepdims=True)
    # The difference across a plane surface is about 0.5; deep inside there is no direction to speak of.
    normals = downhill / numpy.maximum(length, 0.1)
    to_camera = camera - particles.position
    to_camera /= numpy.maximum(numpy.linalg.norm(to_camera, axis=1, keepdims=True), 1e-30)
    away = numpy.minimum(numpy.sum(normals * to_camera, axis=1, keepdims=True), 0.0)
    return normals - 2.0 * away * to_camera
