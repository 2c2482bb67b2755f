#include "io/frames/xdmf.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <filesystem>

#include "io/files/text_file.hpp"

namespace bulkley {

namespace {

struct NumberType {
  const char* name;
  int precision;
};
NumberType number_type(ArrayType type) {
  switch (type) {
    case ArrayType::float32:
      return {"Float", 4};
    case ArrayType::float64:
      return {"Float", 8};
    case ArrayType::int32:
      return {"Int", 4};
    case ArrayType::int64:
      return {"Int", 8};
    case ArrayType::uint8:
      return {"UChar", 1};
  }
  return {"", 0};
}

std::string data_item(const std::string& file, const ArrayInfo& array) {
  const NumberType number = number_type(array.type);
  return fmt::format(R"(<DataItem Dimensions="{}" NumberType="{}" Precision="{}" Format="HDF">{}:{}</DataItem>)",
                     fmt::join(array.shape, " "), number.name, number.precision, file, array.path);
}

/// Scalar, Vector, Tensor, or Matrix for anything else. `axes`: those that number the points.
const char* attribute_type(const ArrayInfo& array, std::size_t axes) {
  switch (n_elements(Extents(array.shape.begin() + static_cast<std::ptrdiff_t>(axes), array.shape.end()))) {
    case 1:
      return "Scalar";
    case 3:
      return "Vector";
    case 9:
      return "Tensor";
    default:
      return "Matrix";
  }
}

std::string attributes(const std::string& file, const std::vector<XdmfField>& fields, std::size_t axes, XdmfCenter center) {
  std::string text;
  for (const XdmfField& field : fields)
    text += fmt::format(
        "        <Attribute Name=\"{}\" AttributeType=\"{}\" Center=\"{}\">\n          {}\n        </Attribute>\n",
        field.name, attribute_type(field.array, axes), center == XdmfCenter::node ? "Node" : "Cell",
        data_item(file, field.array));
  return text;
}

/// A grid of points in space, joined to cells as `topology` (an element's attributes) specifies.
std::string unstructured(const char* name, double time, const std::string& topology, const std::string& connectivity,
                         const std::string& positions, const std::string& attributes) {
  return fmt::format(R"(      <Grid Name="{}" GridType="Uniform">
        <Time Value="{}"/>
        <Topology {}>
          {}
        </Topology>
        <Geometry GeometryType="XYZ">
          {}
        </Geometry>
{}      </Grid>
)",
                     name, time, topology, connectivity, positions, attributes);
}

}  // namespace

std::string xdmf_opening(const std::string& series) {
  return fmt::format(R"(<?xml version="1.0" ?>
<Xdmf Version="3.0">
  <Domain>
    <Grid Name="{}" GridType="Collection" CollectionType="Temporal">
)",
                     series);
}

std::string xdmf_closing() { return "    </Grid>\n  </Domain>\n</Xdmf>\n"; }

std::string xdmf_moment(const XdmfParticles& particles) {
  return unstructured(
      "particles", particles.time,
      fmt::format(R"(TopologyType="Polyvertex" NumberOfElements="{}" NodesPerElement="1")", particles.position.shape[0]),
      data_item(particles.file, particles.connectivity), data_item(particles.file, particles.position),
      attributes(particles.file, particles.fields, 1, XdmfCenter::node));
}

std::string xdmf_moment(const XdmfGrid& grid) {
  return fmt::format(R"(      <Grid Name="{}" GridType="Uniform">
        <Time Value="{}"/>
        <Topology TopologyType="3DCoRectMesh" Dimensions="{}"/>
        <Geometry GeometryType="ORIGIN_DXDYDZ">
          <DataItem Dimensions="3" NumberType="Float" Precision="8" Format="XML">{} {} {}</DataItem>
          <DataItem Dimensions="3" NumberType="Float" Precision="8" Format="XML">{} {} {}</DataItem>
        </Geometry>
{}      </Grid>
)",
                     grid.name, grid.time, fmt::join(grid.n_nodes, " "), grid.origin[2], grid.origin[1], grid.origin[0],
                     grid.cell_size, grid.cell_size, grid.cell_size, attributes(grid.file, grid.fields, 3, grid.center));
}

std::string xdmf_moment(const XdmfSurface& surface) {
  return unstructured("colliders", surface.time,
                      fmt::format(R"(TopologyType="Triangle" NumberOfElements="{}")", surface.triangles.shape[0]),
                      data_item(surface.mesh_file, surface.triangles), data_item(surface.vertex_file, surface.vertices),
                      attributes(surface.mesh_file, surface.fields, 1, XdmfCenter::cell));
}

namespace {

std::string name_of(const Hdf5Reader& file) { return std::filesystem::path(file.path()).filename().string(); }

}  // namespace

XdmfParticles xdmf_particles(const Hdf5Reader& file) {
  XdmfParticles particles{
      name_of(file), file.real("/", "time"), file.array("/particles/position"), file.array("/particles/connectivity"), {}};
  for (const std::string& name : file.members("/particles"))
    if (name != "position" && name != "connectivity") particles.fields.push_back({name, file.array("/particles/" + name)});
  return particles;
}

namespace {

/// The mesh of group /`name`, whose members' first axes are `n_nodes`.
XdmfGrid regular_mesh(const Hdf5Reader& file, const std::string& name, const char* spacing) {
  const std::string group = "/" + name;
  XdmfGrid grid;
  grid.name = name;
  grid.file = name_of(file);
  grid.time = file.real("/", "time");
  grid.origin = file.reals(group, "origin");
  grid.cell_size = file.real(group, spacing);
  for (const std::string& member : file.members(group)) {
    grid.fields.push_back({member, file.array(fmt::format("{}/{}", group, member))});
    grid.n_nodes = grid.fields.back().array.shape;
  }
  grid.n_nodes.resize(3);
  return grid;
}

}  // namespace

XdmfGrid xdmf_grid(const Hdf5Reader& file) { return regular_mesh(file, "grid", "cell_size"); }

XdmfGrid xdmf_magnetic_field(const Hdf5Reader& file) { return regular_mesh(file, "magnetic_field", "cell_size"); }

XdmfGrid xdmf_tiles(const Hdf5Reader& file) {
  XdmfGrid tiles = regular_mesh(file, "tiles", "tile_size");
  tiles.center = XdmfCenter::cell;
  for (GlobalIndex& n : tiles.n_nodes) ++n;
  return tiles;
}

XdmfSurface xdmf_colliders(const Hdf5Reader& frame, const Hdf5Reader& mesh) {
  const bool moved = frame.has("/colliders/vertices");
  XdmfSurface surface;
  surface.mesh_file = name_of(mesh);
  surface.vertex_file = moved ? name_of(frame) : surface.mesh_file;
  surface.time = frame.real("/", "time");
  surface.vertices = (moved ? frame : mesh).array("/colliders/vertices");
  surface.triangles = mesh.array("/colliders/triangles");
  surface.fields = {{"collider", mesh.array("/colliders/collider")}};
  const bool same_colliders = frame.text("/colliders", "names") == mesh.text("/colliders", "names");
  if (!same_colliders || surface.vertices.shape != mesh.array("/colliders/vertices").shape)
    throw RunError(fmt::format("{}: has other colliders than {}", frame.path(), surface.mesh_file));
  return surface;
}

std::string sidecar_of(const std::string& file) { return std::filesystem::path(file).replace_extension(".xdmf").string(); }

void write_sidecar(const std::string& file, GlobalIndex n_particles) {
  if (n_particles == 0)
    remove_file(sidecar_of(file));
  else
    write_text_atomically(sidecar_of(file),
                          xdmf_opening("particles") + xdmf_moment(xdmf_particles(Hdf5Reader(file))) + xdmf_closing());
}

}  // namespace bulkley
