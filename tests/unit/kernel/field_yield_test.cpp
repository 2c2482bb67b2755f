// The yield stress in a magnetic field, through the kernel.

#include <gtest/gtest.h>

#include <cmath>

#include "kernel/stress_update.hpp"
#include "rheometer/specimen.hpp"

namespace bulkley::field_yield_test {
namespace {

using rheometer::Flow;

HerschelBulkley::Parameters paste() {
  HerschelBulkley::Parameters p{3000.0, 1e6, 5e4, 20.0, 5.0, 0.6};
  p.field_yield = {FieldYield::Form::tanh, 500.0, 1e5};
  p.background_viscosity = 0.3;
  return p;
}
HerschelBulkley plain_paste() { return HerschelBulkley{paste()}; }
ThixotropicHerschelBulkley thixotropic_paste() {
  ThixotropicHerschelBulkley::Parameters p;
  static_cast<HerschelBulkley::Parameters&>(p) = paste();
  p.field_yield.form = FieldYield::Form::power;
  p.build_up = 0.1;
  p.breakdown = 0.5;
  p.residual_yield = 0.2;
  return ThixotropicHerschelBulkley{p};
}

/// sigma_xy after a shear strain of 0.2 at 2 1/s, in the field (A/m) where the particle has one.
double sheared(const Material& material, double field) {
  ParticleSet particles = rheometer::make_specimen(material);
  if (particles.has(Field::magnetic_field_strength)) particles.real(Field::magnetic_field_strength)[0] = field;
  const Tensor<double> L = rheometer::step_gradient(Flow::simple_shear, 2e-3, 1e-3);
  for (int c = 0; c < 9; ++c) particles.real(Field::velocity_gradient, c)[0] = L.c[c];
  for (int step = 0; step < 100; ++step) {
    StepBounds bounds;
    stress_update(material, 0, Field::velocity_gradient, 1e-3, particles, bounds);
    EXPECT_FALSE(bounds.failed());
  }
  if (particles.has(Field::magnetic_field_strength)) {
    EXPECT_EQ(particles.real(Field::magnetic_field_strength)[0], field);
  }
  return particles.real(Field::kirchhoff_stress, 3)[0];
}

TEST(FieldYield, HasItsTwoForms) {
  const FieldYield carlson{FieldYield::Form::tanh, 47870.0, 158e3};
  for (const double H : {0.0, 1.0, 3e4, 158e3, 1e6, 1e9})
    EXPECT_NEAR(carlson.at(H), 47870.0 * std::tanh(H / 158e3), 1e-11 * 47870.0) << H;
  const FieldYield ginder{FieldYield::Form::power, 1000.0, 1e5};
  EXPECT_NEAR(ginder.at(2.5e4), 125.0, 1e-12);
  EXPECT_EQ(ginder.at(1e5), 1000.0);
  EXPECT_EQ(ginder.at(5e5), 1000.0);
  EXPECT_EQ(FieldYield{}.at(1e5), 0.0);
}

TEST(FieldYield, IsTheYieldStressAtTheParticle) {
  for (const Material& material : {Material{plain_paste()}, Material{thixotropic_paste()}})
    for (const double field : {0.0, 2e4, 9e4, 4e5}) {
      const double expected = sheared(at_field(material, field), 0.0);
      EXPECT_NEAR(sheared(material, field), expected, 1e-11 * expected) << law_name(material) << " " << field;
    }
  EXPECT_GT(sheared(plain_paste(), 9e4), 10.0 * sheared(plain_paste(), 0.0));
}

TEST(FieldYield, IsHeldByParticlesOnlyWhereAMaterialAsksForIt) {
  HerschelBulkley::Parameters p = paste();
  EXPECT_TRUE(rheometer::make_specimen(HerschelBulkley{p}).has(Field::magnetic_field_strength));
  p.field_yield = {};
  EXPECT_FALSE(rheometer::make_specimen(HerschelBulkley{p}).has(Field::magnetic_field_strength));
}

TEST(FieldYield, BelongsToFluidsThatYield) {
  EXPECT_TRUE(takes_field_yield(plain_paste()));
  EXPECT_TRUE(takes_field_yield(thixotropic_paste()));
  EXPECT_FALSE(takes_field_yield(Newtonian{{1000.0, 1e5, 1.0}}));
  const Material water = Newtonian{{1000.0, 1e5, 1.0}};
  EXPECT_FALSE(field_yield(with_field_yield(water, paste().field_yield)).given());
  EXPECT_FALSE(field_yield(at_field(plain_paste(), 1e5)).given());
}

}  // namespace
}  // namespace bulkley::field_yield_test
