// Deposit and gather of one number per particle and node, against the plain sums of the reference.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>

#include "base/order_free.hpp"
#include "kernel/scalar_deposit.hpp"
#include "kernel/scalar_gather.hpp"
#include "support/reference_particles.hpp"
#include "support/serial_step.hpp"

namespace bulkley::scalar_transfer_test {
namespace {

constexpr SplineOrder orders[] = {SplineOrder::quadratic, SplineOrder::cubic};

// Particles in a box without walls, a number of each, and all nodes; 777 is no multiple of a batch.
struct Particles {
  SerialStep step;
  std::vector<double> q;

  Particles(SplineOrder order, ParticleSet set, std::vector<double> numbers)
      : step(open_scene({.order = order}), std::move(set)), q(std::move(numbers)) {}
  explicit Particles(SplineOrder order, LocalIndex count = 777)
      : Particles(order, random_particles(open_scene({.order = order}), count, 3, false, 0.49), {}) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-2.0, 3.0);
    for (LocalIndex p = 0; p < count; ++p) q.push_back(uniform(random));
  }

  const GridGeometry& grid() const { return step.scene.grid; }
  double largest() const {
    double result = 0.0;
    for (const double x : q) result = std::max(result, std::abs(x));
    return result;
  }
  std::vector<double> deposit() const {
    std::vector<double> pool(static_cast<std::size_t>(step.layout.n_nodes()), 99.0);
    scalar_deposit(grid(), step.layout, step.particles, step.map, q.data(), largest(), step.map.largest_count(),
                   pool.data());
    return pool;
  }
  struct Gathered {
    std::vector<double> value;
    std::array<std::vector<double>, 3> gradient;
  };
  Gathered gather(const std::vector<double>& phi) const {
    Gathered result{std::vector<double>(q.size()), {}};
    for (auto& column : result.gradient) column.resize(q.size());
    scalar_gather(grid(), step.layout, step.particles, step.map, {phi.data(), result.value.data()},
                  {phi.data(), {result.gradient[0].data(), result.gradient[1].data(), result.gradient[2].data()}});
    return result;
  }
  // Values at the pool's nodes of a function of position.
  template <class Function>
  std::vector<double> nodal(Function function) const {
    std::vector<double> phi;
    for (std::size_t n = 0; n < step.indices.size(); ++n) phi.push_back(function(step.node_position(n)));
    return phi;
  }
  ReferenceMpm reference() const {
    ReferenceScene scene;
    scene.grid = grid();
    scene.transfer = step.scene.transfer;
    return {scene, reference_particles(step.particles, step.scene.materials)};
  }
  // By the reference's node: the pool's. Each node of the grid is in the pool once.
  std::vector<std::size_t> pool_node() const {
    std::vector<std::size_t> at(static_cast<std::size_t>(
        grid().node_number({grid().n_nodes(0) - 1, grid().n_nodes(1) - 1, grid().n_nodes(2) - 1}) + 1));
    for (std::size_t n = 0; n < step.indices.size(); ++n) {
      const Int3& node = step.indices[n];
      bool exists = true;
      for (int axis = 0; axis < 3; ++axis) exists = exists && node[axis] < grid().n_nodes(axis);
      if (exists) at[static_cast<std::size_t>(grid().node_number(node))] = n;
    }
    return at;
  }
};

TEST(ScalarDeposit, NodesReceiveWhatTheReferenceGivesThem) {
  for (const SplineOrder order : orders) {
    const Particles run(order);
    const ReferenceMpm reference = run.reference();
    std::vector<double> expected(reference.nodes.size(), 0.0);
    std::vector<int> n_addends(expected.size(), 0);
    for (std::size_t p = 0; p < run.q.size(); ++p)
      for (const ReferenceMpm::Entry& e : reference.stencil(reference.particles[p].x)) {
        expected[e.node] += e.w * run.q[p];
        ++n_addends[e.node];
      }
    const std::vector<double> found = run.deposit();
    const double quantum = rounding_quantum(scalar_sum_bound(order, run.largest(), run.step.map.largest_count()));
    const std::vector<std::size_t> at = run.pool_node();
    int n_reached = 0;
    for (std::size_t n = 0; n < expected.size(); ++n) {
      EXPECT_NEAR(found[at[n]], expected[n], 0.55 * n_addends[n] * quantum);
      EXPECT_EQ(found[at[n]] / quantum, std::nearbyint(found[at[n]] / quantum));
      n_reached += n_addends[n] > 0;
    }
    EXPECT_GT(n_reached, 900);
  }
}

// The weights of a particle sum to one, and their first moment is its position.
TEST(ScalarDeposit, KeepsTheSumAndTheFirstMoment) {
  for (const SplineOrder order : orders) {
    const Particles run(order);
    const std::vector<double> found = run.deposit();
    double sum = 0.0, expected_sum = 0.0;
    Vec3 moment = Vec3::Zero(), expected_moment = Vec3::Zero();
    for (std::size_t n = 0; n < found.size(); ++n) {
      sum += found[n];
      moment += found[n] * run.step.node_position(n);
    }
    for (std::size_t p = 0; p < run.q.size(); ++p) {
      expected_sum += run.q[p];
      expected_moment += run.q[p] * run.step.particles.vector(Field::position, static_cast<LocalIndex>(p));
    }
    EXPECT_NEAR(sum, expected_sum, 1e-11);
    EXPECT_LE((moment - expected_moment).norm(), 1e-11);
  }
}

TEST(ScalarDeposit, HasTheSameBitsForAnyOrderOfTheParticles) {
  for (const SplineOrder order : orders) {
    const Particles run(order);
    const std::vector<double> expected = run.deposit();
    for (unsigned seed = 0; seed < 5; ++seed) {
      std::vector<LocalIndex> sequence(run.q.size());
      std::iota(sequence.begin(), sequence.end(), 0);
      std::shuffle(sequence.begin(), sequence.end(), std::mt19937(seed));
      std::vector<double> q;
      for (const LocalIndex p : sequence) q.push_back(run.q[static_cast<std::size_t>(p)]);
      const Particles other(order, picked(run.step.particles, sequence), q);
      const std::vector<double> found = other.deposit();
      ASSERT_EQ(found.size(), expected.size());
      EXPECT_EQ(std::memcmp(found.data(), expected.data(), found.size() * sizeof(double)), 0);
    }
  }
}

// No node receives more than the bound that contributions are rounded by, nor a single one more than a quarter of it, even
// where as many particles as a cell may hold sit where their weight is largest.
TEST(ScalarDeposit, TheBoundHolds) {
  for (const SplineOrder order : orders) {
    const Particles run(order, 5000);
    const ReferenceMpm reference = run.reference();
    std::vector<double> total(reference.nodes.size(), 0.0);
    const double bound = scalar_sum_bound(order, run.largest(), run.step.map.largest_count());
    for (std::size_t p = 0; p < run.q.size(); ++p)
      for (const ReferenceMpm::Entry& e : reference.stencil(reference.particles[p].x)) {
        total[e.node] += e.w * run.largest();
        EXPECT_LE(e.w * run.largest(), 0.25 * bound);
      }
    EXPECT_LE(*std::max_element(total.begin(), total.end()), bound);
  }
}

TEST(ScalarDeposit, NoParticlesNoSum) {
  for (const SplineOrder order : orders)
    for (const double x : Particles(order, 0).deposit()) EXPECT_EQ(x, 0.0);
}

TEST(ScalarGather, ParticlesReceiveWhatTheReferenceGivesThem) {
  for (const SplineOrder order : orders) {
    const Particles run(order);
    std::mt19937 random(21);
    const std::vector<double> phi =
        run.nodal([&](const Vec3&) { return std::uniform_real_distribution<double>(-1.0, 1.0)(random); });
    const Particles::Gathered found = run.gather(phi);
    const ReferenceMpm reference = run.reference();
    const std::vector<std::size_t> at = run.pool_node();
    for (std::size_t p = 0; p < run.q.size(); ++p) {
      double value = 0.0;
      Vec3 gradient = Vec3::Zero();
      for (const ReferenceMpm::Entry& e : reference.stencil(reference.particles[p].x)) {
        value += e.w * phi[at[e.node]];
        gradient += phi[at[e.node]] * e.gradient;
      }
      EXPECT_NEAR(found.value[p], value, 1e-14);
      for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(found.gradient[axis][p], gradient[axis], 2e-13);
    }
  }
}

TEST(ScalarGather, ConstantsAndLinearFunctionsAreReproduced) {
  const Vec3 slope(3.0, -2.0, 0.5);
  for (const SplineOrder order : orders) {
    const Particles run(order);
    const Particles::Gathered constant = run.gather(run.nodal([](const Vec3&) { return 7.0; }));
    const Particles::Gathered linear = run.gather(run.nodal([&](const Vec3& x) { return 1.0 + slope.dot(x); }));
    for (std::size_t p = 0; p < run.q.size(); ++p) {
      const Vec3 x = run.step.particles.vector(Field::position, static_cast<LocalIndex>(p));
      EXPECT_NEAR(constant.value[p], 7.0, 1e-14);
      EXPECT_NEAR(linear.value[p], 1.0 + slope.dot(x), 1e-14);
      for (std::size_t axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(constant.gradient[axis][p], 0.0, 2e-13);
        EXPECT_NEAR(linear.gradient[axis][p], slope[axis], 2e-13);
      }
    }
  }
}

// Quadratic functions: their gradient is reproduced by both splines, their value up to the constant second moment.
TEST(ScalarGather, QuadraticFunctionsAreReproducedUpToTheSecondMoment) {
  for (const SplineOrder order : orders) {
    const Particles run(order);
    const Particles::Gathered found = run.gather(run.nodal([](const Vec3& x) { return x.squaredNorm(); }));
    for (std::size_t p = 0; p < run.q.size(); ++p) {
      const Vec3 x = run.step.particles.vector(Field::position, static_cast<LocalIndex>(p));
      EXPECT_NEAR(found.value[p], x.squaredNorm() + 3.0 * run.step.second_moment(), 1e-14);
      for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(found.gradient[axis][p], 2.0 * x[axis], 2e-13);
    }
  }
}

TEST(ScalarGather, TakesValuesAndGradientsFromTwoFields) {
  const Particles run(SplineOrder::quadratic);
  const std::vector<double> phi = run.nodal([](const Vec3& x) { return std::sin(9.0 * x[0]) * x[1] + x[2]; });
  const std::vector<double> psi = run.nodal([](const Vec3& x) { return std::cos(7.0 * x[2]) - x[0] * x[1]; });
  std::vector<double> value(run.q.size());
  std::array<std::vector<double>, 3> gradient{value, value, value};
  scalar_gather(run.grid(), run.step.layout, run.step.particles, run.step.map, {phi.data(), value.data()},
                {psi.data(), {gradient[0].data(), gradient[1].data(), gradient[2].data()}});
  EXPECT_EQ(value, run.gather(phi).value);
  EXPECT_EQ(gradient, run.gather(psi).gradient);
}

TEST(ScalarGather, GivesOnlyWhatIsAskedFor) {
  const Particles run(SplineOrder::cubic);
  const std::vector<double> phi = run.nodal([](const Vec3& x) { return std::sin(9.0 * x[0]) * x[1] + x[2]; });
  const Particles::Gathered both = run.gather(phi);
  std::vector<double> value(run.q.size());
  scalar_gather(run.grid(), run.step.layout, run.step.particles, run.step.map, {phi.data(), value.data()}, {});
  EXPECT_EQ(value, both.value);
  std::array<std::vector<double>, 3> gradient{value, value, value};
  scalar_gather(run.grid(), run.step.layout, run.step.particles, run.step.map, {},
                {phi.data(), {gradient[0].data(), gradient[1].data(), gradient[2].data()}});
  EXPECT_EQ(gradient, both.gradient);
}

}  // namespace
}  // namespace bulkley::scalar_transfer_test
