#pragma once
// The signed distance to a mesh, sampled on a lattice near its surface, so that a lookup costs a few memory accesses.

#include <array>
#include <memory>
#include <unordered_map>
#include <vector>

#include "geometry/mesh_solid.hpp"

namespace bulkley {

/// Trilinear between lattice points of the given spacing within `band` of the surface; beyond it at least `band`, with the
/// right sign. Blocks of the lattice are sampled when a lookup first needs them: a rank pays for the surface near its own
/// nodes only, and the values do not depend on the order. Not for several threads at a time.
class SampledDistance {
 public:
  /// Throws UsageError, a sentence that continues after the mesh's name, if the mesh is too large for such a spacing.
  SampledDistance(std::shared_ptr<const MeshSolid> solid, double spacing, double band);

  /// m, negative inside. Not collective, as all functions here.
  double distance(const Vec3& x) const;
  /// Outward unit normal: the gradient over one spacing, where the errors of the interpolation of a smooth surface cancel.
  /// Beyond the band, and where the nearest point jumps, one and the same direction for a block of the lattice.
  Vec3 normal(const Vec3& x) const;

 private:
  static constexpr int width = 4;  ///< lattice intervals along the edge of a block
  static constexpr int n_points = (width + 1) * (width + 1) * (width + 1);
  using Block = std::array<float, n_points>;
  enum State : std::int32_t { unknown = -1, outside = -2, inside = -3 };

  struct Place {
    Int3 block, in_block;
    Vec3 fraction;
    std::size_t index;  ///< of the block
  };
  Place place(const Vec3& x) const;
  std::int32_t sample(const Int3& block) const;
  Vec3 normal_of_block(const Vec3& x) const;

  std::shared_ptr<const MeshSolid> solid_;
  double spacing_, band_;
  Vec3 lower_, upper_;  ///< of the lattice
  Int3 n_blocks_;
  mutable std::vector<std::int32_t> block_at_;  ///< position in blocks_, or a State
  mutable std::vector<Block> blocks_;
  mutable std::unordered_map<std::size_t, Vec3> normals_;  ///< of blocks that have no gradient
};

}  // namespace bulkley
