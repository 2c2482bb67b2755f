// The Newtonian stress that a step may treat implicitly, taken apart from the rest of each law.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "material/viscous_stress.hpp"
#include "support/law_samples.hpp"

namespace bulkley::viscosity_test {
namespace {

using namespace material_test;

class SeparableViscosity : public testing::TestWithParam<LawSample> {};

// tau = (tau of the rest) + 2 eta J dev sym L, and dissipation likewise.
TEST_P(SeparableViscosity, StressAndDissipationAreThoseOfTheRestAndOfTheViscosity) {
  const Material rest = without_viscosity(GetParam().material);
  const double viscosity = separable_viscosity(GetParam().material);
  EXPECT_EQ(separable_viscosity(rest), 0.0);
  std::visit(
      [&]<class Law>(const Law& law) {
        EXPECT_EQ(viscosity, law.viscosity());
        std::mt19937_64 random(17);
        std::uniform_real_distribution<double> uniform(-30.0, 30.0);
        for (int i = 0; i < 50; ++i) {
          auto state = reachable_state(law, random, 0.2);
          auto other = state;
          Tensor<double> L;
          for (double& component : L.c) component = uniform(random);
          const double dt = 1e-3;
          const Update<double> whole = law.update(state, L, dt);
          Update<double> sum = std::get<Law>(rest).update(other, L, dt);
          add_viscous_stress(sum, L, state.volume_ratio, viscosity, dt);
          double scale = 1.0;
          for (const double component : whole.kirchhoff_stress.c) scale = std::max(scale, std::fabs(component));
          EXPECT_EQ(state.volume_ratio, other.volume_ratio);
          for (int c = 0; c < 6; ++c) EXPECT_NEAR(whole.kirchhoff_stress.c[c], sum.kirchhoff_stress.c[c], 1e-12 * scale);
          EXPECT_NEAR(whole.dissipation, sum.dissipation, 1e-12 * (1.0 + whole.dissipation));
          EXPECT_EQ(whole.plastic_shear_rate, sum.plastic_shear_rate);
        }
      },
      GetParam().material);
}

const auto name = [](const auto& test) { return test.param.id; };
INSTANTIATE_TEST_SUITE_P(Law, SeparableViscosity, testing::ValuesIn(law_samples()), name);

TEST(SeparableViscosity, SomeSamplesHaveOne) {
  const auto samples = law_samples();
  EXPECT_GE(
      std::count_if(samples.begin(), samples.end(), [](const auto& s) { return separable_viscosity(s.material) > 0.0; }), 3);
}

}  // namespace
}  // namespace bulkley::viscosity_test
