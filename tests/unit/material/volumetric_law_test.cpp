// Reference: differences of each law's own energy and stress.

#include "material/volumetric_law.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>

#include "support/law_samples.hpp"

namespace bulkley::volumetric_law_test {
namespace {

using namespace material_test;

class VolumetricPart : public testing::TestWithParam<LawSample> {
 protected:
  /// Reachable states whose volume ratio runs over the range in which the sample's stress is that of `volumetric_law`.
  template <class Visit>
  void at_states(const Visit& visit) const {
    const std::optional<VolumetricLaw> part = volumetric_law(GetParam().material);
    const double largest = part && !part->tension ? 0.99 : 1.8;
    std::visit(
        [&](const auto& law) {
          std::mt19937_64 random(91);
          std::uniform_real_distribution<double> ratio(0.4, largest);
          for (int i = 0; i < 50; ++i) {
            auto state = reachable_state(law, random, 0.2);
            state.volume_ratio = ratio(random);
            visit(law, state);
          }
        },
        GetParam().material);
  }
};

std::vector<LawSample> samples(bool with_part) {
  std::vector<LawSample> result;
  for (const LawSample& sample : law_samples())
    if (volumetric_law(sample.material).has_value() == with_part) result.push_back(sample);
  return result;
}

class WithVolumetricPart : public VolumetricPart {};
class WithoutVolumetricPart : public VolumetricPart {};
const auto name = [](const auto& test) { return test.param.id; };
INSTANTIATE_TEST_SUITE_P(Law, WithVolumetricPart, testing::ValuesIn(samples(true)), name);
INSTANTIATE_TEST_SUITE_P(Law, WithoutVolumetricPart, testing::ValuesIn(samples(false)), name);

// A central difference over h J errs by h^2 / 6 of the third derivative and by 1e-16 / h of the energy.
TEST_P(WithVolumetricPart, StressIsTheDerivativeOfTheEnergyByVolume) {
  const VolumetricLaw part = volumetric_law(GetParam().material).value();
  at_states([&](const auto& law, auto state) {
    const double J = state.volume_ratio, h = 1e-5 * J;
    state.volume_ratio = J + h;
    const double above = law.energy_density(state);
    state.volume_ratio = J - h;
    const double below = law.energy_density(state);
    const double scale = part.bulk_modulus + part.slope(J) + std::fabs(above) + std::fabs(part.stress(J));
    EXPECT_NEAR(part.stress(J), (above - below) / (2.0 * h), 1e-8 * scale) << J;
  });
}

TEST_P(WithVolumetricPart, SlopeIsTheDerivativeOfTheStress) {
  const VolumetricLaw part = volumetric_law(GetParam().material).value();
  for (double J = 0.4; J < 2.4; J += 0.05) {
    const double h = 1e-5 * J, slope = part.slope(J);
    EXPECT_NEAR(slope, (part.stress(J + h) - part.stress(J - h)) / (2.0 * h), 1e-8 * (slope + part.bulk_modulus)) << J;
  }
}

TEST_P(WithVolumetricPart, RestIsFreeOfItAndAsStiffAsTheBulkModulus) {
  const VolumetricLaw part = volumetric_law(GetParam().material).value();
  EXPECT_EQ(part.stress(1.0), 0.0);
  EXPECT_NEAR(part.slope(1.0), part.bulk_modulus, 1e-14 * part.bulk_modulus);
}

// tau = (tau of the rest) + J p 1.
TEST_P(WithVolumetricPart, StressIsThatOfTheRestAndOfThePart) {
  const VolumetricLaw part = volumetric_law(GetParam().material).value();
  const Material rest = without_volumetric_law(GetParam().material);
  at_states([&]<class Law>(const Law& law, const auto& state) {
    const auto whole = law.kirchhoff_stress(state), other = std::get<Law>(rest).kirchhoff_stress(state);
    const double J = state.volume_ratio, volumetric = J * part.stress(J);
    const double scale = largest_component(whole) + largest_component(other) + part.bulk_modulus;
    for (int c = 0; c < 6; ++c)
      EXPECT_NEAR(whole.c[c] - other.c[c], c < 3 ? volumetric : 0.0, 1e-13 * scale) << J << ' ' << c;
  });
}

TEST_P(WithVolumetricPart, WavesOfTheRestAreSlower) {
  const Material rest = without_volumetric_law(GetParam().material);
  at_states([&]<class Law>(const Law& law, const auto& state) {
    const double whole = law.wave_speed_squared(state), other = std::get<Law>(rest).wave_speed_squared(state);
    EXPECT_LT(other, whole);
    EXPECT_GE(other, 0.0);
  });
}

TEST_P(WithoutVolumetricPart, MaterialsComeBackAsTheyAre) {
  const Material rest = without_volumetric_law(GetParam().material);
  at_states([&]<class Law>(const Law& law, const auto& state) {
    const Law& same = std::get<Law>(rest);
    EXPECT_EQ(same.density(), law.density());
    EXPECT_EQ(same.wave_speed_squared(state), law.wave_speed_squared(state));
    EXPECT_EQ(same.energy_density(state), law.energy_density(state));
    EXPECT_EQ(largest_difference(same.kirchhoff_stress(state), law.kirchhoff_stress(state)), 0.0);
  });
}

// The solids of a stress that turns with shape and volume together have none; a law that loses its own is seen here.
TEST(VolumetricLawOfSamples, IsThatOfTheLawsThatKeepItApart) {
  for (const LawSample& sample : law_samples()) {
    const std::string law = bulkley::law_name(sample.material);
    const bool none = law == "fixed_corotated" || law == "drucker_prager" || law == "snow";
    EXPECT_EQ(volumetric_law(sample.material).has_value(), !none) << sample.id;
    if (!none) {
      EXPECT_EQ(volumetric_law(sample.material)->tension, std::string(sample.id) != "newtonian_without_tension");
    }
  }
}

// Hencky's p falls from J = e on.
TEST(VolumetricLawOfHencky, SlopeStaysPositiveWhereTheStressFalls) {
  const VolumetricLaw part{VolumetricLaw::Form::hencky, 1e5};
  for (const double J : {std::exp(0.95), std::exp(1.0), 4.0, 20.0})
    EXPECT_NEAR(part.slope(J), 0.1 * 1e5 / (J * J), 1e-12 * 1e5) << J;
}

TEST(VolumetricLawOfTait, WholeExponentsAreThePowersOfOthers) {
  for (const double n : {1.0, 2.0, 7.0, 16.0}) {
    const VolumetricLaw whole{VolumetricLaw::Form::tait, 1e5, n}, near{VolumetricLaw::Form::tait, 1e5, n * (1.0 + 1e-15)};
    for (const double J : {0.7, 0.95, 1.3}) {
      EXPECT_NEAR(whole.stress(J), near.stress(J), 1e-12 * (1e5 + std::fabs(near.stress(J)))) << n << ' ' << J;
      EXPECT_NEAR(whole.slope(J), near.slope(J), 1e-12 * near.slope(J)) << n << ' ' << J;
    }
  }
}

}  // namespace
}  // namespace bulkley::volumetric_law_test
