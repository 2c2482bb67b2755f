// The stress that falls across a particle's layer, through the kernel.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "kernel/stress_update.hpp"
#include "rheometer/specimen.hpp"

namespace bulkley::falling_stress_test {
namespace {

using rheometer::Flow;

HerschelBulkley::Parameters paste() { return {3000.0, 1e6, 5e4, 20.0, 5.0, 0.6}; }
Material plain() { return HerschelBulkley{paste()}; }
Material magnetic() {
  HerschelBulkley::Parameters p = paste();
  p.field_yield = {FieldYield::Form::tanh, 500.0, 1e5};
  return HerschelBulkley{p};
}
Material thixotropic() {
  ThixotropicHerschelBulkley::Parameters p;
  static_cast<HerschelBulkley::Parameters&>(p) = paste();
  p.build_up = 0.1;
  p.breakdown = 0.5;
  return ThixotropicHerschelBulkley{p};
}

/// sigma_xy of two particles sheared at 1e-4 1/s to a strain of 0.05, the second with `fall`.
std::vector<double> sheared(const Material& material, double fall) {
  ParticleSet particles = rheometer::make_specimen(material);
  particles.resize(2);
  set_internal_variables(material, 0, particles);
  const Tensor<double> L = rheometer::step_gradient(Flow::simple_shear, 1e-4, 1.0);
  for (int p = 0; p < 2; ++p) {
    for (int c = 0; c < 3; ++c) particles.real(Field::left_cauchy_green, c)[p] = 1.0;
    particles.real(Field::volume_ratio)[p] = 1.0;
    particles.real(Field::reference_volume)[p] = particles.real(Field::reference_volume)[0];
    particles.material()[p] = 0;
    particles.id()[p] = p;
    if (particles.has(Field::magnetic_field_strength)) particles.real(Field::magnetic_field_strength)[p] = 2e3;
    for (int c = 0; c < 9; ++c) particles.real(Field::velocity_gradient, c)[p] = L.c[c];
  }
  std::vector<double> falls(2 + n_lanes, 0.0);
  falls[1] = fall;
  for (int step = 0; step < 500; ++step) {
    StepBounds bounds;
    stress_update(material, 0, Field::velocity_gradient, 1.0, particles, bounds, {0, 2}, {}, {}, falls.data());
    EXPECT_FALSE(bounds.failed());
  }
  return {particles.real(Field::kirchhoff_stress, 3)[0], particles.real(Field::kirchhoff_stress, 3)[1]};
}

TEST(FallingStress, ParticlesFlowWhereTheStressAtTheFloorIsTheYieldStress) {
  for (const Material& material : {plain(), magnetic(), thixotropic()}) {
    const std::vector<double> without = sheared(material, 0.0), stress = sheared(material, 0.4);
    EXPECT_EQ(without[0], without[1]);
    EXPECT_EQ(stress[0], without[0]) << "its neighbour's fall is not its own";
    EXPECT_GT(stress[1], 0.6 * 20.0 / std::sqrt(3.0)) << law_name(material);
    EXPECT_LT(stress[1], 0.75 * stress[0]) << law_name(material);
  }
}

TEST(FallingStress, IsOfFluidsWithAYieldStress) {
  EXPECT_TRUE(has_yield_stress(plain()));
  EXPECT_TRUE(has_yield_stress(thixotropic()));
  HerschelBulkley::Parameters without = paste();
  without.sigma_Y = 0.0;
  EXPECT_FALSE(has_yield_stress(HerschelBulkley{without}));
  without.field_yield = {FieldYield::Form::tanh, 500.0, 1e5};
  EXPECT_TRUE(has_yield_stress(HerschelBulkley{without}));
  const Material water = Newtonian{{1000.0, 1e5, 1.0}};
  EXPECT_FALSE(has_yield_stress(water));
  const std::vector<double> stress = sheared(water, 0.4);
  EXPECT_EQ(stress[0], stress[1]);
}

}  // namespace
}  // namespace bulkley::falling_stress_test
