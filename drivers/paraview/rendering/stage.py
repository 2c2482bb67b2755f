"""Puts frames on ParaView's stage: material, colliders, floor, words, camera."""

import itertools
import math
from collections import Counter

import numpy
from paraview.servermanager import vtkSMTransferFunctionPresets
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray, vtk_to_numpy
from vtkmodules.vtkCommonCore import vtkPoints
from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkPolyData
from vtkmodules.vtkFiltersCore import vtkPolyDataNormals
from vtkmodules.vtkFiltersFlowPaths import vtkStreamTracer
from vtkmodules.vtkFiltersSources import vtkCubeSource, vtkPlaneSource

from rendering.faults import fail, note
from rendering.look import DIRECTIONS, SPHERE_SHADER, rgb
from rendering.run_data import color_range
from rendering.shade import Light, bytes_of, unit
from rendering.surface import Surface, particle_normals

WIDTH_BESIDE_LEGEND = 0.82  # part of the picture
FLOOR_POINTS = 560  # along the longer side
MOST_TRIANGLES = 60_000  # of one collider, roughly
FEATURE_ANGLE = 35.0  # degrees; sharper edges of colliders stay sharp


def poly_data(points, colors, triangles=None):
    """Points or triangles with a colour at each point."""
    data, corners = vtkPolyData(), vtkPoints()
    corners.SetData(numpy_to_vtk(numpy.ascontiguousarray(points, numpy.float32), deep=True))
    data.SetPoints(corners)
    cells = vtkCellArray()
    width = 1 if triangles is None else 3
    table = numpy.arange(len(points)) if triangles is None else triangles
    cells.SetData(width, numpy_to_vtkIdTypeArray(numpy.ascontiguousarray(table, numpy.int64).ravel(), deep=True))
    data.SetVerts(cells) if triangles is None else data.SetPolys(cells)
    array = numpy_to_vtk(colors, deep=True)
    array.SetName("color")
    data.GetPointData().SetScalars(array)
    return data


def set_colormap(table, colormap):
    """`colormap`: name of a ParaView preset, or colours at even distances."""
    if isinstance(colormap, str):
        # Asked by name: ApplyPreset reports no failure.
        if not vtkSMTransferFunctionPresets.GetInstance().HasPreset(colormap):
            fail(f"particles.colormap is '{colormap}', which ParaView does not know")
        table.ApplyPreset(colormap, True)
        return
    table.ColorSpace = "Lab"
    table.RGBPoints = [x for n, color in enumerate(colormap) for x in (n / (len(colormap) - 1), *rgb(color))]


class Stage:
    def __init__(self, simple, look, series, reader, chosen):
        self.simple, self.look, self.series, self.reader, self.chosen = simple, look, series, reader, chosen
        self.materials, self.collider_names = series.materials(), series.collider_names()
        self.remark_strangers()
        self.field = self.chosen_field()
        self.things = {}  # by kind and number: source and display, used again in every frame
        self.present = Counter()  # how many of each kind the present frame has
        self.legend = None
        self.meshes = {}  # of colliders by name, with the corners they were made from: most stay where they are
        self.domain = look.crop() or series.domain() or self.bounds_of_material()
        self.subject = self.bounds_of_material() if look["camera.fit"] == "material" else self.domain
        self.reach = max(u - l for l, u in zip(*self.subject))
        self.view = self.make_view()
        self.place_camera()
        self.toward_light = self.light_direction()
        self.table = self.color_table()
        if look["picture.title"] and series.scene.get("title"):
            self.add_text(series.scene["title"], [0.03, 0.93], 22)
        self.clock = self.add_text("", [0.03, 0.88] if look["picture.title"] else [0.03, 0.92], 18)

    # --- settings of the look -----------------------------------------------------------------------------------------

    def remark_strangers(self):
        for key, known in (("materials.colors", self.materials), ("colliders.colors", self.collider_names),
                           ("colliders.opacities", self.collider_names), ("colliders.hidden", self.collider_names)):
            for name in self.look[key]:
                if name not in known:
                    note(f"{key} names '{name}', which the run has not; it has {', '.join(known) or 'none'}")

    def chosen_field(self):
        field = self.look["particles.field"]
        if field == "auto":
            field = "velocity" if "velocity" in self.series.fields else next(iter(self.series.fields), "material")
        if field not in self.series.fields and field != "material":
            fail(f"--field is '{field}', and the frames hold {', '.join(self.series.fields) or 'no fields'}")
        return field

    def bounds_of_material(self):
        lower, upper = numpy.full(3, numpy.inf), numpy.full(3, -numpy.inf)
        for number in self.chosen:
            position = self.reader.particles(number).position
            if len(position):
                lower, upper = numpy.minimum(lower, position.min(axis=0)), numpy.maximum(upper, position.max(axis=0))
        if not numpy.all(lower < upper):
            fail("nothing of the material is in the picture")
        return [float(x) for x in lower], [float(x) for x in upper]

    def material_color(self, material):
        palette = self.look["materials.palette"]
        name = self.materials[material] if material < len(self.materials) else ""
        return rgb(self.look["materials.colors"].get(name, palette[material % len(palette)]))

    def light_direction(self):
        direction = self.look["light.direction"]
        if direction != "auto":
            return unit(direction)
        position, target, up = self.camera
        back = unit(numpy.subtract(position, target))
        right = unit(numpy.cross(up, back))
        return unit(1.0 * numpy.asarray(up, float) - 0.55 * right + 0.35 * back)

    # --- view and camera ------------------------------------------------------------------------------------------------

    def make_view(self):
        look = self.look
        view = self.simple.CreateView("RenderView")
        view.ViewSize = list(look["picture.size"])
        view.UseColorPaletteForBackground = 0
        background = [rgb(color) for color in look["picture.background"]]
        view.BackgroundColorMode = "Gradient" if len(background) == 2 else "Single Color"
        view.Background, view.Background2 = background[0], background[-1]
        view.OrientationAxesVisibility = 0
        view.UseFXAA = 1
        if look["light.occlusion"]:
            view.UseAmbientOcclusion = 1
            view.UseSSAODefaultPresets = 0
            view.Radius, view.Bias, view.KernelSize, view.Blur = 0.05 * self.reach, 0.004 * self.reach, 96, 1
        return view

    def place_camera(self):
        look, (lower, upper) = self.look, self.subject
        center = [0.5 * (l + u) for l, u in zip(lower, upper)] if look["camera.focus"] == "auto" else look["camera.focus"]
        direction = look["camera.direction"]
        if direction == "auto":
            size = [u - l for l, u in zip(*self.domain)]
            thin = min(range(3), key=lambda axis: size[axis])
            direction = ("side", "front", "top")[thin] if size[thin] < 0.2 * max(size) else "corner"
        direction = unit(DIRECTIONS.get(direction, direction) if isinstance(direction, str) else direction)
        if look["camera.position"] != "auto":
            direction = numpy.subtract(look["camera.position"], center)
            if not numpy.any(direction):
                fail("camera.position and camera.focus are the same point")
            direction = unit(direction)
        up = look["camera.up"]
        if up == "auto":
            up = [0.0, 1.0, 0.0] if abs(direction[2]) > 0.99 else [0.0, 0.0, 1.0]
        right = numpy.cross(up, direction)
        if not numpy.linalg.norm(right) > 1e-6:
            fail("camera.up points along the line of sight")
        up = numpy.cross(direction, unit(right))
        position = look["camera.position"]
        if position == "auto":
            position = self.position_from(direction, unit(right), up, numpy.asarray(center, float))
        self.camera = position, center, up
        view = self.view
        view.CameraPosition, view.CameraFocalPoint, view.CameraViewUp = map(list, (position, center, up))
        view.CameraViewAngle, view.CameraParallelProjection = look["camera.angle"], 0

    def position_from(self, direction, right, up, center):
        """The nearest place from which every corner of what fills the picture is in it."""
        half = math.tan(math.radians(0.5 * self.look["camera.angle"]))
        width, height = self.look["picture.size"]
        beside = WIDTH_BESIDE_LEGEND if self.look["picture.legend"] else 0.96
        distance = 0.0
        for corner in itertools.product(*zip(*self.subject)):
            offset = numpy.subtract(corner, center)
            toward = offset @ direction
            distance = max(distance, toward + abs(offset @ up) / half,
                           toward + abs(offset @ right) / (half * width / height * beside))
        return center + distance * 1.06 / self.look["camera.zoom"] * direction

    def font_size(self, size):
        """`size` is for a picture 900 pixels high."""
        return max(7, round(size * self.look["picture.text_scale"] * self.look["picture.size"][1] / 900))

    def add_text(self, text, position, size):
        source = self.simple.Text(Text=text)
        display = self.simple.Show(source, self.view)
        display.WindowLocation = "Any Location"
        display.Position = position
        display.FontSize = self.font_size(size)
        display.Color = rgb(self.look["picture.text_color"])
        return source

    # --- colours --------------------------------------------------------------------------------------------------------

    def color_table(self):
        """ParaView's table and legend of the field; None where materials give the colours."""
        field, look = self.field, self.look
        if field == "material" and len(self.materials) < 2:
            return None  # a legend of one entry is useless
        table = self.simple.GetColorTransferFunction(field)
        if field == "material":
            table.InterpretValuesAsCategories = 1
            table.Annotations = [text for i, name in enumerate(self.materials) for text in (str(i), name)]
            table.IndexedColors = [c for i in range(len(self.materials)) for c in self.material_color(i)]
        else:
            set_colormap(table, look["particles.colormap"])
            table.RescaleTransferFunction(*color_range(self.reader, self.chosen, look, field))
            table.NanColor = [1.0, 0.0, 1.0]
        if look["picture.legend"]:
            self.add_legend(table)
        return None if field == "material" else table

    def add_legend(self, table):
        legend = self.simple.GetScalarBar(table, self.view)
        unit_name = self.series.unit(self.chosen[-1], self.field)
        component = self.look["particles.component"]
        title = self.field.replace("_", " ") + ("" if component == "magnitude" else f" [{component}]")
        title = "speed" if title == "velocity" else title
        legend.Title = title + (f" ({unit_name})" if unit_name != "1" else "")
        legend.ComponentTitle = ""
        legend.TitleColor = legend.LabelColor = rgb(self.look["picture.text_color"])
        legend.TitleFontSize, legend.LabelFontSize = self.font_size(16), self.font_size(14)
        legend.HorizontalTitle = 1
        legend.WindowLocation = "Any Location"
        legend.Position = [0.885, 0.3]
        legend.ScalarBarLength = 0.4
        legend.ScalarBarThickness = self.font_size(14)
        if self.field != "material":
            legend.AutomaticLabelFormat = 0
            legend.LabelFormat = legend.RangeLabelFormat = "%-#.3g"
        self.legend = legend
        self.show_legend(True)

    def show_legend(self, shown):
        if self.legend is not None:
            self.legend.Visibility = int(shown)

    def field_colors(self, scalars):
        values = numpy_to_vtk(numpy.ascontiguousarray(scalars, float), deep=True)
        mapped = self.table.GetClientSideObject().MapScalars(values, 1, -1)
        return vtk_to_numpy(mapped)[:, :3].astype(numpy.float32) / 255.0

    def particle_colors(self, particles):
        if self.table is not None:
            return self.field_colors(particles.scalars(self.field, self.look["particles.component"]))
        colors = numpy.array([self.material_color(m) for m in range(max(particles.material.max() + 1, 1))], numpy.float32)
        return colors[particles.material]

    # --- one frame ------------------------------------------------------------------------------------------------------

    def show(self, data, kind, prepare):
        """Shows data in the present frame, as one more of `kind`, and returns its display; `prepare` is called with a new one. What a frame
        before had of that kind gets new data: to make a display and to compile its shaders takes longer than to draw with it."""
        key = kind, self.present[kind]
        self.present[kind] += 1
        if key in self.things:
            source, display = self.things[key]
            source.GetClientSideObject().SetOutput(data)
            source.MarkModified(source.SMProxy)
            display.Visibility = 1
            return display
        source = self.simple.TrivialProducer()
        source.GetClientSideObject().SetOutput(data)
        display = self.simple.Show(source, self.view)
        prepare(display)
        self.things[key] = source, display
        return display

    def show_lit(self, data, kind="surface", opacity=1.0):
        """Colours as they are: light is in them already."""
        def prepare(display):
            self.simple.ColorBy(display, ("POINTS", "color"))
            display.MapScalars = 0
            display.SetScalarBarVisibility(self.view, False)
            display.Ambient, display.Diffuse, display.Specular, display.Opacity = 1.0, 0.0, 0.0, opacity
            if kind == "spheres":
                display.SetRepresentationType("Point Gaussian")
                display.ShaderPreset = "Custom"
                display.CustomShader = SPHERE_SHADER
        return self.show(data, (kind, opacity), prepare)

    def draw(self, number):
        self.present.clear()
        particles = self.reader.particles(number)
        colliders = self.collider_meshes(number)
        # Glass throws no shadow.
        casters = [particles.position] + [mesh[0] for name, mesh in colliders if self.opacity(name) == 1.0]
        light = Light(self.look, self.toward_light, numpy.concatenate(casters), particles.spacing)
        if len(particles.position):
            draw = self.draw_spheres if self.look["particles.representation"] == "spheres" else self.draw_surfaces
            draw(particles, light)
        for name, mesh in colliders:
            self.draw_collider(name, *mesh, light)
        if self.look["field_lines.show"]:
            self.draw_field_lines(number)
        if self.look["floor.show"]:
            self.draw_floor(light)
        for (kind, place), (_, display) in self.things.items():
            if place >= self.present[kind]:
                display.Visibility = 0
        self.view.ViewTime = self.series.times[number]
        self.clock.Text = f"t = {self.series.times[number]:.4g} s" if self.look["picture.time"] else ""

    def draw_spheres(self, particles, light):
        normals = particle_normals(particles, numpy.asarray(self.camera[0], float))
        colors = self.particle_colors(particles) * light.brightness(particles.position, normals)[0][:, None]
        display = self.show_lit(poly_data(particles.position, bytes_of(colors)), "spheres")
        display.GaussianRadius = 0.5 * self.look["particles.radius"] * particles.spacing

    def draw_surfaces(self, particles, light):
        for material in numpy.unique(particles.material):
            chosen = particles.material == material
            surface = Surface(particles, chosen, self.look)
            if len(surface.points) == 0:
                continue
            if self.table is None:
                colors = numpy.array([self.material_color(material)], numpy.float32)
            else:
                scalars = particles.scalars(self.field, self.look["particles.component"])
                colors = self.field_colors(surface.values(particles, chosen, scalars))
            camera = numpy.asarray(self.camera[0], float)
            factor, highlight = light.brightness(surface.points, surface.normals, camera)
            colors = colors * factor[:, None] + self.look["surface.gloss"] * highlight[:, None]
            self.show_lit(poly_data(surface.points, bytes_of(colors), surface.triangles))

    # --- colliders and floor --------------------------------------------------------------------------------------------

    def collider_meshes(self, number):
        """[(name, (points, triangles, normals))], triangles small enough to carry the rim of a shadow."""
        meshes = self.reader.colliders(number)
        if meshes is None:
            return []
        vertices, triangles, owner = meshes
        result = []
        for collider in numpy.unique(owner):
            name = self.collider_names[collider] if collider < len(self.collider_names) else str(collider)
            if name in self.look["colliders.hidden"] or self.opacity(name) == 0.0:
                continue
            corners = vertices[triangles[owner == collider]]
            if name not in self.meshes or not numpy.array_equal(self.meshes[name][0], corners):
                mesh = fine_mesh(vertices, triangles[owner == collider], self.reach / 200)
                self.meshes[name] = corners, mesh
            result.append((name, self.meshes[name][1]))
        return result

    def opacity(self, name):
        return self.look["colliders.opacities"].get(name, self.look["colliders.opacity"])

    def draw_collider(self, name, points, triangles, normals, light):
        look = self.look
        color = numpy.array([rgb(look["colliders.colors"].get(name, look["colliders.color"]))], numpy.float32)
        colors = color * light.brightness(points, normals)[0][:, None]
        self.show_lit(poly_data(points, bytes_of(colors), triangles), opacity=self.opacity(name))

    def draw_floor(self, light):
        look, (lower, upper) = self.look, self.domain
        size = [upper[a] - lower[a] for a in range(2)]
        if self.camera[0][2] <= lower[2] or look["floor.margin"] < 0.0:
            return  # seen from below it would only hide the bodies on it
        margin = look["floor.margin"] * max(size)
        spacing = (max(size) + 2.0 * margin) / FLOOR_POINTS
        counts = [max(2, math.ceil((s + 2.0 * margin) / spacing)) for s in size]
        # A hair below, so that it does not fight with particles on it.
        z = lower[2] - 2e-3 * max(size)
        corner, far = [lower[a] - margin for a in range(2)], [upper[a] + margin for a in range(2)]
        plane = vtkPlaneSource()
        plane.SetOrigin(*corner, z)
        plane.SetPoint1(far[0], corner[1], z)
        plane.SetPoint2(corner[0], far[1], z)
        plane.SetResolution(*counts)
        plane.Update()
        data = plane.GetOutput()
        points = vtk_to_numpy(data.GetPoints().GetData()).astype(float)
        color = numpy.tile(numpy.array(rgb(look["floor.color"])), (len(points), 1))
        if look["floor.grid"]:
            color *= 1.0 - 0.06 * grid_lines(points, nice_distance(max(size) / 8.0), 0.7 * spacing)[:, None]
        lit = blurred(light.visible(points).reshape(counts[1] + 1, counts[0] + 1)).ravel()
        color *= (1.0 - 0.75 * (1.0 - look["light.ambient"]) * (1.0 - lit))[:, None]
        beyond = numpy.linalg.norm([numpy.maximum(numpy.maximum(lower[a] - points[:, a], points[:, a] - upper[a]), 0.0)
                                    for a in range(2)], axis=0)
        fade = numpy.clip(beyond / margin, 0.0, 1.0)[:, None] if margin > 0.0 else numpy.zeros((len(points), 1))
        fade = fade * fade * (3.0 - 2.0 * fade)
        background = numpy.mean([rgb(c) for c in look["picture.background"]], axis=0)
        array = numpy_to_vtk(bytes_of(color + fade * (background - color)), deep=True)
        array.SetName("color")
        data.GetPointData().SetScalars(array)
        self.show_lit(data)
        if look["floor.outline"]:
            self.draw_outline()

    def draw_outline(self):
        def prepare(display):
            display.SetRepresentationType("Outline")
            display.AmbientColor = display.DiffuseColor = (0.65, 0.66, 0.70)
            display.LineWidth = 1.0
        lower, upper = self.domain
        box = vtkCubeSource()
        box.SetBounds(lower[0], upper[0], lower[1], upper[1], lower[2], upper[2])
        box.Update()
        self.show(box.GetOutput(), "outline", prepare)

    def draw_field_lines(self, number):
        """Lines of B through a lattice of points in a plane, as far as the box of the field reaches."""
        lower, upper = (numpy.asarray(corner, float) for corner in self.domain)
        plane = self.look["field_lines.plane"]
        axis, place = (1, 0.5 * (lower[1] + upper[1])) if plane == "auto" else (int(plane[0]), plane[1])
        count = self.look["field_lines.count"]
        parts = (numpy.arange(count) + 0.5) / count
        first, second = (a for a in range(3) if a != axis)
        points = numpy.full((count * count, 3), place, numpy.float32)
        points[:, first] = numpy.repeat(lower[first] + parts * (upper[first] - lower[first]), count)
        points[:, second] = numpy.tile(lower[second] + parts * (upper[second] - lower[second]), count)
        seeds, corners, tracer = vtkPolyData(), vtkPoints(), vtkStreamTracer()
        corners.SetData(numpy_to_vtk(points, deep=True))
        seeds.SetPoints(corners)
        tracer.SetInputData(self.reader.fetch(self.reader.magnetic_reader, number))
        tracer.SetSourceData(seeds)
        tracer.SetInputArrayToProcess(0, 0, 0, 0, "flux_density")
        tracer.SetIntegrationDirectionToBoth()
        tracer.SetIntegratorTypeToRungeKutta4()
        tracer.SetMaximumPropagation(2.0 * self.reach)
        tracer.SetInitialIntegrationStep(0.5)
        tracer.Update()

        def prepare(display):
            self.simple.ColorBy(display, None)
            display.AmbientColor = display.DiffuseColor = rgb(self.look["field_lines.color"])
            display.Ambient, display.Diffuse, display.Specular = 1.0, 0.0, 0.0
            display.LineWidth = self.look["field_lines.width"]
        self.show(tracer.GetOutput(), "field lines", prepare)


def nice_distance(length):
    """The nearest of 1, 2, 5 times a power of ten."""
    power = 10.0 ** math.floor(math.log10(length))
    return min((factor * power for factor in (1, 2, 5, 10)), key=lambda d: abs(math.log(d / length)))


def blurred(field):
    """One two one along both axes: no steps where the floor's points and the pixels of the shadow beat."""
    for axis in range(2):
        ends = [(1, 1) if axis == a else (0, 0) for a in range(2)]
        wide = numpy.pad(field, ends, mode="edge")
        n = field.shape[axis]
        before, here, after = (numpy.take(wide, range(i, i + n), axis=axis) for i in range(3))
        field = 0.25 * before + 0.5 * here + 0.25 * after
    return field


def grid_lines(points, distance, half_width):
    """1 on the lines, 0 away from them."""
    off = numpy.abs(points[:, :2] / distance - numpy.round(points[:, :2] / distance)) * distance
    return numpy.clip(1.5 - off.min(axis=1) / half_width, 0.0, 1.0)


def fine_mesh(vertices, triangles, edge):
    """Points, triangles and normals of a collider, edges at most about `edge` long; sharp edges stay sharp."""
    used, corners = numpy.unique(triangles, return_inverse=True)
    normals = vtkPolyDataNormals()
    normals.SetInputData(poly_data(vertices[used], numpy.zeros((len(used), 3), numpy.uint8), corners.reshape(-1, 3)))
    normals.SetFeatureAngle(FEATURE_ANGLE)
    normals.ConsistencyOff()
    normals.Update()
    mesh = normals.GetOutput()
    table = vtk_to_numpy(mesh.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    # Six numbers a corner: place and normal.
    corners = numpy.concatenate([vtk_to_numpy(mesh.GetPoints().GetData()),
                                 vtk_to_numpy(mesh.GetPointData().GetNormals())], axis=1)[table].astype(float)
    corners = halved(corners, edge).reshape(-1, 6)
    length = numpy.linalg.norm(corners[:, 3:], axis=1, keepdims=True)
    return corners[:, :3], numpy.arange(len(corners)).reshape(-1, 3), corners[:, 3:] / numpy.maximum(length, 1e-12)


def halved(corners, edge):
    """Triangles with their longest edges halved until none is longer than `edge`, or there are many.

    Neighbours divide a common edge in the same way, because only its length decides: no cracks.
    """
    sides = corners[:, 1:, :3] - corners[:, :1, :3]
    area = 0.5 * numpy.linalg.norm(numpy.cross(sides[:, 0], sides[:, 1]), axis=1).sum()
    edge = max(edge, math.sqrt(area / MOST_TRIANGLES))
    done = []
    while len(corners):
        lengths = numpy.linalg.norm(corners[:, [1, 2, 0], :3] - corners[:, :, :3], axis=2)
        longest = lengths.argmax(axis=1)
        fits = lengths.max(axis=1) <= edge
        done.append(corners[fits])
        order = (longest[~fits, None] + numpy.arange(3)) % 3
        a, b, c = numpy.moveaxis(numpy.take_along_axis(corners[~fits], order[:, :, None], axis=1), 1, 0)
        middle = 0.5 * (a + b)
        corners = numpy.concatenate([numpy.stack([a, middle, c], axis=1), numpy.stack([middle, b, c], axis=1)])
    return numpy.concatenate(done)
