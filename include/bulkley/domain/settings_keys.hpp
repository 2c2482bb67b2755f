#pragma once
// Keys of [partition] of a scene.

#include "bulkley/config/keys.hpp"
#include "bulkley/domain/settings.hpp"

namespace bulkley {

inline config::Names<PartitionMethod> names(config::Of<PartitionMethod>) {
  return {{"uniform", PartitionMethod::uniform}, {"ranges", PartitionMethod::ranges}};
}

inline const config::Keys<PartitionSettings>& keys(config::Of<PartitionSettings>) {
  static const auto table =
      config::Keys<PartitionSettings>("How the work is divided among ranks; no result depends on it.")
          .key("method", &PartitionSettings::method,
               {.about =
                    "uniform: equal parts of the grid; ranges: parts cut such that each holds about as many particles."});
  return table;
}

}  // namespace bulkley
