#include "io/checkpoint/particle_check.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include <fmt/format.h>

#include "base/hash.hpp"

namespace bulkley {

namespace {

template <class Number>
Number value_at(const std::byte* rows, GlobalIndex element) {
  Number value;
  std::memcpy(&value, rows + static_cast<std::size_t>(element) * sizeof value, sizeof value);
  return value;
}

bool must_be_positive(Field field) {
  return field == Field::reference_volume || field == Field::volume_ratio;
}

constexpr GlobalIndex ids_per_round = GlobalIndex{1} << 22;  // 32 MiB per rank, for any number of particles

/// Spreads ids evenly over `n` places, for any pattern.
std::size_t place_of(GlobalIndex id, std::size_t n) {
  return static_cast<std::size_t>(splitmix64(static_cast<std::uint64_t>(id))) % n;
}

std::string twice(const std::string& what, std::vector<GlobalIndex>& ids) {
  std::sort(ids.begin(), ids.end());
  const auto found = std::adjacent_find(ids.begin(), ids.end());
  if (found == ids.end()) return {};
  return fmt::format("{}: the particle id {} occurs twice", what, *found);
}

/// The ids of all ranks that this rank compares: those that were sent to it.
std::vector<GlobalIndex> exchange_ids(const Comm& comm, const std::vector<std::vector<GlobalIndex>>& to_rank) {
  const auto n_ranks = static_cast<std::size_t>(comm.size());
  std::vector<int> n_sent, sent_at, n_received(n_ranks), received_at;
  std::vector<GlobalIndex> sent;
  for (const std::vector<GlobalIndex>& ids : to_rank) {
    sent_at.push_back(static_cast<int>(sent.size()));
    n_sent.push_back(static_cast<int>(ids.size()));
    sent.insert(sent.end(), ids.begin(), ids.end());
  }
  BULKLEY_MPI(MPI_Alltoall(n_sent.data(), 1, MPI_INT, n_received.data(), 1, MPI_INT, comm.get()));
  int n = 0;
  for (const int count : n_received) {
    received_at.push_back(n);
    n += count;
  }
  std::vector<GlobalIndex> received(static_cast<std::size_t>(n));
  BULKLEY_MPI(MPI_Alltoallv(sent.data(), n_sent.data(), sent_at.data(), MPI_INT64_T, received.data(), n_received.data(),
                            received_at.data(), MPI_INT64_T, comm.get()));
  return received;
}

}  // namespace

/// Equal ids meet on one rank in one round. A rank's own are compared first: after that no id comes more than once from a
/// rank, so that the hash distributes them evenly even if the file is wrong.
void expect_unique(const Comm& comm, const std::string& what, const std::vector<GlobalIndex>& ids) {
  const auto fewest_rounds = static_cast<GlobalIndex>(ids.size()) / ids_per_round + 1;
  const auto n_rounds = static_cast<std::size_t>(max_global(comm, fewest_rounds));
  const auto n_ranks = static_cast<std::size_t>(comm.size());
  for (std::size_t round = 0; round < n_rounds; ++round) {
    std::vector<std::vector<GlobalIndex>> to_rank(n_ranks);
    std::string fault;
    collective_guard(comm, [&] {
      for (const GlobalIndex id : ids) {
        const std::size_t place = place_of(id, n_rounds * n_ranks);
        if (place / n_ranks == round) to_rank[place % n_ranks].push_back(id);
      }
      for (std::vector<GlobalIndex>& part : to_rank)
        if (fault = twice(what, part); !fault.empty()) throw RunError(fault);
    });
    std::vector<GlobalIndex> received = exchange_ids(comm, to_rank);
    collective_guard(comm, [&] {
      if (fault = twice(what, received); !fault.empty()) throw RunError(fault);
    });
  }
}

void ParticleCheck::refuse(const FieldInfo& field, GlobalIndex particle, const std::string& fault) {
  if (fault_.empty()) fault_ = fmt::format("{}: {} of the particle in row {} is {}", what_, field.name, particle, fault);
}

void ParticleCheck::look_at(const FieldInfo& field, GlobalIndex first, GlobalIndex n, const std::byte* rows) {
  const GlobalIndex n_values = n * field.n_components;
  const auto particle = [&](GlobalIndex value) { return first + value / field.n_components; };
  for (GlobalIndex v = 0; v < n_values && fault_.empty(); ++v) {
    if (field.type == FieldType::uint8) {
      const auto index = static_cast<std::size_t>(rows[v]);
      if (field.field == Field::material && index >= n_materials_)
        refuse(field, particle(v), fmt::format("{}, and the file has {} materials", index, n_materials_));
    } else if (field.type == FieldType::int64) {
      const auto id = value_at<GlobalIndex>(rows, v);
      if (id < 0) refuse(field, particle(v), fmt::format("{} and must not be negative", id));
    } else {
      const auto value = value_at<double>(rows, v);
      if (!std::isfinite(value))
        refuse(field, particle(v), fmt::format("{}, not a finite number", value));
      else if (must_be_positive(field.field) && value <= 0.0)
        refuse(field, particle(v), fmt::format("{} and must be greater than 0", value));
    }
  }
}

void ParticleCheck::throw_if_seen() const {
  if (!fault_.empty()) throw RunError(fault_);
}

}  // namespace bulkley
