#include "io/checkpoint/id_matching.hpp"

#include <algorithm>
#include <cstring>
#include <limits>
#include <numeric>

#include "base/hash.hpp"

namespace bulkley {

namespace {

constexpr GlobalIndex none = std::numeric_limits<GlobalIndex>::max();

std::size_t rounds_for(const Comm& comm, std::size_t n_a, std::size_t n_b, GlobalIndex particles_per_round) {
  return static_cast<std::size_t>(max_global(comm, static_cast<GlobalIndex>(n_a + n_b) / particles_per_round + 1));
}

/// An id and where it has come.
struct Slot {
  GlobalIndex id;
  LocalIndex slot;
};

std::vector<Slot> by_id(const std::vector<std::byte>& received) {
  std::vector<Slot> slots(received.size() / sizeof(GlobalIndex));
  for (std::size_t i = 0; i < slots.size(); ++i) {
    std::memcpy(&slots[i].id, received.data() + i * sizeof(GlobalIndex), sizeof(GlobalIndex));
    slots[i].slot = static_cast<LocalIndex>(i);
  }
  std::sort(slots.begin(), slots.end(), [](const Slot& a, const Slot& b) { return a.id < b.id; });
  return slots;
}

void note_twice(const std::vector<Slot>& slots, IdMatching::Rest& rest) {
  const auto found =
      std::adjacent_find(slots.begin(), slots.end(), [](const Slot& a, const Slot& b) { return a.id == b.id; });
  if (found != slots.end()) rest.twice = std::min(rest.twice, found->id);
}

void reduce(const Comm& comm, IdMatching::Rest& rest) {
  rest.n_only = sum_global(comm, rest.n_only);
  for (GlobalIndex* id : {&rest.first_only, &rest.twice}) {
    *id = min_global(comm, *id);
    if (*id == none) *id = -1;
  }
}

}  // namespace

IdRoutes::IdRoutes(const Comm& comm, const std::vector<GlobalIndex>& ids, std::size_t n_rounds)
    : n_ranks_(static_cast<std::size_t>(comm.size())), order_(ids.size()), begin_(n_rounds * n_ranks_ + 1, 0) {
  const auto place_of = [&](GlobalIndex row) {
    return static_cast<std::size_t>(splitmix64(static_cast<std::uint64_t>(ids[static_cast<std::size_t>(row)]))) %
           (begin_.size() - 1);
  };
  const auto n = static_cast<GlobalIndex>(ids.size());
  for (GlobalIndex row = 0; row < n; ++row) ++begin_[place_of(row) + 1];
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  std::vector<GlobalIndex> next(begin_.begin(), begin_.end() - 1);
  for (GlobalIndex row = 0; row < n; ++row) order_[static_cast<std::size_t>(next[place_of(row)]++)] = row;
}

std::vector<std::byte> IdRoutes::exchange(const Comm& comm, std::size_t round, const std::byte* rows,
                                          std::size_t row_bytes) const {
  std::vector<int> n_sent, sent_at, n_received(n_ranks_), received_at;
  const auto first = begin_.begin() + static_cast<std::ptrdiff_t>(round * n_ranks_);
  for (auto at = first; at != first + static_cast<std::ptrdiff_t>(n_ranks_); ++at) {
    n_sent.push_back(static_cast<int>(at[1] - at[0]));
    sent_at.push_back(static_cast<int>(at[0] - first[0]));
  }
  BULKLEY_MPI(MPI_Alltoall(n_sent.data(), 1, MPI_INT, n_received.data(), 1, MPI_INT, comm.get()));
  int n = 0;
  for (const int count : n_received) {
    received_at.push_back(n);
    n += count;
  }
  const GlobalIndex begin = first[0], end = first[static_cast<std::ptrdiff_t>(n_ranks_)];
  std::vector<std::byte> sent(static_cast<std::size_t>(end - begin) * row_bytes),
      received(static_cast<std::size_t>(n) * row_bytes);
  for (GlobalIndex i = begin; i < end; ++i)
    std::memcpy(sent.data() + static_cast<std::size_t>(i - begin) * row_bytes,
                rows + static_cast<std::size_t>(order_[static_cast<std::size_t>(i)]) * row_bytes, row_bytes);
  MPI_Datatype row = MPI_DATATYPE_NULL;
  BULKLEY_MPI(MPI_Type_contiguous(static_cast<int>(row_bytes), MPI_BYTE, &row));
  BULKLEY_MPI(MPI_Type_commit(&row));
  BULKLEY_MPI(MPI_Alltoallv(sent.data(), n_sent.data(), sent_at.data(), row, received.data(), n_received.data(),
                            received_at.data(), row, comm.get()));
  BULKLEY_MPI(MPI_Type_free(&row));
  return received;
}

IdMatching::IdMatching(const Comm& comm, const std::vector<GlobalIndex>& a, const std::vector<GlobalIndex>& b,
                       GlobalIndex particles_per_round)
    : matches_(rounds_for(comm, a.size(), b.size(), particles_per_round)),
      a_(comm, a, n_rounds()),
      b_(comm, b, n_rounds()),
      rest_a_{0, none, none},
      rest_b_{0, none, none} {
  for (std::size_t round = 0; round < n_rounds(); ++round) match(comm, round, a, b);
  reduce(comm, rest_a_);
  reduce(comm, rest_b_);
}

void IdMatching::match(const Comm& comm, std::size_t round, const std::vector<GlobalIndex>& ids_a,
                       const std::vector<GlobalIndex>& ids_b) {
  const auto met = [&](const IdRoutes& routes, const std::vector<GlobalIndex>& ids) {
    return by_id(routes.exchange(comm, round, reinterpret_cast<const std::byte*>(ids.data()), sizeof(GlobalIndex)));
  };
  const std::vector<Slot> a = met(a_, ids_a), b = met(b_, ids_b);
  note_twice(a, rest_a_);
  note_twice(b, rest_b_);
  const auto only = [](GlobalIndex id, Rest& rest) {
    ++rest.n_only;
    rest.first_only = std::min(rest.first_only, id);
  };
  std::size_t i = 0, j = 0;
  while (i < a.size() || j < b.size()) {
    if (j == b.size() || (i < a.size() && a[i].id < b[j].id)) {
      only(a[i++].id, rest_a_);
    } else if (i == a.size() || b[j].id < a[i].id) {
      only(b[j++].id, rest_b_);
    } else {
      matches_[round].push_back({a[i].id, a[i].slot, b[j].slot});
      ++i, ++j;
    }
  }
}

}  // namespace bulkley
