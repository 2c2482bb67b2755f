#include "io/frames/frame.hpp"

#include <algorithm>
#include <filesystem>
#include <limits>

#include <fmt/format.h>

#include "io/arrays/box_array.hpp"
#include "io/files/text_file.hpp"
#include "io/frames/frame_fields.hpp"

namespace bulkley {

namespace {

const std::string prefix = "frame_";
constexpr const char* particle_series = "frames.xdmf";
constexpr const char* grid_series = "grid.xdmf";
constexpr const char* tile_series = "tiles.xdmf";
constexpr const char* collider_series = "colliders.xdmf";
constexpr const char* magnetic_series = "magnetic_field.xdmf";

GrowingDocument document(const std::string& folder, const char* file, const std::string& series) {
  return {path_in(folder, file), xdmf_opening(series), xdmf_closing()};
}

std::string file_name(GlobalIndex index, const char* suffix) { return fmt::format("{}{:06}{}", prefix, index, suffix); }

FrameInfo checked_info(const Hdf5Reader& file) {
  check_format(file, frame_format, frame_version);
  return {file.integer("/", "index"), file.integer("/", "step"), file.real("/", "time"), file.integer("/", "n_particles")};
}

void add_grid(FileContent& content, const GridNodes& nodes, FloatPrecision precision) {
  const GridGeometry& grid = nodes.geometry;
  const std::vector<double> origin{grid.node_coordinate(0, 0), grid.node_coordinate(1, 0), grid.node_coordinate(2, 0)};
  content.attributes.push_back({"/grid", "origin", origin});
  content.attributes.push_back({"/grid", "cell_size", grid.cell_size});
  for (Array& array : grid_arrays(nodes, precision)) content.arrays.push_back(std::move(array));
}

// A tile is drawn where its particles lie; its nodes begin half a cell (quadratic splines) or a cell (cubic) below. Along a
// periodic axis the last tile reaches beyond the upper face: its particles there lie between lower face and first tile.
void add_tiles(const Comm& comm, FileContent& content, const TileValues& tiles) {
  const GridGeometry& grid = tiles.geometry;
  std::vector<double> origin;
  for (int axis = 0; axis < 3; ++axis)
    origin.push_back(grid.lower[axis] + (grid.base_shift() - grid.node_offset(axis)) * grid.cell_size);
  content.attributes.push_back({"/tiles", "origin", origin});
  content.attributes.push_back({"/tiles", "tile_size", tile_width * grid.cell_size});
  for (Array& array : tile_arrays(comm, tiles)) content.arrays.push_back(std::move(array));
}

std::vector<Array> particle_arrays(const OutputSettings& settings, const ParticleRange& range, const ParticleSet& particles,
                                   int rank, const StressOfState& stress) {
  const auto array = [&](const std::string& name) {
    return frame_array(name, settings.precision, range, particles, rank, stress);
  };
  std::vector<Array> arrays{array("position"), connectivity_array(range)};
  for (const std::string& name : settings.fields)
    if (name != "position") arrays.push_back(array(name));
  return arrays;
}

std::vector<std::string> names_of(std::span<const NamedMaterial> materials) {
  std::vector<std::string> names;
  for (const NamedMaterial& material : materials) names.push_back(material.name);
  return names;
}

}  // namespace

std::string frame_path(const std::string& folder, GlobalIndex index) { return path_in(folder, file_name(index, ".h5")); }

void write_frame(const Comm& comm, const std::string& folder, const FrameInfo& info, const ParticleSet& particles,
                 std::span<const NamedMaterial> materials, const OutputSettings& settings, const GridNodes* nodes,
                 const TileValues* tiles, const ColliderSurfaces* colliders, const BoxFields* box) {
  write_frame_file(comm, frame_path(folder, info.index), info, particles, materials, settings, nodes, tiles, colliders, box);
}

void write_frame_file(const Comm& comm, const std::string& file, const FrameInfo& info, const ParticleSet& particles,
                      std::span<const NamedMaterial> materials, const OutputSettings& settings, const GridNodes* nodes,
                      const TileValues* tiles, const ColliderSurfaces* colliders, const BoxFields* box) {
  const ParticleRange range = particle_range(comm, particles);
  double largest_volume = 0.0;
  for (LocalIndex p = 0; p < particles.size(); ++p)
    largest_volume = std::max(largest_volume, particles.real(Field::reference_volume)[p]);

  FileContent content{frame_format, frame_version, {}, {}, settings.compression};
  content.attributes = {{"/", "index", info.index},
                        {"/", "step", info.step},
                        {"/", "time", info.time},
                        {"/", "n_particles", range.total},
                        {"/", "materials", join_lines(names_of(materials))},
                        {"/", "largest_reference_volume", max_global(comm, largest_volume)},
                        {"/particles", "about", std::string("one row a particle; order without meaning")}};
  const StressOfState stress(particles, materials);
  content.arrays = particle_arrays(settings, range, particles, comm.rank(), stress);
  if (nodes) add_grid(content, *nodes, settings.precision);
  if (tiles) add_tiles(comm, content, *tiles);
  if (box) add_box(content, *box, settings.precision == FloatPrecision::float32 ? ArrayType::float32 : ArrayType::float64);
  if (colliders) colliders->add_to_frame(comm, info.time, content);

  write_array_file(comm, file, content);
  root_guard(comm, [&] { write_sidecar(file, range.total); });
}

GlobalIndex frame_bytes(const OutputSettings& settings, const OptionalFields& fields, const GridGeometry& grid,
                        GlobalIndex n_particles) {
  GlobalIndex bytes = 0;
  const ParticleSet none(fields);
  for (const Array& array : particle_arrays(settings, {0, n_particles, n_particles}, none, 0, {}))
    bytes += stored_bytes(array);
  if (settings.grid)
    for (const Array& array : grid_arrays({grid, {0, 0, 0}, {0, 0, 0}, {}}, settings.precision))
      bytes += stored_bytes(array);
  if (settings.tiles)
    bytes +=
        GlobalIndex{grid.n_tiles()} * static_cast<GlobalIndex>(sizeof(std::int32_t) + sizeof(GlobalIndex) + sizeof(double));
  return bytes;
}

FrameInfo read_frame_info(const Comm& comm, const std::string& file) {
  FrameInfo info;
  root_guard(comm, [&] { info = checked_info(Hdf5Reader(file)); });
  GlobalIndex integers[3] = {info.index, info.step, info.n_particles};
  BULKLEY_MPI(MPI_Bcast(integers, 3, MPI_INT64_T, 0, comm.get()));
  BULKLEY_MPI(MPI_Bcast(&info.time, 1, MPI_DOUBLE, 0, comm.get()));
  return {integers[0], integers[1], info.time, integers[2]};
}

FrameSeries::FrameSeries(const Comm& comm, std::string folder, GlobalIndex restart_step)
    : folder_(std::move(folder)),
      series_{document(folder_, particle_series, "particles"), document(folder_, grid_series, "grid"),
              document(folder_, tile_series, "tiles"), document(folder_, magnetic_series, "magnetic_field"),
              document(folder_, collider_series, "colliders")} {
  root_guard(comm, [&] {
    for (const std::string& name : numbered_files(folder_, prefix, ".h5.tmp")) remove_file(path_in(folder_, name));
    list(restart_step);
  });
}

void FrameSeries::add(const Comm& comm, GlobalIndex index) {
  root_guard(comm, [&] {
    if (index <= last_index_) return list(std::numeric_limits<GlobalIndex>::max());
    const Moments moments = moments_of(frame_path(folder_, index));
    for (std::size_t s = 0; s < n_series; ++s)
      if (moments[s]) series_[s].add(*moments[s]);
    last_index_ = index;
  });
}

/// The series of all frames in the folder up to a step; removes the others.
void FrameSeries::list(GlobalIndex last_step) {
  std::array<std::vector<std::string>, n_series> parts;
  last_index_ = -1;
  for (const std::string& name : numbered_files(folder_, prefix, ".h5")) {
    const std::string file = path_in(folder_, name);
    try {
      if (last_step < 0 || checked_info(Hdf5Reader(file)).step > last_step) {
        remove_file(sidecar_of(file));
        remove_file(file);
        continue;
      }
      Moments moments = moments_of(file);
      for (std::size_t s = 0; s < n_series; ++s)
        if (moments[s]) parts[s].push_back(std::move(*moments[s]));
      last_index_ = number_in(name, prefix);
    } catch (const RunError& error) {
      warnings_.push_back(fmt::format("frame left out of the series: {}", error.what()));
    }
  }
  for (std::size_t s = 0; s < n_series; ++s) series_[s].begin(parts[s]);
}

/// What a frame adds to each series.
FrameSeries::Moments FrameSeries::moments_of(const std::string& file) {
  const Hdf5Reader reader(file);
  Moments moments;
  if (checked_info(reader).n_particles > 0) moments[0] = xdmf_moment(xdmf_particles(reader));
  if (reader.has("/grid")) moments[1] = xdmf_moment(xdmf_grid(reader));
  if (reader.has("/tiles")) moments[2] = xdmf_moment(xdmf_tiles(reader));
  if (reader.has("/magnetic_field")) moments[3] = xdmf_moment(xdmf_magnetic_field(reader));
  const std::string mesh = path_in(folder_, collider_file);
  if (!reader.has("/colliders") || !std::filesystem::exists(mesh)) return moments;
  try {
    moments[4] = xdmf_moment(xdmf_colliders(reader, Hdf5Reader(mesh)));
  } catch (const RunError& error) {
    warnings_.push_back(fmt::format("colliders left out of the series: {}", error.what()));
  }
  return moments;
}

}  // namespace bulkley
