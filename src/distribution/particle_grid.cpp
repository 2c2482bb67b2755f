#include "distribution/particle_grid.hpp"

#include <algorithm>

namespace bulkley {

namespace {

// Particles drift out of cell order slowly. A physical sort costs about as much as the nodes of another tile for every
// particle, so it pays off once that many jumps from tile to tile have been made since the last one. It never changes a
// result.
constexpr GlobalIndex jumps_per_sort = 8;  // per particle

}  // namespace

ParticleGrid::ParticleGrid(const Comm& comm, const GridGeometry& grid, const Faces& faces, int n_materials,
                           Partition partition, ParticleSet particles, PhaseTimes& times)
    : comm_(comm),
      grid_(grid),
      faces_(faces),
      n_materials_(n_materials),
      partition_(std::move(partition)),
      particles_(std::move(particles)),
      times_(times),
      reduce_(comm) {
  begin_move();
  place({});
  finish_move({});
}

void ParticleGrid::begin_move() {
  outside_ = {};
  removed_.clear();
  dropped_.clear();
  leavers_.clear();
  map_.reset(layout_, particles_.size());
}

void ParticleGrid::place(ParticleBlock block) {
  const PhaseTimer timer(times_, Phase::locate);
  confine(grid_, faces_, particles_, removed_, outside_, block);
  if (!outside_.failed()) locate(grid_, layout_, particles_, map_, leavers_, block);
}

void ParticleGrid::place_added(LocalIndex first) {
  map_.resize(particles_.size());
  place({first, particles_.size()});
}

const StepBounds& ParticleGrid::finish_move(StepBounds local) {
  // A position is not finite because the velocity was not: such a particle has been counted already.
  Total& not_finite = outside_.failures.n_not_finite;
  not_finite.value = std::max<GlobalIndex>(0, not_finite - local.failures.n_not_finite);
  local.merge(outside_);
  local.transport.n_removed.value = static_cast<GlobalIndex>(removed_.size());
  removed_.insert(removed_.end(), dropped_.begin(), dropped_.end());
  if (!removed_.empty() && !local.failed()) {
    std::sort(removed_.begin(), removed_.end());
    removed_.erase(std::unique(removed_.begin(), removed_.end()), removed_.end());
    particles_.remove(removed_);
    begin_move();
    place({});
  }
  migrate_leavers(local);
  n_jumps_ += map_.n_jumps;
  local.requests.sort.include(n_jumps_ > jumps_per_sort * particles_.size());
  local.sums.cell_count.value = map_.largest_count();
  local.totals.n_particles.value = particles_.size();
  local.transport.largest_share.value = particles_.size();
  {
    const PhaseTimer timer(times_, Phase::reduce);
    bounds_ = reduce_(local);
  }
  if (bounds_.failed()) return bounds_;
  if (bounds_.requests.rebuild || !exchange_) rebuild();
  if (bounds_.requests.sort) {
    const PhaseTimer timer(times_, Phase::sort);
    sort_particles(particles_, map_);
    n_jumps_ = 0;
  }
  return bounds_;
}

// Sends particles of other ranks' tiles there, takes in theirs, and notes whether the pool lacks a tile of this rank.
void ParticleGrid::migrate_leavers(StepBounds& local) {
  const PhaseTimer timer(times_, Phase::migrate);
  departures_.clear();
  departed_.clear();
  if (!local.failed())
    for (const OutsideParticle& leaver : leavers_) {
      const std::int32_t owner = partition_.map.owner(leaver.tile);
      if (owner == comm_.rank()) {
        local.requests.rebuild.include(1);
      } else {
        departures_.push_back({leaver.particle, owner});
        departed_.push_back(leaver.particle);
      }
    }
  const LocalIndex n_before = particles_.size();
  const LocalIndex n_arrived = migrate(comm_, departures_, particles_);
  local.transport.n_migrated.value = n_arrived;
  if (local.failed() || (n_arrived == 0 && departures_.empty())) return;
  // Leavers are not counted in any cell, so what is left to do is to follow the particles' moves and to count the arrivals.
  fill_gaps<LocalIndex>(departed_, n_before, [&](LocalIndex to, LocalIndex from) { map_.cell[to] = map_.cell[from]; });
  map_.resize(particles_.size());
  leavers_.clear();
  locate(grid_, layout_, particles_, map_, leavers_, {particles_.size() - n_arrived, particles_.size()});
  if (!leavers_.empty()) local.requests.rebuild.include(1);
}

GlobalIndex ParticleGrid::adopt(Partition partition) {
  partition_ = std::move(partition);
  LocalIndex n_arrived = 0;
  {
    const PhaseTimer timer(times_, Phase::migrate);
    departures_.clear();
    for (LocalIndex p = 0; p < particles_.size(); ++p) {
      const TileIndex tile = layout_.tiles()[static_cast<std::size_t>(map_.cell[static_cast<std::size_t>(p)]) / tile_nodes];
      const std::int32_t owner = partition_.map.owner(tile);
      if (owner != comm_.rank()) departures_.push_back({p, owner});
    }
    n_arrived = migrate(comm_, departures_, particles_);
  }
  rebuild();
  n_jumps_ += map_.n_jumps;
  bounds_.transport.largest_share.value = max_global(comm_, GlobalIndex{particles_.size()});
  return sum_global(comm_, GlobalIndex{n_arrived});
}

// A new pool for the tiles that hold particles now or may soon, and the exchange that belongs to it.
void ParticleGrid::rebuild() {
  const PhaseTimer timer(times_, Phase::rebuild);
  ++version_;
  std::vector<TileIndex> tiles = tiles_in_reach(grid_, census());
  std::erase_if(tiles, [&](TileIndex tile) { return partition_.map.owner(tile) != comm_.rank(); });
  collective_guard(comm_, [&] { layout_ = PoolLayout(grid_, std::move(tiles)); });
  if (exchange_) exchange_wait_ += exchange_->seconds_waiting();
  exchange_ = std::make_unique<Exchange>(comm_, grid_, partition_.map, layout_);
  begin_move();
  locate(grid_, layout_, particles_, map_, leavers_);
  BULKLEY_ASSERT(leavers_.empty());
  bounds_.sums.cell_count.value = max_global(comm_, GlobalIndex{map_.largest_count()});
}

std::size_t ParticleGrid::memory() const {
  return particles_.memory() + layout_.memory() + (map_.cell.capacity() + map_.count.capacity()) * sizeof(LocalIndex) +
         partition_.map.memory();
}

}  // namespace bulkley
