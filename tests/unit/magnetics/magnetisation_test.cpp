#include "magnetics/magnetisation.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

namespace bulkley::magnetisation_test {
namespace {

using Law = Magnetisation::Law;

const std::vector<Magnetisation> samples = {
    {Law::linear, 3.0}, {Law::langevin, 1.0, 3e4}, {Law::froehlich_kennelly, 5.0, 4.3e5}, {Law::exponential, 5.76, 4.18e5}};
const std::vector<double> fields = {0.0, 1.0, 300.0, 999.0, 1001.0, 1e4, 9e4, 3e5, 1e7};

/// The field inside a ball in the uniform field `applied`, by halving: H + m/3 = applied.
double field_in_ball(const Magnetisation& law, double applied) {
  double low = 0.0, high = applied;
  for (int n = 0; n < 200; ++n) {
    const double middle = 0.5 * (low + high);
    (middle + law.at(middle) / 3.0 < applied ? low : high) = middle;
  }
  return low;
}

TEST(Magnetisation, SlopeIsTheDerivative) {
  for (const Magnetisation& law : samples)
    for (const double H : fields) {
      if (H == 0.0) continue;
      const double step = 1e-4 * H;
      const double difference = (law.at(H + step) - law.at(H - step)) / (2.0 * step);
      EXPECT_NEAR(law.slope(H), difference, 1e-7 * law.susceptibility) << static_cast<int>(law.law) << " " << H;
    }
}

TEST(Magnetisation, CoEnergyIsTheIntegral) {
  // Gauss's rule with 3 points on 4000 pieces.
  const double node = std::sqrt(0.6);
  for (const Magnetisation& law : samples)
    for (const double H : fields) {
      double sum = 0.0;
      const int pieces = 4000;
      const double half = 0.5 * H / pieces;
      for (int n = 0; n < pieces; ++n) {
        const double middle = (2 * n + 1) * half;
        sum += half / 9.0 * (5.0 * law.at(middle - node * half) + 8.0 * law.at(middle) + 5.0 * law.at(middle + node * half));
      }
      EXPECT_NEAR(law.co_energy(H), sum, 1e-11 * sum) << static_cast<int>(law.law) << " " << H;
    }
}

TEST(Magnetisation, StartsWithItsSusceptibilityAndSaturates) {
  for (const Magnetisation& law : samples) {
    EXPECT_EQ(law.at(0.0), 0.0);
    EXPECT_EQ(law.co_energy(0.0), 0.0);
    EXPECT_DOUBLE_EQ(law.slope(0.0), law.initial_susceptibility());
    EXPECT_NEAR(law.at(1e-3) / 1e-3, law.susceptibility, 1e-6);
    if (law.law == Law::linear) continue;
    EXPECT_LE(law.at(1e12), law.saturation);
    EXPECT_NEAR(law.at(1e12), law.saturation, 1e-5 * law.saturation);
    EXPECT_TRUE(std::isfinite(law.co_energy(1e12)));
  }
}

TEST(Magnetisation, SeriesMeetTheClosedForms) {
  // Where a law changes from the one to the other its value must not jump. 1e-10 is the smoothness over twice the step.
  for (const Magnetisation& law : samples)
    for (const double x : {0.01, 0.1 / 3.0}) {
      if (law.law == Law::linear) continue;
      const double H = x * law.saturation / law.susceptibility;
      const double below = H * (1.0 - 1e-13), above = H * (1.0 + 1e-13);
      EXPECT_NEAR(law.at(above) / law.at(below), 1.0, 2e-12);
      EXPECT_NEAR(law.slope(above) / law.slope(below), 1.0, 2e-12);
      EXPECT_NEAR(law.co_energy(above) / law.co_energy(below), 1.0, 2e-12);
    }
}

// Two laws by other means: 40-digit arithmetic.
TEST(Magnetisation, HasTheFieldsInsideBalls) {
  struct Row {
    Magnetisation law;
    double applied, field, magnetisation;
  };
  const auto carlson = [](double iron) {
    const double saturation = 1.91 * std::pow(iron, 1.133) / vacuum_permeability;
    return Magnetisation{Law::exponential, 10.97 * vacuum_permeability * saturation, saturation};
  };
  const std::vector<Row> rows = {{{Law::langevin, 1.0, 3e4}, 1e4, 7568.528999, 7294.413002},
                                 {{Law::langevin, 1.0, 3e4}, 1e5, 91097.72204, 26706.83387},
                                 {{Law::langevin, 3.0, 4e5}, 1e5, 52113.3369, 143659.9893},
                                 {{Law::froehlich_kennelly, 5.0, 4.3e5}, 5e4, 21419.386, 85741.842},
                                 {carlson(0.32), 5e4, 18554.912536, 94335.262393},
                                 {carlson(0.32), 2e5, 97171.528305, 308485.415085},
                                 {carlson(0.05), 1e5, 88045.340948, 35863.977155}};
  for (const Row& row : rows) {
    const double H = field_in_ball(row.law, row.applied);
    EXPECT_NEAR(H, row.field, 1e-7 * row.field);
    EXPECT_NEAR(row.law.at(H), row.magnetisation, 1e-7 * row.magnetisation);
  }
}

}  // namespace
}  // namespace bulkley::magnetisation_test
