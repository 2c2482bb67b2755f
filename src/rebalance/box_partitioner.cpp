#include "rebalance/box_partitioner.hpp"

#include "rebalance/merged_census.hpp"

namespace bulkley {

namespace {

/// Of all ranks of a communicator.
class AllRanks final : public RegionSums {
 public:
  explicit AllRanks(const Comm& comm) : comm_(comm) {}
  void combine(std::span<GlobalIndex> values, std::size_t n_added) override {
    const auto reduce = [this](std::span<GlobalIndex> part, MPI_Op operation) {
      if (part.empty()) return;
      BULKLEY_MPI(
          MPI_Allreduce(MPI_IN_PLACE, part.data(), static_cast<int>(part.size()), MPI_INT64_T, operation, comm_.get()));
    };
    reduce(values.first(n_added), MPI_SUM);
    reduce(values.subspan(n_added), MPI_MIN);
  }

 private:
  const Comm& comm_;
};

}  // namespace

PartitionProposal BoxPartitioner::find(const Comm& comm, const PartitionRequest& request) {
  const TileMap* const present = request.present ? &request.present->map : nullptr;
  TileLoad load;
  if (!uniform_) {
    SentMessages sent;
    load = tile_load(merged_census(comm, request.census, owners_or_hash(present, comm.size()), sent), request.cost);
  }
  AllRanks sums(comm);
  PartitionProposal proposal;
  proposal.notes.method = uniform_ ? PartitionMethod::uniform : PartitionMethod::ranges;
  Partition next = partition_of_boxes(request.grid, uniform_, load, comm.size(), sums);
  if (!present || next.boxes != request.present->boxes || !(next.map == *present)) proposal.partition = std::move(next);
  return proposal;
}

}  // namespace bulkley
