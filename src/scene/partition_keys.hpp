#pragma once
// Keys of [partition] of a scene.

#include "balance/partition_settings.hpp"
#include "bulkley/config/keys.hpp"

namespace bulkley {

inline config::Names<PartitionMethod> names(config::Of<PartitionMethod>) {
  return {{"uniform", PartitionMethod::uniform}, {"ranges", PartitionMethod::ranges},
          {"hilbert", PartitionMethod::hilbert}, {"bisection", PartitionMethod::bisection},
          {"metis", PartitionMethod::metis},     {"auto", PartitionMethod::automatic}};
}

inline const config::Keys<PartitionSettings>& keys(config::Of<PartitionSettings>) {
  static const auto table =
      config::Keys<PartitionSettings>("How tiles are assigned to ranks; no result depends on it.")
          .key(
              "method", &PartitionSettings::method,
              {.about = "uniform: equal parts of the grid; ranges: boxes of the grid of about equal cost; "
                        "hilbert: runs of a Hilbert curve through tiles of 4 x 4 x 4 nodes; bisection: regions by recursive "
                        "cuts of equal load, which move only where loads ask for it; metis: tiles grouped with few shared "
                        "nodes, on the root; auto: the method with the fastest predicted step, changed "
                        "when that pays, and bisection where more than 400 000 tiles hold particles or the box has more "
                        "than 2^22, and for more than 4096 ranks. The first two need a "
                        "box of tiles for each rank, the others work on any number of ranks."})
          .key("decision_interval", &PartitionSettings::decision_interval,
               {.about =
                    "Steps between the imbalance checks of auto and bisection; more where checks would take over 1 % of the "
                    "time. A check is made earlier when the most loaded rank grows. 0: the initial map is kept.",
                .unit = "steps",
                .range = config::at_least(0.0)})
          .key("remake_interval", &PartitionSettings::remake_interval,
               {.about =
                    "Steps between repartitions by the method, without regard to their benefit; 0: none. Then every method "
                    "except auto and bisection keeps the initial map.",
                .unit = "steps",
                .range = config::at_least(0.0)})
          .key("ranks_per_node", &PartitionSettings::ranks_per_node,
               {.about = "Consecutive ranks that share a node of the machine: bisection cuts between nodes first, so that "
                         "fewer bytes leave them. 0: as MPI says.",
                .range = config::at_least(0.0)});
  return table;
}

}  // namespace bulkley
