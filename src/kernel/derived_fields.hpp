#pragma once
// What frames can hold in addition to the stored fields: quantities that follow from those of one particle.

#include <cstdint>
#include <span>

#include "bulkley/particle/particle_set.hpp"
#include "kernel/particle_stress.hpp"

namespace bulkley {

/// A row of the table: what an output of this name holds for one particle.
struct DerivedField {
  /// Where the particle is.
  struct Place {
    const ParticleSet& particles;
    const StressOfState& stress;  ///< unless they store it
    LocalIndex p;
    std::int32_t rank;  ///< that holds it
  };
  static constexpr int most_components = 9;

  const char* name;
  const char* unit;
  const char* meaning;
  int n_components;
  bool is_integer;                                 ///< written as int32, else as the real numbers of the frame
  void (*evaluate)(const Place& at, double* out);  ///< n_components numbers
};

/// The table, in the order in which names are listed. A new field is a row with its function. Not collective.
std::span<const DerivedField> derived_fields();

}  // namespace bulkley
