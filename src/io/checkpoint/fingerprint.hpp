#pragma once
// Do two lists of particles hold the same, whatever their order and the ranks that they are on?

#include <cstdint>
#include <vector>

#include "bulkley/parallel/comm.hpp"
#include "bulkley/particle/particle_set.hpp"

namespace bulkley {

/// Of a field of all particles: two sums modulo 2^64, over particles and components, of hashes of id, component and the bits of
/// the value. Different lists of (id, value) have the same fingerprint with a probability of 2^-128. That of the field id itself
/// is one of the set of ids. Its values are in files: they do not change.
struct Fingerprint {
  std::uint64_t first = 0, second = 0;
  bool operator==(const Fingerprint&) const = default;
};

/// Adds `n` rows of a field, those of the particles `ids`. Not collective.
void add_rows(const FieldInfo& field, GlobalIndex n, const GlobalIndex* ids, const std::byte* rows, Fingerprint& sum);

/// Of this rank's particles. Precondition: they have the field. Not collective.
Fingerprint fingerprint_of(const ParticleSet& particles, const FieldInfo& field);

/// The ranks' sums added up, on every rank: one reduction. Collective.
void sum_global(const Comm& comm, std::vector<Fingerprint>& fingerprints);

}  // namespace bulkley
