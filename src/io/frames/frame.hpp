#pragma once
// Visual output: fields of a run at one time, for ParaView.
//
// frame_<index>.h5 holds /particles (position and the fields selected in the scene), if requested /grid, /tiles and /magnetic_field,
// and /colliders where there are any (collider_surfaces.hpp); the time series are frames.xdmf, grid.xdmf, tiles.xdmf,
// magnetic_field.xdmf and colliders.xdmf. Frames are for looking at: float32 by default, and never read
// back by a run.

#include <array>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "bulkley/particle/particle_set.hpp"
#include "grid/box_fields.hpp"
#include "grid/node_pool.hpp"
#include "grid/tile_map.hpp"
#include "io/files/growing_document.hpp"
#include "io/frames/collider_surfaces.hpp"
#include "io/frames/xdmf.hpp"
#include "material/material.hpp"
#include "scene/output_settings.hpp"

namespace bulkley {

inline constexpr const char* frame_format = "bulkley frame";
inline constexpr GlobalIndex frame_version = 1;

/// A rank's box of the grid's nodes after the grid update, z fastest; it may be empty. Nodes of no mass count as empty,
/// whatever velocity they hold.
struct GridNodes {
  GridGeometry geometry;
  Int3 first{0, 0, 0};          ///< first node along each axis
  Int3 count{0, 0, 0};          ///< nodes along each axis
  std::span<const Node> nodes;  ///< {velocity, mass}; product of `count`
};

/// How the work is divided: what this rank writes of it, the planes of tiles across z that are its even_share.
struct TileValues {
  GridGeometry geometry;
  const TileMap& owners;
  std::span<const TileIndex> tile;         ///< those with particles, ascending; all of its planes, and maybe others
  std::span<const GlobalIndex> particles;  ///< in each of `tile`
  std::span<const double> load;            ///< estimated cost of each of `tile`
};

struct FrameInfo {
  GlobalIndex index = 0;
  GlobalIndex step = 0;
  double time = 0.0;  ///< s
  GlobalIndex n_particles = 0;
};

/// Path of a frame. Not collective.
std::string frame_path(const std::string& folder, GlobalIndex index);

/// Writes one frame and its sidecar (none for a frame without particles) as array_file.hpp describes. `info.n_particles` is
/// set from `particles`. `nodes`, `tiles`, `colliders`, `box`: null for none. Throws RunError; UsageError for an unknown field
/// name. Collective.
void write_frame(const Comm& comm, const std::string& folder, const FrameInfo& info, const ParticleSet& particles,
                 std::span<const NamedMaterial> materials, const OutputSettings& settings, const GridNodes* nodes,
                 const TileValues* tiles, const ColliderSurfaces* colliders = nullptr, const BoxFields* box = nullptr);

/// The same under any name ending in ".h5".
void write_frame_file(const Comm& comm, const std::string& file, const FrameInfo& info, const ParticleSet& particles,
                      std::span<const NamedMaterial> materials, const OutputSettings& settings,
                      const GridNodes* nodes = nullptr, const TileValues* tiles = nullptr,
                      const ColliderSurfaces* colliders = nullptr, const BoxFields* box = nullptr);

/// Bytes of a frame of `n_particles` that have these optional fields, but for some kilobytes of header, colliders and what
/// compression saves. Throws UsageError for an unknown field name. Not collective.
GlobalIndex frame_bytes(const OutputSettings& settings, const OptionalFields& fields, const GridGeometry& grid,
                        GlobalIndex n_particles);

/// Throws RunError. Collective.
FrameInfo read_frame_info(const Comm& comm, const std::string& file);

/// The time series of a run's frames, written by the root. A frame adds its moment to the files (growing_document.hpp), however
/// many there are. Colliders are listed if colliders.h5 is there.
class FrameSeries {
 public:
  /// `restart_step`: frames up to this step stay in the series; later ones, which belong to the time that is now run again,
  /// are removed. -1 for a fresh start. Collective.
  FrameSeries(const Comm& comm, std::string folder, GlobalIndex restart_step);

  /// Adds a frame that write_frame has written; one without particles is left out. One that was added before, or comes before
  /// the last, makes the series be listed anew. Collective.
  void add(const Comm& comm, GlobalIndex index);

  /// Sentences about frames that could not be read and are left out; on the root.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  static constexpr std::size_t n_series = 5;  ///< particles, grid, tiles, magnetic field, colliders
  using Moments = std::array<std::optional<std::string>, n_series>;

  Moments moments_of(const std::string& file);
  void list(GlobalIndex last_step);

  std::string folder_;
  std::array<GrowingDocument, n_series> series_;
  GlobalIndex last_index_ = -1;
  std::vector<std::string> warnings_;
};

}  // namespace bulkley
