#include "distribution/particle_grid.hpp"

#include <algorithm>
#include <new>

namespace bulkley {

namespace {

// Particles drift out of cell order slowly. A physical sort costs about as much as the nodes of another tile for every
// particle, so it pays off once that many jumps from tile to tile have been made since the last one. It never changes a
// result.
constexpr GlobalIndex jumps_per_sort = 8;  // per particle

// What a rank asks of all (StepRequests::rebuild), the larger including the smaller: that plans of exchange are traded, for its
// pool has changed; that it gets new neighbours; that particles which were to go to them go then.
enum Rebuild : std::int32_t { trade_plans = 1, meet = 2, go_on = 3 };

// Runs work that the other ranks do not wait for at this point: what goes wrong cannot be told to them, and ends them all.
template <class Work>
void alone(Work work) {
  try {
    work();
  } catch (const std::bad_alloc&) {
    abort_all_ranks("out of memory while a pool of nodes is built", __FILE__, __LINE__);
  } catch (const RunError& error) {
    abort_all_ranks(error.what(), __FILE__, __LINE__);
  }
}

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
      reduce_(comm),
      neighbours_(comm),
      exchange_(std::make_unique<Exchange>(comm_, grid_)) {
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
  bool changed = false;
  do {
    migrate_leavers(local);
    local.sums.cell_count.value = map_.largest_count();
    local.totals.n_particles.value = particles_.size();
    local.transport.largest_share.value = particles_.size();
    local.requests.sort.include(n_jumps_ > jumps_per_sort * particles_.size());
    {
      const PhaseTimer timer(times_, Phase::reduce);
      bounds_ = reduce_(local);
    }
    if (bounds_.failed()) return bounds_;
    changed = changed || bounds_.requests.rebuild >= trade_plans;
    if (bounds_.requests.rebuild >= meet) introduce();
  } while (bounds_.requests.rebuild == go_on);
  if (changed) {
    connect();
    release_lists();
  }
  if (bounds_.requests.sort) {
    const PhaseTimer timer(times_, Phase::sort);
    sort_particles(particles_, map_);
    n_jumps_ = 0;
  }
  return bounds_;
}

// Sends particles of other ranks' tiles there and takes in theirs; then the pool follows, if it lacks a tile. Particles of a rank
// that is no neighbour yet stay until it is one: they have moved by more than a cell.
void ParticleGrid::migrate_leavers(StepBounds& local) {
  local.requests.rebuild = {};
  departures_.clear();
  departed_.clear();
  bool lacks_tile = false;
  GlobalIndex n_far = 0;
  LocalIndex n_arrived = 0;
  {
    const PhaseTimer timer(times_, Phase::migrate);
    if (!local.failed())
      for (const OutsideParticle& leaver : leavers_) {
        const std::int32_t owner = partition_.map.owner(leaver.tile);
        if (owner == comm_.rank()) {
          lacks_tile = true;
        } else if (neighbours_.has(owner)) {
          departures_.push_back({leaver.particle, owner});
          departed_.push_back(leaver.particle);
        } else {
          unknown_.push_back(owner);
          ++n_far;
        }
      }
    const LocalIndex n_before = particles_.size();
    n_arrived = migrate(comm_, neighbours_, departures_, particles_);
    local.transport.n_migrated += n_arrived;
    if (local.failed()) return;
    if (n_arrived > 0 || !departures_.empty()) {
      // Leavers are not counted in any cell, so what is left to do is to follow the particles' moves and to count the arrivals.
      fill_gaps<LocalIndex>(departed_, n_before, [&](LocalIndex to, LocalIndex from) { map_.cell[to] = map_.cell[from]; });
      map_.resize(particles_.size());
      leavers_.clear();
      locate(grid_, layout_, particles_, map_, leavers_, {particles_.size() - n_arrived, particles_.size()});
      lacks_tile = lacks_tile || !leavers_.empty();
    }
    n_jumps_ += map_.n_jumps;
    map_.n_jumps = 0;
  }
  if (lacks_tile || n_far > 0) rebuild_pool();
  if (lacks_tile) local.requests.rebuild.include(unknown_.empty() ? trade_plans : meet);
  if (n_far > 0) local.requests.rebuild.include(go_on);
}

GlobalIndex ParticleGrid::adopt(Partition partition) {
  partition_ = std::move(partition);
  exchange_wait_ += exchange_->seconds_waiting();
  exchange_ = std::make_unique<Exchange>(comm_, grid_);
  departures_.clear();
  unknown_.clear();
  for (LocalIndex p = 0; p < particles_.size(); ++p) {
    const TileIndex tile = layout_.tiles()[static_cast<std::size_t>(map_.cell[static_cast<std::size_t>(p)]) / tile_nodes];
    const std::int32_t owner = partition_.map.owner(tile);
    if (owner == comm_.rank()) continue;
    departures_.push_back({p, owner});
    if (unknown_.empty() || unknown_.back() != owner) unknown_.push_back(owner);
  }
  neighbours_.forget();
  introduce();
  LocalIndex n_arrived = 0;
  {
    const PhaseTimer timer(times_, Phase::migrate);
    n_arrived = migrate(comm_, neighbours_, departures_, particles_);
  }
  neighbours_.forget();  // those that only sent particles
  rebuild_pool();
  BULKLEY_ASSERT(leavers_.empty());
  introduce();
  connect();
  n_jumps_ += map_.n_jumps;
  bounds_.sums.cell_count.value = max_global(comm_, GlobalIndex{map_.largest_count()});
  bounds_.transport.largest_share.value = max_global(comm_, GlobalIndex{particles_.size()});
  return sum_global(comm_, GlobalIndex{n_arrived});
}

// A new pool for the tiles that hold particles now or may soon, and the cells of the particles in it. No other rank takes part.
void ParticleGrid::rebuild_pool() {
  const PhaseTimer timer(times_, Phase::rebuild);
  std::vector<TileIndex> tiles = tiles_in_reach(grid_, census());
  std::erase_if(tiles, [&](TileIndex tile) { return partition_.map.owner(tile) != comm_.rank(); });
  alone([&] {
    layout_ = PoolLayout(grid_, std::move(tiles));
    exchange_->set_pool(partition_.map, layout_);
  });
  ++local_version_;
  begin_move();
  locate(grid_, layout_, particles_, map_, leavers_);
  if (leavers_.empty()) release_lists();
  note_unknown_owners();
}

// At a start and with another map all particles may be in them; afterwards few are.
void ParticleGrid::release_lists() {
  const auto release = [](auto& list) { std::decay_t<decltype(list)>().swap(list); };
  release(leavers_);
  release(departures_);
  release(departed_);
}

// Neighbours must be the owners of all nodes of the pool and of all tiles that a particle of it may enter.
void ParticleGrid::note_unknown_owners() {
  const auto note = [&](int owner) {
    if (owner != comm_.rank() && !neighbours_.has(owner) && (unknown_.empty() || unknown_.back() != owner))
      unknown_.push_back(owner);
  };
  for (const int owner : exchange_->owners()) note(owner);
  for (const TileIndex tile : layout_.tiles()) {
    const Int3 at = grid_.tile_coordinates(tile);
    for (int d = 0; d < 27; ++d)
      if (const TileIndex there = grid_.neighbour(at, {d / 9 - 1, d / 3 % 3 - 1, d % 3 - 1}); there >= 0)
        note(partition_.map.owner(there));
  }
}

void ParticleGrid::introduce() {
  const PhaseTimer timer(times_, Phase::rebuild);
  neighbours_.introduce(unknown_);
  unknown_.clear();
}

// After pools have changed, on whatever ranks.
void ParticleGrid::connect() {
  const PhaseTimer timer(times_, Phase::rebuild);
  ++version_;
  alone([&] {
    if (exchange_->connect(neighbours_)) ++local_version_;
  });
}

std::size_t ParticleGrid::memory() const {
  return particles_.memory() + layout_.memory() + (map_.cell.capacity() + map_.count.capacity()) * sizeof(LocalIndex) +
         partition_.map.memory();
}

}  // namespace bulkley
