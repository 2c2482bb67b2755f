#include "parallel/node_layout.hpp"

namespace bulkley {

NodeLayout node_layout(const Comm& comm) {
  MPI_Comm node = MPI_COMM_NULL;
  BULKLEY_MPI(MPI_Comm_split_type(comm.get(), MPI_COMM_TYPE_SHARED, comm.rank(), MPI_INFO_NULL, &node));
  int size = 0;
  BULKLEY_MPI(MPI_Comm_size(node, &size));
  int ends[2] = {comm.rank(), -comm.rank()};  // the first rank there and, negative, the last one
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, ends, 2, MPI_INT, MPI_MIN, node));
  BULKLEY_MPI(MPI_Comm_free(&node));
  const int first = ends[0], last = -ends[1];
  const auto largest = static_cast<int>(max_global(comm, GlobalIndex{size}));
  const bool in_order = min_global(comm, GlobalIndex{last - first + 1 == size}) == 1;
  const bool alike = min_global(comm, GlobalIndex{first % largest == 0}) == 1;  // all but the last node have as many
  return {in_order && alike ? largest : 1, in_order};
}

std::string placement_fault(const NodeLayout& layout) {
  if (layout.in_order) return {};
  return "ranks that follow each other are on different nodes, so that most of what neighbours exchange leaves its node; "
         "place ranks in blocks (mpirun --map-by slot, srun --distribution=block)";
}

}  // namespace bulkley
