#include "parallel/gather.hpp"

#include <algorithm>
#include <cstring>

namespace bulkley::detail {

namespace {

constexpr int tag = 2;
constexpr std::size_t message_limit = std::size_t{1} << 30;  // bytes; an int counts them

}  // namespace

// A rank's number of the work comes first. Its bytes are messages of the largest size and, last, a smaller one; so nobody needs to be
// told how many there are.
void gather_bytes(const Comm& comm, const void* from, std::size_t size, const std::function<void*(std::size_t)>& room) {
  const char* at = static_cast<const char*>(from);
  const GlobalIndex number = comm.draw_number();
  if (!comm.is_root()) {
    BULKLEY_MPI(MPI_Send(&number, 1, MPI_INT64_T, 0, tag, comm.get()));
    for (std::size_t sent = message_limit; sent == message_limit; at += sent, size -= sent) {
      sent = std::min(message_limit, size);
      BULKLEY_MPI(MPI_Send(at, static_cast<int>(sent), MPI_BYTE, 0, tag, comm.get()));
    }
    return;
  }
  std::size_t total = size;
  if (size > 0) std::memcpy(room(size), at, size);
  for (int rank = 1; rank < comm.size(); ++rank) {
    GlobalIndex theirs = 0;
    BULKLEY_MPI(MPI_Recv(&theirs, 1, MPI_INT64_T, rank, tag, comm.get(), MPI_STATUS_IGNORE));
    expect_number(comm, joint_work, rank, theirs, number);
    for (int count = static_cast<int>(message_limit); count == static_cast<int>(message_limit);) {
      MPI_Status status;
      BULKLEY_MPI(MPI_Probe(rank, tag, comm.get(), &status));
      BULKLEY_MPI(MPI_Get_count(&status, MPI_BYTE, &count));
      char* to = static_cast<char*>(room(total + static_cast<std::size_t>(count))) + total;
      BULKLEY_MPI(MPI_Recv(to, count, MPI_BYTE, rank, tag, comm.get(), MPI_STATUS_IGNORE));
      total += static_cast<std::size_t>(count);
    }
  }
}

void broadcast_bytes(const Comm& comm, void* bytes, std::size_t size) {
  for (std::size_t begin = 0; begin < size; begin += message_limit)
    BULKLEY_MPI(MPI_Bcast(static_cast<char*>(bytes) + begin, static_cast<int>(std::min(message_limit, size - begin)),
                          MPI_BYTE, 0, comm.get()));
}

}  // namespace bulkley::detail
