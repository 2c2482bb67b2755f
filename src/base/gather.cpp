#include "bulkley/base/gather.hpp"

#include <algorithm>

namespace bulkley::detail {

namespace {

constexpr int tag = 2;
constexpr std::size_t message_limit = std::size_t{1} << 30;  // bytes; an int counts them

// Calls visit(begin, size) for the messages that `size` bytes make.
template <class Visit>
void for_each_message(std::size_t size, Visit visit) {
  for (std::size_t begin = 0; begin < size; begin += message_limit)
    visit(begin, static_cast<int>(std::min(message_limit, size - begin)));
}

}  // namespace

std::vector<GlobalIndex> gather_sizes(const Comm& comm, std::size_t size) {
  const auto mine = static_cast<GlobalIndex>(size);
  std::vector<GlobalIndex> sizes(comm.is_root() ? static_cast<std::size_t>(comm.size()) : 0);
  BULKLEY_MPI(MPI_Gather(&mine, 1, MPI_INT64_T, sizes.data(), 1, MPI_INT64_T, 0, comm.get()));
  return sizes;
}

void gather_bytes(const Comm& comm, const void* from, std::size_t size, void* to, const std::vector<GlobalIndex>& sizes) {
  if (!comm.is_root()) {
    for_each_message(size, [&](std::size_t begin, int count) {
      BULKLEY_MPI(MPI_Send(static_cast<const char*>(from) + begin, count, MPI_BYTE, 0, tag, comm.get()));
    });
    return;
  }
  auto* at = static_cast<char*>(to);
  std::copy_n(static_cast<const char*>(from), size, at);
  at += size;
  std::vector<MPI_Request> requests;
  for (int rank = 1; rank < comm.size(); ++rank) {
    const auto bytes = static_cast<std::size_t>(sizes[static_cast<std::size_t>(rank)]);
    for_each_message(bytes, [&](std::size_t begin, int count) {
      BULKLEY_MPI(MPI_Irecv(at + begin, count, MPI_BYTE, rank, tag, comm.get(), &requests.emplace_back()));
    });
    at += bytes;
  }
  BULKLEY_MPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
}

void broadcast_bytes(const Comm& comm, void* bytes, std::size_t size) {
  for_each_message(size, [&](std::size_t begin, int count) {
    BULKLEY_MPI(MPI_Bcast(static_cast<char*>(bytes) + begin, count, MPI_BYTE, 0, comm.get()));
  });
}

}  // namespace bulkley::detail
