#include "io/arrays/particle_array.hpp"

#include <cstring>
#include <limits>
#include <numeric>

namespace bulkley {

namespace {

std::size_t first_column(const ParticleSet& particles, Field field) {
  std::size_t column = 0;
  while (particles.columns()[column].field != field) ++column;
  return column;
}

// A constant size lets the compiler turn the copies into moves.
template <std::size_t size>
void copy_strided(const std::byte* from, std::size_t from_stride, std::byte* to, std::size_t to_stride, GlobalIndex n) {
  for (std::size_t p = 0; p < static_cast<std::size_t>(n); ++p)
    std::memcpy(to + p * to_stride, from + p * from_stride, size);
}
void copy_strided(std::size_t size, const std::byte* from, std::size_t from_stride, std::byte* to, std::size_t to_stride,
                  GlobalIndex n) {
  if (size == 1)
    copy_strided<1>(from, from_stride, to, to_stride, n);
  else
    copy_strided<8>(from, from_stride, to, to_stride, n);
}

}  // namespace

ParticleRange particle_range(const Comm& comm, const ParticleSet& particles) {
  const GlobalIndex count = particles.size();
  return {exclusive_sum(comm, count), count, sum_global(comm, count)};
}

Extents row_shape(int n_components) {
  if (n_components == 1) return {};
  if (n_components == 9) return {3, 3};
  return {n_components};
}

ArrayType stored_type(FieldType type) {
  switch (type) {
    case FieldType::uint8:
      return ArrayType::uint8;
    case FieldType::int64:
      return ArrayType::int64;
    case FieldType::real:
      break;
  }
  return ArrayType::float64;
}

Array particle_array(const std::string& name, ArrayType type, int n_components, const ParticleRange& range) {
  Array array;
  array.path = "/particles/" + name;
  array.type = type;
  const Extents row = row_shape(n_components);
  array.shape = {range.total};
  array.start = {range.first};
  array.count = {range.count};
  for (const GlobalIndex extent : row) {
    array.shape.push_back(extent);
    array.start.push_back(0);
    array.count.push_back(extent);
  }
  return array;
}

void field_to_rows(const ParticleSet& particles, const FieldInfo& field, GlobalIndex first, GlobalIndex n, std::byte* rows) {
  const std::size_t column = first_column(particles, field.field);
  const std::size_t size = element_size(field.type), row = size * static_cast<std::size_t>(field.n_components);
  for (std::size_t c = 0; c < static_cast<std::size_t>(field.n_components); ++c)
    copy_strided(size, particles.data(column + c) + static_cast<std::size_t>(first) * size, size, rows + c * size, row, n);
}

void rows_to_field(const std::byte* rows, const FieldInfo& field, GlobalIndex first, GlobalIndex n, ParticleSet& particles) {
  const std::size_t column = first_column(particles, field.field);
  const std::size_t size = element_size(field.type), row = size * static_cast<std::size_t>(field.n_components);
  for (std::size_t c = 0; c < static_cast<std::size_t>(field.n_components); ++c)
    copy_strided(size, rows + c * size, row, particles.data(column + c) + static_cast<std::size_t>(first) * size, size, n);
}

Array connectivity_array(const ParticleRange& range) {
  const bool small = range.total <= std::numeric_limits<std::int32_t>::max();
  Array array = particle_array("connectivity", small ? ArrayType::int32 : ArrayType::int64, 1, range);
  array.unit = "1";
  array.meaning = "0 .. N-1, for viewers";
  array.fill = [start = range.first, small](GlobalIndex first, GlobalIndex n, std::byte* out) {
    if (small)
      std::iota(reinterpret_cast<std::int32_t*>(out), reinterpret_cast<std::int32_t*>(out) + n,
                static_cast<std::int32_t>(start + first));
    else
      std::iota(reinterpret_cast<GlobalIndex*>(out), reinterpret_cast<GlobalIndex*>(out) + n, start + first);
  };
  return array;
}

}  // namespace bulkley
