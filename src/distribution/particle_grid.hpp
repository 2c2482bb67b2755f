#pragma once
// The particles of one run, distributed over the ranks, and the pools of nodes that they reach: transport without any
// scheme.
//
// An integrator changes particles in place and hands them back block by block; what it stores on nodes is its own affair
// (integrator/). Here particles are confined to the domain, found in their cells, sent to the owners of their tiles and
// sorted, and the pools follow them.

#include <memory>
#include <vector>

#include "balance/partition.hpp"
#include "distribution/exchange.hpp"
#include "distribution/migrate.hpp"
#include "distribution/reduce_bounds.hpp"
#include "kernel/cells.hpp"
#include "parallel/phases.hpp"

namespace bulkley {

class ParticleGrid {
 public:
  /// `particles`: any distribution over ranks; they are sent to the owners of their tiles. After it bounds() may have
  /// failed: a particle is outside the domain; nothing else may be called then but particles() and bounds(). `comm` and
  /// `times` must outlive this. Collective.
  ParticleGrid(const Comm& comm, const GridGeometry& grid, const Faces& faces, int n_materials, Partition partition,
               ParticleSet particles, PhaseTimes& times);

  const Comm& comm() const { return comm_; }
  const GridGeometry& grid() const { return grid_; }
  const Partition& partition() const { return partition_; }

  /// The particles of this rank. Whoever changes positions hands every block to `place` and ends with `finish_move`.
  ParticleSet& particles() { return particles_; }
  const ParticleSet& particles() const { return particles_; }
  /// Tiles and rows of this rank's pool, where its particles are in it, and the way to the owners of its nodes. Layout and
  /// exchange change when local_version() does.
  const PoolLayout& layout() const { return layout_; }
  const CellMap& map() const { return map_; }
  Exchange& exchange() { return *exchange_; }
  const Exchange& exchange() const { return *exchange_; }
  /// Number of the present pools of all ranks: what ranks have made together for other ones does not fit. The same on every rank.
  GlobalIndex version() const { return version_; }
  /// The same for this rank: arrays made for another one do not fit. It stays when pools change that have nothing to do with
  /// this rank's.
  GlobalIndex local_version() const { return local_version_; }
  /// The ranks with which this one exchanges particles and nodes.
  const Neighbours& neighbours() const { return neighbours_; }

  /// What is known of the particles as they are, merged over ranks.
  const StepBounds& bounds() const { return bounds_; }
  /// Replaces it: by measured bounds at the start of a run, or those of a checkpoint. Not collective (the same on every
  /// rank).
  void set_bounds(const StepBounds& bounds) { bounds_ = bounds; }
  /// Merges over ranks what each has learned. Collective.
  StepBounds reduce(const StepBounds& local) const { return reduce_(local); }

  /// Begins to move all particles; then each block once to `place`; then finish_move. Not collective.
  void begin_move();
  /// Positions of `block` -> domain and cells. After a failure cells are undefined; finish_move stops every rank. Not
  /// collective.
  void place(ParticleBlock block);
  /// Those that `place` has found beyond outflow faces: finish_move removes them. Not collective.
  std::span<const LocalIndex> removed() const { return removed_; }
  /// Takes in the particles that were appended after the last block, from `first` on: positions inside the domain. Not
  /// collective.
  void place_added(LocalIndex first);
  /// finish_move takes these out of the run, too; they do not count as removed. Not collective.
  void drop(std::vector<LocalIndex> particles) { dropped_ = std::move(particles); }
  /// Brings every particle to the owner of its tile. `local`: what this rank has learned in the step. The merged bounds,
  /// which bounds() gives from now on; where they have failed, particles stay as they are. One all-reduce. Collective.
  const StepBounds& finish_move(StepBounds local);

  /// Continues under another partition: sends the particles to its owners. Returns the number of particles that have changed
  /// ranks. No particle changes otherwise. Collective.
  GlobalIndex adopt(Partition partition);

  /// What each tile holds of this rank's particles. Not collective.
  TileCensus census() const { return take_census(grid_, particles_, n_materials_); }
  /// Of the wall time in phase "exchange", what went into waiting for other ranks so far, s.
  double exchange_wait() const { return exchange_wait_ + exchange_->seconds_waiting(); }
  /// Bytes of particles, layout and maps on this rank. Not collective.
  std::size_t memory() const;

 private:
  void migrate_leavers(StepBounds& local);
  void rebuild_pool();
  void note_unknown_owners();
  void release_lists();
  void introduce();
  void connect();

  const Comm& comm_;
  GridGeometry grid_;
  Faces faces_;
  int n_materials_;
  Partition partition_;
  ParticleSet particles_;
  PhaseTimes& times_;
  StepBounds bounds_;
  BoundsReduction reduce_;
  PoolLayout layout_;
  Neighbours neighbours_;
  std::vector<int> unknown_;  ///< ranks that must become neighbours
  std::unique_ptr<Exchange> exchange_;
  CellMap map_;
  StepBounds outside_;                    ///< what `place` has found since begin_move
  std::vector<OutsideParticle> leavers_;  ///< particles that are in no tile of the pool
  std::vector<LocalIndex> removed_, dropped_, departed_;
  std::vector<Departure> departures_;
  double exchange_wait_ = 0.0;  ///< of exchanges that are gone, s
  GlobalIndex n_jumps_ = 0;     ///< since the last sort
  GlobalIndex version_ = 1, local_version_ = 1;
};

}  // namespace bulkley
