// What the implicit pressure makes of the particles that inflows carry (docs/theory.md, "Inflow").

#include "integrator/implicit_pressure.hpp"

namespace bulkley {

// What an inflow carries takes part as far behind its exit as stencils reach. Farther behind nothing past the exit feels it, and its volume
// is not the nodes' to change, whatever walls beside it say.
void ImplicitPressure::find_cells(double time) {
  const Physics& physics = parts_.physics;
  if (physics.feeds.empty()) return;
  const ParticleSet& particles = parts_.particles.particles();
  cell_of_ = parts_.particles.map().cell;
  carried_.assign(static_cast<std::size_t>(particles.size()), 0);
  const double reach = 0.5 * stencil_width(physics.grid.order) * physics.grid.cell_size;
  std::vector<NozzleState> nozzles;
  for (std::size_t f = 0; f < physics.feeds.size(); ++f)
    nozzles.push_back(physics.feeds[f].at(time, parts_.feeds.stretches()[f]));
  for_each_carried(physics, time, particles, [&](std::size_t f, LocalIndex p) {
    const Feed& feed = physics.feeds[f];
    const GlobalIndex id = particles.id()[p];
    carried_[static_cast<std::size_t>(p)] = 1;
    if (feed.distance(nozzles[f], feed.layer_of(id), feed.point_of(id)) < -reach)
      cell_of_[static_cast<std::size_t>(p)] = grid_->n_own_ids();
  });
}

const std::vector<LocalIndex>& ImplicitPressure::cells() const {
  return parts_.physics.feeds.empty() ? parts_.particles.map().cell : cell_of_;
}

// What an inflow carries cannot be squeezed, its J is given: where it shares a cell with others, they alone take up what the cell's volume
// changes by. A cell of its own has the pressure of the last step, whatever J says, and changes it as if it were not carried.
void ImplicitPressure::account_for_carried(std::size_t k) {
  const ParticleSet& particles = parts_.particles.particles();
  double compliance = 0.0, target = 0.0, last = 0.0;  // of the others; of all that is carried
  for (const LocalIndex p : members_.of(static_cast<LocalIndex>(k))) {
    const VolumetricLaw& law = *laws_[particles.material()[p]];
    const double J = particles.real(Field::volume_ratio)[p];
    const double share = particles.real(Field::reference_volume)[p] / law.slope(J);
    if (carried_[static_cast<std::size_t>(p)]) {
      last += share * particles.real(Field::cell_mean_stress)[p];
    } else {
      compliance += share;
      target += share * law.stress(J);
    }
  }
  if (compliance > 0.0) {
    compliance_[k] = compliance;
    target_[k] = target;
  } else {
    target_[k] = last;
  }
}

}  // namespace bulkley
