// What must hold for any law: the contract of law.hpp, and mechanics.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <random>

#include "support/law_samples.hpp"

namespace bulkley::all_laws_test {
namespace {

using namespace material_test;

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

// Snow's stretches are held one by one, also against their stress, and that gains energy.
template <class Law>
constexpr bool may_not_gain = !std::is_same_v<Law, Snow>;

class AllLaws : public testing::TestWithParam<LawSample> {
 protected:
  template <class Visit>
  void with_law(const Visit& visit) const {
    std::visit(visit, GetParam().material);
  }
  double rate() const { return GetParam().speed_of_flow; }
};

INSTANTIATE_TEST_SUITE_P(Law, AllLaws, testing::ValuesIn(law_samples()), [](const auto& test) { return test.param.id; });

TEST_P(AllLaws, RestIsFreeOfStressAndEnergyAndStaysSo) {
  with_law([](const auto& law) {
    auto state = state_at_rest(law);
    const auto before = state;
    EXPECT_EQ(norm(law.kirchhoff_stress(state)), 0.0);
    EXPECT_EQ(law.energy_density(state), 0.0);
    const auto update = law.update(state, Tensor<double>{}, 1e-3);
    EXPECT_EQ(norm(update.kirchhoff_stress), 0.0);
    EXPECT_EQ(update.dissipation, 0.0);
    EXPECT_EQ(update.plastic_shear_rate, 0.0);
    EXPECT_EQ(largest_difference(state.left_cauchy_green, before.left_cauchy_green), 0.0);
    EXPECT_EQ(state.volume_ratio, 1.0);
  });
}

TEST_P(AllLaws, ParametersAreSound) {
  with_law([](const auto& law) { EXPECT_EQ(material_fault(law).value_or(""), ""); });
}

// J holds all volume; what the update returns is the stress of the state it leaves, but for the viscous part; what it
// loses is not negative.
TEST_P(AllLaws, UpdatesAreConsistent) {
  with_law([&]<class Law>(const Law& law) {
    std::mt19937_64 random(51);
    int n_flowing = 0;
    for (int path = 0; path < 30; ++path) {
      auto state = state_at_rest(law);
      double J = 1.0;
      for (int step = 0; step < 60; ++step) {
        const Tensor<double> L = random_tensor(random, rate());
        Tensor<double> f;
        for (int c = 0; c < 9; ++c) f.c[c] = 1e-3 * L.c[c] + (c % 4 == 0 ? 1.0 : 0.0);
        J *= determinant(f);
        const auto update = law.update(state, L, 1e-3);
        ASSERT_TRUE(is_finite(state, update));
        EXPECT_NEAR(state.volume_ratio, J, 1e-13 * J);
        if (may_not_gain<Law>) {
          EXPECT_GE(update.dissipation, 0.0);
        }
        EXPECT_GE(update.plastic_shear_rate, 0.0);
        n_flowing += update.plastic_shear_rate > 0.0;
        SymTensor<double> tau = law.kirchhoff_stress(state);
        const SymTensor<double> D = shear_rate_tensor(L);
        for (int c = 0; c < 6; ++c) tau.c[c] += 2.0 * law.viscosity() * J * D.c[c];
        EXPECT_LT(largest_difference(tau, update.kirchhoff_stress), 1e-12 * bulk_stiffness(law)) << path << ' ' << step;
        if (std::string(law.law_name) != "oldroyd_b") {
          // A determinant is no better than the rounding of its largest products.
          const double size = norm(state.left_cauchy_green);
          EXPECT_NEAR(determinant(state.left_cauchy_green), 1.0, 1e-13 + 2e-15 * size * size * size);
        }
      }
    }
    EXPECT_EQ(n_flowing > 300, Law::flows) << n_flowing;
    EXPECT_EQ(n_flowing > 0, Law::flows) << n_flowing;
  });
}

// dW/dt = tau : D along any motion during which nothing flows.
TEST_P(AllLaws, StressIsTheDerivativeOfTheEnergy) {
  with_law([](const auto& law) {
    std::mt19937_64 random(52);
    for (int i = 0; i < 300; ++i) {
      const auto state = reachable_state(law, random, 0.15);
      const Tensor<double> L = random_tensor(random, 1.0);
      constexpr double step = 1e-5;
      auto after = state, before = state;
      move_elastically(law, after, L, step);
      move_elastically(law, before, L, -step);
      const double power = (law.energy_density(after) - law.energy_density(before)) / (2.0 * step);
      EXPECT_NEAR(power, contract(law.kirchhoff_stress(state), L), 1e-6 * bulk_stiffness(law)) << i;
    }
  });
}

// rho_0 c^2 = d^2/de^2 W((1 + e m n^T) F) for a plane wave with displacements along m, in direction n. Returns the largest
// eigenvalue of that quadratic form in m, over rho_0.
template <class Law, int n>
double fastest_wave(const Law& law, const State<double, n>& state, const Eigen::Vector3d& direction) {
  const auto curvature = [&](const Eigen::Vector3d& m) {
    constexpr double step = 1e-3;
    const auto energy = [&](double e) {
      auto moved = state;
      move_elastically(law, moved, tensor(m * direction.transpose()), e);
      return law.energy_density(moved);
    };
    return (-energy(2 * step) + 16 * energy(step) - 30 * energy(0.0) + 16 * energy(-step) - energy(-2 * step)) /
           (12 * step * step);
  };
  const auto unit = [](int k) -> Eigen::Vector3d { return Eigen::Vector3d::Unit(k); };
  Eigen::Matrix3d acoustic;
  for (int i = 0; i < 3; ++i) acoustic(i, i) = curvature(unit(i));
  for (int i = 0; i < 3; ++i)
    for (int j = i + 1; j < 3; ++j)
      acoustic(i, j) = acoustic(j, i) = 0.5 * (curvature(unit(i) + unit(j)) - acoustic(i, i) - acoustic(j, j));
  return Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(acoustic).eigenvalues().maxCoeff() / law.density();
}

TEST_P(AllLaws, WaveSpeedBoundsEveryPlaneWave) {
  with_law([&](const auto& law) {
    std::mt19937_64 random(53);
    std::normal_distribution<double> normal(0.0, 1.0);
    double largest_ratio = 0.0;
    for (int i = 0; i < 3000; ++i) {
      auto state = reachable_state(law, random, 0.05 * (1 + i % 8));
      // Where the stiffness jumps no differences can be taken: the fluid that does not pull, the tip of sand.
      if (std::string(GetParam().id) == "newtonian_without_tension" && std::fabs(state.volume_ratio - 1.0) < 1e-2) continue;
      if constexpr (std::is_same_v<std::decay_t<decltype(law)>, DruckerPrager>)
        if (std::fabs(std::log(state.volume_ratio) - law.tip_strain()) < 1e-2) continue;
      Eigen::Vector3d n = random_vector(normal, random);
      if (i % 2 == 0)  // a principal direction
        n = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix(state.left_cauchy_green)).eigenvectors().col(i / 2 % 3);
      n.normalize();
      const double ratio = fastest_wave(law, state, n) / law.wave_speed_squared(state);
      EXPECT_LE(ratio, 1.0 + 1e-5) << i << " J " << state.volume_ratio;
      largest_ratio = std::max(largest_ratio, ratio);
    }
    EXPECT_GE(largest_ratio, 0.85);  // nor lax
  });
}

// The outcome of a step seen by a turned observer, and, without a stress that follows the rate, with the step's rotation
// turned on further.
TEST_P(AllLaws, IsObjective) {
  with_law([&](const auto& law) {
    std::mt19937_64 random(54);
    constexpr double dt = 1e-3;
    for (int i = 0; i < 200; ++i) {
      const auto start = reachable_state(law, random, 0.05);
      const Tensor<double> L = random_tensor(random, rate());
      const Eigen::Matrix3d Q = random_rotation(random);
      auto plain = start;
      const auto update = law.update(plain, L, dt);
      const auto expected = rotated(law, plain, tensor(Q));
      const auto expected_tau = push_forward(tensor(Q), update.kirchhoff_stress);
      const auto expect_rotated = [&](auto state, const Eigen::Matrix3d& turned_L) {
        const auto turned = law.update(state, tensor(turned_L), dt);
        EXPECT_LT(largest_difference(state.left_cauchy_green, expected.left_cauchy_green), 1e-12);
        EXPECT_NEAR(state.volume_ratio, expected.volume_ratio, 1e-12);
        EXPECT_LT(largest_difference(turned.kirchhoff_stress, expected_tau), 1e-12 * bulk_stiffness(law));
        EXPECT_NEAR(turned.dissipation, update.dissipation, 1e-12 * bulk_stiffness(law));
        if constexpr (n_internal < std::decay_t < decltype(law) >>> 0) {
          for (int k = 0; k < n_internal<std::decay_t<decltype(law)>>; ++k)
            EXPECT_NEAR(state.internal[k], expected.internal[k], 1e-12 * std::max(1.0, std::fabs(expected.internal[k])));
        }
      };
      expect_rotated(rotated(law, start, tensor(Q)), Q * matrix(L) * Q.transpose());
      if (law.viscosity() == 0.0) {
        const Eigen::Matrix3d one = Eigen::Matrix3d::Identity();
        expect_rotated(start, (Q * (one + dt * matrix(L)) - one) / dt);
      }
    }
  });
}

// Particles at rest, elastic, flowing and torn side by side.
TEST_P(AllLaws, EachLaneIsTheScalarResultWhateverItsNeighbours) {
  with_law([&]<class Law>(const Law& law) {
    constexpr int n = n_internal<Law>;
    std::mt19937_64 random(55);
    const double increments[] = {0.0, 1e-9, 1e-3, 5e-2, 1e-6, 1e-2, 0.2, 1e-4};  // dt |L|
    for (const double dt : {1e-9, 1e-3, 10.0})
      for (int i = 0; i < 300; ++i) {
        State<double, n> one[n_lanes];
        Tensor<double> L[n_lanes];
        State<Pack, n> state;
        Tensor<Pack> gradient;
        for (int lane = 0; lane < n_lanes; ++lane) {
          one[lane] = lane == i % n_lanes ? state_at_rest(law) : reachable_state(law, random, 0.05 * lane);
          L[lane] = random_tensor(random, increments[(lane + i) % 8] / dt);
          for (int c = 0; c < 6; ++c) state.left_cauchy_green.c[c][lane] = one[lane].left_cauchy_green.c[c];
          state.volume_ratio[lane] = one[lane].volume_ratio;
          if constexpr (n > 0)
            for (int k = 0; k < n; ++k) state.internal[k][lane] = one[lane].internal[k];
          for (int c = 0; c < 9; ++c) gradient.c[c][lane] = L[lane].c[c];
        }
        const auto packs = law.update(state, gradient, dt);
        const Pack speed = law.wave_speed_squared(state), energy = law.energy_density(state);
        for (int lane = 0; lane < n_lanes; ++lane) {
          const auto scalar = law.update(one[lane], L[lane], dt);
          const auto lane_state = of_lane(state, lane);
          const auto lane_update = of_lane(packs, lane);
          const auto expect_same = [&](double value, double expected) {
            const bool same = to_bits(value) == to_bits(expected) || (std::isnan(value) && std::isnan(expected));
            EXPECT_TRUE(same) << value << " is not " << expected << ", lane " << lane << ", dt " << dt;
          };
          for (int c = 0; c < 6; ++c) {
            expect_same(lane_state.left_cauchy_green.c[c], one[lane].left_cauchy_green.c[c]);
            expect_same(lane_update.kirchhoff_stress.c[c], scalar.kirchhoff_stress.c[c]);
          }
          expect_same(lane_state.volume_ratio, one[lane].volume_ratio);
          if constexpr (n > 0)
            for (int k = 0; k < n; ++k) expect_same(lane_state.internal[k], one[lane].internal[k]);
          expect_same(lane_update.plastic_shear_rate, scalar.plastic_shear_rate);
          expect_same(lane_update.dissipation, scalar.dissipation);
          expect_same(speed[lane], law.wave_speed_squared(one[lane]));
          expect_same(energy[lane], law.energy_density(one[lane]));
        }
      }
  });
}

// Whatever of its inputs is NaN, the law ends, and the kernel will notice.
TEST_P(AllLaws, NaNShows) {
  with_law([&]<class Law>(const Law& law) {
    std::mt19937_64 random(56);
    const auto start = reachable_state(law, random, 0.1);
    const Tensor<double> L = random_tensor(random, rate());
    for (int c = 0; c < 9; ++c) {
      auto state = start;
      Tensor<double> bad = L;
      bad.c[c] = nan_value;
      const auto update = advance<Pack>(law, state, bad, 1e-3);
      EXPECT_FALSE(is_finite(state, update)) << "L " << c;
    }
    if (std::string(law.law_name) != "newtonian") {  // which does not read it
      for (int c = 0; c < 6; ++c) {
        auto state = start;
        state.left_cauchy_green.c[c] = nan_value;
        const auto update = advance<Pack>(law, state, L, 1e-3);
        EXPECT_FALSE(is_finite(state, update)) << "b " << c;
      }
    }
    auto lost = start;
    lost.volume_ratio = nan_value;
    const auto update = advance<Pack>(law, lost, L, 1e-3);
    EXPECT_FALSE(is_finite(lost, update)) << "J";
    if constexpr (n_internal < Law >> 0)
      for (int k = 0; k < n_internal<Law>; ++k) {
        auto state = start;
        state.internal[k] = nan_value;
        const auto after = advance<Pack>(law, state, L, 1e-3);
        EXPECT_FALSE(is_finite(state, after)) << "internal " << k;
      }
  });
}

// What is left of the work of the stress at the end of each of `n` steps, after storage and dissipation; and that work.
template <class Law>
std::pair<double, double> unaccounted_work(const Law& law, const Tensor<double>& L, double duration, int n) {
  auto state = state_at_rest(law);
  double work = 0.0, dissipation = 0.0;
  for (int step = 0; step < n; ++step) {
    const auto update = law.update(state, L, duration / n);
    for (int r = 0; r < 3; ++r)
      for (int c = 0; c < 3; ++c) work += update.kirchhoff_stress(r, c) * L(r, c) * duration / n;
    dissipation += update.dissipation;
  }
  return {work - law.energy_density(state) - dissipation, work};
}

// All work is stored or dissipated in the limit of small steps: what is left is of first order, and gone by extrapolation.
TEST_P(AllLaws, WorkIsStoredOrDissipated) {
  with_law([&](const auto& law) {
    std::mt19937_64 random(60);
    for (int path = 0; path < 8; ++path) {
      Tensor<double> L = random_tensor(random, rate());
      if (L(0, 0) + L(1, 1) + L(2, 2) > 0.0)  // sand does nothing where it expands
        for (double& c : L.c) c = -c;
      const auto [coarse, work] = unaccounted_work(law, L, 1e-2, 1000);
      const auto [fine, finer_work] = unaccounted_work(law, L, 1e-2, 2000);
      EXPECT_GT(work, 0.0);
      EXPECT_NEAR(2.0 * fine - coarse, 0.0, 1e-4 * work) << path << ": " << coarse << ", " << fine;
    }
  });
}

// Far beyond what a simulation should meet, results stay numbers, and the elastic volume follows.
TEST_P(AllLaws, ExtremeStatesStayFinite) {
  with_law([&](const auto& law) {
    const Tensor<double> extremes[] = {
        diagonal(-0.415196452357427, -0.415196452357427, -0.415196452357427),  // J = 0.2
        diagonal(0.709975946676697, 0.709975946676697, 0.709975946676697),     // J = 5
        diagonal(2.0, -0.422649730810374, -0.422649730810374),                 // stretch 3 at constant volume
        diagonal(0.732050807568877, 0.732050807568877, -2.0 / 3.0),            // squeezed to a third
        {{0, 10, 0, 0, 0, 0, 0, 0, 0}},                                        // shear of 10
        {{0, -1, 0, 1, 0, 0, 0, 0, 0}},                                        // a turn that is not small
        diagonal(1e-12, -1e-12, 1e-13),
    };
    for (const Tensor<double>& increment : extremes)
      for (const double dt : {1e-12, 1e-3, 1.0, 1e6}) {
        auto state = state_at_rest(law);
        Tensor<double> L = increment;
        for (double& c : L.c) c /= dt;
        for (int step = 0; step < 2; ++step) {
          const auto update = advance<Pack>(law, state, step == 0 ? L : Tensor<double>{}, dt);
          EXPECT_TRUE(is_finite(state, update)) << dt;
          if (may_not_gain<std::decay_t<decltype(law)>>) {
            EXPECT_GE(update.dissipation, 0.0);
          }
          const double speed = law.wave_speed_squared(state);
          EXPECT_TRUE(std::isfinite(speed) && speed > 0.0) << speed;
          EXPECT_TRUE(std::isfinite(law.energy_density(state)));
        }
      }
  });
}

// --- laws without a time of their own -------------------------------------------------------------------------------------

class RateIndependent : public AllLaws {};
INSTANTIATE_TEST_SUITE_P(Law, RateIndependent,
                         testing::Values(LawSample{"plastic", HerschelBulkley{{1000.0, 1e5, 1e4, 300.0, 0.0, 0.5}}, 30.0},
                                         LawSample{"sand", reference_sand(), 10.0},
                                         LawSample{"cohesive_sand", cohesive_sand(), 10.0},
                                         LawSample{"snow", reference_snow(), 20.0}),
                         [](const auto& test) { return test.param.id; });

// What has returned to the yield surface lies on it: a second step without motion changes nothing.
TEST_P(RateIndependent, TheReturnIsIdempotent) {
  with_law([&]<class Law>(const Law& law) {
    std::mt19937_64 random(57);
    int n_flowing = 0;
    for (int i = 0; i < 500; ++i) {
      auto state = state_at_rest(law);
      const auto first = law.update(state, random_tensor(random, rate()), 1e-3 * (1 + i % 20));
      const auto before = state;
      const auto second = law.update(state, Tensor<double>{}, 1e-3);
      n_flowing += first.plastic_shear_rate > 0.0;
      EXPECT_LT(largest_difference(state.left_cauchy_green, before.left_cauchy_green), 1e-14);
      EXPECT_LT(largest_difference(first.kirchhoff_stress, second.kirchhoff_stress), 1e-13 * bulk_stiffness(law));
      EXPECT_EQ(state.volume_ratio, before.volume_ratio);
      EXPECT_LT(second.plastic_shear_rate * 1e-3, 1e-13);
      EXPECT_LT(second.dissipation, 1e-13 * bulk_stiffness(law));
      if constexpr (n_internal < Law >> 0) {
        EXPECT_NEAR(state.internal[0], before.internal[0], 1e-14);
      }
    }
    EXPECT_GT(n_flowing, 300);
  });
}

// And dt does not matter.
TEST_P(RateIndependent, OnlyTheIncrementCounts) {
  with_law([&](const auto& law) {
    std::mt19937_64 random(58);
    for (int i = 0; i < 100; ++i) {
      auto slow = reachable_state(law, random, 0.05), quick = slow;
      Tensor<double> L = random_tensor(random, 0.02);
      const auto once = law.update(slow, L, 1.0);
      for (double& c : L.c) c *= 1024.0;
      const auto again = law.update(quick, L, 1.0 / 1024.0);
      EXPECT_EQ(largest_difference(once.kirchhoff_stress, again.kirchhoff_stress), 0.0);
      EXPECT_EQ(once.dissipation, again.dissipation);
      EXPECT_NEAR(once.plastic_shear_rate * 1024.0, again.plastic_shear_rate, 1e-12 * again.plastic_shear_rate);
    }
  });
}

}  // namespace
}  // namespace bulkley::all_laws_test
