// Oscillatory shear of an elastic solid, a Maxwell limit and a yielding fluid.

#include "rheometer/oscillation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support.hpp"

namespace bulkley::rheometer::oscillation_test {
namespace {

using namespace rheometer_test;

TEST(Oscillation, SolidStoresAll) {
  const Measurement m = measure_oscillation(rubber(), {.amplitudes = {0.01, 0.5}, .frequencies = {1.0, 50.0}});
  ASSERT_EQ(m.table.rows.size(), 4u);
  for (const double storage : m.table.column("storage_modulus")) EXPECT_NEAR(storage, 2000.0, 1e-6);
  for (const double loss : m.table.column("loss_modulus")) EXPECT_NEAR(loss, 0.0, 1e-6);
  for (const double third : m.table.column("third_harmonic")) EXPECT_LT(third, 1e-9);
}

// Relaxation time 0.02 s: from flowing to elastic.
TEST(Oscillation, MaxwellLimit) {
  const Measurement m = measure_oscillation(maxwell(), {.amplitudes = {1e-3}, .frequencies = {5.0, 50.0, 500.0}});
  const std::vector<double> storage = m.table.column("storage_modulus"), loss = m.table.column("loss_modulus");
  const double x[] = {0.1, 1.0, 10.0};  // frequency times relaxation time
  for (int k = 0; k < 3; ++k) {
    const double size = 1000.0 * x[k] / std::sqrt(1.0 + x[k] * x[k]);
    EXPECT_NEAR(storage[k], 1000.0 * x[k] * x[k] / (1.0 + x[k] * x[k]), 1e-5 * size) << k;
    EXPECT_NEAR(loss[k], 1000.0 * x[k] / (1.0 + x[k] * x[k]), 1e-5 * size) << k;
    EXPECT_EQ(m.table.column("steady")[k], 1.0);
    EXPECT_NEAR(m.table.column("analytic_storage_modulus")[k], storage[k], 1e-5 * size);
    EXPECT_NEAR(m.table.column("loss_angle")[k], std::atan(1.0 / x[k]) * 180.0 / std::numbers::pi, 0.06);
  }
}

// Perfectly plastic at strains far beyond yield: a rectangular stress of height tau_y, whose third harmonic is a third of
// its first.
TEST(Oscillation, PlasticSolidIsRectangular) {
  const HerschelBulkley plastic{{1000.0, 1e5, 1e6, 30.0, 0.0, 1.0}};
  const double yield = 30.0 / std::sqrt(3.0);
  const Measurement m = measure_oscillation(plastic, {.amplitudes = {1.0}, .frequencies = {1.0}});
  EXPECT_NEAR(m.table.column("loss_modulus")[0], 4.0 / std::numbers::pi * yield, 1e-3 * yield);
  EXPECT_NEAR(m.table.column("third_harmonic")[0], 1.0 / 3.0, 2e-3);
}

TEST(Oscillation, FarBelowYieldIsElastic) {
  const Measurement m = measure_oscillation(foam(), {.amplitudes = {0.01}, .frequencies = {1.0}});
  EXPECT_NEAR(m.table.column("storage_modulus")[0], 290.0, 1e-6);
  EXPECT_FALSE(m.table.has("analytic_storage_modulus"));
}

}  // namespace
}  // namespace bulkley::rheometer::oscillation_test
