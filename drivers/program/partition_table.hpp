#pragma once
// What every method of partition makes of one distribution of particles, as a human-readable table and as CSV.

#include <limits>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "balance/partition_settings.hpp"
#include "balance/tile_load.hpp"
#include "scene/scene.hpp"

namespace bulkley {

/// The names of the methods, as scenes spell them.
std::vector<std::string> partition_method_names();
/// Nothing for a name that is none of them.
std::optional<PartitionMethod> partition_method(const std::string& name);

/// What is to be divided.
struct PartitionTask {
  GridGeometry grid;
  CostModel cost;
  TileLoad load;                   ///< now
  std::optional<TileLoad> before;  ///< at an earlier time, for which the map that is left was made
  GlobalIndex n_particles = 0;
  int ranks_per_node = 0;  ///< of the nodes between which bytes are counted; 0: they are not
};

/// One method for one number of ranks.
struct PartitionRow {
  int n_ranks = 0;
  std::string method;  ///< that was requested
  std::string chosen;  ///< that made the partition; empty if there is none
  std::vector<std::string> remarks;
  double load = 1.0, particles = 1.0;  ///< largest over mean
  double halo = 0.0;                   ///< nodes of footprints beyond a rank's tiles, over those of its tiles
  double neighbours_mean = 0.0, neighbours_max = 0.0;
  double bytes_mean = 0.0, bytes_max = 0.0;                    ///< sent per rank and step
  double off_node = std::numeric_limits<double>::quiet_NaN();  ///< part of all bytes that leaves a node; NaN: no nodes
  double messages_mean = 0.0, messages_max = 0.0;
  double step_seconds = 0.0;
  double moved = std::numeric_limits<double>::quiet_NaN();  ///< part of the particles that change ranks; NaN: no `before`
  double seconds = 0.0;                                     ///< that the partition took
};

/// A method without a partition has a row with remarks only. Where there is a `before`, `automatic` has two more
/// rows: the map that is left, with few tiles moved; and `bisection`: with more of its cuts moved, and made anew.
std::vector<PartitionRow> partition_rows(const PartitionTask& task, std::span<const PartitionMethod> methods, int n_ranks);

/// Human-readable: the rows of one number of ranks under a heading.
std::string partition_table(std::span<const PartitionRow> rows);

/// Any rows, with a header that names units. A method without a partition has empty cells.
std::string partition_csv(const PartitionTask& task, std::span<const PartitionRow> rows);

}  // namespace bulkley
