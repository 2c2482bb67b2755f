#include "io/checkpoint/fingerprint.hpp"

#include <algorithm>
#include <cstring>

#include "base/hash.hpp"
#include "io/arrays/particle_array.hpp"

namespace bulkley {

namespace {

// A constant size lets the compiler turn the copy into a move.
template <std::size_t size>
void add_values(std::uint64_t n_components, GlobalIndex n, const GlobalIndex* ids, const std::byte* rows, Fingerprint& sum) {
  for (GlobalIndex p = 0; p < n; ++p) {
    const std::uint64_t key = splitmix64(static_cast<std::uint64_t>(ids[p]));
    for (std::uint64_t c = 0; c < n_components; ++c, rows += size) {
      std::uint64_t bits = 0;
      std::memcpy(&bits, rows, size);
      const std::uint64_t hash = splitmix64(bits ^ (key * (2 * c + 1)));
      sum.first += hash;
      sum.second += splitmix64(hash);
    }
  }
}

}  // namespace

void add_rows(const FieldInfo& field, GlobalIndex n, const GlobalIndex* ids, const std::byte* rows, Fingerprint& sum) {
  const auto n_components = static_cast<std::uint64_t>(field.n_components);
  if (element_size(field.type) == 1)
    add_values<1>(n_components, n, ids, rows, sum);
  else
    add_values<8>(n_components, n, ids, rows, sum);
}

Fingerprint fingerprint_of(const ParticleSet& particles, const FieldInfo& field) {
  constexpr GlobalIndex rows_at_a_time = 1024;
  std::vector<std::byte> rows(static_cast<std::size_t>(rows_at_a_time * field.n_components) * element_size(field.type));
  Fingerprint sum;
  for (GlobalIndex first = 0; first < particles.size(); first += rows_at_a_time) {
    const GlobalIndex n = std::min<GlobalIndex>(rows_at_a_time, particles.size() - first);
    field_to_rows(particles, field, first, n, rows.data());
    add_rows(field, n, particles.id() + first, rows.data(), sum);
  }
  return sum;
}

void sum_global(const Comm& comm, std::vector<Fingerprint>& fingerprints) {
  static_assert(sizeof(Fingerprint) == 2 * sizeof(std::uint64_t));
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, fingerprints.data(), static_cast<int>(2 * fingerprints.size()), MPI_UINT64_T,
                            MPI_SUM, comm.get()));
}

}  // namespace bulkley
