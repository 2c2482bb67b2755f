#include "distribution/neighbours.hpp"

#include <algorithm>
#include <iterator>
#include <thread>

#include "distribution/message_tags.hpp"

namespace bulkley {

namespace {

// Takes in the introductions that have arrived.
void receive_introductions(const Comm& comm, std::vector<int>& from) {
  for (;;) {
    int there = 0;
    MPI_Status status;
    BULKLEY_MPI(MPI_Iprobe(MPI_ANY_SOURCE, message_tag::introductions, comm.get(), &there, &status));
    if (!there) return;
    BULKLEY_MPI(
        MPI_Recv(nullptr, 0, MPI_BYTE, status.MPI_SOURCE, message_tag::introductions, comm.get(), MPI_STATUS_IGNORE));
    from.push_back(status.MPI_SOURCE);
  }
}

}  // namespace

bool Neighbours::has(int rank) const { return std::binary_search(ranks_.begin(), ranks_.end(), rank); }

// A synchronous send ends when it is received, and the barrier ends when all of them have. A second one keeps a rank that is ahead
// from sending the introductions of its next call to one that still receives those of this.
void Neighbours::introduce(std::span<const int> others) {
  std::vector<int> found(others.begin(), others.end());
  std::erase_if(found, [&](int rank) { return rank == comm_->rank() || has(rank); });
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  std::vector<MPI_Request> sent;
  for (const int rank : found)
    BULKLEY_MPI(MPI_Issend(nullptr, 0, MPI_BYTE, rank, message_tag::introductions, comm_->get(), &sent.emplace_back()));
  MPI_Request barrier = MPI_REQUEST_NULL;
  for (bool in_barrier = false;;) {
    receive_introductions(*comm_, found);
    int done = 0;
    if (in_barrier) {
      BULKLEY_MPI(MPI_Test(&barrier, &done, MPI_STATUS_IGNORE));
      if (done) break;
    } else {
      BULKLEY_MPI(MPI_Testall(static_cast<int>(sent.size()), sent.data(), &done, MPI_STATUSES_IGNORE));
      if (done) {
        BULKLEY_MPI(MPI_Ibarrier(comm_->get(), &barrier));
        in_barrier = true;
      }
    }
    if (!done) std::this_thread::yield();
  }
  BULKLEY_MPI(MPI_Barrier(comm_->get()));
  ranks_.insert(ranks_.end(), found.begin(), found.end());
  std::sort(ranks_.begin(), ranks_.end());
  ranks_.erase(std::unique(ranks_.begin(), ranks_.end()), ranks_.end());
}

void Neighbours::forget() {
  ranks_.clear();
  ++generation_;
}

}  // namespace bulkley
