#include "integrator/crowding.hpp"

#include <algorithm>

#include "bulkley/base/pack.hpp"

namespace bulkley {

namespace {

bool takes_part(const Physics& physics, std::size_t m) {
  const bool of_cells = physics.volumetric_laws.empty() ? !physics.shares_dilation.empty() && physics.shares_dilation[m]
                                                        : physics.volumetric_laws[m].has_value();
  return of_cells && flows(physics.materials[m].material);
}

}  // namespace

Crowding::Crowding(const Physics& physics, LocalIndex block_size) : physics_(physics) {
  for (std::size_t m = 0; m < physics.materials.size(); ++m) takes_part_.push_back(takes_part(physics, m));
  const double dx = physics.grid.cell_size;
  inverse_full_mass_ = 1.0 / (physics.largest_density() * dx * dx * dx);
  if (std::ranges::count(takes_part_, 1) > 0) fullness_.resize(static_cast<std::size_t>(block_size) + n_lanes);
}

void Crowding::fit(const Exchange& exchange) {
  if (fullness_.empty()) return;
  const auto active = exchange.active_nodes();
  near_walls_ = node_volumes(physics_.grid, physics_.faces, physics_.colliders, exchange.active_positions());
  for (NodeVolume& near : near_walls_) near.node = active[static_cast<std::size_t>(near.node)];
}

void Crowding::find_fullness(std::span<const LocalIndex> active, Node* nodes) const {
  if (fullness_.empty()) return;
  for (const LocalIndex n : active) nodes[n].c[3] *= inverse_full_mass_;
  for (const NodeVolume& near : near_walls_) nodes[near.node].c[3] /= near.part;
}

void Crowding::spare(const char* carried, ParticleBlock block, LocalIndex n_particles) {
  if (fullness_.empty() || !carried) return;
  const LocalIndex end = std::min(block.end, n_particles);
  for (LocalIndex p = block.begin; p < end; ++p)
    if (carried[p]) fullness_[static_cast<std::size_t>(p - block.begin)] = 0.0;
}

}  // namespace bulkley
