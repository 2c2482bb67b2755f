#pragma once
// METIS, and what can be wrong with its answers.

#include <optional>
#include <string>

#include "balance/tile_graph.hpp"

namespace bulkley {

/// A graph partitioner: weights of the vertices, number of parts -> part of each vertex; nothing if it fails.
using GraphPartitioner = std::optional<std::vector<std::int32_t>> (*)(const TileGraph&,
                                                                      const std::vector<std::int32_t>& weights, int n_parts);

/// METIS's partition by recursive bisection, fixed seed. Measured on the scenes of docs/partitions.md, with loads made
/// equal afterwards: the borders of its k-way partition are as long, and take three to four times the time beyond 250 parts.
std::optional<std::vector<std::int32_t>> metis_bisections(const TileGraph& graph, const std::vector<std::int32_t>& weights,
                                                          int n_parts);

/// Parts of about equal load with few nodes shared between them. METIS crashes for one part, leaves parts empty where there
/// are few tiles and where weights exceed 32 bits, and may scatter a part; so weights are scaled, the answer is checked, and
/// if it cannot be used `fault` says why and nothing is returned. `partitioner`: for tests of that.
std::optional<std::vector<std::int32_t>> graph_parts(const TileGraph& graph, const TileLoad& load, int n_parts,
                                                     std::string& fault, GraphPartitioner partitioner = metis_bisections);

}  // namespace bulkley
