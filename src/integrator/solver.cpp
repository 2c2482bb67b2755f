#include "integrator/solver.hpp"

#include <algorithm>
#include <cmath>

#include "integrator/describe_failure.hpp"
#include "kernel/g2p.hpp"
#include "kernel/p2g.hpp"
#include "kernel/stress_update.hpp"

namespace bulkley {

namespace {

// Particles drift out of cell order slowly. A physical sort costs about as much as the nodes of another tile for every
// particle, so it pays off once that many jumps from tile to tile have been made since the last one. It never changes a
// result.
constexpr GlobalIndex jumps_per_sort = 8;  // per particle

// Particles are advanced in blocks whose columns stay in the second-level cache from one kernel to the next.
constexpr LocalIndex block_size = 1024;

// A node with less than this part of the largest possible nodal mass counts as empty: there the rounding of the order-free
// sums nears the velocity itself. No larger than that, for what an empty node received is lost to the particles.
constexpr double empty_mass = 0x1p-48;

// Direct access to a Vec's local values as nodes, given back at the end of the scope.
class NodeAccess {
 public:
  explicit NodeAccess(const VecHandle& vec) : vec_(vec.get()) {
    PetscScalar* values = nullptr;
    BULKLEY_PETSC(VecGetArray(vec_, &values));
    values_ = values;
  }
  ~NodeAccess() { BULKLEY_PETSC(VecRestoreArray(vec_, &values_)); }
  NodeAccess(const NodeAccess&) = delete;
  NodeAccess& operator=(const NodeAccess&) = delete;
  Node* get() const { return reinterpret_cast<Node*>(values_); }

 private:
  Vec vec_;
  PetscScalar* values_ = nullptr;
};

}  // namespace

Solver::Solver(const Comm& comm, Physics physics, Partition partition, ParticleSet particles,
               std::optional<StepBounds> bounds)
    : comm_(comm),
      physics_(std::move(physics)),
      partition_(std::move(partition)),
      particles_(std::move(particles)),
      reduce_(comm),
      trial_impulses_(no_contact_impulses(physics_)),
      contact_impulses_(trial_impulses_),
      material_seconds_(physics_.materials.size(), 0.0) {
  if (physics_.acceleration_field.given()) acceleration_.emplace(physics_.acceleration_field);
  StepBounds local;
  start_placing();
  place({}, local);
  settle(local);
  if (bounds_.failed()) report_failure();
  if (bounds)
    bounds_ = *bounds;
  else
    measure_start();
}

Solver::~Solver() = default;

ContactImpulses no_contact_impulses(const Physics& physics) {
  const GridGeometry& grid = physics.grid;
  double density = 1e-300;  // a run without materials has nothing to sum
  for (const NamedMaterial& named : physics.materials)
    density = std::max(density, std::visit([](const auto& law) { return law.density(); }, named.material));
  return {physics.colliders.size(), density * grid.cell_size * grid.cell_size * grid.cell_size,
          (grid.upper() - grid.lower).maxCoeff()};
}

ContactImpulses Solver::contact_impulses() const {
  // Halves of 32 bits, so that sums over ranks cannot overflow; then the carries.
  constexpr std::int64_t low_half = 0xffffffff;
  std::vector<std::int64_t> words = contact_impulses_.words();
  std::vector<std::int64_t> halves;
  for (std::size_t w = 0; w < words.size(); ++w) {
    halves.push_back(words[w] & low_half);
    // The topmost half carries the sign; the others are parts of a sum without one.
    halves.push_back(w % 2 == 1 ? words[w] >> 32 : (words[w] >> 32) & low_half);
  }
  BULKLEY_MPI(
      MPI_Allreduce(MPI_IN_PLACE, halves.data(), static_cast<int>(halves.size()), MPI_INT64_T, MPI_SUM, comm_.get()));
  for (std::size_t h = 0; h < halves.size(); h += 4) {
    for (std::size_t k = h; k < h + 3; ++k) {
      halves[k + 1] += halves[k] >> 32;
      halves[k] &= low_half;
    }
    words[h / 2] = static_cast<std::int64_t>(static_cast<std::uint64_t>(halves[h + 1]) << 32) | halves[h];
    words[h / 2 + 1] = static_cast<std::int64_t>(static_cast<std::uint64_t>(halves[h + 3]) << 32) | halves[h + 2];
  }
  ContactImpulses total = contact_impulses_;
  total.set_words(words);
  return total;
}

void Solver::set_contact_impulses(const ContactImpulses& sums) {
  contact_impulses_.clear();
  if (comm_.is_root()) contact_impulses_.add(sums);
}

StepReport Solver::step(double remaining, int stop_request, TimeStepState& state, double time) {
  try {
    return take_step(remaining, stop_request, state, time);
  } catch (const NoStep& reason) {  // alike on every rank
    throw_failure(comm_, particles_, physics_.materials, reason);
  }
}

StepReport Solver::take_step(double remaining, int stop_request, TimeStepState& state, double time) {
  StepReport report;
  StepBounds local;
  // A collider as fast as the material may move as far: until the end of the longest step that the material allows.
  bounds_.collider_speed = 0.0;
  const double longest = std::min(remaining, time_step_limit(physics_.time_stepping, physics_.grid.cell_size, bounds_).dt);
  bounds_.collider_speed = collider_speed(physics_.grid, physics_.colliders, time, time + longest);
  for (;;) {
    report.plan = plan_step(physics_.time_stepping, physics_.grid.cell_size, bounds_, remaining, state);
    local = {};
    transfer_to_grid(report.plan.dt, time, local);
    if (!report.plan.checked) break;
    const StepBounds motion = motion_of_trial(local);
    if (is_acceptable(physics_.time_stepping, physics_.grid.cell_size, report.plan, motion)) break;
    reject_step(physics_.time_stepping, report.plan, motion, state);
    ++report.n_rejected;
  }
  contact_impulses_.add(trial_impulses_);
  local.stop_request = stop_request;
  transfer_to_particles(report.plan.dt, local);
  settle(local);
  if (bounds_.failed()) report_failure();
  check_motion(comm_, physics_.time_stepping, physics_.grid.cell_size, report.plan.dt, particles_, bounds_);
  accept_step(physics_.time_stepping, report.plan, bounds_, state);
  report.bounds = bounds_;
  return report;
}

// Particles -> nodes' velocity in every pool. Changes no particle.
void Solver::transfer_to_grid(double dt, double time, StepBounds& faults) {
  const bool split = physics_.transfer.flip_fraction() > 0.0;
  const SumBounds sums = sum_bounds(physics_.grid, physics_.transfer, bounds_, dt);
  {
    const Phase phase(times_, "p2g");
    p2g(physics_.grid, physics_.transfer, layout_, particles_, map_, sums, dt, pool_.data(),
        split ? impulse_.data() : nullptr);
  }
  Node* const owned = owned_.data();
  Node* const impulse = split ? owned_impulse_.data() : nullptr;
  {
    const Phase phase(times_, "exchange");
    exchange_->add(pool_.data(), owned);
    if (split) exchange_->add(impulse_.data(), impulse);
  }
  {
    const Phase phase(times_, "grid_update");
    const GridUpdate update{physics_.gravity, dt, empty_mass * sums.mass};
    if (acceleration_ && dt > 0.0) accelerate(update, time, owned, impulse, faults);
    fold_images(update, images_, owned, impulse);
    grid_update(update, exchange_->active_nodes(), owned, impulse);
    trial_impulses_.clear();
    apply_constraints(constraints_, owned, impulse, trial_impulses_);
    if (moving_constraints_) apply_constraints(moving_constraints_->at(time, dt), owned, impulse, trial_impulses_);
    unfold_images(images_, owned, impulse);
  }
  {
    const Phase phase(times_, "exchange");
    exchange_->get(owned, pool_.data());
    if (split) exchange_->get(impulse, impulse_.data());
  }
}

// Adds the forces of the acceleration field, times dt, to the nodes that have mass. Each node has one owner, who evaluates
// it.
void Solver::accelerate(const GridUpdate& update, double time, Node* nodes, Node* impulse, StepBounds& faults) {
  const GridGeometry& geometry = physics_.grid;
  const auto active = exchange_->active_nodes();
  for (std::size_t a = 0; a < active.size(); ++a) {
    const LocalIndex n = active[a];
    const double mass = nodes[n].c[3];
    if (!(mass > update.smallest_mass)) continue;
    const Int3& node = active_positions_[a];
    const Vec3 gain = (mass * update.dt) * (*acceleration_)(geometry.node_position(node), time);
    for (int axis = 0; axis < 3; ++axis) (impulse ? impulse : nodes)[n].c[axis] += gain[axis];
    if (gain.allFinite()) continue;
    ++faults.n_undefined_nodes;
    faults.undefined_node = std::min(faults.undefined_node, geometry.node_number(node));
  }
}

// The motion that the nodes would give the particles. One more all-reduce, on judged steps only.
StepBounds Solver::motion_of_trial(const StepBounds& faults) {
  const Phase phase(times_, "judge");
  StepBounds motion = faults;
  measure_motion(physics_.grid, physics_.transfer, layout_, map_, pool_.data(), particles_, motion);
  motion = reduce_(motion);
  if (motion.failed()) {  // no smaller step would mend it
    bounds_ = motion;
    report_failure();
  }
  return motion;
}

// Nodes -> particles, their stress, and their new cells.
void Solver::transfer_to_particles(double dt, StepBounds& local) {
  const Field gradient = physics_.transfer.needs_velocity_gradient() ? Field::velocity_gradient : Field::affine_velocity;
  const Node* change = impulse_.empty() ? nullptr : impulse_.data();
  StepBounds outside;
  start_placing();
  for (LocalIndex first = 0; first < particles_.size(); first += block_size) {
    const ParticleBlock block{first, first + block_size};
    {
      const Phase phase(times_, "g2p");
      g2p(physics_.grid, physics_.transfer, layout_, map_, dt, pool_.data(), change, particles_, local, block);
    }
    {
      const Phase phase(times_, "stress_update");
      double begin = MPI_Wtime();
      for (std::size_t m = 0; m < physics_.materials.size(); ++m) {
        stress_update(physics_.materials[m].material, static_cast<std::uint8_t>(m), gradient, dt, particles_, local, block);
        const double end = MPI_Wtime();
        material_seconds_[m] += end - begin;
        begin = end;
      }
    }
    place(block, outside);
  }
  // A position is not finite because the velocity was not: such a particle has been counted already.
  outside.n_not_finite = std::max<GlobalIndex>(0, outside.n_not_finite - local.n_not_finite);
  local.merge(outside);
}

void Solver::start_placing() {
  removed_.clear();
  strays_.clear();
  map_.reset(layout_, particles_.size());
}

// Positions -> domain and cells. After a failure cells are undefined; the all-reduce will stop every rank.
void Solver::place(ParticleBlock block, StepBounds& outside) {
  const Phase phase(times_, "locate");
  confine(physics_.grid, physics_.faces, particles_, removed_, outside, block);
  if (!outside.failed()) locate(physics_.grid, layout_, particles_, map_, strays_, block);
}

// Brings every particle that has been placed to the rank that works on its tile, and merges what the ranks have learned.
void Solver::settle(StepBounds& local) {
  local.n_removed = static_cast<GlobalIndex>(removed_.size());
  if (!removed_.empty() && !local.failed()) {
    particles_.remove(removed_);
    start_placing();
    place({}, local);
  }
  send_strays(local);
  n_jumps_ += map_.n_jumps;
  local.needs_sort = n_jumps_ > jumps_per_sort * particles_.size();
  local.cell_count = map_.largest_count();
  local.n_particles = local.largest_share = particles_.size();
  {
    const Phase phase(times_, "reduce");
    bounds_ = reduce_(local);
  }
  if (bounds_.failed()) return;
  if (bounds_.needs_rebuild || !exchange_) rebuild();
  if (bounds_.needs_sort) {
    const Phase phase(times_, "sort");
    sort_particles(particles_, map_);
    n_jumps_ = 0;
  }
}

// Sends particles of other ranks' tiles there, takes in theirs, and notes whether the pool lacks a tile of this rank.
void Solver::send_strays(StepBounds& local) {
  const Phase phase(times_, "migrate");
  departures_.clear();
  departed_.clear();
  if (!local.failed())
    for (const Stray& stray : strays_) {
      const std::int32_t worker = partition_.worker[static_cast<std::size_t>(stray.tile)];
      if (worker == comm_.rank()) {
        local.needs_rebuild = 1;
      } else {
        departures_.push_back({stray.particle, worker});
        departed_.push_back(stray.particle);
      }
    }
  const LocalIndex n_before = particles_.size();
  const LocalIndex n_arrived = migrate(comm_, departures_, particles_);
  local.n_migrated = n_arrived;
  if (local.failed() || (n_arrived == 0 && departures_.empty())) return;
  // Strays are not counted in any cell, so what is left to do is to follow the particles' moves and to count the arrivals.
  fill_gaps<LocalIndex>(departed_, n_before, [&](LocalIndex to, LocalIndex from) { map_.cell[to] = map_.cell[from]; });
  map_.resize(particles_.size());
  strays_.clear();
  locate(physics_.grid, layout_, particles_, map_, strays_, {particles_.size() - n_arrived, particles_.size()});
  if (!strays_.empty()) local.needs_rebuild = 1;
}

GlobalIndex Solver::adopt(Partition partition) {
  if (!(partition.boxes == partition_.boxes)) grid_.reset();
  partition_ = std::move(partition);
  LocalIndex n_arrived = 0;
  {
    const Phase phase(times_, "migrate");
    departures_.clear();
    for (LocalIndex p = 0; p < particles_.size(); ++p) {
      const TileIndex tile = layout_.tiles()[static_cast<std::size_t>(map_.cell[static_cast<std::size_t>(p)]) / tile_nodes];
      const std::int32_t worker = partition_.worker[static_cast<std::size_t>(tile)];
      if (worker != comm_.rank()) departures_.push_back({p, worker});
    }
    n_arrived = migrate(comm_, departures_, particles_);
  }
  rebuild();
  n_jumps_ += map_.n_jumps;
  bounds_.largest_share = max_global(comm_, GlobalIndex{particles_.size()});
  return sum_global(comm_, GlobalIndex{n_arrived});
}

// A new pool for the tiles that hold particles now or may soon, and the exchange and constraints that belong to it.
void Solver::rebuild() {
  const Phase phase(times_, "rebuild");
  ++n_rebuilds_;
  const GridGeometry& geometry = physics_.grid;
  std::vector<TileIndex> tiles = tiles_in_reach(geometry, census());
  std::erase_if(tiles, [&](TileIndex tile) { return partition_.worker[static_cast<std::size_t>(tile)] != comm_.rank(); });
  collective_guard(comm_, [&] { layout_ = PoolLayout(geometry, std::move(tiles)); });
  if (exchange_) exchange_wait_ += exchange_->seconds_waiting();
  exchange_ = std::make_unique<Exchange>(comm_, geometry, partition_.worker, layout_);
  owned_.assign(static_cast<std::size_t>(exchange_->n_owned()), Node{});
  pool_.assign(static_cast<std::size_t>(layout_.n_nodes()), Node{});
  if (physics_.transfer.flip_fraction() > 0.0) {
    impulse_.assign(static_cast<std::size_t>(layout_.n_nodes()), Node{});
    owned_impulse_.assign(owned_.size(), Node{});
  }

  const auto active = exchange_->active_nodes();
  std::vector<Int3> nodes = exchange_->active_positions();
  constraints_ = node_constraints(geometry, physics_.faces, physics_.colliders, nodes);
  const auto moves = [](const Collider& collider) { return collider.motion.moves(); };
  if (std::any_of(physics_.colliders.begin(), physics_.colliders.end(), moves))
    moving_constraints_.emplace(geometry, physics_.colliders, nodes, std::vector(active.begin(), active.end()),
                                constraints_);
  for (NodeConstraint& constraint : constraints_) constraint.node = active[static_cast<std::size_t>(constraint.node)];
  images_ = node_images(geometry, physics_.faces, nodes);
  for (NodeImage& image : images_) {
    image.behind = active[static_cast<std::size_t>(image.behind)];
    image.front = active[static_cast<std::size_t>(image.front)];
  }
  if (acceleration_) active_positions_ = std::move(nodes);

  start_placing();
  locate(geometry, layout_, particles_, map_, strays_);
  BULKLEY_ASSERT(strays_.empty());
  bounds_.cell_count = max_global(comm_, GlobalIndex{map_.largest_count()});
}

namespace {

// Wave speed, viscosity and stress bounds of particles as they are, without a step.
void measure_state(const std::vector<NamedMaterial>& materials, const ParticleSet& particles, StepBounds& bounds) {
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    SymTensor<double> stress;
    for (int c = 0; c < 6; ++c) stress.c[c] = particles.real(Field::kirchhoff_stress, c)[p];
    const double J = particles.real(Field::volume_ratio)[p];
    const GlobalIndex id = particles.id()[p];
    std::visit(
        [&](const auto& law) {
          bounds.wave_speed.include(std::sqrt(law.wave_speed_squared(particle_state(law, particles, p))), id);
          if (law.viscosity() > 0.0) bounds.viscosity.include(J * law.viscosity() / law.density(), id);
        },
        materials[particles.material()[p]].material);
    bounds.stress_volume =
        std::max(bounds.stress_volume, particles.real(Field::reference_volume)[p] * std::sqrt(norm_squared(stress)));
    bounds.smallest_volume_ratio = std::min(bounds.smallest_volume_ratio, J);
    bounds.largest_volume_ratio = std::max(bounds.largest_volume_ratio, J);
  }
}

}  // namespace

// The bounds that the first step needs, from the particles as they were seeded.
void Solver::measure_start() {
  StepBounds local;
  measure_particles(physics_.grid, physics_.transfer, particles_, local);
  measure_state(physics_.materials, particles_, local);
  local.cell_count = bounds_.cell_count;
  local.n_particles = local.largest_share = particles_.size();
  bounds_ = reduce_(local);
}

VecHandle Solver::node_values(double time) {
  BULKLEY_ASSERT(partition_.boxes);
  if (!grid_) grid_.emplace(comm_, physics_.grid, *partition_.boxes);
  StepBounds none;
  transfer_to_grid(0.0, time, none);
  VecHandle copy = grid_->create_vector();
  const NodeAccess to(copy);
  exchange_->store(comm_, owned_.data(), *grid_, to.get());
  return copy;
}

void Solver::report_failure() const { throw_failure(comm_, physics_.grid, particles_, physics_.materials, bounds_); }

GlobalIndex Solver::halo_bytes() const {
  const std::size_t once = exchange_->sent_by_add().bytes + exchange_->sent_by_get().bytes;
  return physics_.transfer.n_exchanges() * static_cast<GlobalIndex>(once);
}

std::size_t Solver::memory() const {
  std::size_t total = particles_.memory() + layout_.memory();
  total += (pool_.capacity() + impulse_.capacity() + owned_.capacity() + owned_impulse_.capacity()) * sizeof(Node);
  total += (map_.cell.capacity() + map_.count.capacity()) * sizeof(LocalIndex);
  total += images_.capacity() * sizeof(NodeImage);
  if (moving_constraints_) total += moving_constraints_->memory();
  total += constraints_.capacity() * sizeof(NodeConstraint) + partition_.worker.capacity() * sizeof(std::int32_t);
  return total;
}

}  // namespace bulkley
