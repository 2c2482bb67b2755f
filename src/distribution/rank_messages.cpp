#include "distribution/rank_messages.hpp"

#include <algorithm>
#include <thread>

#include "distribution/message_tags.hpp"

namespace bulkley {

namespace {

// Takes in the messages that have arrived.
void receive(const Comm& comm, std::vector<RankMessage>& received) {
  for (;;) {
    int there = 0, size = 0;
    MPI_Message handle;
    MPI_Status status;
    BULKLEY_MPI(MPI_Improbe(MPI_ANY_SOURCE, message_tag::unasked, comm.get(), &there, &handle, &status));
    if (!there) return;
    BULKLEY_MPI(MPI_Get_count(&status, MPI_INT64_T, &size));
    RankMessage& message = received.emplace_back(RankMessage{status.MPI_SOURCE, {}});
    message.words.resize(static_cast<std::size_t>(size));
    BULKLEY_MPI(MPI_Mrecv(message.words.data(), size, MPI_INT64_T, &handle, MPI_STATUS_IGNORE));
  }
}

}  // namespace

// A synchronous send ends when it is received, and the barrier ends when all of them have. A second one keeps a rank that is ahead
// from sending the messages of its next call to one that still receives those of this.
std::vector<RankMessage> sparse_exchange(const Comm& comm, const std::vector<RankMessage>& sent) {
  std::vector<MPI_Request> requests;
  for (const RankMessage& message : sent)
    BULKLEY_MPI(MPI_Issend(message.words.data(), static_cast<int>(message.words.size()), MPI_INT64_T, message.rank,
                           message_tag::unasked, comm.get(), &requests.emplace_back()));
  std::vector<RankMessage> received;
  MPI_Request barrier = MPI_REQUEST_NULL;
  for (bool in_barrier = false;;) {
    receive(comm, received);
    int done = 0;
    if (in_barrier) {
      BULKLEY_MPI(MPI_Test(&barrier, &done, MPI_STATUS_IGNORE));
      if (done) break;
    } else {
      BULKLEY_MPI(MPI_Testall(static_cast<int>(requests.size()), requests.data(), &done, MPI_STATUSES_IGNORE));
      if (done) {
        BULKLEY_MPI(MPI_Ibarrier(comm.get(), &barrier));
        in_barrier = true;
      }
    }
    if (!done) std::this_thread::yield();
  }
  BULKLEY_MPI(MPI_Barrier(comm.get()));
  std::sort(received.begin(), received.end(), [](const RankMessage& a, const RankMessage& b) { return a.rank < b.rank; });
  return received;
}

void exchange_messages(const Comm& comm, int tag, const std::vector<RankMessage>& sent, std::vector<RankMessage>& received) {
  std::vector<MPI_Request> requests;
  for (RankMessage& message : received)
    BULKLEY_MPI(MPI_Irecv(message.words.data(), static_cast<int>(message.words.size()), MPI_INT64_T, message.rank, tag,
                          comm.get(), &requests.emplace_back()));
  for (const RankMessage& message : sent)
    BULKLEY_MPI(MPI_Isend(message.words.data(), static_cast<int>(message.words.size()), MPI_INT64_T, message.rank, tag,
                          comm.get(), &requests.emplace_back()));
  BULKLEY_MPI(MPI_Waitall(static_cast<int>(requests.size()), requests.data(), MPI_STATUSES_IGNORE));
}

}  // namespace bulkley
