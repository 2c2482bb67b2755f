// The real kernels, chained in one process, against the reference MPM: the same particles after the same steps.

#include <gtest/gtest.h>

#include "support/reference_particles.hpp"
#include "support/serial_step.hpp"

namespace bulkley::step_against_reference_test {
namespace {

/// A box with one wall of each kind, a round obstacle, gravity, an elastic and a flowing material.
SerialScene walled_scene(const TransferSettings& transfer) {
  SerialScene scene = open_scene(transfer);
  scene.gravity = Vec3(1.0, -2.0, 40.0);
  scene.faces[0].kind = FaceKind::slip;
  scene.faces[1].kind = FaceKind::slip;
  scene.faces[2] = {FaceKind::separating, 0.3};
  scene.faces[3] = {FaceKind::separating, 0.0};
  scene.faces[4] = {FaceKind::sticky, 0.0, Vec3(0.5, -0.3, 0.0)};
  scene.faces[5].kind = FaceKind::outflow;
  scene.colliders = {{"ball", {Sphere{{0.2, 0.5, 0.5}, 0.2}}, Contact::separating, 0.4, {}, {}}};
  return scene;
}

ReferenceScene as_reference(const SerialScene& scene) {
  ReferenceScene result{scene.grid, scene.transfer, scene.gravity, scene.faces, scene.colliders, {}};
  for (const NamedMaterial& m : scene.materials) {
    if (const auto* solid = std::get_if<NeoHookean>(&m.material))
      result.materials.push_back({solid->parameters.bulk_modulus, solid->parameters.shear_modulus, false, 0.0, 0.0, 1.0});
    if (const auto* fluid = std::get_if<HerschelBulkley>(&m.material)) {
      const auto& f = fluid->parameters;
      result.materials.push_back({f.bulk_modulus, f.shear_modulus, true, f.sigma_Y, f.eta, f.h});
    }
  }
  return result;
}

/// Largest |a - b| over particles, over the largest |b|; NaN, which passes no test, if all b are zero.
template <class Get>
double difference(const std::vector<ReferenceParticle>& a, const std::vector<ReferenceParticle>& b, const Get& get) {
  double largest = 0.0, scale = 0.0;
  for (std::size_t p = 0; p < b.size(); ++p) {
    largest = std::max(largest, Mat3(get(a[p]) - get(b[p])).norm());
    scale = std::max(scale, Mat3(get(b[p])).norm());
  }
  return largest / scale;
}

Mat3 as_matrix(const Vec3& v) { return v.asDiagonal(); }
Mat3 as_matrix(double value) { return value * Mat3::Identity(); }

double heaviest(const std::vector<ReferenceParticle>& particles) {
  double result = 0.0;
  for (const ReferenceParticle& p : particles) result = std::max(result, p.m);
  return result;
}

TEST(Step, TakesTheStepsOfTheReference) {
  for (TransferSettings transfer : all_transfers()) {
    for (const double damping : {0.0, 0.3}) {
      if (damping > 0.0 && transfer.scheme != TransferScheme::apic) continue;
      transfer.affine_damping = damping;
      SCOPED_TRACE(describe(transfer) + (damping > 0.0 ? " damped" : ""));
      const SerialScene scene = walled_scene(transfer);
      SerialStep step(scene, random_particles(scene, 600, 11, true, 0.499));
      ReferenceMpm reference(as_reference(scene), reference_particles(step.particles, step.scene.materials));
      for (int n = 0; n < 4; ++n) {
        step.step(4e-3);
        reference.empty_node = SerialStep::empty_mass * step.sums.mass / heaviest(reference.particles);
        reference.step(4e-3);
      }
      const std::vector<ReferenceParticle> real = reference_particles(step.particles, step.scene.materials);
      ASSERT_EQ(real.size(), reference.particles.size());
      EXPECT_LT(real.size(), 600u);  // some left through the outflow
      EXPECT_GT(real.size(), 500u);
      for (std::size_t p = 0; p < real.size(); ++p) ASSERT_EQ(real[p].id, reference.particles[p].id);

      const auto differs = [&](const auto& get) { return difference(real, reference.particles, get); };
      EXPECT_LE(differs([](const ReferenceParticle& p) { return as_matrix(p.x); }), 1e-12);
      EXPECT_LE(differs([](const ReferenceParticle& p) { return as_matrix(p.v); }), 1e-11);
      EXPECT_LE(differs([](const ReferenceParticle& p) { return as_matrix(p.J); }), 1e-11);
      // The slope of a weight is unbounded relative to the weight itself: a light node magnifies the rounding of order-free sums.
      const double tolerance = transfer.gradient == GradientForm::bspline ? 1e-8 : 1e-10;
      EXPECT_LE(differs([](const ReferenceParticle& p) { return p.b; }), tolerance);
      EXPECT_LE(differs([](const ReferenceParticle& p) { return p.L; }), tolerance);
      EXPECT_LE(differs([](const ReferenceParticle& p) { return p.tau; }), tolerance);
      EXPECT_LE(differs([](const ReferenceParticle& p) { return as_matrix(p.shear_rate); }), 10.0 * tolerance);
      EXPECT_LE(differs([](const ReferenceParticle& p) { return as_matrix(p.dissipation); }), 10.0 * tolerance);
    }
  }
}

}  // namespace
}  // namespace bulkley::step_against_reference_test
