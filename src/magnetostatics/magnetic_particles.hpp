#pragma once
// The magnetic field of particles and its force on them.

#include <memory>
#include <optional>

#include "distribution/particle_grid.hpp"
#include "field/tile_scatter.hpp"
#include "magnetostatics/magnetostatics.hpp"

namespace bulkley {

/// A box of nodes around a grid: it holds all nodes of `grid`, and on every open axis at least `air` times the extent of the magnetic
/// bodies between them (`lower` to `upper`, m) and its faces; 4 to 8 cells times a power of two. Not collective.
FieldLayout magnetic_layout(const GridGeometry& grid, const Vec3& lower, const Vec3& upper, double air);

class MagneticParticles {
 public:
  /// `magnetisations`: by material of the particles; none for those that are not magnetic. `applied` must outlive this. Throws
  /// UsageError where PETSc cannot number the field's nodes. Collective.
  MagneticParticles(const Comm& comm, const FieldLayout& layout, const MagneticsSettings& settings, const Vec3& origin,
                    const std::vector<std::optional<Magnetisation>>& magnetisations, const AppliedField& applied);

  /// Finds the field of the particles as they are, and with it `forces` and `strengths`. Collective.
  MagneticReport solve(double time, ParticleGrid& particles);

  /// Of the last solution, by particle as the particles were then: F = V sum_i Phi_i grad w_i (G10) along an axis, N, zero for materials
  /// that are not magnetic; |H| as nodes with material have it, A/m.
  const std::vector<double>& forces(int axis) const { return forces_[static_cast<std::size_t>(axis)]; }
  const std::vector<double>& strengths() const { return strengths_; }

  /// Likewise, into the fields `magnetic_field` and `magnetisation` of the particles as they are, of those that they have: means over the
  /// nodes with material in their stencil. Collective.
  void show(ParticleGrid& particles);

  Magnetostatics& field() { return field_; }
  std::size_t memory() const;

 private:
  void find_forces(ParticleGrid& particles);
  void to_pool(ParticleGrid& particles, std::span<const double> field, std::vector<double>& pool);

  std::vector<double> gathered(ParticleGrid& particles, std::span<const double> field);

  std::vector<int> magnet_of_;  ///< by material: among the magnetic ones, or -1
  Magnetostatics field_;
  std::unique_ptr<TileScatter> scatter_;
  GlobalIndex fitted_ = -1;
  std::vector<double> pool_, strength_pool_, owned_, volume_, strengths_;
  std::array<std::vector<double>, 3> forces_, gradient_;
};

}  // namespace bulkley
