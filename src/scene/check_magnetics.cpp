#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "bulkley/base/error.hpp"
#include "geometry/shape.hpp"
#include "scene/scene.hpp"

namespace bulkley {

namespace {

constexpr int n_samples = 9;             // along each direction of a magnet or a body
constexpr double largest_defect = 0.01;  // of a formula's divergence or curl, over |H|/L

/// Points of a source that no material may hold, in the scene's axes at the start, m: its inside, or its wire.
std::vector<Vec3> points_of(const FieldSource& source) {
  std::vector<Vec3> points;
  const Pose pose = source.motion.pose(0.0);
  std::visit(
      [&](const auto& kind) {
        using Kind = std::decay_t<decltype(kind)>;
        if constexpr (requires { kind.center; }) {
          Mat3 axes = own_axes(kind.axis);
          if constexpr (requires { kind.side; }) axes = own_axes(kind.axis, kind.side);
          const auto add = [&](const Vec3& own) { points.push_back(pose.to_world(kind.center + axes * own)); };
          const auto part = [](int k) { return 2.0 * k / (n_samples - 1) - 1.0; };
          const auto around = [&](double radius, double height) {
            for (int k = 0; k < 4 * n_samples; ++k) {
              const double angle = 2.0 * std::numbers::pi * k / (4 * n_samples);
              add({radius * std::cos(angle), radius * std::sin(angle), height});
            }
          };
          if constexpr (std::is_same_v<Kind, Dipole>) add(Vec3::Zero());
          if constexpr (std::is_same_v<Kind, Coil>) around(kind.radius, 0.0);
          if constexpr (std::is_same_v<Kind, BoxMagnet>)
            for (int i = 0; i < n_samples; ++i)
              for (int j = 0; j < n_samples; ++j)
                for (int k = 0; k < n_samples; ++k) add(0.5 * kind.sizes.cwiseProduct(Vec3(part(i), part(j), part(k))));
          if constexpr (std::is_same_v<Kind, CylinderMagnet>)
            for (int i = 0; i < n_samples; ++i)
              for (int k = 0; k < n_samples; ++k) around(kind.radius * i / (n_samples - 1), 0.5 * kind.length * part(k));
        }
      },
      source.kind);
  return points;
}

bool is_magnetic(const Scene& scene, const Body& body) {
  return scene.materials[body.material_index].magnetisation.has_value();
}

// Material inside a magnet would see its B/mu_0, and an infinite field on a wire. Touching is no fault.
void refuse_material_in_magnets(const Scene& scene, std::string& faults) {
  for (const FieldSource& source : scene.magnetics->sources)
    for (const Body& body : scene.bodies) {
      if (!is_magnetic(scene, body)) continue;
      const auto inside = [&](const Vec3& x) { return signed_distance(body.shape, x) < -1e-3 * scene.grid.cell_size; };
      if (std::ranges::none_of(points_of(source), inside)) continue;
      faults += fmt::format("{}{}: the source is inside body '{}' at the start; its field holds outside of it alone",
                            faults.empty() ? "" : "\n", source.place, body.name);
      break;
    }
}

struct Defects {
  double divergence = 0.0, curl = 0.0;  ///< over |H|/L
  Vec3 place = Vec3::Zero();
};

// Those of a formula in the magnetic bodies, by central differences over half a cell, at some times.
Defects defects_of(const Scene& scene, const FieldSource& source) {
  FieldSource steady = source;
  steady.amplitude = "1";
  const AppliedField field({steady});
  const double h = 0.25 * scene.grid.cell_size;
  Defects worst;
  for (const Body& body : scene.bodies) {
    if (!is_magnetic(scene, body)) continue;
    const Bounds all = bounds(body.shape);
    const Bounds box{all.lower.cwiseMax(scene.grid.lower), all.upper.cwiseMin(scene.grid.upper())};
    const double length = (box.upper - box.lower).maxCoeff();
    for (const double t : {0.0, 0.37, 1.0})
      for (int n = 0; n < n_samples * n_samples * n_samples; ++n) {
        const Vec3 part(n / (n_samples * n_samples) + 0.5, n / n_samples % n_samples + 0.5, n % n_samples + 0.5);
        const Vec3 x = box.lower + part.cwiseProduct(box.upper - box.lower) / n_samples;
        if (signed_distance(body.shape, x) > 0.0) continue;
        const double time = t * scene.time_stepping.end_time;
        Mat3 gradient;
        for (int a = 0; a < 3; ++a)
          gradient.col(a) = (field.at(x + h * Vec3::Unit(a), time) - field.at(x - h * Vec3::Unit(a), time)) / (2.0 * h);
        const double strength = field.at(x, time).norm();
        if (!(strength > 0.0)) continue;
        const double divergence = std::abs(gradient.trace()) * length / strength;
        const double curl = (gradient - gradient.transpose()).norm() / std::numbers::sqrt2 * length / strength;
        if (std::max(divergence, curl) > std::max(worst.divergence, worst.curl)) worst = {divergence, curl, x};
      }
  }
  return worst;
}

void refuse_impossible_formulas(const Scene& scene, std::string& faults) {
  for (const FieldSource& source : scene.magnetics->sources) {
    if (!std::holds_alternative<FieldFormula>(source.kind)) continue;
    const Defects found = defects_of(scene, source);
    if (std::max(found.divergence, found.curl) <= largest_defect) continue;
    const bool diverges = found.divergence >= found.curl;
    faults += fmt::format(
        "{}{}: the formula is no field of magnets outside of the material: its {} at ({:.6g}, {:.6g}, {:.6g}) m in a "
        "magnetic body is "
        "{:.2g} |H|/L, "
        "L the largest side of the body; at most {} is allowed",
        faults.empty() ? "" : "\n", source.place, diverges ? "divergence" : "curl", found.place[0], found.place[1],
        found.place[2], diverges ? found.divergence : found.curl, largest_defect);
  }
}

}  // namespace

void check_magnetics(const Scene& scene) {
  if (!scene.magnetics) return;
  std::string faults;
  refuse_material_in_magnets(scene, faults);
  refuse_impossible_formulas(scene, faults);
  if (!faults.empty()) throw UsageError(faults);
}

}  // namespace bulkley
