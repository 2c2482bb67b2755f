#include "integrator/implicit_pressure.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "integrator/petsc_solver.hpp"
#include "parallel/reproducible_sum.hpp"

namespace bulkley {

namespace {

// Of the residual, while it is only to be found which walls hold.
constexpr double rough_tolerance = 0.1;

// Where little changes from step to step, the pressure of the step before is within the tolerance, and what it lacks would
// accumulate as noise.
constexpr int least_iterations = 2;

}  // namespace

ImplicitPressure::ImplicitPressure(StepParts& parts)
    : parts_(parts), laws_(parts.physics.volumetric_laws), contact_(parts.physics) {
  any_may_part_ = std::any_of(laws_.begin(), laws_.end(), [](const auto& law) { return law && !law->tension; });
  if (RigidContact* const bodies = parts_.contact.rigid_bodies())
    bodies_ = std::make_unique<PressureBodies>(parts_.comm(), *bodies);
  const PressureSettings& settings = parts_.physics.time_stepping.pressure;
  if (settings.solver == PressureSolver::petsc) petsc_ = std::make_unique<PetscSolver>(parts_.comm(), settings);
}

ImplicitPressure::~ImplicitPressure() = default;

void ImplicitPressure::fit() {
  if (fitted_ == parts_.particles.version()) return;
  const PhaseTimer timer(parts_.times, Phase::rebuild);
  grid_ = std::make_unique<CellGrid>(parts_.comm(), parts_.particles, parts_.physics.faces);
  collective_guard(parts_.comm(), [&] {
    contact_.fit(*grid_);
    if (bodies_) bodies_->fit(parts_.physics.grid, *grid_);
    pool_.assign(static_cast<std::size_t>(parts_.particles.layout().n_nodes()), Node{});
    owned_impulses_.assign(static_cast<std::size_t>(parts_.particles.exchange().n_owned()), Node{});
  });
  fitted_ = parts_.particles.version();
}

void ImplicitPressure::begin(double time, const GridUpdate& update, const Node* nodes) {
  const PhaseTimer timer(parts_.times, Phase::pressure);
  fit();
  find_cells(time);
  count_cells();
  fetch(nodes);
  select_nodes(update, nodes);
  number_cells();
  fill_cells();
}

PressureReport ImplicitPressure::apply(double time, const GridUpdate& update, double unclipped_dt, Node* nodes,
                                       Node* change) {
  const PhaseTimer timer(parts_.times, Phase::pressure);
  copy_nodes(update, nodes);
  gradients_of(pressure_, RowEntries::rounded);
  find_unheld(update.dt);
  contact_.begin(time, update.dt, parts_.feeds.stretches(), held_.data(),
                 bodies_ ? bodies_->find(contact_.nodes(), scale_.data()) : std::span<const NodeConstraint>());
  if (bodies_) merge_bodies(time, update);
  set_diagonal(update.dt, unclipped_dt);
  set_right_side(update.dt);
  square_of_right_ = precondition(right_);
  find_unheld(update.dt);
  if (petsc_) matrix_.number_rows(parts_.comm(), halo_, own_, rows_.size());
  preconditioned_ = false;
  PressureReport report;
  // Rough solutions until few walls and free surfaces change their state, then ones that are as good as they have to be.
  const PressureSettings& settings = parts_.physics.time_stepping.pressure;
  const GlobalIndex few = sum_global(parts_.comm(), static_cast<GlobalIndex>(own_.size())) / 100;
  double tolerance = settings.contact_rounds > 1 ? std::max(rough_tolerance, settings.tolerance) : settings.tolerance;
  GlobalIndex n_changed = 1;
  for (bool settled = false; !settled;) {
    if (n_changed > 0) begin_solution(update.dt);
    if (!solve(update.dt, tolerance, report)) {
      report.solved = false;
      return report;
    }
    ++report.n_rounds;
    const bool last = tolerance == settings.tolerance;
    n_changed = revise(update.dt, last ? RowEntries::exact : RowEntries::rounded);
    if (bodies_ && n_changed > 0) {
      merge_bodies(time, update);
      find_unheld(update.dt);
    }
    settled = last && (n_changed == 0 || report.n_rounds >= settings.contact_rounds);
    if (n_changed <= few || report.n_rounds + 1 >= settings.contact_rounds) tolerance = settings.tolerance;
  }
  add_impulses(update, nodes, change);
  return report;
}

// pool_ has those of other ranks.
void ImplicitPressure::copy_nodes(const GridUpdate& update, const Node* nodes) {
  for (const CellGrid::Copy& copy : contact_.nodes().owned()) free_[static_cast<std::size_t>(copy.node)] = nodes[copy.other];
  for (const CellGrid::Copy& copy : contact_.nodes().in_pool())
    free_[static_cast<std::size_t>(copy.node)] = pool_[static_cast<std::size_t>(copy.other)];
  for (const LocalIndex n : contact_.nodes().complete()) {
    const double mass = free_[static_cast<std::size_t>(n)].c[3];
    scale_[static_cast<std::size_t>(n)] = mass > update.smallest_mass ? 1.0 / mass : 0.0;
  }
  repeat(contact_.repeated(), free_.data());
}

// impulses_ = B^T p of all complete nodes; fetches p of other ranks.
void ImplicitPressure::gradients_of(std::vector<double>& p, RowEntries entries) {
  halo_.exchange(parts_.comm(), p.data(), 1);
  std::fill(impulses_.begin(), impulses_.end(), Node{});
  add_gradients(rows_, entries, 0, rows_.size(), p.data(), impulses_.data());
  fold_repeated(contact_.repeated(), impulses_.data());
}

// For the walls in force.
void ImplicitPressure::merge_bodies(double time, const GridUpdate& update) {
  held_ = free_;
  contact_.hold_by_walls(held_.data());
  bodies_->merge(time, update, contact_, held_.data(), rows_, own_);
}

PressureBodies::Coupling ImplicitPressure::couple(const std::vector<double>& p) const {
  return bodies_ ? bodies_->couple(p) : PressureBodies::Coupling();
}

// product_ = (A + dt^2 B P M^-1 P^T B^T + Z) p of this rank's cells. `coupling`: of p.
void ImplicitPressure::multiply(double dt, std::vector<double>& p, const PressureBodies::Coupling& coupling) {
  halo_.exchange(parts_.comm(), p.data(), 1);
  const CellWaves& waves = contact_.waves();
  LocalIndex end_of_nodes = 0;
  for (LocalIndex w = 0; w < waves.size(); ++w) {
    const LocalIndex end = contact_.end_of_nodes(w);
    std::fill(impulses_.begin() + end_of_nodes, impulses_.begin() + end, Node{});
    end_of_nodes = end;
    add_gradients(rows_, RowEntries::rounded, end_of_plane_[static_cast<std::size_t>(w)],
                  end_of_plane_[static_cast<std::size_t>(w) + 1], p.data(), impulses_.data());
    contact_.spread(scale_.data(), w, impulses_.data());
    volume_rates(rows_, RowEntries::rounded, own_ranges_.of(own_by_wave_, w), impulses_.data(), product_.data());
  }
  if (bodies_) bodies_->add_rates(coupling, product_.data());
  sum_blocks(p);
  const double dt_squared = dt * dt;
  for (std::size_t k = 0; k < own_.size(); ++k) {
    const auto c = static_cast<std::size_t>(own_[k]);
    product_[c] = (compliance_[k] * p[c] + dt_squared * product_[c]) + stabilisation(k, p);
  }
}

void ImplicitPressure::sum_blocks(const std::vector<double>& p) {
  std::fill(block_sum_.begin(), block_sum_.end(), 0.0);
  for (std::size_t k = 0; k < own_.size(); ++k)
    block_sum_[static_cast<std::size_t>(block_of_[k])] += volume_[k] * p[static_cast<std::size_t>(own_[k])];
}

// (Z p) of this rank's k-th cell, after `sum_blocks`.
double ImplicitPressure::stabilisation(std::size_t k, const std::vector<double>& p) const {
  const auto c = static_cast<std::size_t>(own_[k]), b = static_cast<std::size_t>(block_of_[k]);
  return within_block_[k] * (p[c] - block_sum_[b] * inverse_block_volume_[b]);
}

// held_ as walls and bodies hold it, and behind walls as images.
template <class F>
void ImplicitPressure::hold_nodes(F velocity_of_body) {
  if (bodies_)
    contact_.hold(held_.data(), velocity_of_body);
  else
    contact_.hold(held_.data());
}

// For the constraints in force. Changes held_.
void ImplicitPressure::set_right_side(double dt) {
  held_ = free_;
  hold_nodes([&](const NodeConstraint& constraint) { return bodies_->velocity_at(constraint); });
  volume_rates(rows_, RowEntries::exact, own_, held_.data(), right_.data());
  for (std::size_t k = 0; k < own_.size(); ++k) {
    double& right = right_[static_cast<std::size_t>(own_[k])];
    right = target_[k] + dt * right;
  }
}

// residual_ = b - S p, in one product: the change of volume under the velocities that p leaves, which are held_ before their
// constraints hold them. Changes held_.
void ImplicitPressure::find_residual(double dt) {
  std::vector<RigidVelocity> bodies;
  if (bodies_) bodies = bodies_->velocities_under(couple(pressure_), dt);
  hold_nodes([&](const NodeConstraint& constraint) { return bodies_->velocity_at(constraint, bodies); });
  volume_rates(rows_, RowEntries::exact, own_, held_.data(), residual_.data());
  sum_blocks(pressure_);
  for (std::size_t k = 0; k < own_.size(); ++k) {
    const auto c = static_cast<std::size_t>(own_[k]);
    residual_[c] = ((target_[k] - compliance_[k] * pressure_[c]) + dt * residual_[c]) - stabilisation(k, pressure_);
  }
}

// Z of (I7), and the diagonal with the constraints that are in force at first, but for what images behind walls share with
// those in front.
void ImplicitPressure::set_diagonal(double dt, double unclipped_dt) {
  NodeVector& scales = held_;
  for (std::size_t n = 0; n < scale_.size(); ++n) scales[n] = {{scale_[n], scale_[n], scale_[n], 0.0}};
  contact_.weaken(scales.data());
  const double dx = parts_.physics.grid.cell_size;
  const double stiffness = parts_.physics.time_stepping.pressure.stabilisation * unclipped_dt * unclipped_dt / (dx * dx);
  within_block_.resize(own_.size());
  std::vector<double>& by_bodies = product_;
  std::fill(by_bodies.begin(), by_bodies.end(), 0.0);
  if (bodies_) bodies_->add_diagonal(by_bodies.data());
  for (std::size_t b = 0; b < block_volume_.size(); ++b)
    inverse_block_volume_[b] = block_volume_[b] > 0.0 ? 1.0 / block_volume_[b] : 0.0;
  for (std::size_t k = 0; k < own_.size(); ++k) {
    const auto c = static_cast<std::size_t>(own_[k]), b = static_cast<std::size_t>(block_of_[k]);
    within_block_[k] = stiffness * block_volume_[b] / block_mass_[b] * volume_[k];
    const double z = within_block_[k] * (1.0 - volume_[k] * inverse_block_volume_[b]);
    inverse_diagonal_[c] =
        1.0 / (compliance_[k] + dt * dt * (diagonal_of(rows_, own_[k], scales.data()) + by_bodies[c]) + z);
  }
}

// m/s: what changes of velocity are compared with.
double ImplicitPressure::speed_scale(double dt) const {
  return parts_.particles.bounds().motion.speed.value + dt * parts_.physics.gravity.norm();
}

// scaled_ = `from` over the diagonal, 0 where the cell has parted. Returns their product.
double ImplicitPressure::precondition(const std::vector<double>& from) {
  for (std::size_t c = 0; c < from.size(); ++c) scaled_[c] = inverse_diagonal_[c] * from[c];
  if (any_may_part_)
    for (std::size_t k = 0; k < own_.size(); ++k)
      if (parted_[k]) scaled_[static_cast<std::size_t>(own_[k])] = 0.0;
  if (bodies_) return bodies_->dot(from, scaled_, coupling_of_scaled_);
  return reproducible_dot(parts_.comm(), from, scaled_);
}

// From the pressures that are there, for the constraints in force; held_: the velocities that they leave where nothing holds.
void ImplicitPressure::begin_solution(double dt) {
  if (petsc_) {
    set_right_side(dt);
    return assemble(dt);
  }
  find_residual(dt);
  square_ = precondition(residual_);
  direction_ = scaled_;
  coupling_of_direction_ = coupling_of_scaled_;
}

// Continues to a tolerance.
bool ImplicitPressure::solve(double dt, double tolerance, PressureReport& report) {
  const PressureSettings& settings = parts_.physics.time_stepping.pressure;
  const StepBounds& bounds = parts_.particles.bounds();
  // Squares of an energy norm, J: below the second, velocities are right to 1e-12 of the fastest.
  const double speed = speed_scale(dt);
  const double rounding = 1e-24 * static_cast<double>(bounds.totals.n_particles) * bounds.sums.mass.value * speed * speed;
  const double goal = std::max(tolerance * tolerance * square_of_right_, rounding);
  if (petsc_) return solve_with_petsc({goal, rounding, least_iterations - report.n_iterations}, report);
  for (int n = 0; square_ > (report.n_iterations < least_iterations ? rounding : goal); ++n) {
    if (n == settings.max_iterations) return false;
    multiply(dt, direction_, coupling_of_direction_);
    for (std::size_t k = 0; k < own_.size(); ++k)
      if (parted_[k]) product_[static_cast<std::size_t>(own_[k])] = 0.0;
    const double curvature = reproducible_dot(parts_.comm(), direction_, product_);
    if (!(curvature > 0.0)) return false;
    const double length = square_ / curvature;
    for (const LocalIndex own : own_) {
      const auto c = static_cast<std::size_t>(own);
      pressure_[c] += length * direction_[c];
      residual_[c] -= length * product_[c];
    }
    const double next = precondition(residual_), ratio = next / square_;
    for (const LocalIndex own : own_) {
      const auto c = static_cast<std::size_t>(own);
      direction_[c] = scaled_[c] + ratio * direction_[c];
    }
    for (std::size_t b = 0; b < coupling_of_direction_.size(); ++b)
      coupling_of_direction_[b] = coupling_of_scaled_[b] + ratio * coupling_of_direction_[b];
    square_ = next;
    ++report.n_iterations;
  }
  return std::isfinite(square_) && std::isfinite(goal);
}

// The matrix with the constraints in force. Its preconditioner stays through the step.
void ImplicitPressure::assemble(double dt) {
  if (matrix_.n_rows() == 0) return;
  const SparseRows& rows = matrix_.assemble(
      parts_.comm(), halo_,
      {dt, rows_, contact_, scale_, own_, volume_, compliance_, within_block_, block_of_, block_volume_, parted_});
  if (preconditioned_)
    petsc_->change_matrix(rows);
  else
    petsc_->set_matrix(rows);
  preconditioned_ = true;
}

// From the pressures that are there. The right side of cells that have parted is their pressure, 0.
bool ImplicitPressure::solve_with_petsc(const PetscGoal& goal, PressureReport& report) {
  if (matrix_.n_rows() == 0) return true;
  std::vector<double> right(own_.size()), weight(own_.size()), pressure(own_.size());
  for (std::size_t k = 0; k < own_.size(); ++k) {
    const auto c = static_cast<std::size_t>(own_[k]);
    right[k] = parted_[k] ? 0.0 : right_[c];
    weight[k] = inverse_diagonal_[c];
    pressure[k] = pressure_[c];
  }
  const PetscOutcome outcome = petsc_->solve(goal, right, weight, pressure);
  for (std::size_t k = 0; k < own_.size(); ++k)
    pressure_[static_cast<std::size_t>(own_[k])] = parted_[k] ? 0.0 : pressure[k];
  report.n_iterations += outcome.n_iterations;
  if (outcome.fault.empty()) return true;
  report.fault = fmt::format("by PETSc after {} iterations: {}", outcome.n_iterations, outcome.fault);
  return false;
}

// held_ = the velocities that the gradients in impulses_ would give the nodes if no wall held them.
void ImplicitPressure::find_unheld(double dt) {
  held_ = impulses_;
  contact_.fold(held_.data());
  for (const LocalIndex n : contact_.nodes().complete()) {
    const auto i = static_cast<std::size_t>(n);
    for (int a = 0; a < 3; ++a) held_[i].c[a] = free_[i].c[a] - dt * scale_[i] * held_[i].c[a];
  }
}

// Walls that would pull let go, those that would be penetrated hold, and cells that hold no tension part. Returns how many
// changed.
GlobalIndex ImplicitPressure::revise(double dt, RowEntries entries) {
  GlobalIndex n_changed = 0;
  gradients_of(pressure_, entries);
  find_unheld(dt);
  if (any_may_part_) {
    find_residual(dt);
    n_changed = revise_parted();
    gradients_of(pressure_, entries);
    find_unheld(dt);
  }
  std::vector<RigidVelocity> bodies;
  if (bodies_ && bodies_->any_separates()) bodies = bodies_->velocities_under(couple(pressure_), dt);
  n_changed += contact_.revise(scale_.data(), held_.data(),
                               parts_.physics.time_stepping.pressure.tolerance * speed_scale(dt), bodies);
  return sum_global(parts_.comm(), n_changed);
}

// By the residual, of which cells that have parted may have what closes them.
GlobalIndex ImplicitPressure::revise_parted() {
  GlobalIndex n_changed = 0;
  for (std::size_t k = 0; k < own_.size(); ++k) {
    if (!may_part_[k]) continue;
    const auto c = static_cast<std::size_t>(own_[k]);
    const bool part = parted_[k] ? residual_[c] >= 0.0 : pressure_[c] > 0.0;
    n_changed += part != static_cast<bool>(parted_[k]);
    parted_[k] = part;
    if (part) pressure_[c] = 0.0;
  }
  return n_changed;
}

// owned_impulses_ = -dt B^T p, which is in impulses_.
void ImplicitPressure::copy_impulses(double dt) {
  std::ranges::fill(owned_impulses_, Node{});
  for (const CellGrid::Copy& copy : contact_.nodes().owned()) {
    const double* const gradient = impulses_[static_cast<std::size_t>(copy.node)].c;
    owned_impulses_[static_cast<std::size_t>(copy.other)] = {{-dt * gradient[0], -dt * gradient[1], -dt * gradient[2], 0.0}};
  }
}

std::span<const Node> ImplicitPressure::last_impulses(double dt) {
  const PhaseTimer timer(parts_.times, Phase::pressure);
  gradients_of(pressure_, RowEntries::exact);
  copy_impulses(dt);
  return owned_impulses_;
}

// After the last `revise`, which has left B^T p in impulses_.
void ImplicitPressure::add_impulses(const GridUpdate& update, Node* nodes, Node* change) {
  copy_impulses(update.dt);
  parts_.add_later_impulses(update, owned_impulses_.data(), nodes, change);
}

void ImplicitPressure::keep_volumes(ParticleBlock block) {
  const ParticleSet& particles = parts_.particles.particles();
  const double* const J = particles.real(Field::volume_ratio);
  before_.resize(static_cast<std::size_t>(particles.size()));
  const LocalIndex end = std::min(block.end, particles.size());
  std::copy(J + block.begin, J + end, before_.begin() + block.begin);
}

void ImplicitPressure::update_volumes(StepBounds& local) {
  const PhaseTimer timer(parts_.times, Phase::pressure);
  ParticleSet& particles = parts_.particles.particles();
  const VolumeUpdate update{parts_.physics.time_stepping.pressure.relaxation, before_.data(), parts_.feeds.carried()};
  for (std::size_t k = 0; k < own_.size(); ++k)
    bulkley::update_volumes(laws_, update, members_.of(static_cast<LocalIndex>(k)),
                            pressure_[static_cast<std::size_t>(own_[k])], parted_[k], particles);
  double* const J = particles.real(Field::volume_ratio);
  if (const char* const carried = parts_.feeds.carried())
    for (LocalIndex p = 0; p < particles.size(); ++p)
      if (carried[p]) J[p] = before_[static_cast<std::size_t>(p)];
  local.totals.smallest_volume_ratio = {};
  local.totals.largest_volume_ratio = {};
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    local.totals.smallest_volume_ratio.include(J[p]);
    local.totals.largest_volume_ratio.include(J[p]);
    if (std::isfinite(J[p])) continue;
    ++local.failures.n_not_finite;
    local.failures.failed_id.include(particles.id()[p]);
  }
}

std::size_t ImplicitPressure::memory() const {
  const std::size_t n_values = pressure_.capacity() * 7 + block_volume_.capacity() * 4 + within_block_.capacity() +
                               scale_.capacity() + before_.capacity() + takes_part_.capacity() / sizeof(double);
  const std::size_t n_nodes =
      free_.capacity() * 3 + pool_.capacity() + owned_impulses_.capacity() + rows_.gradient.capacity();
  const std::size_t n_indices = cell_of_.capacity() + number_of_.capacity() + counts_.capacity() + own_.capacity() +
                                place_of_.capacity() + members_.first.capacity() + members_.particle.capacity() +
                                rows_.first.capacity() + rows_.rounded.capacity() + block_of_.capacity() +
                                others_.capacity() + end_of_plane_.capacity() + wave_of_own_.capacity() +
                                own_by_wave_.capacity();
  return n_values * sizeof(double) + n_nodes * sizeof(Node) + n_indices * sizeof(LocalIndex) +
         3 * volume_.capacity() * sizeof(double) + contact_.memory() + matrix_.memory() + (bodies_ ? bodies_->memory() : 0) +
         (grid_ ? grid_->memory() : 0);
}

}  // namespace bulkley
