// Reference: Eigen's solver.

#include "bulkley/base/spectral.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "support/random_vectors.hpp"

namespace bulkley::spectral_test {
namespace {

using Symmetric = SymTensor<double>;

Eigen::Matrix3d matrix(const Symmetric& t) {
  Eigen::Matrix3d m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = t(i, j);
  return m;
}

Symmetric symmetric(const Eigen::Matrix3d& m) {
  return {{m(0, 0), m(1, 1), m(2, 2), 0.5 * (m(0, 1) + m(1, 0)), 0.5 * (m(1, 2) + m(2, 1)), 0.5 * (m(0, 2) + m(2, 0))}};
}

// Q diag(values) Q^T
Symmetric with_values(const Eigen::Vector3d& values, std::mt19937_64& random) {
  const Eigen::Matrix3d Q = random_rotation(random);
  return symmetric(Q * values.asDiagonal() * Q.transpose());
}

// Tensors of every kind that the iteration could stumble over.
std::vector<Symmetric> samples() {
  std::mt19937_64 random(31);
  std::normal_distribution<double> normal(0.0, 1.0);
  std::vector<Symmetric> all;
  for (int i = 0; i < 300; ++i) {
    Symmetric t;
    for (double& c : t.c) c = normal(random);
    all.push_back(t);  // any signs
  }
  for (int i = 0; i < 100; ++i) {
    all.push_back(with_values({1.0, 1.0, 2.0}, random));
    all.push_back(with_values({3.0, 3.0, 3.0}, random));
    for (const double gap : {1e-3, 1e-8, 1e-12, 1e-15}) {
      all.push_back(with_values({1.0, 1.0 + gap, 0.5}, random));
      all.push_back(with_values({1.0, 1.0 + gap, 1.0 - gap}, random));
    }
    for (const double ratio : {1e4, 1e8, 1e15}) all.push_back(with_values({1.0, ratio, 1.0 / ratio}, random));
  }
  for (const double size : {1e-30, 1.0, 1e30}) {
    all.push_back({{size, 2 * size, 3 * size, 0, 0, 0}});
    all.push_back({{size, size, size, 0, 0, 0}});
    all.push_back({{0, 0, 0, size, 0, 0}});
    all.push_back({{0, 0, 0, 0, size, 0}});
    all.push_back({{0, 0, 0, 0, 0, size}});
    all.push_back({{0, 0, 0, size, size, size}});
    all.push_back({{size, size, size, size, size, size}});
    all.push_back({{size, size, size, 1e-9 * size, -1e-12 * size, 1e-15 * size}});
    all.push_back({{size, 0, -size, 1e-20 * size, 0, 0}});
  }
  all.push_back({{0, 0, 0, 0, 0, 0}});
  return all;
}

double largest_value(const Symmetric& t) { return matrix(t).cwiseAbs().maxCoeff(); }

TEST(Spectrum, ValuesAreThoseOfEigen) {
  for (const Symmetric& t : samples()) {
    std::array<double, 3> values;
    std::copy_n(spectrum(t).value, 3, values.begin());
    std::sort(values.begin(), values.end());
    const Eigen::Vector3d expected = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(matrix(t)).eigenvalues();
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(values[k], expected[k], 4e-15 * largest_value(t));
  }
}

TEST(Spectrum, AxesAreOrthonormal) {
  for (const Symmetric& t : samples()) {
    const Tensor<double> axes = spectrum(t).axes;
    for (int a = 0; a < 3; ++a)
      for (int b = 0; b < 3; ++b) {
        double product = 0.0;
        for (int i = 0; i < 3; ++i) product += axes(i, a) * axes(i, b);
        EXPECT_NEAR(product, a == b ? 1.0 : 0.0, 1e-14);
      }
  }
}

TEST(Spectrum, GivesTheTensorBack) {
  for (const Symmetric& t : samples()) {
    const auto s = spectrum(t);
    const Symmetric again = from_spectrum(s.value, s.axes);
    for (int c = 0; c < 6; ++c) EXPECT_NEAR(again.c[c], t.c[c], 4e-15 * largest_value(t));
  }
}

// A value known from the structure of the tensor must come out relative to itself where the large one is separate.
TEST(Spectrum, DiagonalTensorsAreExact) {
  const auto s = spectrum(Symmetric{{1e-12, 1e12, 1.0, 0, 0, 0}});
  EXPECT_EQ(s.value[0], 1e-12);
  EXPECT_EQ(s.value[1], 1e12);
  EXPECT_EQ(s.value[2], 1.0);
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) EXPECT_EQ(s.axes(a, b), a == b ? 1.0 : 0.0);
}

TEST(Spectrum, NaNAndInfinityEndAndDoNotLookSound) {
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()})
    for (int c = 0; c < 6; ++c) {
      Symmetric t{{1.0, 2.0, 3.0, 0.1, 0.2, 0.3}};
      t.c[c] = bad;
      const auto s = spectrum(t);
      const Symmetric again = from_spectrum(s.value, s.axes);
      double sum = 0.0;
      for (const double value : again.c) sum += std::fabs(value);
      EXPECT_FALSE(std::isfinite(sum)) << c;
    }
}

// Converged, degenerate and slow tensors side by side.
TEST(Spectrum, EachLaneIsTheScalarResultWhateverItsNeighbours) {
  const std::vector<Symmetric> all = samples();
  std::mt19937_64 random(32);
  std::uniform_int_distribution<std::size_t> pick(0, all.size() - 1);
  for (int repeat = 0; repeat < 2000; ++repeat) {
    SymTensor<Pack> pack;
    std::size_t chosen[n_lanes];
    for (int lane = 0; lane < n_lanes; ++lane) {
      chosen[lane] = pick(random);
      for (int c = 0; c < 6; ++c) pack.c[c][lane] = all[chosen[lane]].c[c];
    }
    const Spectrum<Pack> lanes = spectrum(pack);
    const SymTensor<Pack> again = from_spectrum(lanes.value, lanes.axes);
    for (int lane = 0; lane < n_lanes; ++lane) {
      const Spectrum<double> scalar = spectrum(all[chosen[lane]]);
      const Symmetric scalar_again = from_spectrum(scalar.value, scalar.axes);
      for (int k = 0; k < 3; ++k) EXPECT_EQ(to_bits(double{lanes.value[k][lane]}), to_bits(scalar.value[k]));
      for (int c = 0; c < 9; ++c) EXPECT_EQ(to_bits(double{lanes.axes.c[c][lane]}), to_bits(scalar.axes.c[c]));
      for (int c = 0; c < 6; ++c) EXPECT_EQ(to_bits(double{again.c[c][lane]}), to_bits(scalar_again.c[c]));
    }
  }
}

}  // namespace
}  // namespace bulkley::spectral_test
