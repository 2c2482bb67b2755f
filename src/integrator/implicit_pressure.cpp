#include "integrator/implicit_pressure.hpp"

#include <algorithm>
#include <cmath>

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
  may_part_ = std::any_of(laws_.begin(), laws_.end(), [](const auto& law) { return law && !law->tension; });
}

void ImplicitPressure::fit() {
  if (fitted_ == parts_.particles.version()) return;
  const PhaseTimer timer(parts_.times, Phase::rebuild);
  grid_ = std::make_unique<CellGrid>(parts_.comm(), parts_.particles, parts_.physics.faces);
  collective_guard(parts_.comm(), [&] {
    contact_.fit(*grid_);
    const auto n = static_cast<std::size_t>(grid_->n_nodes()) + 1;
    for (NodeVector* nodes : {&free_, &held_, &impulses_}) nodes->assign(n, Node{});
    scale_.assign(n, 0.0);
    pool_.assign(static_cast<std::size_t>(parts_.particles.layout().n_nodes()), Node{});
    owned_impulses_.assign(static_cast<std::size_t>(parts_.particles.exchange().n_owned()), Node{});
  });
  fitted_ = parts_.particles.version();
}

PressureReport ImplicitPressure::apply(double time, const GridUpdate& update, Node* nodes, Node* change) {
  const PhaseTimer timer(parts_.times, Phase::pressure);
  fit();
  number_cells();
  fill_cells();
  parted_.assign(own_.size(), 0);
  fetch_nodes(update, nodes);
  contact_.begin(time, update.dt, free_.data());
  set_diagonal(update.dt);
  PressureReport report;
  // Rough solutions until walls and free surfaces keep their state, then one that is as good as it has to be.
  const PressureSettings& settings = parts_.physics.time_stepping.pressure;
  double tolerance = settings.contact_rounds > 1 ? std::max(rough_tolerance, settings.tolerance) : settings.tolerance;
  for (bool settled = false; !settled;) {
    if (!solve(update.dt, tolerance, report)) {
      report.solved = false;
      return report;
    }
    ++report.n_rounds;
    const bool last = tolerance == settings.tolerance;
    const bool changed = revise(update.dt, !last);
    settled = last && (!changed || report.n_rounds >= settings.contact_rounds);
    if (!changed || report.n_rounds + 1 >= settings.contact_rounds) tolerance = settings.tolerance;
  }
  add_impulses(update, nodes, change);
  return report;
}

// Which cells have particles, here and on the ranks around.
void ImplicitPressure::number_cells() {
  const ParticleSet& particles = parts_.particles.particles();
  const std::vector<LocalIndex>& cell = parts_.particles.map().cell;
  counts_.assign(static_cast<std::size_t>(grid_->n_ids()), 0);
  const std::uint8_t* const material = particles.material();
  for (LocalIndex p = 0; p < particles.size(); ++p)
    if (laws_[material[p]]) ++counts_[static_cast<std::size_t>(cell[static_cast<std::size_t>(p)])];
  exchange_counts(parts_.comm(), *grid_, counts_);

  number_of_.assign(static_cast<std::size_t>(grid_->n_ids()), -1);
  place_of_.assign(static_cast<std::size_t>(grid_->n_own_ids()), -1);
  own_.clear();
  block_of_.clear();
  LocalIndex n = 0;
  for (const LocalIndex id : grid_->order()) {
    if (counts_[static_cast<std::size_t>(id)] == 0) continue;
    if (id < grid_->n_own_ids()) {
      place_of_[static_cast<std::size_t>(id)] = static_cast<LocalIndex>(own_.size());
      own_.push_back(n);
      const LocalIndex place = id % tile_nodes;
      block_of_.push_back(id / tile_nodes * 8 + place / 32 * 4 + place / 8 % 2 * 2 + place / 2 % 2);
    }
    number_of_[static_cast<std::size_t>(id)] = n++;
  }
  halo_.connect(*grid_, number_of_);

  const int s = stencil_width(parts_.physics.grid.order);
  rows_.n_stencil = s * s * s;
  rows_.node.resize(static_cast<std::size_t>(n) * static_cast<std::size_t>(rows_.n_stencil));
  rows_.gradient.resize(rows_.node.size());
  LocalIndex* nodes = rows_.node.data();
  for (const LocalIndex id : grid_->order())
    if (counts_[static_cast<std::size_t>(id)] > 0) {
      grid_->stencil(id, nodes);
      nodes += rows_.n_stencil;
    }
}

void ImplicitPressure::fill_cells() {
  const Physics& physics = parts_.physics;
  const ParticleSet& particles = parts_.particles.particles();
  const auto n = static_cast<std::size_t>(rows_.size());
  group_by_cell(laws_, particles, parts_.particles.map().cell, place_of_, static_cast<LocalIndex>(own_.size()), members_);
  cells_.resize(own_.size());
  for (std::vector<double>* values : {&pressure_, &right_, &residual_, &direction_, &product_, &scaled_, &inverse_diagonal_})
    values->assign(n, 0.0);
  const auto n_blocks = static_cast<std::size_t>(grid_->n_own_ids()) / 8;
  for (std::vector<double>* sums : {&block_volume_, &block_mass_, &block_sum_}) sums->assign(n_blocks, 0.0);
  for (std::size_t k = 0; k < own_.size(); ++k) {
    const auto c = static_cast<std::size_t>(own_[k]);
    PressureCell& cell = cells_[k];
    fill_cell(physics.grid, physics.transfer.gradient, laws_, particles, members_.of(static_cast<LocalIndex>(k)), cell,
              rows_.gradient.data() + c * static_cast<std::size_t>(rows_.n_stencil));
    pressure_[c] = cell.start;
    block_volume_[static_cast<std::size_t>(block_of_[k])] += cell.volume;
    block_mass_[static_cast<std::size_t>(block_of_[k])] += cell.mass;
  }
  halo_.exchange(parts_.comm(), reinterpret_cast<double*>(rows_.gradient.data()), 4 * rows_.n_stencil);
  round_rows(rows_);
}

void ImplicitPressure::fetch_nodes(const GridUpdate& update, const Node* nodes) {
  parts_.particles.exchange().get(nodes, pool_.data());
  for (const CellGrid::Copy& copy : grid_->owned()) free_[static_cast<std::size_t>(copy.node)] = nodes[copy.other];
  for (const CellGrid::Copy& copy : grid_->in_pool())
    free_[static_cast<std::size_t>(copy.node)] = pool_[static_cast<std::size_t>(copy.other)];
  for (const LocalIndex n : grid_->complete_nodes()) {
    const double mass = free_[static_cast<std::size_t>(n)].c[3];
    scale_[static_cast<std::size_t>(n)] = mass > update.smallest_mass ? 1.0 / mass : 0.0;
  }
}

// impulses_ = B^T p of all complete nodes; fetches p of other ranks. `rounded`: with the entries that iterations use.
void ImplicitPressure::gradients_of(std::vector<double>& p, bool rounded) {
  halo_.exchange(parts_.comm(), p.data(), 1);
  std::fill(impulses_.begin(), impulses_.end(), Node{});
  if (rounded)
    add_rounded_gradients(rows_, p, impulses_.data());
  else
    add_gradients(rows_, p, impulses_.data());
}

// Of a block of cells, zeta dt^2 / (rho dx^2): the compliance, per volume, against pressures that differ within it.
double ImplicitPressure::compliance_of_block(LocalIndex own, double dt) const {
  const double dx = parts_.physics.grid.cell_size;
  const auto b = static_cast<std::size_t>(block_of_[static_cast<std::size_t>(own)]);
  return parts_.physics.time_stepping.pressure.stabilisation * dt * dt * block_volume_[b] / (block_mass_[b] * dx * dx);
}

// product_ = (A + dt^2 B P M^-1 P^T B^T + Z) p of this rank's cells.
void ImplicitPressure::multiply(double dt, std::vector<double>& p) {
  gradients_of(p, true);
  contact_.spread(scale_.data(), grid_->complete_nodes(), impulses_.data());
  std::fill(block_sum_.begin(), block_sum_.end(), 0.0);
  for (std::size_t k = 0; k < own_.size(); ++k)
    block_sum_[static_cast<std::size_t>(block_of_[k])] += cells_[k].volume * p[static_cast<std::size_t>(own_[k])];
  for (std::size_t k = 0; k < own_.size(); ++k) {
    const auto c = static_cast<std::size_t>(own_[k]), b = static_cast<std::size_t>(block_of_[k]);
    const double deviation = p[c] - block_sum_[b] / block_volume_[b];
    const double z = compliance_of_block(static_cast<LocalIndex>(k), dt) * cells_[k].volume * deviation;
    product_[c] = (cells_[k].compliance * p[c] + dt * dt * rounded_volume_rate(rows_, own_[k], impulses_.data())) + z;
  }
}

void ImplicitPressure::set_right_side(double dt) {
  held_ = free_;
  contact_.hold(held_.data());
  for (std::size_t k = 0; k < own_.size(); ++k)
    right_[static_cast<std::size_t>(own_[k])] = cells_[k].target + dt * volume_rate(rows_, own_[k], held_.data());
}

// The diagonal with the constraints that are in force at first, but for what images behind walls share with those in front.
void ImplicitPressure::set_diagonal(double dt) {
  NodeVector& scales = held_;
  for (const LocalIndex n : grid_->complete_nodes()) {
    const double s = scale_[static_cast<std::size_t>(n)];
    scales[static_cast<std::size_t>(n)] = {{s, s, s, 0.0}};
  }
  contact_.weaken(scales.data());
  const auto n_stencil = static_cast<std::size_t>(rows_.n_stencil);
  for (std::size_t k = 0; k < own_.size(); ++k) {
    const auto c = static_cast<std::size_t>(own_[k]), b = static_cast<std::size_t>(block_of_[k]);
    double sum = 0.0;
    for (std::size_t a = c * n_stencil; a < (c + 1) * n_stencil; ++a) {
      const double* const B = rows_.gradient[a].c;
      const double* const s = scales[static_cast<std::size_t>(rows_.node[a])].c;
      sum += (s[0] * (B[0] * B[0]) + s[1] * (B[1] * B[1])) + s[2] * (B[2] * B[2]);
    }
    const double z =
        compliance_of_block(static_cast<LocalIndex>(k), dt) * cells_[k].volume * (1.0 - cells_[k].volume / block_volume_[b]);
    inverse_diagonal_[c] = 1.0 / (cells_[k].compliance + dt * dt * sum + z);
  }
}

// m/s: what changes of velocity are compared with.
double ImplicitPressure::speed_scale(double dt) const {
  return parts_.particles.bounds().motion.speed.value + dt * parts_.physics.gravity.norm();
}

bool ImplicitPressure::solve(double dt, double tolerance, PressureReport& report) {
  const PressureSettings& settings = parts_.physics.time_stepping.pressure;
  const Comm& comm = parts_.comm();
  const StepBounds& bounds = parts_.particles.bounds();
  set_right_side(dt);
  const auto precondition = [&](const std::vector<double>& from) {
    for (std::size_t c = 0; c < from.size(); ++c) scaled_[c] = inverse_diagonal_[c] * from[c];
    if (may_part_)
      for (std::size_t k = 0; k < own_.size(); ++k)
        if (parted_[k]) scaled_[static_cast<std::size_t>(own_[k])] = 0.0;
    return reproducible_dot(comm, from, scaled_);
  };
  // Squares of an energy norm, J: below the second, velocities are right to 1e-12 of the fastest.
  const double speed = speed_scale(dt);
  const double rounding = 1e-24 * static_cast<double>(bounds.totals.n_particles) * bounds.sums.mass.value * speed * speed;
  const double goal = std::max(tolerance * tolerance * precondition(right_), rounding);

  for (std::size_t k = 0; k < own_.size(); ++k)
    if (parted_[k]) pressure_[static_cast<std::size_t>(own_[k])] = 0.0;
  multiply(dt, pressure_);
  for (const LocalIndex own : own_) {
    const auto c = static_cast<std::size_t>(own);
    residual_[c] = right_[c] - product_[c];
  }
  double square = precondition(residual_);
  direction_ = scaled_;
  for (int n = 0; square > (n < least_iterations ? rounding : goal); ++n) {
    if (n == settings.max_iterations) return false;
    multiply(dt, direction_);
    for (std::size_t k = 0; k < own_.size(); ++k)
      if (parted_[k]) product_[static_cast<std::size_t>(own_[k])] = 0.0;
    const double curvature = reproducible_dot(comm, direction_, product_);
    if (!(curvature > 0.0)) return false;
    const double length = square / curvature;
    for (const LocalIndex own : own_) {
      const auto c = static_cast<std::size_t>(own);
      pressure_[c] += length * direction_[c];
      residual_[c] -= length * product_[c];
    }
    const double next = precondition(residual_), ratio = next / square;
    for (const LocalIndex own : own_) {
      const auto c = static_cast<std::size_t>(own);
      direction_[c] = scaled_[c] + ratio * direction_[c];
    }
    square = next;
    ++report.n_iterations;
  }
  return std::isfinite(square) && std::isfinite(goal);
}

// Walls that would pull let go, those that would be penetrated hold, and cells that hold no tension part.
bool ImplicitPressure::revise(double dt, bool rounded) {
  const bool parted = may_part_ && revise_parted(dt);
  gradients_of(pressure_, rounded);
  held_ = impulses_;
  contact_.fold(held_.data());
  for (const LocalIndex n : grid_->complete_nodes()) {
    const auto i = static_cast<std::size_t>(n);
    for (int a = 0; a < 3; ++a) held_[i].c[a] = free_[i].c[a] - dt * scale_[i] * held_[i].c[a];
  }
  const bool touched =
      contact_.revise(scale_.data(), held_.data(), parts_.physics.time_stepping.pressure.tolerance * speed_scale(dt));
  return max_global(parts_.comm(), GlobalIndex{parted || touched}) > 0;
}

bool ImplicitPressure::revise_parted(double dt) {
  multiply(dt, pressure_);
  bool changed = false;
  for (std::size_t k = 0; k < own_.size(); ++k) {
    if (!cells_[k].parts) continue;
    const auto c = static_cast<std::size_t>(own_[k]);
    const bool part = parted_[k] ? right_[c] >= product_[c] : pressure_[c] > 0.0;
    changed = changed || part != static_cast<bool>(parted_[k]);
    parted_[k] = part;
  }
  return changed;
}

// After the last `revise`, which has left B^T p in impulses_.
void ImplicitPressure::add_impulses(const GridUpdate& update, Node* nodes, Node* change) {
  for (const CellGrid::Copy& copy : grid_->owned()) {
    const double* const gradient = impulses_[static_cast<std::size_t>(copy.node)].c;
    owned_impulses_[static_cast<std::size_t>(copy.other)] = {
        {-update.dt * gradient[0], -update.dt * gradient[1], -update.dt * gradient[2], 0.0}};
  }
  Node* const impulses = owned_impulses_.data();
  parts_.contact.fold_later(impulses);
  const std::span<const LocalIndex> active = parts_.particles.exchange().active_nodes();
  parts_.budget.later_kick(update, active, nodes, impulses);
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
  const VolumeUpdate update{parts_.physics.time_stepping.pressure.relaxation, before_.data()};
  for (std::size_t k = 0; k < own_.size(); ++k)
    bulkley::update_volumes(laws_, update, members_.of(static_cast<LocalIndex>(k)),
                            pressure_[static_cast<std::size_t>(own_[k])], parted_[k], particles);
  const double* const J = particles.real(Field::volume_ratio);
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
  const std::size_t n_values =
      pressure_.capacity() * 7 + block_volume_.capacity() * 3 + scale_.capacity() + before_.capacity();
  const std::size_t n_nodes =
      free_.capacity() * 3 + pool_.capacity() + owned_impulses_.capacity() + rows_.gradient.capacity();
  const std::size_t n_indices = number_of_.capacity() + counts_.capacity() + own_.capacity() + place_of_.capacity() +
                                members_.first.capacity() + members_.particle.capacity() + rows_.node.capacity() +
                                block_of_.capacity();
  return n_values * sizeof(double) + n_nodes * sizeof(Node) + n_indices * sizeof(LocalIndex) +
         cells_.capacity() * sizeof(PressureCell) + contact_.memory() + (grid_ ? grid_->memory() : 0);
}

}  // namespace bulkley
