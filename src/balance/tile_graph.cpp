#include "balance/tile_graph.hpp"

#include <algorithm>
#include <cstdlib>

#include "grid/slot_table.hpp"

namespace bulkley {

TileGraph tile_graph(const GridGeometry& grid, const TileLoad& load) {
  // Along an axis in which two tiles differ their footprints share what one reaches into the other. Nodes near an edge or a
  // corner are those of faces, too: there a pair of tiles counts a quarter and a sixteenth.
  const int reach = footprint_width(grid.order) - tile_width;
  const SlotTable number(load.tile);
  TileGraph graph;
  graph.first.reserve(load.size() + 1);
  graph.first.push_back(0);
  for (std::size_t t = 0; t < load.size(); ++t) {
    const Int3 here = grid.tile_coordinates(load.tile[t]);
    for (int d = 0; d < 27; ++d) {
      const Int3 step{d / 9 - 1, d / 3 % 3 - 1, d % 3 - 1};
      const TileIndex there = grid.neighbour(here, step);
      if (there < 0 || there == load.tile[t]) continue;
      const std::int32_t other = number.slot(there);
      if (other < 0) continue;
      const auto entries = graph.neighbour.begin() + graph.first.back();
      if (std::find(entries, graph.neighbour.end(), other) != graph.neighbour.end()) continue;  // both ways around an axis
      const int n_differing = std::abs(step[0]) + std::abs(step[1]) + std::abs(step[2]);
      graph.neighbour.push_back(other);
      graph.shared.push_back(tile_width * tile_width * reach >> 2 * (n_differing - 1));
    }
    graph.first.push_back(static_cast<GlobalIndex>(graph.neighbour.size()));
  }
  return graph;
}

int n_pieces(const TileGraph& graph, const std::vector<std::int32_t>& part) {
  std::vector<bool> seen(part.size(), false);
  std::vector<std::int32_t> open;
  int n = 0;
  for (std::int32_t start = 0; start < graph.size(); ++start) {
    if (seen[static_cast<std::size_t>(start)]) continue;
    ++n;
    open.assign(1, start);
    seen[static_cast<std::size_t>(start)] = true;
    while (!open.empty()) {
      const std::int32_t t = open.back();
      open.pop_back();
      for (GlobalIndex e = graph.first[static_cast<std::size_t>(t)]; e < graph.first[static_cast<std::size_t>(t) + 1]; ++e) {
        const auto other = static_cast<std::size_t>(graph.neighbour[static_cast<std::size_t>(e)]);
        if (seen[other] || part[other] != part[static_cast<std::size_t>(t)]) continue;
        seen[other] = true;
        open.push_back(static_cast<std::int32_t>(other));
      }
    }
  }
  return n;
}

}  // namespace bulkley
