// ranks: 1 2 3 7
#include "integrator/fronts.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/random_vectors.hpp"
#include "support/solver_run.hpp"

namespace bulkley::fronts_mpi_test {
namespace {

Front along(const Vec3& direction, double quantile = 1.0) {
  Front front;
  front.direction = direction;
  front.quantile = quantile;
  return front;
}

class FrontsTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};

  // Particles at random places with masses of four sizes, the same on every rank.
  static ParticleSet cloud(LocalIndex n) {
    ParticleSet set(OptionalFields{}, Densities(std::array{1.0, 2.0}));
    set.resize(n);
    std::mt19937_64 random(5);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    for (LocalIndex p = 0; p < n; ++p) {
      const Vec3 x = random_vector(uniform, random);
      place_particle(set, p, x, p % 3 == 0 ? 0.7 : 0.1);
      set.material()[p] = p % 2;
    }
    return set;
  }

  double reach(const Front& front, const ParticleSet& all) const {
    return reaches(comm, {front}, share_of(comm, all, {}))[0];
  }

  // By sorting.
  static double expected(const Front& front, const ParticleSet& all) {
    std::vector<std::pair<double, double>> sorted;
    double total = 0.0;
    for (LocalIndex p = 0; p < all.size(); ++p) {
      const double r = reach_of(front, all.vector(Field::position, p));
      if (std::isnan(r) || (front.material_number >= 0 && all.material()[p] != front.material_number)) continue;
      sorted.emplace_back(r, all.mass(p));
      total += sorted.back().second;
    }
    std::sort(sorted.begin(), sorted.end());
    double sum = 0.0;
    for (const auto& [r, mass] : sorted)
      if ((sum += mass) >= (front.quantile - 1e-12) * total) return r;
    return std::nan("");
  }
};

TEST_F(FrontsTest, FindTheQuantileOfTheMass) {
  const ParticleSet all = cloud(4321);
  for (const double quantile : {1e-9, 0.01, 0.1, 0.5, 0.9, 0.995, 0.9999, 1.0})
    for (const Vec3& direction : {Vec3(1.0, 0.0, 0.0), Vec3(0.0, 0.0, -2.0), Vec3(0.3, -0.4, 0.1)}) {
      Front front = along(direction, quantile);
      EXPECT_EQ(reach(front, all), expected(front, all)) << quantile;
      front.material_number = 1;
      EXPECT_EQ(reach(front, all), expected(front, all)) << quantile << ", one material";
      Front round;
      round.axis = direction;
      round.origin = Vec3(0.1, 0.2, 0.3);
      round.quantile = quantile;
      EXPECT_EQ(reach(round, all), expected(round, all)) << quantile << ", from an axis";
    }
}

// Ten particles of one mass at 1, 2, ... 10: nine tenths of the mass reach to 9.
TEST_F(FrontsTest, CountsWholeParticles) {
  ParticleSet all(OptionalFields{}, Densities(std::array{1.0}));
  all.resize(10);
  for (LocalIndex p = 0; p < 10; ++p) place_particle(all, p, Vec3(p + 1.0, 0.0, 0.0), 0.3);
  for (int tenths = 1; tenths <= 10; ++tenths) EXPECT_EQ(reach(along(Vec3::UnitX(), 0.1 * tenths), all), tenths);
  EXPECT_EQ(reach(along(Vec3::UnitX(), 0.91), all), 10.0);
  EXPECT_EQ(reach(along(-Vec3::UnitX(), 0.1), all), -10.0);
  Front shifted = along(Vec3::UnitX());
  shifted.origin = Vec3(0.5, 7.0, 7.0);
  EXPECT_EQ(reach(shifted, all), 9.5);
}

TEST_F(FrontsTest, OfManyAtOnceAreThoseOfEach) {
  const ParticleSet all = cloud(500);
  const std::vector<Front> fronts = {along(Vec3::UnitX(), 0.3), along(Vec3::UnitY()), along(Vec3::UnitZ(), 0.7)};
  const std::vector<double> together = reaches(comm, fronts, share_of(comm, all, {}));
  for (std::size_t f = 0; f < fronts.size(); ++f) EXPECT_EQ(together[f], expected(fronts[f], all));
  EXPECT_TRUE(reaches(comm, {}, all).empty());
}

TEST_F(FrontsTest, OfNothingAreNotNumbers) {
  ParticleSet all = cloud(5);
  Front front = along(Vec3::UnitX(), 0.5);
  front.material_number = 2;
  EXPECT_TRUE(std::isnan(reach(front, all)));
  EXPECT_TRUE(std::isnan(reach(along(Vec3::UnitX()), ParticleSet())));
  EXPECT_TRUE(std::isnan(reach(along(Vec3::UnitX(), 0.5), ParticleSet())));
}

// The line from the eye through the particle meets the floor in the shadow.
TEST(Front, OfAShadow) {
  Front front = along(Vec3::UnitX());
  front.eye = Vec3(0.1, -0.2, 0.5);
  front.plane = 0.05;
  const Vec3 eye = *front.eye, x(0.3, 0.1, 0.2);
  const double part = (eye[2] - 0.05) / (eye[2] - x[2]);
  EXPECT_NEAR(reach_of(front, x), eye[0] + part * (x[0] - eye[0]), 1e-15);
  EXPECT_NEAR(reach_of(front, Vec3(0.3, 0.1, 0.05)), 0.3, 1e-16);
  EXPECT_TRUE(std::isnan(reach_of(front, Vec3(0.3, 0.1, 0.5))));
  EXPECT_TRUE(std::isnan(reach_of(front, Vec3(0.3, 0.1, 0.7))));
}

}  // namespace
}  // namespace bulkley::fronts_mpi_test
