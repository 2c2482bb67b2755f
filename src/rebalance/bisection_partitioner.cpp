#include "rebalance/bisection_partitioner.hpp"

#include <algorithm>
#include <array>
#include <tuple>

namespace bulkley {

namespace {

constexpr double least_gain = 0.02;  // of the load of the most loaded rank

static_assert(sizeof(TileRecord) == 32, "it is sent as bytes, without padding");

// A tree, and what it would mean for the most loaded and the busiest rank.
struct Candidate {
  CutTree tree;
  GlobalIndex largest_load = 0, busiest_moves = 0;  // ps; particles that a rank sends or receives
};

}  // namespace

CutTree bisected_together(const Comm& comm, const GridGeometry& grid, Cutting cutting, std::vector<TileRecord>& records,
                          const KeptCuts& kept, SentMessages& sent, RankHalves halves) {
  RankRange range(comm, sent, halves);
  GlobalIndex total = 0;
  for (const TileRecord& record : records) total += record.weight;
  range.combine({&total, 1}, 1);
  if (total == 0) return kept.present ? *kept.present : even_cuts(grid, comm.size(), halves);

  const Bisection bisection(grid, cutting, halves, comm.size(), total, kept);
  std::uint64_t mine = 0;  // the cut between this rank and the next
  for (int depth = 0; range.size() > 1; ++depth) {
    const Cut cut = bisection.cut(records, range.first(), range.size(), depth, range);
    if (halves.cut_of(range.first(), range.size()) == static_cast<std::size_t>(comm.rank())) mine = cut.bits();
    range.divide(records, [&](const TileRecord& record) { return cut.below(record.at); });
    range = range.half();
  }
  std::vector<std::uint64_t> all(static_cast<std::size_t>(comm.size()));
  BULKLEY_MPI(MPI_Allgather(&mine, 1, MPI_UINT64_T, all.data(), 1, MPI_UINT64_T, comm.get()));
  std::vector<Cut> cuts;
  cuts.reserve(all.size());
  for (std::size_t n = 0; n + 1 < all.size(); ++n) cuts.push_back(Cut::of_bits(all[n]));
  return {grid, std::move(cuts), cutting, halves};
}

PartitionProposal BisectionPartitioner::find(const Comm& comm, const PartitionRequest& request) {
  const GridGeometry& grid = request.grid;
  const TileMap* const present = request.present ? &request.present->map : nullptr;
  const CutTree* const tree = present ? present->tree() : nullptr;
  const CutTree* const old = tree && tree->cutting() == cutting_ && tree->halves() == halves_ ? tree : nullptr;
  SentMessages sent;
  const TileLoad load =
      tile_load(merged_census(comm, request.census, owners_or_hash(present, comm.size()), sent), request.cost);
  std::vector<TileRecord> records = records_of(grid, cutting_, load);
  for (TileRecord& record : records) record.owner = comm.rank();
  const GlobalIndex n_here = std::accumulate(load.count.begin(), load.count.end(), GlobalIndex{0});
  const auto tried = [&](const KeptCuts& kept) {
    std::vector<TileRecord> moved = records;
    Candidate candidate{bisected_together(comm, grid, cutting_, moved, kept, sent, halves_)};
    GlobalIndex here = 0, n_stay = 0, n_arrive = 0;
    for (const TileRecord& record : moved) {
      here += record.weight;
      (record.owner == comm.rank() ? n_stay : n_arrive) += record.count;
    }
    std::array<GlobalIndex, 2> largest{here, n_here - n_stay + n_arrive};
    BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, largest.data(), 2, MPI_INT64_T, MPI_MAX, comm.get()));
    candidate.largest_load = largest[0];
    if (present) candidate.busiest_moves = largest[1];
    return candidate;
  };

  PartitionProposal proposal;
  proposal.notes.method = cutting_ == Cutting::curve ? PartitionMethod::hilbert : PartitionMethod::bisection;
  const auto propose = [&](Candidate candidate) {
    if (old && candidate.tree == *old) return;
    proposal.partition = Partition{TileMap(std::move(candidate.tree)), {}};
    proposal.busiest_moves = candidate.busiest_moves;
  };
  if (!present || !request.horizon) {
    propose(tried({old}));
    return proposal;
  }
  const auto seconds = [](GlobalIndex picoseconds) { return 1e-12 * static_cast<double>(picoseconds); };
  const double now = seconds(max_global(comm, load.total()));
  const double mean = seconds(sum_global(comm, load.total())) / comm.size();
  const GlobalIndex heaviest = load.size() > 0 ? *std::max_element(load.weight.begin(), load.weight.end()) : 0;
  const double reachable = std::max(target_imbalance * mean, seconds(max_global(comm, heaviest)));
  const double rebuild = max_global(comm, request.change.rebuild), particle = max_global(comm, request.change.particle);
  if (now - reachable < least_gain * now || (now - reachable) * *request.horizon <= rebuild) return proposal;

  std::vector<KeptCuts> ways{{}};
  if (old) ways = {{old, KeptCuts::usual_tolerance}, {old, KeptCuts::tight_tolerance}, {old, KeptCuts::no_tolerance}};
  std::optional<Candidate> best;
  double most = 0.0;  // saved over the horizon, less the cost, s
  for (const KeptCuts& way : ways) {
    Candidate candidate = tried(way);
    const double gain = now - seconds(candidate.largest_load);
    const double net = gain * *request.horizon - rebuild - particle * static_cast<double>(candidate.busiest_moves);
    if (net <= most || gain < least_gain * now) continue;
    most = net;
    best = std::move(candidate);
  }
  if (best) propose(std::move(*best));
  return proposal;
}

}  // namespace bulkley
