#include "bulkley/particle/particle_set.hpp"

#include <algorithm>
#include <cstring>
#include <new>
#include <string>
#include <utility>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {
constexpr std::size_t alignment = 64;
// Columns of equal size tend to start at the same place modulo the cache's set size; a different offset each avoids that.
constexpr std::size_t stagger = 5 * alignment;
}  // namespace

void ParticleSet::Free::operator()(std::byte* p) const { ::operator delete[](p, std::align_val_t{alignment}); }

ParticleSet::Buffer ParticleSet::allocate(std::size_t bytes) {
  return Buffer(static_cast<std::byte*>(::operator new[](bytes, std::align_val_t{alignment})));
}

ByMaterial::ByMaterial(std::span<const double> values) {
  BULKLEY_ASSERT(values.size() <= values_.size());
  std::ranges::copy(values, values_.begin());
  uniform_ = std::ranges::all_of(values, [&](double value) { return value == values_.front(); });
}

ParticleSet::ParticleSet(OptionalFields fields, const Densities& densities) : optional_(fields), densities_(densities) {
  for (const FieldInfo& f : field_table) {
    auto& first = first_column_[static_cast<std::size_t>(f.field)];
    first = -1;
    if (f.optional && !fields.contains(f.field)) continue;
    first = static_cast<int>(columns_.size());
    for (int c = 0; c < f.n_components; ++c) columns_.push_back({f.field, c, element_size(f.type), f.moves});
  }
  buffers_.resize(columns_.size());
  data_.resize(columns_.size(), nullptr);
  reserve(padding);
}

ParticleSet::~ParticleSet() = default;
ParticleSet::ParticleSet(ParticleSet&&) noexcept = default;
ParticleSet& ParticleSet::operator=(ParticleSet&&) noexcept = default;

bool ParticleSet::has(Field field) const { return first_column_[static_cast<std::size_t>(field)] >= 0; }

std::size_t ParticleSet::first_column(Field field) const {
  BULKLEY_ASSERT(has(field));
  return static_cast<std::size_t>(first_column_[static_cast<std::size_t>(field)]);
}

std::size_t ParticleSet::column_bytes(std::size_t column) const {
  const std::size_t rows = is_whole(column) ? static_cast<std::size_t>(capacity_) + padding : block_rows_;
  return rows * columns_[column].element_size + columns_.size() * stagger;
}

void ParticleSet::reserve(LocalIndex count) {
  if (count <= capacity_) return;
  capacity_ = count;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (!is_whole(c)) continue;
    Buffer fresh = allocate(column_bytes(c));
    std::byte* start = fresh.get() + c * stagger;
    const std::size_t used = static_cast<std::size_t>(size_) * columns_[c].element_size;
    if (used > 0) std::memcpy(start, data_[c], used);
    std::memset(start + used, 0, padding * columns_[c].element_size);
    buffers_[c] = std::move(fresh);
    data_[c] = start;
  }
  scratch_.reset();
  scratch_bytes_ = 0;
}

void ParticleSet::reserve_more(LocalIndex count) {
  if (count > capacity_) reserve(static_cast<LocalIndex>(std::min<GlobalIndex>(count + GlobalIndex{count} / 8, largest_size)));
}

void ParticleSet::hold_block(ParticleBlock block) {
  const std::size_t rows = static_cast<std::size_t>(block.end - block.begin) + padding;
  const bool grows = rows > block_rows_;
  if (grows) block_rows_ = rows;
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (columns_[c].moves) continue;
    if (grows) {
      buffers_[c] = allocate(column_bytes(c));
      std::memset(buffers_[c].get(), 0, column_bytes(c));
    }
    // Where the first particle of all would be: an address that is only ever used with an offset into the block.
    const auto start = reinterpret_cast<std::uintptr_t>(buffers_[c].get() + c * stagger);
    data_[c] = reinterpret_cast<std::byte*>(start - static_cast<std::size_t>(block.begin) * columns_[c].element_size);
  }
}

bool ParticleSet::holds_all(Field field) const { return is_whole(first_column(field)); }

LocalIndex ParticleSet::checked_size(GlobalIndex n_particles) {
  if (n_particles > largest_size)
    throw RunError(std::to_string(n_particles) + " particles are more than the " + std::to_string(largest_size) +
                   " that one rank can number; use more ranks");
  return static_cast<LocalIndex>(n_particles);
}

void ParticleSet::resize(LocalIndex new_size) {
  reserve_more(new_size);
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (!is_whole(c)) continue;
    const std::size_t element = columns_[c].element_size;
    const LocalIndex from = std::min(size_, new_size);
    const LocalIndex to = std::max(size_, new_size) + padding;
    std::memset(data_[c] + static_cast<std::size_t>(from) * element, 0, static_cast<std::size_t>(to - from) * element);
  }
  size_ = new_size;
}

double* ParticleSet::real(Field field, int component) {
  BULKLEY_ASSERT(info(field).type == FieldType::real && component < info(field).n_components);
  return reinterpret_cast<double*>(data_[first_column(field) + static_cast<std::size_t>(component)]);
}
const double* ParticleSet::real(Field field, int component) const {
  return const_cast<ParticleSet*>(this)->real(field, component);
}
std::uint8_t* ParticleSet::material() { return reinterpret_cast<std::uint8_t*>(data_[first_column(Field::material)]); }
const std::uint8_t* ParticleSet::material() const { return const_cast<ParticleSet*>(this)->material(); }
GlobalIndex* ParticleSet::id() { return reinterpret_cast<GlobalIndex*>(data_[first_column(Field::id)]); }
const GlobalIndex* ParticleSet::id() const { return const_cast<ParticleSet*>(this)->id(); }

Vec3 ParticleSet::vector(Field field, LocalIndex p) const {
  return {real(field, 0)[p], real(field, 1)[p], real(field, 2)[p]};
}
void ParticleSet::set_vector(Field field, LocalIndex p, const Vec3& value) {
  for (int a = 0; a < 3; ++a) real(field, a)[p] = value[a];
}

void ParticleSet::reorder(std::span<const LocalIndex> order) {
  BULKLEY_ASSERT(order.size() == static_cast<std::size_t>(size_));
  const std::size_t n = order.size();
  // The scratch buffer is swapped with each column in turn; one-byte columns are copied back instead, being smaller.
  const std::size_t needed = (static_cast<std::size_t>(capacity_) + padding) * sizeof(double) + columns_.size() * stagger;
  if (scratch_bytes_ < needed) {
    scratch_ = allocate(needed);
    scratch_bytes_ = needed;
  }
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (!columns_[c].moves) continue;
    if (columns_[c].element_size == 1) {
      const std::byte* from = data_[c];
      std::byte* to = scratch_.get();
      for (std::size_t k = 0; k < n; ++k) to[k] = from[order[k]];
      std::memcpy(data_[c], to, n);
    } else {
      const auto* from = reinterpret_cast<const std::int64_t*>(data_[c]);
      std::byte* start = scratch_.get() + c * stagger;
      auto* to = reinterpret_cast<std::int64_t*>(start);
      for (std::size_t k = 0; k < n; ++k) to[k] = from[order[k]];
      std::memset(to + n, 0, padding * sizeof(std::int64_t));
      std::swap(buffers_[c], scratch_);
      data_[c] = start;
    }
  }
}

void ParticleSet::remove(std::span<const LocalIndex> gone) {
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (!is_whole(c)) continue;
    const std::size_t element = columns_[c].element_size;
    fill_gaps(gone, size_, [&](LocalIndex to, LocalIndex from) {
      std::memcpy(data_[c] + static_cast<std::size_t>(to) * element, data_[c] + static_cast<std::size_t>(from) * element,
                  element);
    });
  }
  resize(size_ - static_cast<LocalIndex>(gone.size()));
}

ParticleSet ParticleSet::selected(std::span<const LocalIndex> chosen) const {
  ParticleSet copy(optional_, densities_);
  copy.resize(static_cast<LocalIndex>(chosen.size()));
  for (std::size_t c = 0; c < columns_.size(); ++c) {
    if (!is_whole(c)) continue;
    const std::size_t element = columns_[c].element_size;
    for (std::size_t k = 0; k < chosen.size(); ++k)
      std::memcpy(copy.data_[c] + k * element, data_[c] + static_cast<std::size_t>(chosen[k]) * element, element);
  }
  return copy;
}

std::size_t ParticleSet::memory() const {
  std::size_t total = scratch_bytes_;
  for (std::size_t c = 0; c < columns_.size(); ++c) total += column_bytes(c);
  return total;
}

std::size_t ParticleSet::bytes_per_particle() const {
  std::size_t total = 0;
  for (const Column& c : columns_)
    if (c.moves) total += c.element_size;
  return total;
}

}  // namespace bulkley
