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

namespace bulkley {

/// Every per-particle quantity. The order is that of `field_table`.
enum class Field : int {
  position,
  velocity,
  affine_velocity,
  left_cauchy_green,
  volume_ratio,
  kirchhoff_stress,
  plastic_shear_rate,
  plastic_dissipation,
  mass,
  reference_volume,
  velocity_gradient,
  structure,
  hardening,
  plastic_volume_ratio,
  viscous_left_cauchy_green,
  added_law_variables,
  material,
  id,
};

enum class FieldType { real, uint8, int64 };

/// What the rest of the program needs to know of a field; packing, sorting, output and checkpoints iterate the table.
struct FieldInfo {
  Field field;
  const char* name;
  const char* unit;
  const char* meaning;
  FieldType type;
  int n_components;
  bool moves;             ///< travels with the particle when it migrates (else it is recomputed before it is read)
  bool written;           ///< part of the checkpoint: needed for a bit-identical restart
  bool optional = false;  ///< held only where the scene needs it
};

inline constexpr std::array field_table = {
    FieldInfo{Field::position, "position", "m", "x_p", FieldType::real, 3, true, true},
    FieldInfo{Field::velocity, "velocity", "m/s", "v_p", FieldType::real, 3, true, true},
    FieldInfo{Field::affine_velocity, "affine_velocity", "1/s", "APIC matrix C_p = B_p D_p^-1, row-major", FieldType::real,
              9, true, true},
    FieldInfo{Field::left_cauchy_green, "left_cauchy_green", "1",
              "isochoric elastic left Cauchy-Green tensor, xx yy zz xy yz xz", FieldType::real, 6, true, true},
    FieldInfo{Field::volume_ratio, "volume_ratio", "1", "J = det F", FieldType::real, 1, true, true},
    FieldInfo{Field::kirchhoff_stress, "kirchhoff_stress", "Pa", "tau = J sigma, xx yy zz xy yz xz", FieldType::real, 6,
              true, true},
    FieldInfo{Field::plastic_shear_rate, "plastic_shear_rate", "1/s", "sqrt(2) gamma of the last step", FieldType::real, 1,
              true, true},
    FieldInfo{Field::plastic_dissipation, "plastic_dissipation", "J/m^3", "energy dissipated so far per reference volume",
              FieldType::real, 1, true, true},
    FieldInfo{Field::mass, "mass", "kg", "m_p", FieldType::real, 1, true, true},
    FieldInfo{Field::reference_volume, "reference_volume", "m^3", "V_p^0", FieldType::real, 1, true, true},
    FieldInfo{Field::velocity_gradient, "velocity_gradient", "1/s",
              "L_p where it differs from affine_velocity, row-major; lives within one step", FieldType::real, 9, false,
              false, true},
    FieldInfo{Field::structure, "structure", "1", "structure of a thixotropic fluid, 0 broken down, 1 built up",
              FieldType::real, 1, true, true, true},
    FieldInfo{Field::hardening, "hardening", "1", "accumulated plastic strain of sand", FieldType::real, 1, true, true,
              true},
    FieldInfo{Field::plastic_volume_ratio, "plastic_volume_ratio", "1", "J / J_elastic of snow", FieldType::real, 1, true,
              true, true},
    FieldInfo{Field::viscous_left_cauchy_green, "viscous_left_cauchy_green", "1",
              "elastic left Cauchy-Green tensor of a relaxing branch, xx yy zz xy yz xz", FieldType::real, 6, true, true,
              true},
    FieldInfo{Field::added_law_variables, "added_law_variables", "1",
              "variables of a law that the program added, in the order of the law", FieldType::real, 8, true, true, true},
    FieldInfo{Field::material, "material", "1", "index into the scene's materials", FieldType::uint8, 1, true, true},
    FieldInfo{Field::id, "id", "1", "unique, from the seeding geometry alone", FieldType::int64, 1, true, true},
};

constexpr const FieldInfo& info(Field field) { return field_table[static_cast<std::size_t>(field)]; }

constexpr std::size_t element_size(FieldType type) { return type == FieldType::uint8 ? 1 : 8; }

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
  explicit ParticleSet(OptionalFields fields = {});
  ~ParticleSet();
  ParticleSet(ParticleSet&&) noexcept;
  ParticleSet& operator=(ParticleSet&&) noexcept;

  LocalIndex size() const { return size_; }
  LocalIndex capacity() const { return capacity_; }
  bool has(Field field) const;
  /// The optional fields that this set has.
  OptionalFields optional_fields() const { return optional_; }

  /// Keeps the first min(old, new) particles; new ones are zero.
  void resize(LocalIndex new_size);
  /// Room for `count` particles without another allocation.
  void reserve(LocalIndex count);

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
  /// Bytes that one particle occupies in all columns.
  std::size_t bytes_per_particle() const;

 private:
  struct Free {
    void operator()(std::byte* p) const;
  };
  using Buffer = std::unique_ptr<std::byte[], Free>;
  static Buffer allocate(std::size_t bytes);
  std::size_t column_bytes(std::size_t column) const;
  std::size_t first_column(Field field) const;

  OptionalFields optional_;
  std::vector<Column> columns_;
  std::array<int, field_table.size()> first_column_{};
  std::vector<Buffer> buffers_;
  std::vector<std::byte*> data_;
  Buffer scratch_;  ///< target of reorder, swapped with each column in turn
  std::size_t scratch_bytes_ = 0;
  LocalIndex size_ = 0;
  LocalIndex capacity_ = 0;
};

}  // namespace bulkley
