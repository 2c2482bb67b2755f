#include "bulkley/solver/solver.hpp"

#include <algorithm>
#include <cmath>

#include "bulkley/kernel/g2p.hpp"
#include "bulkley/kernel/p2g.hpp"
#include "bulkley/kernel/stress_update.hpp"
#include "failure.hpp"

namespace bulkley {

namespace {

// Particles drift out of cell order slowly; a physical sort pays off every few steps. It never changes a result.
constexpr GlobalIndex sort_interval = 8;

// A node with less than this part of the largest possible nodal mass counts as empty: there the rounding of the order-free
// sums nears the velocity itself. No larger than that, for what an empty node received is lost to the particles.
constexpr double empty_mass = 0x1p-48;

// Direct access to a Vec's local values as nodes, given back at the end of the scope.
class NodeAccess {
 public:
  explicit NodeAccess(const VecHandle& vec) : vec_(vec.get()) {
    if (!vec_) return;
    PetscScalar* values = nullptr;
    BULKLEY_PETSC(VecGetArray(vec_, &values));
    values_ = values;
  }
  ~NodeAccess() {
    if (vec_) BULKLEY_PETSC(VecRestoreArray(vec_, &values_));
  }
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
      grid_(comm, physics_.grid, partition_),
      owned_(grid_.create_vector()) {
  if (physics_.transfer.flip_fraction() > 0.0) owned_impulse_ = grid_.create_vector();
  StepBounds local;
  settle(local);
  if (bounds_.failed()) report_failure();
  if (bounds)
    bounds_ = *bounds;
  else
    measure_start();
}

Solver::~Solver() = default;

StepReport Solver::step(double remaining, int stop_request, TimeStepState& state) {
  StepReport report;
  for (;;) {
    report.plan = plan_step(physics_.time, physics_.grid.cell_size, bounds_, remaining, state);
    transfer_to_grid(report.plan.dt);
    if (!report.plan.checked || judge(report.plan)) break;
    reject_step(physics_.time, report.plan, state);
    ++report.n_rejected;
  }
  StepBounds local;
  local.stop_request = stop_request;
  transfer_to_particles(report.plan.dt, local);
  settle(local);
  if (bounds_.failed()) report_failure();
  accept_step(physics_.time, report.plan, bounds_, state);
  report.bounds = bounds_;
  return report;
}

// Particles -> nodes' velocity in every pool. Changes no particle.
void Solver::transfer_to_grid(double dt) {
  const bool split = physics_.transfer.flip_fraction() > 0.0;
  const SumBounds sums = sum_bounds(physics_.grid, physics_.transfer, bounds_, dt);
  {
    const Phase phase(times_, "p2g");
    p2g(physics_.grid, physics_.transfer, layout_, particles_, map_, sums, dt, pool_.data(),
        split ? impulse_.data() : nullptr);
  }
  const NodeAccess owned(owned_), impulse(owned_impulse_);
  {
    const Phase phase(times_, "exchange");
    exchange_->add(pool_.data(), owned.get());
    if (split) exchange_->add(impulse_.data(), impulse.get());
  }
  {
    const Phase phase(times_, "grid_update");
    grid_update({physics_.gravity, dt, empty_mass * sums.mass}, exchange_->active_nodes(), owned.get(), impulse.get());
    apply_constraints(constraints_, owned.get(), impulse.get());
  }
  {
    const Phase phase(times_, "exchange");
    exchange_->get(owned.get(), pool_.data());
    if (split) exchange_->get(impulse.get(), impulse_.data());
  }
}

// Whether the motion that the nodes would give the particles is acceptable. One more all-reduce, on judged steps only.
bool Solver::judge(const TimeStepPlan& plan) {
  const Phase phase(times_, "judge");
  StepBounds motion;
  measure_motion(physics_.grid, physics_.transfer, layout_, map_, pool_.data(), particles_, motion);
  motion = reduce_(motion);
  if (motion.failed()) {  // no smaller step would mend it
    bounds_ = motion;
    report_failure();
  }
  return is_acceptable(physics_.time, physics_.grid.cell_size, plan, motion);
}

void Solver::transfer_to_particles(double dt, StepBounds& local) {
  {
    const Phase phase(times_, "g2p");
    g2p(physics_.grid, physics_.transfer, layout_, map_, dt, pool_.data(), impulse_.empty() ? nullptr : impulse_.data(),
        particles_, local);
  }
  const Phase phase(times_, "stress_update");
  const Field gradient = physics_.transfer.needs_velocity_gradient() ? Field::velocity_gradient : Field::affine_velocity;
  for (std::size_t m = 0; m < physics_.materials.size(); ++m)
    stress_update(physics_.materials[m].material, static_cast<std::uint8_t>(m), gradient, dt, particles_, local);
}

// Brings every particle into its cell on the rank that works on its tile, and merges what the ranks have learned.
void Solver::settle(StepBounds& local) {
  {
    const Phase phase(times_, "locate");
    departures_.clear();
    local.needs_rebuild = settle_locally(local, departures_);
  }
  {
    const Phase phase(times_, "migrate");
    const LocalIndex arrived = migrate(comm_, departures_, particles_);
    local.n_migrated = arrived;
    if (arrived > 0 || !departures_.empty()) {
      departures_.clear();
      local.cell_count = 0;
      strays_.clear();
      if (!local.failed()) locate(physics_.grid, layout_, particles_, map_, strays_, local);
      if (!strays_.empty()) local.needs_rebuild = 1;
    }
  }
  local.n_particles = local.largest_share = particles_.size();
  {
    const Phase phase(times_, "reduce");
    bounds_ = reduce_(local);
  }
  if (bounds_.failed()) return;
  if (bounds_.needs_rebuild || !exchange_) rebuild();
  if (++steps_since_sort_ >= sort_interval) {
    const Phase phase(times_, "sort");
    sort_particles(particles_, map_);
    steps_since_sort_ = 0;
  }
}

// Positions -> domain and cells; particles of other ranks' tiles become departures. Returns whether the pool lacks a tile.
bool Solver::settle_locally(StepBounds& local, std::vector<Departure>& departures) {
  removed_.clear();
  StepBounds outside;
  confine(physics_.grid, physics_.faces, particles_, removed_, outside);
  // A position is not finite because the velocity was not: such a particle has been counted already.
  outside.n_not_finite = std::max<GlobalIndex>(0, outside.n_not_finite - local.n_not_finite);
  local.merge(outside);
  if (local.failed()) return false;  // cells are undefined; the all-reduce will stop every rank
  if (!removed_.empty()) particles_.remove(removed_);
  local.n_removed = static_cast<GlobalIndex>(removed_.size());

  strays_.clear();
  locate(physics_.grid, layout_, particles_, map_, strays_, local);
  bool lacks_tile = false;
  for (const Stray& stray : strays_) {
    const std::int32_t worker = partition_.worker[static_cast<std::size_t>(stray.tile)];
    if (worker == comm_.rank())
      lacks_tile = true;
    else
      departures.push_back({stray.particle, worker});
  }
  return lacks_tile;
}

namespace {

void sort_unique(std::vector<TileIndex>& tiles) {
  std::sort(tiles.begin(), tiles.end());
  tiles.erase(std::unique(tiles.begin(), tiles.end()), tiles.end());
}

// The tiles of this rank that hold particles, with a margin: those that a particle may enter by moving one cell.
std::vector<TileIndex> tiles_in_reach(const GridGeometry& geometry, const ParticleSet& particles,
                                      std::span<const std::int32_t> worker, int rank) {
  std::vector<TileIndex> tiles;
  Int3 last{-1, -1, -1};
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    const Vec3 x = particles.vector(Field::position, p);
    Int3 base, from, to;
    for (int a = 0; a < 3; ++a) base[a] = geometry.base_node(a, x[a]);
    if (base == last) continue;
    last = base;
    for (int a = 0; a < 3; ++a) {  // another tile can be reached only from a cell at the tile's edge
      from[a] = base[a] % tile_width == 0 ? base[a] - 1 : base[a];
      to[a] = base[a] % tile_width == tile_width - 1 ? base[a] + 1 : base[a];
    }
    Int3 node;
    auto place = [&](int axis, int index) {  // false beyond the grid
      const int n = geometry.n_nodes(axis);
      node[axis] = geometry.periodic[axis] ? (index + n) % n : index;
      return node[axis] >= 0 && node[axis] < n;
    };
    for (int i = from[0]; i <= to[0]; ++i)
      for (int j = from[1]; j <= to[1]; ++j)
        for (int k = from[2]; k <= to[2]; ++k) {
          if (!place(0, i) || !place(1, j) || !place(2, k)) continue;
          const TileIndex tile = geometry.tile_of_node(node);
          if (worker[static_cast<std::size_t>(tile)] == rank && (tiles.empty() || tiles.back() != tile))
            tiles.push_back(tile);
        }
    if (tiles.size() > (1u << 20)) sort_unique(tiles);  // bounds the memory of an unsorted particle set
  }
  sort_unique(tiles);
  return tiles;
}

}  // namespace

// A new pool for the tiles that hold particles now or may soon, and the exchange and constraints that belong to it.
void Solver::rebuild() {
  const Phase phase(times_, "rebuild");
  ++n_rebuilds_;
  const GridGeometry& geometry = physics_.grid;
  std::vector<TileIndex> tiles = tiles_in_reach(geometry, particles_, partition_.worker, comm_.rank());
  collective_guard(comm_, [&] { layout_ = PoolLayout(geometry, std::move(tiles)); });
  exchange_ = std::make_unique<Exchange>(comm_, grid_, layout_);
  pool_.assign(static_cast<std::size_t>(layout_.n_nodes()), Node{});
  if (physics_.transfer.flip_fraction() > 0.0) impulse_.assign(static_cast<std::size_t>(layout_.n_nodes()), Node{});

  const auto active = exchange_->active_nodes();
  std::vector<Int3> nodes(active.size());
  for (std::size_t n = 0; n < active.size(); ++n) nodes[n] = grid_.node(active[n]);
  constraints_ = node_constraints(geometry, physics_.faces, physics_.colliders, nodes);
  for (NodeConstraint& constraint : constraints_) constraint.node = active[static_cast<std::size_t>(constraint.node)];

  StepBounds count;
  strays_.clear();
  locate(geometry, layout_, particles_, map_, strays_, count);
  BULKLEY_ASSERT(strays_.empty());
  bounds_.cell_count = max_global(comm_, count.cell_count);
  steps_since_sort_ = sort_interval;
}

namespace {

// Wave speed and stress bounds of particles as they are, without a step.
void measure_state(const std::vector<NamedMaterial>& materials, const ParticleSet& particles, StepBounds& bounds) {
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    State<double> state;
    SymTensor<double> stress;
    for (int c = 0; c < 6; ++c) {
      state.left_cauchy_green.c[c] = particles.real(Field::left_cauchy_green, c)[p];
      stress.c[c] = particles.real(Field::kirchhoff_stress, c)[p];
    }
    state.volume_ratio = particles.real(Field::volume_ratio)[p];
    const double speed = std::visit([&](const auto& law) { return std::sqrt(law.wave_speed_squared(state)); },
                                    materials[particles.material()[p]].material);
    bounds.wave_speed.include(speed, particles.id()[p]);
    bounds.stress_volume =
        std::max(bounds.stress_volume, particles.real(Field::reference_volume)[p] * std::sqrt(norm_squared(stress)));
    bounds.smallest_volume_ratio = std::min(bounds.smallest_volume_ratio, state.volume_ratio);
    bounds.largest_volume_ratio = std::max(bounds.largest_volume_ratio, state.volume_ratio);
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

VecHandle Solver::node_values() {
  transfer_to_grid(0.0);
  VecHandle copy = grid_.create_vector();
  const NodeAccess from(owned_), to(copy);
  for (const LocalIndex n : exchange_->active_nodes()) to.get()[n] = from.get()[n];
  return copy;
}

void Solver::report_failure() const { throw RunError(describe_failure(comm_, particles_, physics_.materials, bounds_)); }

std::size_t Solver::memory() const {
  std::size_t total = particles_.memory() + layout_.memory();
  total += (pool_.capacity() + impulse_.capacity()) * sizeof(Node);
  total += static_cast<std::size_t>(grid_.n_owned()) * sizeof(Node) * (owned_impulse_ ? 2 : 1);
  total += (map_.cell.capacity() + map_.count.capacity()) * sizeof(LocalIndex);
  total += constraints_.capacity() * sizeof(NodeConstraint) + partition_.worker.capacity() * sizeof(std::int32_t);
  return total;
}

}  // namespace bulkley
