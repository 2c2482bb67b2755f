#pragma once
// Keys of [partition] of a scene.

#include "balance/partition_settings.hpp"
#include "bulkley/config/keys.hpp"

namespace bulkley {

inline config::Names<PartitionMethod> names(config::Of<PartitionMethod>) {
  return {{"uniform", PartitionMethod::uniform},
          {"ranges", PartitionMethod::ranges},
          {"hilbert", PartitionMethod::hilbert},
          {"metis", PartitionMethod::metis},
          {"auto", PartitionMethod::automatic}};
}

inline const config::Keys<PartitionSettings>& keys(config::Of<PartitionSettings>) {
  static const auto table =
      config::Keys<PartitionSettings>("How the work is divided among ranks; no result depends on it.")
          .key("method", &PartitionSettings::method,
               {.about =
                    "uniform: equal parts of the grid; ranges: boxes of the grid cut so that each costs about as much; "
                    "hilbert: tiles of 4 x 4 x 4 nodes in the order of a Hilbert curve; metis: tiles grouped with few "
                    "shared nodes; auto: whichever is predicted to be fastest, changed when that pays. The first two need "
                    "a box of tiles for each rank, the others work on any number of ranks."})
          .key("decision_interval", &PartitionSettings::decision_interval,
               {.about =
                    "Steps after which auto looks in any case whether a new map pays; more where looks would take over 1 % "
                    "of the time. It looks earlier when the most loaded rank grows. 0: the map of the start stays.",
                .unit = "steps",
                .range = config::at_least(0.0)})
          .key("remake_interval", &PartitionSettings::remake_interval,
               {.about =
                    "Steps between two new maps by the method, whether they pay or not; 0: none. Without it every method "
                    "but auto keeps the map of the start.",
                .unit = "steps",
                .range = config::at_least(0.0)});
  return table;
}

}  // namespace bulkley
