#include "integrator/implicit_viscosity.hpp"

#include <algorithm>
#include <cmath>

#include "parallel/reproducible_sum.hpp"

namespace bulkley {

ImplicitViscosity::ImplicitViscosity(StepParts& parts) : parts_(parts), contact_(parts.physics) {
  const Physics& physics = parts.physics;
  for (std::size_t m = 0; m < physics.materials.size(); ++m) {
    const double density = rest_density(physics.materials[m].material);
    kinematic_viscosity_ = std::max(kinematic_viscosity_, physics.implicit_viscosities[m] / density);
  }
}

void ImplicitViscosity::fit() {
  if (fitted_ == parts_.particles.version()) return;
  const PhaseTimer timer(parts_.times, Phase::rebuild);
  contact_.fit(parts_.particles.exchange().active_positions(), active(), parts_.particles.exchange().n_owned());
  const auto n_owned = static_cast<std::size_t>(parts_.particles.exchange().n_owned());
  const auto n_pool = static_cast<std::size_t>(parts_.particles.layout().n_nodes());
  for (NodeVector* values : {&residual_, &direction_, &spread_, &impulses_, &total_}) values->assign(n_owned, Node{});
  for (NodeVector* values : {&pool_velocity_, &pool_force_}) values->assign(n_pool, Node{});
  scale_.assign(n_owned, 0.0);
  mass_.assign(active().size(), 0.0);
  addends_.assign(active().size(), 0.0);
  fitted_ = parts_.particles.version();
}

ViscosityReport ImplicitViscosity::apply(double time, const GridUpdate& update, std::span<const Node> predicted, Node* nodes,
                                         Node* change) {
  const PhaseTimer timer(parts_.times, Phase::viscosity);
  fit();
  ViscosityReport report;
  largest_weight_ = max_global(
      parts_.comm(), set_viscous_weights(parts_.physics.implicit_viscosities, parts_.particles.particles(), weights_));
  if (largest_weight_ == 0.0) return report;
  start(time, update, predicted, nodes);
  report.solved = solve(update.dt, report);
  if (report.solved) parts_.add_later_impulses(update, total_.data(), nodes, change);
  return report;
}

// direction_: the velocities that the step would end with without viscosity, as its walls hold them.
void ImplicitViscosity::start(double time, const GridUpdate& update, std::span<const Node> predicted, const Node* nodes) {
  std::size_t place = 0;
  for (const LocalIndex n : active()) {
    const auto i = static_cast<std::size_t>(n);
    const double mass = nodes[n].c[3];
    const bool moves = mass > update.smallest_mass;
    scale_[i] = moves ? 1.0 / mass : 0.0;
    mass_[place++] = moves ? mass : 0.0;
    impulses_[i] = predicted.empty() ? Node{} : predicted[i];
  }
  contact_.fold(impulses_.data());
  for (const LocalIndex n : active()) {
    const auto i = static_cast<std::size_t>(n);
    for (int a = 0; a < 3; ++a) direction_[i].c[a] = nodes[n].c[a] + scale_[i] * impulses_[i].c[a];
  }
  contact_.begin(time, update.dt, parts_.feeds.stretches(), direction_.data());
  contact_.hold(direction_.data());
}

// impulses_ = -dt K v, of nodes in front of walls and behind; false where a velocity is not finite.
bool ImplicitViscosity::impulses_of(const NodeVector& velocity, double dt) {
  double largest = 0.0;
  for (const LocalIndex n : active()) {
    const double* const v = velocity[static_cast<std::size_t>(n)].c;
    const double square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    largest = square <= largest ? largest : square;  // a NaN counts
  }
  largest = max_global(parts_.comm(), std::isfinite(largest) ? largest : INFINITY);
  const double speed = std::sqrt(largest);
  ParticleGrid& particles = parts_.particles;
  const Physics& physics = parts_.physics;
  const double bound =
      dt * viscous_force_bound(physics.grid, physics.transfer, particles.bounds().sums.cell_count, largest_weight_, speed);
  if (!std::isfinite(bound)) return false;
  particles.exchange().get(velocity.data(), pool_velocity_.data());
  viscous_forces(physics.grid, physics.transfer, particles.layout(), particles.map(), particles.particles(), weights_.data(),
                 bound / dt, pool_velocity_.data(), pool_force_.data());
  particles.exchange().add(pool_force_.data(), impulses_.data());
  for (const LocalIndex n : active())
    for (double& component : impulses_[static_cast<std::size_t>(n)].c) component *= dt;
  return true;
}

// Impulses -> the changes of velocity that walls leave of them.
void ImplicitViscosity::spread(NodeVector& nodes) const { contact_.spread(scale_.data(), 0, nodes.data()); }

// Sum of m a . b over the nodes in front of walls; those behind have given their mass away.
double ImplicitViscosity::dot(const NodeVector& a, const NodeVector& b) {
  std::size_t place = 0;
  for (const LocalIndex n : active()) {
    const double* const u = a[static_cast<std::size_t>(n)].c;
    const double* const v = b[static_cast<std::size_t>(n)].c;
    addends_[place] = mass_[place] * (u[0] * v[0] + u[1] * v[1] + u[2] * v[2]);
    ++place;
  }
  return reproducible_sum(parts_.comm(), addends_);
}

// Conjugate gradients for the change of velocity since `start`, preconditioned by the mass: total_ = -dt K v of the velocities v
// found. The residual is that change which v lacks to obey the impulses.
bool ImplicitViscosity::solve(double dt, ViscosityReport& report) {
  const ViscousSettings& settings = parts_.physics.time_stepping.viscous;
  const StepBounds& bounds = parts_.particles.bounds();
  // Squares of an energy norm, J: below it, velocities are right to 1e-12 of the fastest.
  const double speed = bounds.motion.speed.value + dt * parts_.physics.gravity.norm();
  const double rounding = 1e-24 * static_cast<double>(bounds.totals.n_particles) * bounds.sums.mass.value * speed * speed;

  if (!impulses_of(direction_, dt)) return false;
  for (const LocalIndex n : active()) {
    const auto i = static_cast<std::size_t>(n);
    total_[i] = residual_[i] = impulses_[i];
  }
  spread(residual_);
  for (const LocalIndex n : active()) direction_[static_cast<std::size_t>(n)] = residual_[static_cast<std::size_t>(n)];
  double square = dot(residual_, residual_), change = 0.0;
  const double goal = settings.tolerance * settings.tolerance;
  while (square > std::max(goal * change, rounding)) {
    if (report.n_iterations == settings.max_iterations || !impulses_of(direction_, dt)) return false;
    for (const LocalIndex n : active()) spread_[static_cast<std::size_t>(n)] = impulses_[static_cast<std::size_t>(n)];
    spread(spread_);
    const double curvature = dot(direction_, direction_) - dot(direction_, spread_);
    if (!(curvature > 0.0)) return false;
    const double length = square / curvature;
    for (const LocalIndex n : active()) {
      const auto i = static_cast<std::size_t>(n);
      for (int a = 0; a < 3; ++a) {
        total_[i].c[a] += length * impulses_[i].c[a];
        residual_[i].c[a] -= length * (direction_[i].c[a] - spread_[i].c[a]);
      }
    }
    change += length * square;
    const double next = dot(residual_, residual_), ratio = next / square;
    for (const LocalIndex n : active()) {
      const auto i = static_cast<std::size_t>(n);
      for (int a = 0; a < 3; ++a) direction_[i].c[a] = residual_[i].c[a] + ratio * direction_[i].c[a];
    }
    square = next;
    ++report.n_iterations;
  }
  return std::isfinite(square);
}

void ImplicitViscosity::record(Field gradient, double dt, ParticleBlock block) {
  record_viscous_stress(parts_.physics.implicit_viscosities, gradient, dt, parts_.particles.particles(), block);
}

std::size_t ImplicitViscosity::memory() const {
  const std::size_t n_nodes = residual_.capacity() * 5 + pool_velocity_.capacity() * 2;
  const std::size_t n_values = weights_.capacity() + scale_.capacity() + mass_.capacity() + addends_.capacity();
  return n_nodes * sizeof(Node) + n_values * sizeof(double) + contact_.memory();
}

}  // namespace bulkley
