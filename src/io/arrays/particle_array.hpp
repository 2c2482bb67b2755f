#pragma once
// Particle fields as rows of a file's arrays.

#include <string>

#include "bulkley/particle/particle_set.hpp"
#include "io/arrays/array_file.hpp"

namespace bulkley {

/// This rank's place among all particles, which are stored in rank order.
struct ParticleRange {
  GlobalIndex first = 0;
  GlobalIndex count = 0;
  GlobalIndex total = 0;
};
/// Collective.
ParticleRange particle_range(const Comm& comm, const ParticleSet& particles);

/// Extents of a row: () for 1 component, (3,3) for 9, else (n).
Extents row_shape(int n_components);
ArrayType stored_type(FieldType type);

/// An array of `range.total` rows under /particles.
Array particle_array(const std::string& name, ArrayType type, int n_components, const ParticleRange& range);

/// Copies rows [first, first + n) of a field between its columns and rows in memory, component fastest.
void field_to_rows(const ParticleSet& particles, const FieldInfo& field, GlobalIndex first, GlobalIndex n, std::byte* rows);
void rows_to_field(const std::byte* rows, const FieldInfo& field, GlobalIndex first, GlobalIndex n, ParticleSet& particles);

/// 0, 1, 2, ...: the connectivity that ParaView needs to draw particles, in the smallest type that holds it.
Array connectivity_array(const ParticleRange& range);

}  // namespace bulkley
