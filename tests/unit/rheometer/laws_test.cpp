// Fluids other than Herschel-Bulkley's, against their own theory.

#include <gtest/gtest.h>

#include <cmath>

#include "rheometer/analytic.hpp"
#include "rheometer/creep.hpp"
#include "rheometer/oscillation.hpp"
#include "rheometer/steady.hpp"
#include "rheometer/transient.hpp"
#include "support.hpp"

namespace bulkley::rheometer::laws_test {
namespace {

using namespace rheometer_test;

Newtonian oil() { return {{.density = 1000.0, .bulk_modulus = 1e5, .viscosity = 3.0}}; }
OldroydB polymer() {
  return {{.density = 1000.0, .bulk_modulus = 1e5, .shear_modulus = 50.0, .relaxation_time = 0.2, .solvent_viscosity = 4.0}};
}
ThixotropicHerschelBulkley gel() {
  ThixotropicHerschelBulkley::Parameters p;
  static_cast<HerschelBulkley::Parameters&>(p) = bingham().parameters;
  p.build_up = 0.5;
  p.breakdown = 0.2;
  p.residual_yield = 0.3;
  return {p};
}

TEST(Newtonian, TroutonRatios) {
  const double ratios[] = {1.0, 3.0, 4.0};
  const Flow flows[] = {Flow::simple_shear, Flow::uniaxial_extension, Flow::planar_extension};
  for (int k = 0; k < 3; ++k) {
    const Measurement m = measure_steady(oil(), {.flow = flows[k], .rates = {0.1, 20.0}, .pressure = 500.0});
    const std::vector<double> stress = m.table.column(k == 0 ? "shear_stress" : "tensile_stress");
    EXPECT_NEAR(stress[0], ratios[k] * 3.0 * 0.1, 2e-4 * stress[0]);
    EXPECT_NEAR(stress[1], ratios[k] * 3.0 * 20.0, 2e-4 * stress[1]);
    EXPECT_NEAR(m.table.column("analytic_stress")[1], stress[1], 2e-4 * stress[1]);
  }
  const Measurement creep = measure_creep(oil(), {.stresses = {6.0}, .duration = 1.0});
  EXPECT_NEAR(creep.table.column("strain").back(), 2.0, 1e-6);
}

TEST(OldroydB, SteadyShearAndExtension) {
  const Measurement shear = measure_steady(polymer(), {.rates = {0.5, 10.0}});
  for (const int k : {0, 1}) {
    const double rate = k == 0 ? 0.5 : 10.0, strain = 0.2 * rate;
    EXPECT_NEAR(shear.table.column("shear_stress")[k], (4.0 + 10.0) * rate, 1e-3 * 14.0 * rate);
    EXPECT_NEAR(shear.table.column("first_normal_stress_difference")[k], 100.0 * strain * strain,
                5e-3 * 100.0 * strain * strain);
    EXPECT_NEAR(shear.table.column("analytic_stress")[k], 14.0 * rate, 1e-9 * rate);
  }
  const Measurement extension = measure_steady(polymer(), {.flow = Flow::uniaxial_extension, .rates = {1.0}});
  const double expected = 50.0 * (1.0 / 0.6 - 1.0 / 1.2) + 3.0 * 4.0;
  EXPECT_NEAR(extension.table.column("tensile_stress")[0], expected, 2e-3 * expected);
  EXPECT_NEAR(extension.table.column("analytic_stress")[0], expected, 1e-9 * expected);
  EXPECT_FALSE(steady_flow(polymer(), Flow::uniaxial_extension, 2.5));
}

TEST(OldroydB, StartUpAndOscillation) {
  const Measurement start_up = measure_start_up(polymer(), {.rates = {2.0}, .strain = 2.0});
  const std::vector<double> stress = start_up.table.column("shear_stress"), truth = start_up.table.column("analytic_stress");
  for (std::size_t k = 0; k < stress.size(); ++k) EXPECT_NEAR(stress[k], truth[k], 0.02);
  EXPECT_NEAR(truth.back(), 28.0 - 20.0 * std::exp(-5.0), 1e-9);
  const Measurement shaken = measure_oscillation(polymer(), {.amplitudes = {0.3}, .frequencies = {5.0}});
  EXPECT_NEAR(shaken.table.column("storage_modulus")[0], 25.0, 1e-3);
  EXPECT_NEAR(shaken.table.column("loss_modulus")[0], 25.0 + 20.0, 1e-3);
}

TEST(Thixotropic, StructureComesIntoBalance) {
  const Measurement m = measure_steady(gel(), {.rates = {0.5, 5.0}});
  for (const int k : {0, 1}) {
    const double rate = k == 0 ? 0.5 : 5.0, structure = 1.0 / (1.0 + 0.4 * rate);
    EXPECT_NEAR(m.table.column("structure")[k], structure, 1e-3);
    const double stress = 30.0 / std::sqrt(3.0) * (0.3 + 0.7 * structure) + 5.0 * structure * rate;
    EXPECT_NEAR(m.table.column("shear_stress")[k], stress, 1e-3 * stress);
    EXPECT_NEAR(m.table.column("analytic_stress")[k], stress, 1e-4 * stress);
  }
  const Measurement intervals =
      measure_thixotropy(gel(), {.rates = {0.1, 20.0, 0.0}, .durations = {2.0, 2.0, 2.0}, .n_steps = 2000, .n_points = 20});
  const std::vector<double> structure = intervals.table.column("structure");
  EXPECT_GT(structure[0], 0.9);
  EXPECT_NEAR(structure[39], 1.0 / 9.0, 1e-3);
  EXPECT_NEAR(structure[59], 1.0 - (1.0 - structure[39]) * std::exp(-0.5 * 2.0), 2e-3);  // rest: only the build-up
}

TEST(Background, AddsItsStress) {
  HerschelBulkley law = bingham();
  law.parameters.background_viscosity = 2.0;
  const Measurement m = measure_steady(law, {.rates = {10.0}});
  EXPECT_NEAR(m.table.column("shear_stress")[0], 67.318474 + 20.0, 1e-4 * 87.0);
  EXPECT_NEAR(m.table.column("analytic_stress")[0], 67.318474 + 20.0, 1e-6 * 87.0);
  EXPECT_NEAR(*steady_shear_rate(law, 87.318474), 10.0, 1e-6);
}

}  // namespace
}  // namespace bulkley::rheometer::laws_test
