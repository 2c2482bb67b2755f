#include "material/laws/snow.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "support/law_samples.hpp"

namespace bulkley::snow_test {
namespace {

using namespace material_test;

template <class Real>
class SnowOf : public testing::Test {};
using Reals = testing::Types<double, Pack>;
TYPED_TEST_SUITE(SnowOf, Reals);

TYPED_TEST(SnowOf, OneReturnOfTheReference) {
  const Snow snow = reference_snow();
  auto state = stretched(snow, 1.02, 0.95, 0.99);
  const double J = state.volume_ratio;
  const auto update = advance<TypeParam>(snow, state, Tensor<double>{}, 1e-3);
  EXPECT_EQ(state.volume_ratio, J);
  EXPECT_NEAR(state.internal[0], 0.98644779538, 1e-11);
  const double J_elastic = J / state.internal[0], expected[] = {1.0075, 0.975, 0.99};
  for (int k = 0; k < 3; ++k)
    EXPECT_NEAR(std::sqrt(state.left_cauchy_green.c[k]) * std::cbrt(J_elastic), expected[k], 1e-14);
  const double stiffening = of_lane(snow.stiffening(broadcast<TypeParam>(state.internal[0])), 0);
  EXPECT_NEAR(stiffening * snow.parameters.shear_modulus, 66799.509082, 1e-6);
  EXPECT_NEAR(stiffening * snow.elastic().lambda(), 44533.006055, 1e-6);
  const double tau[] = {-181.91913, -4447.90278, -2514.05699};
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(update.kirchhoff_stress.c[k], tau[k], 6e-6);  // as many digits as the table has
}

TYPED_TEST(SnowOf, WithinTheCriticalStretchesItIsFixedCorotated) {
  std::mt19937_64 random(77);
  const Snow snow = reference_snow();
  for (int i = 0; i < 200; ++i) {
    const Tensor<double> L = random_tensor(random, 1e-3);
    auto state = state_at_rest(snow);
    auto elastic = at_rest();
    const auto update = advance<TypeParam>(snow, state, L, 1.0);
    const auto expected = snow.elastic().update(elastic, L, 1.0);
    EXPECT_LT(largest_difference(update.kirchhoff_stress, expected.kirchhoff_stress), 1e-9);
    EXPECT_EQ(update.plastic_shear_rate, 0.0);
    EXPECT_EQ(update.dissipation, 0.0);
    EXPECT_EQ(state.internal[0], 1.0);
  }
}

// After any motion the elastic stretches lie between 1 - theta_c and 1 + theta_s, and J = J_e J_p.
TYPED_TEST(SnowOf, ElasticStretchesStayWithinTheirBounds) {
  std::mt19937_64 random(78);
  const Snow snow = reference_snow();
  for (int path = 0; path < 20; ++path) {
    auto state = state_at_rest(snow);
    for (int step = 0; step < 100; ++step) {
      advance<TypeParam>(snow, state, random_tensor(random, 10.0), 1e-3);
      const auto v = principal_stretches(state.left_cauchy_green, state.volume_ratio / state.internal[0]);
      for (const double stretch : v.value) {
        EXPECT_GE(stretch, 0.975 - 1e-13);
        EXPECT_LE(stretch, 1.0075 + 1e-13);
      }
    }
  }
}

TYPED_TEST(SnowOf, PackingHardensAndTearingSoftens) {
  const Snow snow = reference_snow();
  auto packed = state_at_rest(snow), torn = packed;
  for (int step = 0; step < 10; ++step) {
    advance<TypeParam>(snow, packed, diagonal(-0.02, -0.02, -0.02), 1.0);
    advance<TypeParam>(snow, torn, diagonal(0.02, 0.02, 0.02), 1.0);
  }
  EXPECT_LT(packed.internal[0], 0.7);
  EXPECT_GT(torn.internal[0], 1.3);
  EXPECT_GT(snow.wave_speed_squared(packed), 4.0 * snow.wave_speed_squared(state_at_rest(snow)));
  EXPECT_LT(snow.wave_speed_squared(torn), 0.3 * snow.wave_speed_squared(state_at_rest(snow)));
}

// The exponent counts J_p from 0.6 to 20 only.
TYPED_TEST(SnowOf, HardeningIsBounded) {
  const Snow snow = reference_snow();
  const auto at = [&](double J_p) { return of_lane(snow.stiffening(broadcast<TypeParam>(J_p)), 0); };
  EXPECT_NEAR(at(0.6), std::exp(4.0), 1e-12);
  EXPECT_EQ(at(0.1), at(0.6));
  EXPECT_NEAR(at(20.0), std::exp(-190.0), 1e-12 * std::exp(-190.0));
  EXPECT_EQ(at(1e3), at(20.0));
  EXPECT_EQ(at(1.0), 1.0);
}

}  // namespace
}  // namespace bulkley::snow_test
