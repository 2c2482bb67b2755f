#include "rebalance/merged_census.hpp"

#include <algorithm>

namespace bulkley {

namespace {

// Particles of a material that a rank has in a tile.
struct CensusItem {
  TileIndex tile;
  std::int32_t material;
  GlobalIndex count;
  std::uint64_t cells;
};
static_assert(sizeof(CensusItem) == 24, "it is sent as bytes, without padding");

TileCensus census_of(std::vector<CensusItem> items, int n_materials) {
  std::sort(items.begin(), items.end(), [](const CensusItem& a, const CensusItem& b) { return a.tile < b.tile; });
  TileCensus census;
  census.n_materials = n_materials;
  const auto n = static_cast<std::size_t>(n_materials);
  for (const CensusItem& item : items) {
    if (census.tile.empty() || census.tile.back() != item.tile) {
      census.tile.push_back(item.tile);
      census.cells.push_back(0);
      census.count.resize(census.count.size() + n, 0);
    }
    census.cells.back() |= item.cells;
    census.count[census.count.size() - n + static_cast<std::size_t>(item.material)] += item.count;
  }
  return census;
}

}  // namespace

TileHome owners_or_hash(const TileMap* present, int n_ranks) {
  if (present) return [present](TileIndex tile) { return present->owner(tile); };
  return [n_ranks](TileIndex tile) {
    constexpr std::uint32_t spreading = 2654435769u;  // 2^32 over the golden ratio
    return static_cast<int>(std::uint64_t{static_cast<std::uint32_t>(tile) * spreading} * static_cast<unsigned>(n_ranks) >>
                            32);
  };
}

TileCensus merged_census(const Comm& comm, const TileCensus& local, const TileHome& home_of, SentMessages& sent) {
  std::vector<CensusItem> items;
  GlobalIndex all_at_home = 1;
  const auto n_materials = static_cast<std::size_t>(local.n_materials);
  for (std::size_t t = 0; t < local.size(); ++t) {
    if (home_of(local.tile[t]) != comm.rank()) all_at_home = 0;
    for (std::size_t m = 0; m < n_materials; ++m)
      if (const GlobalIndex count = local.count[t * n_materials + m]; count > 0)
        items.push_back({local.tile[t], static_cast<std::int32_t>(m), count, local.cells[t]});
  }
  RankRange range(comm, sent);
  range.combine({&all_at_home, 1}, 0);
  for (; all_at_home == 0 && range.size() > 1; range = range.half()) {
    const int end = range.middle();
    range.divide(items, [&](const CensusItem& item) { return home_of(item.tile) < end; });
  }
  return census_of(std::move(items), local.n_materials);
}

}  // namespace bulkley
