#include "bulkley/particle/particle_set.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <numeric>
#include <random>
#include <set>
#include <string>

#include "bulkley/base/error.hpp"

namespace bulkley::particle_set_test {
namespace {

// A value that tells particle, field and component apart, in every type.
std::int64_t value_of(GlobalIndex particle, std::size_t column) {
  return (particle * 131 + static_cast<std::int64_t>(column) * 17) % 251;
}

void fill(ParticleSet& set, LocalIndex p, GlobalIndex particle) {
  for (std::size_t c = 0; c < set.columns().size(); ++c) {
    const FieldInfo& field = info(set.columns()[c].field);
    const std::int64_t value = value_of(particle, c);
    if (field.type == FieldType::real)
      set.real(field.field, set.columns()[c].component)[p] = static_cast<double>(value) + 0.5;
    else if (field.type == FieldType::int64)
      set.id()[p] = particle;
    else
      set.material()[p] = static_cast<std::uint8_t>(value);
  }
}

// Whether place p holds `particle` in every column; in those that travel with it, if `moving_only`.
bool holds(const ParticleSet& set, LocalIndex p, GlobalIndex particle, bool moving_only = false) {
  for (std::size_t c = 0; c < set.columns().size(); ++c) {
    const FieldInfo& field = info(set.columns()[c].field);
    if (moving_only && !field.moves) continue;
    const std::int64_t value = value_of(particle, c);
    bool same = false;
    if (field.type == FieldType::real)
      same = set.real(field.field, set.columns()[c].component)[p] == static_cast<double>(value) + 0.5;
    else if (field.type == FieldType::int64)
      same = set.id()[p] == particle;
    else
      same = set.material()[p] == static_cast<std::uint8_t>(value);
    if (!same) return false;
  }
  return true;
}

bool is_zero(const ParticleSet& set, LocalIndex p) {
  for (std::size_t c = 0; c < set.columns().size(); ++c)
    for (std::size_t byte = 0; byte < set.columns()[c].element_size; ++byte)
      if (set.data(c)[static_cast<std::size_t>(p) * set.columns()[c].element_size + byte] != std::byte{0}) return false;
  return true;
}

constexpr OptionalFields all_fields{
    Field::kirchhoff_stress,
    Field::velocity_gradient,         Field::structure,           Field::hardening,        Field::plastic_volume_ratio,
    Field::viscous_left_cauchy_green, Field::added_law_variables, Field::cell_mean_stress, Field::layer_pressure, Field::viscous_stress,
    Field::magnetic_field_strength,   Field::magnetic_force,
    Field::magnetic_field,            Field::magnetisation};

ParticleSet filled(LocalIndex count) {
  ParticleSet set(all_fields);
  set.resize(count);
  for (LocalIndex p = 0; p < count; ++p) fill(set, p, p);
  return set;
}

TEST(FieldTable, StandsInTheOrderOfTheEnumWithNamesOfItsOwn) {
  std::set<std::string> names;
  for (std::size_t n = 0; n < field_table.size(); ++n) {
    EXPECT_EQ(static_cast<std::size_t>(field_table[n].field), n);
    EXPECT_TRUE(names.insert(field_table[n].name).second) << field_table[n].name;
    EXPECT_TRUE(!field_table[n].written || field_table[n].moves) << field_table[n].name << " would be lost in a migration";
  }
}

TEST(ParticleSet, ColumnsFollowTheTable) {
  for (const bool with : {false, true}) {
    const ParticleSet set(with ? all_fields : OptionalFields{});
    for (const FieldInfo& field : field_table) EXPECT_EQ(set.has(field.field), with || !field.optional) << field.name;
    std::size_t next = 0, bytes = 0;
    for (const FieldInfo& field : field_table) {
      if (!set.has(field.field)) continue;
      for (int c = 0; c < field.n_components; ++c, ++next) {
        ASSERT_LT(next, set.columns().size());
        EXPECT_EQ(set.columns()[next].field, field.field);
        EXPECT_EQ(set.columns()[next].component, c);
        EXPECT_EQ(set.columns()[next].moves, field.moves);
        if (field.moves) bytes += set.columns()[next].element_size;
      }
    }
    EXPECT_EQ(next, set.columns().size());
    EXPECT_EQ(set.bytes_per_particle(), bytes);
  }
}

TEST(ParticleSet, EveryColumnHasItsOwnMemory) {
  const ParticleSet set = filled(1000);
  for (LocalIndex p = 0; p < set.size(); ++p) ASSERT_TRUE(holds(set, p, p)) << p;
}

TEST(ParticleSet, ColumnsAreAlignedAndPaddedWhateverHappens) {
  ParticleSet set = filled(7);
  const auto check = [&] {
    for (std::size_t c = 0; c < set.columns().size(); ++c)
      EXPECT_EQ(reinterpret_cast<std::uintptr_t>(set.data(c)) % 64, 0u) << c;
    // Writing over the end, as vector code does, harms no particle.
    for (std::size_t c = 0; c < set.columns().size(); ++c) {
      const std::size_t size = set.columns()[c].element_size, n = static_cast<std::size_t>(set.size());
      std::fill_n(set.data(c) + n * size, ParticleSet::padding * size, std::byte{0xff});
    }
  };
  check();
  for (LocalIndex p = 0; p < 7; ++p) EXPECT_TRUE(holds(set, p, p));
  set.resize(1000);
  for (LocalIndex p = 7; p < 1000; ++p) EXPECT_TRUE(is_zero(set, p)) << "the padding was not clean";
  check();
  std::vector<LocalIndex> order(1000);
  std::iota(order.rbegin(), order.rend(), 0);
  set.reorder(order);
  check();
  set.remove(std::vector<LocalIndex>{0, 500, 999});
  check();
}

TEST(ParticleSet, HoldsWhatDoesNotMoveForOneBlock) {
  constexpr LocalIndex count = 5000, block = 1024;
  const auto gradient = [](LocalIndex p, int c) { return 100.0 * p + c; };
  ParticleSet set = filled(count);
  const std::size_t memory = set.memory();
  EXPECT_TRUE(set.holds_all(Field::velocity_gradient));
  for (LocalIndex first = 0; first < count; first += block) {
    set.hold_block({first, first + block});
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(set.real(Field::velocity_gradient, 8) + first) % 64, 0u);
    const LocalIndex end = std::min(first + block, count) + ParticleSet::padding;  // kernels write whole packs
    for (int c = 0; c < 9; ++c)
      for (LocalIndex p = first; p < end; ++p) set.real(Field::velocity_gradient, c)[p] = gradient(p, c);
    for (int c = 0; c < 9; ++c)
      for (LocalIndex p = first; p < end; ++p) ASSERT_EQ(set.real(Field::velocity_gradient, c)[p], gradient(p, c));
  }
  EXPECT_FALSE(set.holds_all(Field::velocity_gradient));
  EXPECT_TRUE(set.holds_all(Field::position));
  EXPECT_LE(set.memory() + 9 * sizeof(double) * (count - 2 * block), memory);

  // The other fields go on through everything that happens to particles.
  const std::vector<LocalIndex> gone = {3, 10}, chosen = {4000, 7};
  set.remove(gone);
  EXPECT_TRUE(holds(set, 3, count - 2, true));
  set.resize(count + 10000);
  EXPECT_TRUE(holds(set, 4990, 4990, true));
  const ParticleSet copy = set.selected(chosen);
  EXPECT_TRUE(holds(copy, 0, 4000, true));
  EXPECT_TRUE(copy.holds_all(Field::velocity_gradient));
  EXPECT_EQ(copy.real(Field::velocity_gradient)[0], 0.0);
  std::vector<LocalIndex> order(static_cast<std::size_t>(set.size()));
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = set.size() - 1 - static_cast<LocalIndex>(k);
  set.reorder(order);
  EXPECT_TRUE(holds(set, set.size() - 1 - 4990, 4990, true));
}

TEST(ParticleSet, ResizeKeepsTheFirstAndZeroesTheNew) {
  ParticleSet set = filled(100);
  set.resize(40);
  set.resize(90);  // within the capacity: what was there before must be gone
  set.resize(5000);
  for (LocalIndex p = 0; p < 40; ++p) EXPECT_TRUE(holds(set, p, p));
  for (LocalIndex p = 40; p < 5000; ++p) ASSERT_TRUE(is_zero(set, p)) << p;
  set.resize(0);
  EXPECT_EQ(set.size(), 0);
  set.resize(3);
  for (LocalIndex p = 0; p < 3; ++p) EXPECT_TRUE(is_zero(set, p));
}

TEST(ParticleSet, ReserveAvoidsLaterAllocations) {
  ParticleSet set = filled(10);
  set.reserve(1000);
  EXPECT_GE(set.capacity(), 1000);
  const std::byte* const before = set.data(0);
  const std::size_t memory = set.memory();
  set.resize(1000);
  EXPECT_EQ(set.data(0), before);
  EXPECT_EQ(set.memory(), memory);
  for (LocalIndex p = 0; p < 10; ++p) EXPECT_TRUE(holds(set, p, p));
  set.reserve(5);
  EXPECT_GE(set.capacity(), 1000);
  EXPECT_GE(memory, 1000 * set.bytes_per_particle());
}

TEST(ParticleSet, ReorderPermutesEverythingThatMoves) {
  ParticleSet set = filled(1003);
  std::vector<GlobalIndex> expected(1003);
  std::iota(expected.begin(), expected.end(), 0);
  std::mt19937 generator(41);
  for (int round = 0; round < 4; ++round) {
    std::vector<LocalIndex> order(1003);
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), generator);
    set.reorder(order);
    const std::vector<GlobalIndex> before = expected;
    for (std::size_t k = 0; k < order.size(); ++k) expected[k] = before[static_cast<std::size_t>(order[k])];
    for (LocalIndex p = 0; p < set.size(); ++p) ASSERT_TRUE(holds(set, p, expected[static_cast<std::size_t>(p)], true)) << p;
    if (round == 1) set.reserve(5000);  // the scratch memory must grow with it
  }
  ParticleSet none;
  none.reorder({});
  EXPECT_EQ(none.size(), 0);
}

TEST(ParticleSet, RemoveKeepsAllOthersOnce) {
  std::mt19937 generator(42);
  const std::vector<std::vector<LocalIndex>> cases = {
      {}, {0}, {99}, {0, 99}, {97, 98, 99}, {0, 1, 2}, {50}, {10, 95, 96, 97}, {3, 4, 60, 99}};
  std::vector<std::vector<LocalIndex>> gone_lists = cases;
  std::vector<LocalIndex> everyone(100);
  std::iota(everyone.begin(), everyone.end(), 0);
  gone_lists.push_back(everyone);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<LocalIndex> gone;
    std::sample(everyone.begin(), everyone.end(), std::back_inserter(gone), trial * 2, generator);
    gone_lists.push_back(gone);
  }
  for (const std::vector<LocalIndex>& gone : gone_lists) {
    ParticleSet set = filled(100);
    set.remove(gone);
    ASSERT_EQ(set.size(), 100 - static_cast<LocalIndex>(gone.size()));
    std::set<GlobalIndex> left;
    for (LocalIndex p = 0; p < set.size(); ++p) {
      ASSERT_TRUE(holds(set, p, set.id()[p])) << "mixed up two particles";
      left.insert(set.id()[p]);
    }
    EXPECT_EQ(left.size(), static_cast<std::size_t>(set.size()));
    for (const LocalIndex p : gone) EXPECT_EQ(left.count(p), 0u);
  }
}

TEST(ParticleSet, MovesLeaveTheParticlesWhereTheyAre) {
  ParticleSet set = filled(50);
  const double* const x = set.real(Field::position);
  ParticleSet other = std::move(set);
  EXPECT_EQ(other.real(Field::position), x);
  for (LocalIndex p = 0; p < 50; ++p) EXPECT_TRUE(holds(other, p, p));
}

TEST(ParticleSet, RefusesNumbersOfParticlesThatOneRankCannotNumber) {
  constexpr GlobalIndex largest = ParticleSet::largest_size;
  EXPECT_EQ(ParticleSet::checked_size(0), 0);
  EXPECT_EQ(ParticleSet::checked_size(largest), largest);
  // The last one would wrap to 1 in 32 bits.
  for (const GlobalIndex n : {largest + 1, GlobalIndex{1} << 31, (GlobalIndex{1} << 32) + 1}) {
    try {
      ParticleSet::checked_size(n);
      ADD_FAILURE() << n << " particles pass";
    } catch (const RunError& error) {
      EXPECT_EQ(std::string(error.what()).find(std::to_string(n) + " particles are more than the "), 0u) << error.what();
    }
  }
}

TEST(ParticleSet, MassIsDensityTimesReferenceVolume) {
  ParticleSet set(OptionalFields{}, Densities(std::array{1000.0, 2.5}));
  set.resize(3);
  for (LocalIndex p = 0; p < 3; ++p) {
    set.real(Field::reference_volume)[p] = 0.5 * (p + 1);
    set.material()[p] = static_cast<std::uint8_t>(p % 2);
  }
  EXPECT_EQ(set.mass(0), 500.0);
  EXPECT_EQ(set.mass(1), 2.5);
  const ParticleSet copy = set.selected(std::vector<LocalIndex>{2, 1});
  EXPECT_EQ(copy.densities(), set.densities());
  EXPECT_EQ(copy.mass(0), 1500.0);
  set.material()[0] = 7;  // a number beyond
  EXPECT_EQ(set.mass(0), 0.0);
}

TEST(ParticleSet, DensitiesAreUniformWhereThereIsOneValue) {
  EXPECT_TRUE(Densities().uniform());
  EXPECT_TRUE(Densities(std::array{3.0}).uniform());
  EXPECT_TRUE(Densities(std::array{3.0, 3.0}).uniform());
  EXPECT_FALSE(Densities(std::array{3.0, 3.0, 4.0}).uniform());
}

TEST(ParticleSet, VectorsAreThreeColumns) {
  ParticleSet set;
  set.resize(2);
  set.set_vector(Field::velocity, 1, Vec3(1.0, 2.0, 3.0));
  EXPECT_EQ(set.vector(Field::velocity, 1), Vec3(1.0, 2.0, 3.0));
  EXPECT_EQ(set.vector(Field::velocity, 0), Vec3(0.0, 0.0, 0.0));
  for (int a = 0; a < 3; ++a) EXPECT_EQ(set.real(Field::velocity, a)[1], a + 1.0);
}

}  // namespace
}  // namespace bulkley::particle_set_test
