#include "balance/graph_parts.hpp"

#include <fmt/format.h>
#include <metis.h>

#include <algorithm>
#include <limits>

namespace bulkley {

namespace {

static_assert(sizeof(idx_t) == sizeof(std::int32_t), "graphs are handed to METIS as they are");

constexpr GlobalIndex largest_total = GlobalIndex{1} << 30;  // of the weights; METIS adds them in 32 bits
constexpr int tiles_per_part = 4;                            // with fewer on average METIS degrades, and leaves parts empty

std::vector<std::int32_t> scaled_weights(const TileLoad& load) {
  const double scale = static_cast<double>(largest_total - static_cast<GlobalIndex>(load.size())) /
                       static_cast<double>(std::max<GlobalIndex>(load.total(), 1));
  std::vector<std::int32_t> weights;
  weights.reserve(load.size());
  for (const GlobalIndex weight : load.weight)
    weights.push_back(1 + static_cast<std::int32_t>(std::min(scale, 1.0) * static_cast<double>(weight)));
  return weights;
}

std::string fault_in(const TileGraph& graph, const std::vector<std::int32_t>& part, int n_parts) {
  std::vector<int> n_tiles(static_cast<std::size_t>(n_parts), 0);
  for (const std::int32_t p : part) {
    if (p < 0 || p >= n_parts) return fmt::format("it names a part {} of {}", p, n_parts);
    ++n_tiles[static_cast<std::size_t>(p)];
  }
  if (const auto n_empty = std::count(n_tiles.begin(), n_tiles.end(), 0); n_empty > 0)
    return fmt::format("it leaves {} of {} parts empty", n_empty, n_parts);
  // A part may hold several drops, and a few tiles cut off are no harm.
  const int pieces = n_pieces(graph, part);
  const int whole = n_pieces(graph, std::vector<std::int32_t>(part.size(), 0));
  if (pieces > 2 * (n_parts + whole)) return fmt::format("its {} parts are {} pieces", n_parts, pieces);
  return {};
}

}  // namespace

std::optional<std::vector<std::int32_t>> metis_bisections(const TileGraph& graph, const std::vector<std::int32_t>& weights,
                                                          int n_parts) {
  idx_t options[METIS_NOPTIONS];
  METIS_SetDefaultOptions(options);
  options[METIS_OPTION_SEED] = 1;
  options[METIS_OPTION_NUMBERING] = 0;
  options[METIS_OPTION_UFACTOR] = 1;  // 0.1 % above the mean in each bisection
  // METIS takes all of these by pointers to what it does not change.
  std::vector<idx_t> first(graph.first.begin(), graph.first.end()), neighbour = graph.neighbour, shared = graph.shared;
  std::vector<idx_t> w = weights;
  idx_t n = graph.size(), n_constraints = 1, parts = n_parts, cut = 0;
  std::vector<std::int32_t> part(static_cast<std::size_t>(n), 0);
  const int result = METIS_PartGraphRecursive(&n, &n_constraints, first.data(), neighbour.data(), w.data(), nullptr,
                                              shared.data(), &parts, nullptr, nullptr, options, &cut, part.data());
  if (result != METIS_OK) return std::nullopt;
  return part;
}

std::optional<std::vector<std::int32_t>> graph_parts(const TileGraph& graph, const TileLoad& load, int n_parts,
                                                     std::string& fault, GraphPartitioner partitioner) {
  if (n_parts == 1) return std::vector<std::int32_t>(load.size(), 0);
  if (static_cast<GlobalIndex>(load.size()) < GlobalIndex{tiles_per_part} * n_parts) {
    fault = fmt::format("{} tiles hold particles, fewer than {} for each of {} ranks", load.size(), tiles_per_part, n_parts);
    return std::nullopt;
  }
  if (graph.first.back() > std::numeric_limits<idx_t>::max()) {
    fault = fmt::format("{} tiles have {} neighbours, more than it numbers in 32 bits", load.size(), graph.first.back());
    return std::nullopt;
  }
  std::optional<std::vector<std::int32_t>> part = partitioner(graph, scaled_weights(load), n_parts);
  fault = part ? fault_in(graph, *part, n_parts) : "it reports an error";
  if (!fault.empty()) return std::nullopt;
  return part;
}

}  // namespace bulkley
