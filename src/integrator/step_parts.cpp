#include "integrator/step_parts.hpp"

#include <algorithm>
#include <cmath>

#include "bulkley/base/error.hpp"

namespace bulkley {

StepParts::StepParts(const Physics& all_physics, ParticleGrid& all_particles, NodeForces node_forces,
                     PhaseTimes& phase_times)
    : physics(all_physics),
      particles(all_particles),
      contact(all_physics, all_particles.comm()),
      forces(std::move(node_forces)),
      budget(all_physics, forces.size()),
      feeds(all_physics, budget),
      times(phase_times),
      material_seconds(all_physics.materials.size(), 0.0) {
  for (std::size_t k = 0; k < forces.size(); ++k) {
    if (!forces[k]->on_particles()) continue;
    BULKLEY_ASSERT(!forced_by_);  // p2g takes one
    forced_by_ = k;
  }
}

bool StepParts::fit() {
  if (fitted_ == particles.local_version()) return false;
  const PhaseTimer timer(times, Phase::rebuild);
  contact.fit(particles.exchange());
  if (!forces.empty()) active_positions = particles.exchange().active_positions();
  fitted_ = particles.local_version();
  return true;
}

void StepParts::prepare_forces(double time, double dt) {
  if (forces.empty() || !(dt > 0.0)) return;
  const PhaseTimer timer(times, Phase::forces);
  for (const auto& force : forces) force->prepare(particles, time, dt);
}

StepBounds StepParts::with_waves_of_forces(const StepBounds& bounds, double time) const {
  double square = 0.0;
  for (const auto& force : forces) square += force->wave_speed_squared();
  StepBounds result = bounds;
  include_feeds(physics, time, result);
  if (!(square > 0.0)) return result;
  Extreme& speed = result.motion.wave_speed;
  speed.value = std::sqrt(std::max(speed.value, 0.0) * std::max(speed.value, 0.0) + square);
  return result;
}

void StepParts::add_forces(const GridUpdate& update, double time, const Node* momenta, Node* impulses,
                           FailureCounts& failures) {
  if (!(update.dt > 0.0)) return;
  const ForcedNodes nodes{particles, particles.exchange().active_nodes(), active_positions, update, time, momenta, impulses};
  for (std::size_t k = 0; k < forces.size(); ++k) {
    if (k == forced_by_) continue;
    budget.before_force(nodes.active, impulses);
    forces[k]->add(nodes, failures);
    budget.after_force(k, nodes.active, impulses);
  }
}

void StepParts::before_move(ParticleBlock block) {
  if (forced_by_) budget.before_move(particles.particles(), block);
}

void StepParts::after_move(ParticleBlock block) {
  if (const ForceField force = force_on_particles())
    budget.add_force_work(*forced_by_, force->field, particles.particles(), block);
  budget.add_moved(std::min(block.end, particles.particles().size()) - block.begin);
}

void StepParts::add_later_impulses(const GridUpdate& update, Node* impulses, Node* nodes, Node* change) {
  contact.fold_later(impulses);
  const std::span<const LocalIndex> active = particles.exchange().active_nodes();
  budget.later_kick(update, active, nodes, impulses);
  for (const LocalIndex n : active) {
    if (!(nodes[n].c[3] > update.smallest_mass)) continue;
    const double inverse = 1.0 / nodes[n].c[3];
    for (int a = 0; a < 3; ++a) {
      const double given = impulses[n].c[a] * inverse;
      nodes[n].c[a] += given;
      if (change) change[n].c[a] += given;
    }
  }
}

std::size_t StepParts::memory() const {
  std::size_t total = contact.memory() + budget.memory() + active_positions.capacity() * sizeof(Int3);
  for (const auto& force : forces) total += force->memory();
  return total;
}

}  // namespace bulkley
