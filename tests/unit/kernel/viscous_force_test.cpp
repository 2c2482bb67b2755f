// The viscous operator on node velocities: the plain sums of the reference, symmetry, momentum, the bound of its sums.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>

#include "base/order_free.hpp"
#include "kernel/viscous_force.hpp"
#include "support/reference_particles.hpp"
#include "support/serial_step.hpp"

namespace bulkley::viscous_force_test {
namespace {

const std::vector<double> viscosities{0.0, 3.0};  // of the scene's two materials
constexpr LocalIndex count = 777;                 // no multiple of a batch

class ViscousForce : public testing::TestWithParam<std::tuple<SplineOrder, GradientForm>> {
 protected:
  static TransferSettings transfer() { return {.order = std::get<0>(GetParam()), .gradient = std::get<1>(GetParam())}; }

  ViscousForce() {
    for (LocalIndex p = 0; p < count; ++p) step.particles.real(Field::volume_ratio)[p] = 0.8 + 0.3 * uniform(random);
    largest_weight = set_viscous_weights(viscosities, step.particles, weights);
  }

  NodeVector random_velocities() {
    NodeVector nodes(step.indices.size());
    for (Node& node : nodes)
      for (int a = 0; a < 3; ++a) node.c[a] = 2.0 * uniform(random) - 1.0;
    return nodes;
  }
  double bound(const NodeVector& velocity) const {
    double largest = 0.0;
    for (const Node& node : velocity) largest = std::max(largest, vector_of(node).norm());
    return viscous_force_bound(step.scene.grid, step.scene.transfer, step.map.largest_count(), largest_weight, largest);
  }
  NodeVector forces(const NodeVector& velocity) const {
    NodeVector result(velocity.size(), Node{{99.0, 99.0, 99.0, 99.0}});
    viscous_forces(step.scene.grid, step.scene.transfer, step.layout, step.map, step.particles, weights.data(),
                   bound(velocity), velocity.data(), result.data());
    return result;
  }
  static double dot(const NodeVector& a, const NodeVector& b) {
    double sum = 0.0;
    for (std::size_t n = 0; n < a.size(); ++n) sum += vector_of(a[n]).dot(vector_of(b[n]));
    return sum;
  }

  std::mt19937 random{5};
  std::uniform_real_distribution<double> uniform{0.0, 1.0};
  SerialStep step{open_scene(transfer()), random_particles(open_scene(transfer()), count, 3, false, 0.4)};
  std::vector<double> weights;
  double largest_weight = 0.0;
};

TEST_P(ViscousForce, WeightsAreThoseOfTheMaterials) {
  double largest = 0.0;
  for (LocalIndex p = 0; p < count; ++p) {
    const double expected =
        p % 2 == 0 ? 0.0
                   : 6.0 * step.particles.real(Field::volume_ratio)[p] * step.particles.real(Field::reference_volume)[p];
    EXPECT_DOUBLE_EQ(weights[static_cast<std::size_t>(p)], expected);
    largest = std::max(largest, expected);
  }
  EXPECT_DOUBLE_EQ(largest_weight, largest);
  EXPECT_EQ(weights.size(), static_cast<std::size_t>(count + ParticleSet::padding));
}

TEST_P(ViscousForce, IsWhatTheReferenceSums) {
  ReferenceScene scene;
  scene.grid = step.scene.grid;
  scene.transfer = step.scene.transfer;
  const ReferenceMpm reference(scene, reference_particles(step.particles, step.scene.materials));
  std::vector<std::size_t> at(reference.nodes.size(), step.indices.size());  // by the reference's node: the pool's
  for (std::size_t n = 0; n < step.indices.size(); ++n) {
    const Int3& node = step.indices[n];
    bool exists = true;
    for (int axis = 0; axis < 3; ++axis) exists = exists && node[axis] < scene.grid.n_nodes(axis);
    if (exists) at[static_cast<std::size_t>(scene.grid.node_number(node))] = n;
  }
  const NodeVector velocity = random_velocities();
  const double second_moment = std::pow(scene.grid.cell_size, 2) / inverse_second_moment(scene.transfer.order);
  const auto slope = [&](const ReferenceMpm::Entry& e) -> Vec3 {
    return scene.transfer.gradient == GradientForm::bspline ? e.gradient : Vec3(e.w * e.offset / second_moment);
  };
  std::vector<Vec3> expected(velocity.size(), Vec3::Zero());
  std::vector<double> magnitude(velocity.size(), 0.0);
  for (std::size_t p = 0; p < reference.particles.size(); ++p) {
    const auto stencil = reference.stencil(reference.particles[p].x);
    Mat3 L = Mat3::Zero();
    for (const auto& e : stencil) L += vector_of(velocity[at[e.node]]) * slope(e).transpose();
    Mat3 rate = 0.5 * (L + L.transpose());
    rate -= rate.trace() / 3.0 * Mat3::Identity();
    for (const auto& e : stencil) {
      const Vec3 force = -weights[p] * rate * slope(e);
      expected[at[e.node]] += force;
      magnitude[at[e.node]] += force.norm();
    }
  }
  const NodeVector found = forces(velocity);
  const double quantum = rounding_quantum(bound(velocity));
  for (std::size_t n = 0; n < found.size(); ++n) {
    EXPECT_LT((vector_of(found[n]) - expected[n]).norm(), 100.0 * quantum + 1e-13 * magnitude[n]);
    EXPECT_LE(magnitude[n], bound(velocity)) << "what the rounding relies on";
    for (int a = 0; a < 3; ++a) EXPECT_EQ(found[n].c[a] / quantum, std::nearbyint(found[n].c[a] / quantum));
  }
}

// a . K b = b . K a, and a . K a >= 0: conjugate gradients need both.
TEST_P(ViscousForce, IsSymmetricAndTakesEnergy) {
  const NodeVector a = random_velocities(), b = random_velocities();
  const double ab = dot(a, forces(b)), ba = dot(b, forces(a)), aa = dot(a, forces(a));
  EXPECT_LT(aa, 0.0);
  EXPECT_NEAR(ab, ba, 1e-12 * std::abs(aa));
}

TEST_P(ViscousForce, KeepsMomentumAndAngularMomentum) {
  const NodeVector velocity = random_velocities();
  const NodeVector found = forces(velocity);
  Vec3 force = Vec3::Zero(), torque = Vec3::Zero();
  for (std::size_t n = 0; n < found.size(); ++n) {
    force += vector_of(found[n]);
    torque += step.node_position(n).cross(vector_of(found[n]));
  }
  EXPECT_LT(force.norm(), 1e-12 * bound(velocity));
  EXPECT_LT(torque.norm(), 1e-12 * bound(velocity));
}

TEST_P(ViscousForce, LeavesRigidMotionAlone) {
  NodeVector rigid(step.indices.size());
  for (std::size_t n = 0; n < rigid.size(); ++n) {
    const Vec3 v = Vec3(1.0, -2.0, 0.5) + Vec3(3.0, 1.0, -2.0).cross(step.node_position(n));
    std::copy_n(v.data(), 3, rigid[n].c);
  }
  for (const Node& force : forces(rigid)) EXPECT_LT(vector_of(force).norm(), 1e-13 * bound(rigid));
}

TEST_P(ViscousForce, DoesNotDependOnTheOrderOfParticles) {
  const NodeVector velocity = random_velocities();
  const NodeVector before = forces(velocity);
  ParticleSet turned = random_particles(step.scene, count, 3, false);
  for (LocalIndex p = 0; p < count; ++p) {
    const LocalIndex from = count - 1 - p;
    turned.set_vector(Field::position, p, step.particles.vector(Field::position, from));
    for (const Field field : {Field::volume_ratio, Field::reference_volume})
      turned.real(field)[p] = step.particles.real(field)[from];
    turned.material()[p] = step.particles.material()[from];
  }
  SerialStep other(step.scene, std::move(turned));
  std::vector<double> other_weights;
  set_viscous_weights(viscosities, other.particles, other_weights);
  NodeVector after(before.size());
  viscous_forces(other.scene.grid, other.scene.transfer, other.layout, other.map, other.particles, other_weights.data(),
                 bound(velocity), velocity.data(), after.data());
  for (std::size_t n = 0; n < before.size(); ++n)
    for (int a = 0; a < 3; ++a) EXPECT_EQ(before[n].c[a], after[n].c[a]);
}

INSTANTIATE_TEST_SUITE_P(All, ViscousForce,
                         testing::Combine(testing::Values(SplineOrder::quadratic, SplineOrder::cubic),
                                          testing::Values(GradientForm::mls, GradientForm::bspline)));

TEST(ViscousStress, IsRecordedWithItsWork) {
  ParticleSet particles(OptionalFields{Field::viscous_stress});
  particles.resize(70);
  for (LocalIndex p = 0; p < 70; ++p) {
    place_particle(particles, p, Vec3::Zero(), 1e-3);
    particles.material()[p] = static_cast<std::uint8_t>(p % 2);
    particles.real(Field::volume_ratio)[p] = 1.5;
    particles.real(Field::plastic_dissipation)[p] = 2.0;
    Mat3 L;
    L << 1.0, 4.0, 0.0, 2.0, -3.0, 0.0, 0.0, 0.0, 5.0;
    set_tensor(particles, Field::affine_velocity, p, L);
  }
  record_viscous_stress(viscosities, Field::affine_velocity, 0.1, particles, {64, 128});
  const double expected[6] = {0.0, -36.0, 36.0, 27.0, 0.0, 0.0};  // 2 eta J dev sym L
  for (LocalIndex p = 0; p < 70; ++p) {
    const bool told = p >= 64 && p % 2 == 1;
    for (int c = 0; c < 6; ++c)
      EXPECT_NEAR(particles.real(Field::viscous_stress, c)[p], told ? expected[c] : 0.0, 1e-13) << p << ' ' << c;
    // dt 2 eta J |dev sym L|^2, of which the diagonal has 32 and the shear 2 x 9
    EXPECT_NEAR(particles.real(Field::plastic_dissipation)[p], 2.0 + (told ? 0.1 * 9.0 * 50.0 : 0.0), 1e-12);
  }
}

}  // namespace
}  // namespace bulkley::viscous_force_test
