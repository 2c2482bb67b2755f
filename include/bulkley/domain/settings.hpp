#pragma once
// How the work is divided among ranks, table [partition] of a scene.

namespace bulkley {

enum class PartitionMethod {
  uniform,  ///< equal numbers of tiles per rank along each axis
  ranges,   ///< DMDA ownership ranges chosen for the smallest largest load
};

struct PartitionSettings {
  PartitionMethod method = PartitionMethod::ranges;
};

}  // namespace bulkley
