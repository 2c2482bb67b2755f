#include "kernel/stress_update.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "support/law_samples.hpp"

namespace bulkley::stress_update_test {
namespace {

constexpr double dt = 1e-3;
constexpr double infinity = std::numeric_limits<double>::infinity();

const HerschelBulkley foam{{200.0, 109000.0, 290.0, 31.9, 27.2, 0.22}};
const HerschelBulkley thickening{{1000.0, 1e5, 1e4, 0.1, 10.0, 2.8}};
const HerschelBulkley extreme{{1000.0, 1e5, 1e4, 5.0, 3.0, 0.1}};
const HerschelBulkley plastic{{1000.0, 1e5, 1e4, 0.0, 0.0, 1.0}};
const NeoHookean solid{{1100.0, 1e5, 2.5e4}};

using material_test::LawSample;

constexpr Field internal_field_list[] = {Field::structure, Field::hardening, Field::plastic_volume_ratio,
                                         Field::viscous_left_cauchy_green};
const OptionalFields every_field{Field::kirchhoff_stress, Field::structure, Field::hardening, Field::plastic_volume_ratio,
                                 Field::viscous_left_cauchy_green};

// One particle, all that stress_update reads and writes.
struct Point {
  GlobalIndex id;
  std::uint8_t material = 0;
  Tensor<double> L{};
  State<double> state{isochoric_identity<double>(), 1.0};
  double reference_volume = 1e-9;
  SymTensor<double> tau{};
  double rate = 0.0;
  double dissipation = 0.0;
  std::array<double, 9> internal = {0.7, 0.01, 0.98, 1.1, 0.95, 1.0, 0.05, -0.02, 0.01};  // by internal_field_list
};

// Calls visit(column, k) for the columns of the internal variables that the set has.
template <class Set, class Visit>
void for_internal_columns(Set& set, const Visit& visit) {
  std::size_t k = 0;
  for (const Field field : internal_field_list)
    for (int c = 0; c < info(field).n_components; ++c, ++k)
      if (set.has(field)) visit(set.real(field, c), k);
}

void put(ParticleSet& set, LocalIndex p, const Point& point, Field gradient = Field::affine_velocity) {
  for (int c = 0; c < 9; ++c) set.real(gradient, c)[p] = point.L.c[c];
  for (int c = 0; c < 6; ++c) set.real(Field::left_cauchy_green, c)[p] = point.state.left_cauchy_green.c[c];
  for (int c = 0; c < 6 && set.has(Field::kirchhoff_stress); ++c)
    set.real(Field::kirchhoff_stress, c)[p] = point.tau.c[c];
  set.real(Field::volume_ratio)[p] = point.state.volume_ratio;
  set.real(Field::reference_volume)[p] = point.reference_volume;
  set.real(Field::plastic_shear_rate)[p] = point.rate;
  set.real(Field::plastic_dissipation)[p] = point.dissipation;
  for_internal_columns(set, [&](double* column, std::size_t k) { column[p] = point.internal[k]; });
  set.material()[p] = point.material;
  set.id()[p] = point.id;
}

Point get(const ParticleSet& set, LocalIndex p, Field gradient = Field::affine_velocity) {
  Point point{.id = set.id()[p], .material = set.material()[p]};
  for (int c = 0; c < 9; ++c) point.L.c[c] = set.real(gradient, c)[p];
  for (int c = 0; c < 6; ++c) point.state.left_cauchy_green.c[c] = set.real(Field::left_cauchy_green, c)[p];
  for (int c = 0; c < 6 && set.has(Field::kirchhoff_stress); ++c)
    point.tau.c[c] = set.real(Field::kirchhoff_stress, c)[p];
  point.state.volume_ratio = set.real(Field::volume_ratio)[p];
  point.reference_volume = set.real(Field::reference_volume)[p];
  point.rate = set.real(Field::plastic_shear_rate)[p];
  point.dissipation = set.real(Field::plastic_dissipation)[p];
  for_internal_columns(set, [&](const double* column, std::size_t k) { point.internal[k] = column[p]; });
  return point;
}

bool identical(const Point& a, const Point& b) {
  const auto same = [](const auto& x, const auto& y) { return std::memcmp(&x, &y, sizeof x) == 0; };
  return same(a.state, b.state) && same(a.tau, b.tau) && same(a.rate, b.rate) && same(a.dissipation, b.dissipation) &&
         same(a.L, b.L) && same(a.internal, b.internal) && a.id == b.id && a.material == b.material;
}

ParticleSet make_set(const std::vector<Point>& points) {
  ParticleSet set(every_field);
  set.resize(static_cast<LocalIndex>(points.size()));
  for (std::size_t p = 0; p < points.size(); ++p) put(set, static_cast<LocalIndex>(p), points[p]);
  return set;
}

// At rest, elastic, just yielding, far beyond yield; ids in no particular order.
std::vector<Point> mixed_points(int count, int n_materials = 1) {
  std::mt19937_64 random(21);
  std::normal_distribution<double> normal(0.0, 1.0);
  const double rates[] = {0.0, 1e-9, 0.3, 3.0, 30.0, 100.0, 60.0};
  std::vector<Point> points;
  for (int i = 0; i < count; ++i) {
    Point point{.id = 1000 + (i * 7919) % 100003, .material = static_cast<std::uint8_t>(i * 31 % 97 % n_materials)};
    Tensor<double> strain;
    for (double& c : strain.c) c = 0.02 * (i % 4) * normal(random);
    deform(point.state, strain, 1.0);
    for (double& c : point.L.c) c = rates[i % 7] * normal(random);
    point.reference_volume = 1e-9 * (1.0 + 0.1 * (i % 5));
    point.dissipation = i % 3;
    points.push_back(point);
  }
  return points;
}

// Every law, and extremes of one.
std::vector<LawSample> law_cases() {
  std::vector<LawSample> cases = material_test::law_samples();
  cases.push_back({"thickening", thickening, 30.0});
  cases.push_back({"extreme", extreme, 30.0});
  cases.push_back({"plastic", plastic, 30.0});
  return cases;
}

class StressUpdate : public testing::TestWithParam<LawSample> {};

INSTANTIATE_TEST_SUITE_P(Laws, StressUpdate, testing::ValuesIn(law_cases()), [](const auto& test) { return test.param.id; });

// The kernel may fuse products and sums, so it agrees with the scalar law to rounding only.
TEST_P(StressUpdate, AgreesWithTheLaw) {
  const auto before = mixed_points(101);
  ParticleSet set = make_set(before);
  StepBounds bounds;
  stress_update(GetParam().material, 0, Field::affine_velocity, dt, set, bounds);
  EXPECT_FALSE(bounds.failed());
  const ParticleSet start = make_set(before);
  std::visit(
      [&]<class Law>(const Law& law) {
        double largest_change = 0.0;
        for (LocalIndex p = 0; p < set.size(); ++p) {
          auto expected = particle_state(law, start, p);
          const auto result = law.update(expected, before[p].L, dt);
          const Point after = get(set, p);
          const auto state = particle_state(law, set, p);
          for (int c = 0; c < 6; ++c) {
            EXPECT_NEAR(state.left_cauchy_green.c[c], expected.left_cauchy_green.c[c], 1e-13);
            EXPECT_NEAR(after.tau.c[c], result.kirchhoff_stress.c[c],
                        2e-13 * (1e5 + material_test::norm(result.kirchhoff_stress)));
          }
          EXPECT_NEAR(state.volume_ratio, expected.volume_ratio, 1e-14);
          if constexpr (n_internal < Law >> 0)
            for (int k = 0; k < n_internal<Law>; ++k) {
              EXPECT_NEAR(state.internal[k], expected.internal[k], 1e-13);
              largest_change =
                  std::max(largest_change, std::fabs(state.internal[k] - particle_state(law, start, p).internal[k]));
            }
          if (Law::flows) {
            EXPECT_NEAR(after.rate, result.plastic_shear_rate, 1e-8 * (1e-3 + result.plastic_shear_rate));
            EXPECT_NEAR(after.dissipation, before[p].dissipation + result.dissipation, 1e-10);
          }
        }
        EXPECT_EQ(largest_change > 1e-4, n_internal<Law> > 0);
      },
      GetParam().material);
}

// The internal variables of other laws are not touched, and the fields of other laws need not be there.
TEST_P(StressUpdate, NeedsAndChangesItsOwnInternalVariablesOnly) {
  const std::vector<NamedMaterial> materials{{"only", GetParam().material}};
  const auto points = mixed_points(33);
  ParticleSet with_all = make_set(points), with_own(internal_fields(materials));
  with_own.resize(with_all.size());
  for (LocalIndex p = 0; p < with_own.size(); ++p) put(with_own, p, points[static_cast<std::size_t>(p)]);
  StepBounds bounds;
  stress_update(GetParam().material, 0, Field::affine_velocity, dt, with_all, bounds);
  stress_update(GetParam().material, 0, Field::affine_velocity, dt, with_own, bounds);
  for (LocalIndex p = 0; p < with_own.size(); ++p) {
    Point expected = get(with_own, p);  // with what it lacks as at the start
    if (!with_own.has(Field::kirchhoff_stress)) expected.tau = get(with_all, p).tau;
    EXPECT_TRUE(identical(get(with_all, p), expected)) << p;
  }
}

TEST_P(StressUpdate, SetsTheInternalVariablesOfItsParticlesOnly) {
  const auto points = mixed_points(40, 2);
  ParticleSet set = make_set(points);
  set_internal_variables(GetParam().material, 1, set);
  std::visit(
      [&]<class Law>(const Law& law) {
        for (LocalIndex p = 0; p < set.size(); ++p) {
          const Point& before = points[static_cast<std::size_t>(p)];
          if constexpr (n_internal < Law >> 0)
            for (int k = 0; before.material == 1 && k < n_internal<Law>; ++k) {
              EXPECT_EQ(particle_state(law, set, p).internal[k], law.initial_internal()[static_cast<std::size_t>(k)]);
            }
          EXPECT_EQ(identical(get(set, p), before), before.material != 1 || n_internal<Law> == 0) << p;
        }
      },
      GetParam().material);
}

// A particle whose internal variable is lost is counted, named and left alone.
TEST_P(StressUpdate, AnInternalVariableThatIsNotFiniteIsAFailure) {
  const auto own = internal_fields(std::vector<NamedMaterial>{{"only", GetParam().material}});
  for (std::size_t k = 0; k < 9; ++k) {
    const Field field = k < 3 ? internal_field_list[k] : internal_field_list[3];
    if (!own.contains(field)) continue;
    auto points = mixed_points(n_lanes + 2);
    points[1].internal[k] = std::nan("");
    points[1].id = 3;
    ParticleSet set = make_set(points);
    StepBounds bounds;
    stress_update(GetParam().material, 0, Field::affine_velocity, dt, set, bounds);
    EXPECT_EQ(bounds.failures.n_not_finite, 1) << k;
    EXPECT_EQ(bounds.failures.failed_id, 3);
    EXPECT_TRUE(identical(get(set, 1), points[1]));
  }
}

// The kinematic viscosity nu = eta J / rho_0 of the particle where it is largest.
TEST_P(StressUpdate, ViscosityBoundsAreTheLargest) {
  ParticleSet set = make_set(mixed_points(50, 2));
  StepBounds bounds;
  stress_update(GetParam().material, 1, Field::affine_velocity, dt, set, bounds);
  Extreme expected;
  std::visit(
      [&](const auto& law) {
        if (law.viscosity() == 0.0) return;
        for (LocalIndex p = 0; p < set.size(); ++p)
          if (set.material()[p] == 1)
            expected.include(law.viscosity() / law.density() * set.real(Field::volume_ratio)[p], set.id()[p]);
      },
      GetParam().material);
  EXPECT_NEAR(bounds.motion.viscosity.value, expected.value, 1e-15 * expected.value);
  EXPECT_EQ(bounds.motion.viscosity.id, expected.id);
}

// A particle's result must not depend on its place in a pack, on its neighbours, or on how many particles there are.
TEST_P(StressUpdate, GivesTheSameBitsInAnyOrderAndCompany) {
  const auto points = mixed_points(61);
  std::vector<Point> alone;
  for (const Point& point : points) {
    ParticleSet set = make_set({point});
    StepBounds bounds;
    stress_update(GetParam().material, 0, Field::affine_velocity, dt, set, bounds);
    alone.push_back(get(set, 0));
  }
  std::mt19937_64 random(5);
  for (int repeat = 0; repeat < 40; ++repeat) {
    std::vector<Point> company = mixed_points(repeat);
    for (Point& stranger : company) {
      stranger.material = static_cast<std::uint8_t>(repeat % 3);  // of this material in every third repeat
      stranger.id += 1000000;
    }
    company.insert(company.end(), points.begin(), points.end());
    std::shuffle(company.begin(), company.end(), random);
    ParticleSet set = make_set(company);
    StepBounds bounds;
    stress_update(GetParam().material, 0, Field::affine_velocity, dt, set, bounds);
    for (LocalIndex p = 0; p < set.size(); ++p) {
      const Point after = get(set, p);
      if (after.id >= 1000000) continue;
      const auto expected = std::find_if(alone.begin(), alone.end(), [&](const Point& a) { return a.id == after.id; });
      ASSERT_NE(expected, alone.end());
      EXPECT_TRUE(identical(after, *expected)) << "id " << after.id << " repeat " << repeat;
    }
  }
}

TEST_P(StressUpdate, BoundsAreTheExtremesOverItsParticles) {
  std::vector<Point> points = mixed_points(77, 2);
  ParticleSet set = make_set(points);
  StepBounds bounds;
  stress_update(GetParam().material, 1, Field::affine_velocity, dt, set, bounds);
  Extreme wave_speed;
  double stress_volume = 0.0, smallest = infinity, largest = 0.0;
  for (LocalIndex p = 0; p < set.size(); ++p) {
    const Point after = get(set, p);
    if (after.material != 1) continue;
    const auto speed_squared = [&](const auto& law) { return law.wave_speed_squared(particle_state(law, set, p)); };
    wave_speed.include(std::sqrt(std::visit(speed_squared, GetParam().material)), after.id);
    stress_volume = std::max(stress_volume, after.reference_volume * std::sqrt(norm_squared(after.tau)));
    smallest = std::min(smallest, after.state.volume_ratio);
    largest = std::max(largest, after.state.volume_ratio);
  }
  EXPECT_NEAR(bounds.motion.wave_speed.value, wave_speed.value, 1e-14 * wave_speed.value);
  EXPECT_EQ(bounds.motion.wave_speed.id, wave_speed.id);
  EXPECT_NEAR(bounds.sums.stress_volume, stress_volume, 1e-14 * stress_volume);
  EXPECT_EQ(bounds.totals.smallest_volume_ratio, smallest);
  EXPECT_EQ(bounds.totals.largest_volume_ratio, largest);
  EXPECT_FALSE(bounds.failed());
}

TEST(StressUpdateBounds, MergesIntoWhatIsThere) {
  ParticleSet set = make_set(mixed_points(20));
  StepBounds bounds;
  bounds.motion.wave_speed = {1e9, 5};
  bounds.sums.stress_volume.value = 1e9;
  bounds.totals.smallest_volume_ratio.value = 1e-9;
  bounds.totals.largest_volume_ratio.value = 1e9;
  bounds.failures.n_not_finite.value = 3;
  bounds.failures.failed_id.value = 4;
  stress_update(foam, 0, Field::affine_velocity, dt, set, bounds);
  EXPECT_EQ(bounds.motion.wave_speed.value, 1e9);
  EXPECT_EQ(bounds.motion.wave_speed.id, 5);
  EXPECT_EQ(bounds.sums.stress_volume, 1e9);
  EXPECT_EQ(bounds.totals.smallest_volume_ratio, 1e-9);
  EXPECT_EQ(bounds.totals.largest_volume_ratio, 1e9);
  EXPECT_EQ(bounds.failures.n_not_finite, 3);
  EXPECT_EQ(bounds.failures.failed_id, 4);
}

TEST(StressUpdateBounds, SmallestIdWinsTiesWhereverItStands) {
  for (LocalIndex place = 0; place < 3 * n_lanes + 1; ++place) {
    std::vector<Point> points;
    for (LocalIndex p = 0; p < 3 * n_lanes + 1; ++p) points.push_back({.id = p == place ? 7 : 100 + (p * 13) % 29});
    ParticleSet set = make_set(points);
    StepBounds bounds;
    stress_update(foam, 0, Field::affine_velocity, dt, set, bounds);
    EXPECT_EQ(bounds.motion.wave_speed.id, 7) << place;
  }
}

TEST(StressUpdateSelection, OtherMaterialsAreUntouched) {
  const auto points = mixed_points(90, 3);
  ParticleSet set = make_set(points);
  StepBounds bounds;
  stress_update(foam, 1, Field::affine_velocity, dt, set, bounds);
  int n_changed = 0;
  for (LocalIndex p = 0; p < set.size(); ++p) {
    if (points[p].material == 1)
      n_changed += identical(get(set, p), points[p]) ? 0 : 1;
    else
      EXPECT_TRUE(identical(get(set, p), points[p])) << p;
  }
  EXPECT_GT(n_changed, 10);
}

TEST(StressUpdateSelection, WhatLiesPastTheEndNeverCounts) {
  for (LocalIndex size = 0; size <= 2 * n_lanes + 1; ++size) {
    ParticleSet set = make_set(mixed_points(size));
    ParticleSet clean = make_set(mixed_points(size));
    for (LocalIndex beyond = size; beyond < size + n_lanes; ++beyond) {
      Point garbage{.id = -17};
      garbage.L.c[0] = beyond % 2 == 0 ? -1e9 : std::nan("");
      garbage.state.volume_ratio = 1e-30;
      garbage.reference_volume = 1e30;
      put(set, beyond, garbage);
    }
    StepBounds bounds, expected;
    stress_update(foam, 0, Field::affine_velocity, dt, set, bounds);
    stress_update(foam, 0, Field::affine_velocity, dt, clean, expected);
    EXPECT_EQ(std::memcmp(&bounds.motion.wave_speed, &expected.motion.wave_speed, sizeof bounds.motion.wave_speed), 0);
    EXPECT_EQ(bounds.sums.stress_volume, expected.sums.stress_volume);
    EXPECT_EQ(bounds.totals.smallest_volume_ratio, expected.totals.smallest_volume_ratio);
    EXPECT_FALSE(bounds.failed());
    for (LocalIndex p = 0; p < size; ++p) EXPECT_TRUE(identical(get(set, p), get(clean, p)));
  }
}

// dt sqrt(2 D' : D'), D' the deviator of the rate of deformation.
double shear_of(const Tensor<double>& L) {
  double square = 0.0;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) {
      const double D = 0.5 * (L(r, c) + L(c, r)) - (r == c ? (L(0, 0) + L(1, 1) + L(2, 2)) / 3.0 : 0.0);
      square += 2.0 * D * D;
    }
  return dt * std::sqrt(square);
}

// J of a particle that has less room than it says, or more where there should be none, goes towards what there is, by the shear; of others,
// and of solids, it stays what it is.
TEST(StressUpdateCrowding, VolumeRatiosFollowTheRoomThereIs) {
  constexpr int count = 2 * n_lanes + 1;
  const double fullness[count + n_lanes] = {0.0, 0.4, 1.0, 1.09, 1.11, 1.3, 2.0, 4.0};
  double missing[count + n_lanes] = {0.9, 0.5, 0.0, 0.5};
  missing[count - 1] = 0.2;
  const double most = 1.01;
  for (const Material& material : {Material(foam), Material(solid)}) {
    const bool flows = std::holds_alternative<HerschelBulkley>(material);
    std::vector<Point> points = mixed_points(count);
    for (std::size_t i = 0; i < points.size(); ++i) points[i].state.volume_ratio = 1.0 + 0.02 * static_cast<double>(i % 3);
    points[0].state.volume_ratio = most - 1e-6;  // may grow a little, those at 1.02 not at all
    std::vector<Point> expected = points;
    for (std::size_t i = 0; i < points.size(); ++i) {
      double& J = expected[i].state.volume_ratio;
      if (flows) J = std::min(J * (1.0 + shear_of(points[i].L) * missing[i]), std::max(J, most));
      if (flows && fullness[i] * J > 1.1)
        J /= 1.0 + shear_of(points[i].L) * std::min(5.0 * std::pow(fullness[i] * J - 1.1, 2), 0.2);
    }
    for (const std::size_t i : {3, 5}) EXPECT_NE(expected[i].state.volume_ratio == points[i].state.volume_ratio, flows);
    ParticleSet with = make_set(points), without = make_set(expected), untouched = make_set(points);
    StepBounds bounds;
    stress_update(material, 0, Field::affine_velocity, dt, with, bounds, {}, {}, {fullness, missing});
    stress_update(material, 0, Field::affine_velocity, dt, without, bounds);
    stress_update(material, 0, Field::affine_velocity, dt, untouched, bounds);
    EXPECT_FALSE(bounds.failed());
    for (LocalIndex p = 0; p < count; ++p) {
      EXPECT_NEAR(with.real(Field::volume_ratio)[p], without.real(Field::volume_ratio)[p], 1e-14) << p;
      const bool changes = missing[p] > 0.0 || fullness[p] * points[static_cast<std::size_t>(p)].state.volume_ratio > 1.1;
      EXPECT_TRUE((flows && changes) || identical(get(with, p), get(untouched, p))) << p;
    }
  }
}

TEST(StressUpdateCrowding, FullnessIsByPlaceInTheBlock) {
  std::vector<Point> points = mixed_points(3 * n_lanes);
  const std::vector<double> all(points.size() + n_lanes, 1.5);
  ParticleSet whole = make_set(points), in_blocks = make_set(points);
  StepBounds bounds;
  stress_update(foam, 0, Field::affine_velocity, dt, whole, bounds, {}, {}, {all.data()});
  for (LocalIndex first = 0; first < whole.size(); first += n_lanes)
    stress_update(foam, 0, Field::affine_velocity, dt, in_blocks, bounds, {first, first + n_lanes}, {}, {all.data()});
  for (LocalIndex p = 0; p < whole.size(); ++p) EXPECT_TRUE(identical(get(whole, p), get(in_blocks, p))) << p;
}

TEST(StressUpdateSelection, ReadsTheGradientFieldItIsTold) {
  ParticleSet set({Field::velocity_gradient, Field::kirchhoff_stress});
  set.resize(1);
  Point point{.id = 1};
  point.L.c[1] = 20.0;
  put(set, 0, point, Field::velocity_gradient);
  StepBounds bounds;
  stress_update(solid, 0, Field::affine_velocity, dt, set, bounds);
  EXPECT_EQ(set.real(Field::kirchhoff_stress, 3)[0], 0.0);
  stress_update(solid, 0, Field::velocity_gradient, dt, set, bounds);
  EXPECT_NEAR(set.real(Field::kirchhoff_stress, 3)[0], solid.parameters.shear_modulus * 20.0 * dt, 1e-10);
}

class StressUpdateFailure : public testing::TestWithParam<int> {};

INSTANTIATE_TEST_SUITE_P(Place, StressUpdateFailure, testing::Range(0, 2 * n_lanes + 1));

// A failed particle is counted and keeps its state; the others advance and alone make the bounds.
TEST_P(StressUpdateFailure, InvertedAndNotFiniteParticlesAreCountedAndNamed) {
  const int place = GetParam();
  auto points = mixed_points(2 * n_lanes + 3);
  const auto clean = points;
  points[place].id = 50;
  points[place].L = {{-1.0 / dt, 0, 0, 0, 1, 0, 0, 0, 1}};  // det(1 + dt L) = 0
  points[place + 1].id = 40;
  points[place + 1].L.c[4] = std::nan("");
  points[place + 2].id = 60;
  points[place + 2].state.left_cauchy_green.c[3] = infinity;
  ParticleSet set = make_set(points);
  StepBounds bounds;
  stress_update(foam, 0, Field::affine_velocity, dt, set, bounds);
  EXPECT_EQ(bounds.failures.n_inverted, 1);
  EXPECT_EQ(bounds.failures.n_not_finite, 2);
  EXPECT_EQ(bounds.failures.failed_id, 40);
  EXPECT_TRUE(std::isfinite(bounds.motion.wave_speed.value));
  EXPECT_TRUE(std::isfinite(bounds.sums.stress_volume));
  EXPECT_GT(bounds.totals.smallest_volume_ratio, 0.5);

  ParticleSet others = make_set(clean);
  StepBounds unused;
  stress_update(foam, 0, Field::affine_velocity, dt, others, unused);
  for (LocalIndex p = 0; p < set.size(); ++p) {
    if (p >= place && p <= place + 2)
      EXPECT_TRUE(identical(get(set, p), points[p])) << p;
    else
      EXPECT_TRUE(identical(get(set, p), get(others, p))) << p;
  }
}

TEST(StressUpdateFailures, CompressionToZeroVolumeOrThroughItIsAnInversion) {
  constexpr double binary_step = 0x1p-10;  // so that 1 + dt L is exactly 0 for the first
  for (const double rate : {-1024.0, -1536.0, -1e300}) {
    Point point{.id = 9};
    point.L.c[8] = rate;
    ParticleSet set = make_set({point});
    StepBounds bounds;
    stress_update(solid, 0, Field::affine_velocity, binary_step, set, bounds);
    EXPECT_EQ(bounds.failures.n_inverted, 1) << rate;
    EXPECT_EQ(bounds.failures.failed_id, 9);
    EXPECT_EQ(bounds.motion.wave_speed.id, -1);
  }
}

}  // namespace
}  // namespace bulkley::stress_update_test
