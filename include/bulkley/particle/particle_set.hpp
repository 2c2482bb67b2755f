#pragma once
// The particles of one rank: structure of arrays, described by one field table.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <memory>
#include <span>
#include <vector>

#include "bulkley/base/types.hpp"
#include "bulkley/particle/field.hpp"

namespace bulkley {

/// Fields in addition to those that every particle has.
class OptionalFields {
 public:
  constexpr OptionalFields() = default;
  constexpr OptionalFields(std::initializer_list<Field> fields) {
    for (const Field field : fields) insert(field);
  }
  constexpr void insert(Field field) { bits_ |= bit(field); }
  constexpr bool contains(Field field) const { return (bits_ & bit(field)) != 0; }
  bool operator==(const OptionalFields&) const = default;

 private:
  static constexpr std::uint64_t bit(Field field) { return std::uint64_t{1} << static_cast<int>(field); }
  std::uint64_t bits_ = 0;
};
static_assert(field_table.size() <= 64);

/// Particles begin .. end - 1, or all from `begin` on if there are fewer. Kernels that write particles write whole packs:
/// for them `end` is a multiple of ParticleSet::padding above `begin`, or beyond the last particle.
struct ParticleBlock {
  LocalIndex begin = 0;
  LocalIndex end = std::numeric_limits<LocalIndex>::max();
};

/// Calls move(to, from) for each survivor that fills a gap when the elements `gone` (ascending, each once) of `size`
/// elements are removed: the last ones fill the gaps, in order.
template <class Index, class Move>
void fill_gaps(std::span<const Index> gone, Index size, Move move) {
  const Index remaining = size - static_cast<Index>(gone.size());
  auto gap = gone.begin();
  auto next_gone = std::lower_bound(gone.begin(), gone.end(), remaining);
  for (Index from = remaining; from < size; ++from) {
    if (next_gone != gone.end() && *next_gone == from)
      ++next_gone;
    else
      move(*gap++, from);
  }
}

/// A number for each material, by the material's own. Not collective.
class ByMaterial {
 public:
  /// Zero for all.
  ByMaterial() = default;
  /// Those of at most 256 materials; zero for numbers beyond.
  explicit ByMaterial(std::span<const double> values);

  double operator[](std::uint8_t material) const { return values_[material]; }
  /// For any number that a material may have.
  const double* data() const { return values_.data(); }
  /// Whether all materials that there are have that of the first.
  bool uniform() const { return uniform_; }
  bool operator==(const ByMaterial&) const = default;

 private:
  std::array<double, std::numeric_limits<std::uint8_t>::max() + 1> values_{};
  bool uniform_ = true;
};

/// Of materials, kg/m^3: what gives particles of a reference volume their mass.
using Densities = ByMaterial;

/// The particles of one rank. Each component of each field is a contiguous array ("column") of `size()` elements, 64-byte
/// aligned, followed by at least `padding` readable elements so that vector code may run over the end.
/// Not collective.
class ParticleSet {
 public:
  static constexpr LocalIndex padding = 64;
  /// Loops over packs, batches and blocks count on a little beyond the last particle.
  static constexpr LocalIndex largest_size = std::numeric_limits<LocalIndex>::max() - (1 << 16);
  /// A number of particles that one rank is to hold, as its size. Throws RunError if it is more than largest_size.
  static LocalIndex checked_size(GlobalIndex n_particles);

  /// One component of one field.
  struct Column {
    Field field;
    int component;
    std::size_t element_size;
    bool moves;
  };

  /// Asking for an optional field that is not among `fields` is a bug.
  explicit ParticleSet(OptionalFields fields = {}, const Densities& densities = {});
  ~ParticleSet();
  ParticleSet(ParticleSet&&) noexcept;
  ParticleSet& operator=(ParticleSet&&) noexcept;

  LocalIndex size() const { return size_; }
  LocalIndex capacity() const { return capacity_; }
  bool has(Field field) const;
  /// The optional fields that this set has.
  OptionalFields optional_fields() const { return optional_; }
  const Densities& densities() const { return densities_; }

  /// Keeps the first min(old, new) particles; new ones are zero.
  void resize(LocalIndex new_size);
  /// Room for `count` particles without another allocation.
  void reserve(LocalIndex count);
  /// The same, and for arrivals to come: memory that nobody has written to is not occupied.
  void reserve_more(LocalIndex count);

  /// Fields that do not move (FieldInfo::moves) are held for the particles of `block` only from now on, with undefined values:
  /// what one kernel gives the next then stays in cache. real() of such a field must be asked again, and used for particles of
  /// the block alone.
  void hold_block(ParticleBlock block);
  /// Whether a field that this set has is held for all particles.
  bool holds_all(Field field) const;

  /// All columns, in the order of field_table.
  std::span<const Column> columns() const { return columns_; }
  std::byte* data(std::size_t column) { return data_[column]; }
  const std::byte* data(std::size_t column) const { return data_[column]; }

  /// Component of a real field.
  double* real(Field field, int component = 0);
  const double* real(Field field, int component = 0) const;
  std::uint8_t* material();
  const std::uint8_t* material() const;
  GlobalIndex* id();
  const GlobalIndex* id() const;

  /// m_p, kg.
  double mass(LocalIndex p) const { return densities_[material()[p]] * real(Field::reference_volume)[p]; }
  Vec3 vector(Field field, LocalIndex p) const;
  void set_vector(Field field, LocalIndex p, const Vec3& value);

  /// Physically reorders: particle k becomes the former particle `order[k]`; `order` has size() entries, each index once.
  void reorder(std::span<const LocalIndex> order);

  /// Removes the particles of `gone` (ascending, each once); the last particles fill the gaps.
  void remove(std::span<const LocalIndex> gone);

  /// Copies of the particles `chosen` (each < size()), in that order.
  ParticleSet selected(std::span<const LocalIndex> chosen) const;

  /// Bytes allocated.
  std::size_t memory() const;
  /// Bytes that one particle occupies in all columns that move.
  std::size_t bytes_per_particle() const;

 private:
  struct Free {
    void operator()(std::byte* p) const;
  };
  using Buffer = std::unique_ptr<std::byte[], Free>;
  static Buffer allocate(std::size_t bytes);
  bool is_whole(std::size_t column) const { return columns_[column].moves || block_rows_ == 0; }
  std::size_t column_bytes(std::size_t column) const;
  std::size_t first_column(Field field) const;

  OptionalFields optional_;
  Densities densities_;
  std::vector<Column> columns_;
  std::array<int, field_table.size()> first_column_{};
  std::vector<Buffer> buffers_;
  std::vector<std::byte*> data_;
  Buffer scratch_;  ///< target of reorder, swapped with each column in turn
  std::size_t scratch_bytes_ = 0;
  LocalIndex size_ = 0;
  LocalIndex capacity_ = 0;
  std::size_t block_rows_ = 0;  ///< room of the columns that do not move; 0: for all particles
};

}  // namespace bulkley
