#include "integrator/crowding.hpp"

#include <algorithm>
#include <cmath>
#include <ranges>

#include "bulkley/base/pack.hpp"

namespace bulkley {

namespace {

constexpr double least_fullness = 0.95;  // of (V6)
constexpr double clear_cells = 2.0;      // from what moves, whose room is not known

}  // namespace

Crowding::Crowding(const Physics& physics, LocalIndex block_size) : physics_(physics) {
  for (std::size_t m = 0; m < physics.materials.size(); ++m)
    takes_part_.push_back(physics.keeps_volume_of_cells(m) && flows(physics.materials[m].material));
  const double dx = physics.grid.cell_size;
  inverse_full_mass_ = 1.0 / (physics.largest_density() * dx * dx * dx);
  if (std::ranges::count(takes_part_, 1) == 0) return;
  fullness_.resize(static_cast<std::size_t>(block_size) + n_lanes);
  if (!physics.transfer.close_voids) return;
  for (const NamedMaterial& named : physics.materials)
    lightness_.push_back(physics.largest_density() / rest_density(named.material));
  floors_ = floors_of(physics.grid, physics.faces, physics.gravity);
  for (const Floor& floor : floors_) slopes_[floor.axis].resize(fullness_.size());
  if (!floors_.empty()) voids_.resize(fullness_.size());
}

Gathered Crowding::of_block() {
  if (fullness_.empty()) return {};
  Gathered gathered{.value = fullness_.data()};
  for (const Floor& floor : floors_) gathered.slope[floor.axis] = slopes_[floor.axis].data();
  return gathered;
}

void Crowding::fit(const Exchange& exchange) {
  if (fullness_.empty()) return;
  const auto active = exchange.active_nodes();
  const std::vector<Int3> nodes = exchange.active_positions();
  near_walls_ = node_volumes(physics_.grid, physics_.faces, physics_.colliders, nodes);
  for (NodeVolume& near : near_walls_) near.node = active[static_cast<std::size_t>(near.node)];
  behind_walls_.clear();
  for (int f = 0; f < 6; ++f)
    if (behaviour(physics_.faces[static_cast<std::size_t>(f)].kind).contact)
      for (const MirrorPair& pair : mirror_pairs(physics_.grid, f, nodes))
        behind_walls_.push_back({active[static_cast<std::size_t>(pair.behind)], active[static_cast<std::size_t>(pair.front)]});
}

// A node behind a wall is as full as the one in front, or a full cell would look half empty from the wall. Faces in reverse, as for
// velocities: what is behind two of them takes what the other has in front.
void Crowding::find_fullness(std::span<const LocalIndex> active, Node* nodes) const {
  if (fullness_.empty()) return;
  for (const LocalIndex n : active) nodes[n].c[3] *= inverse_full_mass_;
  for (const NodeVolume& near : near_walls_) nodes[near.node].c[3] /= near.part;
  for (const MirrorPair& pair : std::views::reverse(behind_walls_)) nodes[pair.behind].c[3] = nodes[pair.front].c[3];
}

void Crowding::find_moving(double time, const RigidContact* bodies) {
  if (voids_.empty()) return;
  moving_.clear();
  for (const Collider& collider : physics_.colliders)
    if (collider.motion.moves()) moving_.push_back({collider.shape, collider.motion.pose(time)});
  bodies_ = bodies;
  if (bodies) body_poses_ = bodies->poses();
}

bool Crowding::near_moving(const Vec3& x) const {
  const double clearance = clear_cells * physics_.grid.cell_size;
  for (const Moving& collider : moving_)
    if (signed_distance_within(collider.shape, collider.pose.to_shape(x), clearance) < clearance) return true;
  return bodies_ && bodies_->any_within(clearance, x, body_poses_);
}

// A void has material over it: the fullness rises from the floor by what is missing. A film thinner than a cell is not full either, but
// there it falls. Where densities differ, all that is there counts as if it were as light as the particle: then less is missing,
// never more.
void Crowding::find_voids(const ParticleSet& particles, ParticleBlock block, const double* pressures) {
  if (voids_.empty()) return;
  const LocalIndex end = std::min(block.end, particles.size());
  const double* const J = particles.real(Field::volume_ratio);
  const std::uint8_t* const material = particles.material();
  std::fill_n(voids_.begin(), end - block.begin, 0.0);
  for (const Floor& floor : floors_) {
    const double* const x = particles.real(Field::position, floor.axis);
    const double* const slope = slopes_[floor.axis].data();
    for (LocalIndex p = block.begin; p < end; ++p) {
      const auto k = static_cast<std::size_t>(p - block.begin);
      if (!(pressures[k] > 0.0) || std::abs(floor.height(x[p])) >= physics_.grid.cell_size) continue;
      const double lightness = lightness_[material[p]];
      const double missing = std::min(least_fullness - lightness * fullness_[k] * J[p], lightness * floor.upwards * slope[k]);
      if (missing > 0.0 && !near_moving(particles.vector(Field::position, p))) voids_[k] = missing;
    }
  }
}

Room Crowding::of_material(std::size_t m) const {
  if (!takes_part_[m]) return {};
  return {fullness_.data(), voids_.empty() ? nullptr : voids_.data()};
}

void Crowding::spare(const char* carried, ParticleBlock block, LocalIndex n_particles) {
  if (fullness_.empty() || !carried) return;
  const LocalIndex end = std::min(block.end, n_particles);
  for (LocalIndex p = block.begin; p < end; ++p)
    if (carried[p]) {
      fullness_[static_cast<std::size_t>(p - block.begin)] = 0.0;
      if (!voids_.empty()) voids_[static_cast<std::size_t>(p - block.begin)] = 0.0;
    }
}

}  // namespace bulkley
