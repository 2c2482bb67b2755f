#include "rebalance/root_partitioner.hpp"

#include "balance/traffic.hpp"
#include "rebalance/share.hpp"

namespace bulkley {

PartitionProposal RootPartitioner::find(const Comm& comm, const PartitionRequest& request) {
  const TileCensus census = gather_census(comm, request.census);
  PartitionProposal proposal;
  root_guard(comm, [&] { proposal = find_on_root(request, census, comm.size()); });
  std::array<GlobalIndex, 2> head{proposal.partition.has_value() ? 1 : 0, proposal.busiest_moves};
  BULKLEY_MPI(MPI_Bcast(head.data(), 2, MPI_INT64_T, 0, comm.get()));
  proposal.busiest_moves = head[1];
  if (head[0] != 0)
    proposal.partition = share_partition(comm, proposal.partition ? std::move(*proposal.partition) : Partition{});
  return proposal;
}

PartitionProposal RootPartitioner::find_on_root(const PartitionRequest& request, const TileCensus& census, int n_ranks) {
  const GridGeometry& grid = request.grid;
  const TileLoad load = tile_load(census, request.cost);
  const Partition* const present = request.present;
  PartitionProposal proposal;
  std::optional<Partition>& next = proposal.partition;
  if (!present || !request.horizon) {
    next = make_partition(grid, settings_, load, n_ranks, present, request.cost, &proposal.notes);
    if (present && next->map == present->map && next->boxes == present->boxes) next.reset();
  } else {
    const auto exchange_of = [&](const Partition& p) {
      return predicted_exchange(predict_traffic(grid, p.map, load), request.cost);
    };
    if (fresh_exchange_ < 0.0) fresh_exchange_ = exchange_of(*present);
    Change found = worthwhile_change(grid, load, *present, request.cost, request.change, *request.horizon, fresh_exchange_,
                                     settings_.ranks_per_node);
    proposal.tile_seconds = load.size() > 0 ? found.making / static_cast<double>(load.size()) : 0.0;
    next = std::move(found.partition);
    if (next && found.whole) fresh_exchange_ = exchange_of(*next);
  }
  if (present && next) proposal.busiest_moves = busiest_moves(present->map, next->map, load);
  return proposal;
}

}  // namespace bulkley
