#pragma once
// Two checkpoints compared by one process, particle by particle in the order of ids: what many ranks must say, too.

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "bulkley/particle/field.hpp"
#include "io/checkpoint/compare.hpp"
#include "support/io_particles.hpp"

namespace bulkley {

inline double value_of(const std::vector<std::uint8_t>& bytes, const FieldInfo& field, std::size_t at) {
  if (field.type == FieldType::uint8) return bytes[at];
  double value = 0.0;
  GlobalIndex integer = 0;
  std::memcpy(&value, bytes.data() + 8 * at, 8);
  std::memcpy(&integer, bytes.data() + 8 * at, 8);
  return field.type == FieldType::int64 ? static_cast<double>(integer) : value;
}

inline std::vector<std::uint8_t> bytes_of(const Hdf5Reader& file, const FieldInfo& field) {
  const ArrayInfo array = file.array(std::string("/particles/") + field.name);
  std::vector<std::uint8_t> bytes(static_cast<std::size_t>(n_elements(array.shape)) * element_size(array.type));
  file.read(array, Extents(array.shape.size(), 0), array.shape, bytes.data());
  return bytes;
}

inline std::map<GlobalIndex, std::size_t> rows_by_id(const Hdf5Reader& file) {
  std::map<GlobalIndex, std::size_t> rows;
  for (const GlobalIndex id : whole_array<GlobalIndex>(file, "/particles/id")) rows.emplace(id, rows.size());
  return rows;
}

inline FieldDifference serial_difference(const Hdf5Reader& file_a, const Hdf5Reader& file_b, const FieldInfo& field) {
  FieldDifference result;
  result.name = field.name;
  result.unit = field.unit;
  const std::vector<std::uint8_t> a = bytes_of(file_a, field), b = bytes_of(file_b, field);
  const std::map<GlobalIndex, std::size_t> rows_b = rows_by_id(file_b);
  const auto n = static_cast<std::size_t>(field.n_components), size = element_size(field.type);
  for (const auto& [id, row] : rows_by_id(file_a)) {
    if (!rows_b.contains(id)) continue;
    for (std::size_t c = 0; c < n; ++c) {
      const std::size_t i = row * n + c, j = rows_b.at(id) * n + c;
      const double x = value_of(a, field, i), y = value_of(b, field, j);
      result.scale = std::max({result.scale, std::abs(x), std::abs(y)});
      if (std::memcmp(a.data() + i * size, b.data() + j * size, size) == 0) continue;
      const double absolute = std::abs(x - y),
                   relative = absolute == 0.0 ? 0.0 : absolute / std::max(std::abs(x), std::abs(y));
      if (result.n_different == 0 || absolute > result.largest_absolute)
        result.absolute_id = id, result.largest_absolute = absolute;
      if (result.n_different == 0 || relative > result.largest_relative)
        result.relative_id = id, result.largest_relative = relative;
      ++result.n_different;
    }
  }
  return result;
}

inline void count_only(const Hdf5Reader& file, const Hdf5Reader& other, GlobalIndex& n, GlobalIndex& first) {
  const auto rows = rows_by_id(other);
  for (const auto& [id, row] : rows_by_id(file))
    if (!rows.contains(id) && n++ == 0) first = id;
}

/// Precondition: checksums are right and ids unique. Not collective.
inline Comparison serial_comparison(const std::string& file_a, const std::string& file_b) {
  const Hdf5Reader a(file_a), b(file_b);
  Comparison result;
  result.step_a = a.integer("/", "step"), result.step_b = b.integer("/", "step");
  result.time_a = a.real("/", "time"), result.time_b = b.real("/", "time");
  count_only(a, b, result.n_only_a, result.first_only_a);
  count_only(b, a, result.n_only_b, result.first_only_b);
  bool same = result.step_a == result.step_b && result.time_a == result.time_b && result.n_only_a + result.n_only_b == 0;
  for (const FieldInfo& field : field_table) {
    const bool in_a = a.has(std::string("/particles/") + field.name), in_b = b.has(std::string("/particles/") + field.name);
    if (in_a != in_b) result.only_in_one.emplace_back(field.name);
    if (in_a && in_b) result.fields.push_back(serial_difference(a, b, field));
    same = same && in_a == in_b && (!in_a || result.fields.back().n_different == 0);
  }
  result.identical = same;
  return result;
}

}  // namespace bulkley
