#pragma once
// Where maps of tiles come from.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "balance/map_change.hpp"
#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// What a partitioner may use. The references must outlive the call.
struct PartitionRequest {
  const GridGeometry& grid;  ///< the same on every rank
  const TileCensus& census;  ///< of this rank's particles, or share of them; a tile may be in those of several ranks
  const CostModel& cost;     ///< of steps; the same on every rank
  const Partition* present = nullptr;  ///< none where no map has been made yet
  /// Steps over which a change must save more than it costs; none: a new map is wanted whether it pays or not. Alike on
  /// every rank.
  std::optional<double> horizon = std::nullopt;
  ChangeCost change = {};  ///< as this rank has measured it: those of ranks differ
};

/// What a partitioner answers.
struct PartitionProposal {
  std::optional<Partition> partition;  ///< the same on every rank; none: the present one stays
  GlobalIndex busiest_moves = 0;       ///< particles that the busiest rank sends or receives in the change; 0: not known
  double tile_seconds = 0.0;           ///< for each loaded tile of a whole map made on the root, there; 0: none was
  PartitionNotes notes;                ///< how it came about, with warnings; on the root
};

/// Makes and changes the map of tiles. A partitioner may keep what it learns from one call to the next.
///
/// Nobody but the partitioner knows where a map is made: it is given what each rank holds, and no rank needs to see all.
class Partitioner {
 public:
  virtual ~Partitioner() = default;

  /// A map for as many ranks as `comm` has, over all tiles of the grid. Throws UsageError, the same on every rank, where
  /// there is none; and RunError, the same on every rank, if the partitioner answers differently on different ranks or with
  /// a map for another grid or number of ranks: particles would be lost. Collective.
  PartitionProposal propose(const Comm& comm, const PartitionRequest& request);

 private:
  virtual PartitionProposal find(const Comm& comm, const PartitionRequest& request) = 0;
};

/// The partitioner that a scene asks for, among the ranks of `comm`; where `settings` do not say how many ranks share a node, MPI
/// does (node_layout). Collective.
std::unique_ptr<Partitioner> make_partitioner(const Comm& comm, PartitionSettings settings);

}  // namespace bulkley
