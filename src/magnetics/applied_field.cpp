#include "magnetics/applied_field.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <type_traits>

#include "magnetics/elliptic.hpp"
#include "magnetics/magnetisation.hpp"

namespace bulkley {
namespace {

constexpr double pi = std::numbers::pi;

/// A field around the z axis.
struct Axial {
  double radial, axial;  ///< A/m
};

Vec3 around_axis(const Vec3& r, double distance, const Axial& field) {
  const double share = distance > 0.0 ? field.radial / distance : 0.0;
  return {share * r[0], share * r[1], field.axial};
}

/// A unit moment along z.
Vec3 unit_dipole(const Vec3& r) {
  const double square = r.squaredNorm();
  return (3.0 * r[2] / square * r - Vec3::UnitZ()) / (4.0 * pi * square * std::sqrt(square));
}

/// ln((r_1 + u_1)/(r_2 + u_2)) for u_1 < u_2 and r_i = sqrt(u_i^2 + w^2): the potential of an edge. Its forms are equal; each keeps
/// its digits where it is used.
double edge_potential(double u1, double u2, double w_squared) {
  const double r1 = std::sqrt(u1 * u1 + w_squared);
  const double r2 = std::sqrt(u2 * u2 + w_squared);
  if (u1 >= 0.0) return std::log((r1 + u1) / (r2 + u2));
  if (u2 <= 0.0) return std::log((r2 - u2) / (r1 - u1));
  return std::log(w_squared / ((r1 - u1) * (r2 + u2)));
}

/// A block of the half sizes `half` with a unit magnetisation along z: the fields of its two charged faces.
Vec3 unit_box(const Vec3& r, const Vec3& half) {
  const std::array<double, 2> X = {r[0] - half[0], r[0] + half[0]};
  const std::array<double, 2> Y = {r[1] - half[1], r[1] + half[1]};
  const std::array<double, 2> Z = {r[2] - half[2], r[2] + half[2]};
  const auto sign = [](int i) { return i == 0 ? 1.0 : -1.0; };
  Vec3 sum = Vec3::Zero();
  for (int c = 0; c < 2; ++c) {
    for (int i = 0; i < 2; ++i) {
      sum[0] += sign(i) * sign(c) * edge_potential(Y[0], Y[1], X[i] * X[i] + Z[c] * Z[c]);
      sum[1] += sign(i) * sign(c) * edge_potential(X[0], X[1], Y[i] * Y[i] + Z[c] * Z[c]);
      for (int j = 0; j < 2; ++j) {
        const double distance = std::sqrt(X[i] * X[i] + Y[j] * Y[j] + Z[c] * Z[c]);
        sum[2] -= sign(i) * sign(j) * sign(c) * std::atan2(X[i] * Y[j], Z[c] * distance);
      }
    }
  }
  return -sum / (4.0 * pi);
}

/// A cylinder with a unit magnetisation along z, as a sheet of current around it (Derby and Olbert, American Journal of Physics 78
/// (2010) 229).
Vec3 unit_cylinder(const Vec3& r, double radius, double half_length) {
  const double rho = std::hypot(r[0], r[1]);
  const double sum = radius + rho;
  const double g = (radius - rho) / sum;
  Axial field{0.0, 0.0};
  for (const double end : {1.0, -1.0}) {
    const double z = r[2] + end * half_length;
    const double S = std::hypot(z, sum);
    const double k = std::hypot(z, radius - rho) / S;
    field.radial += end * radius / S * complete_elliptic(k, 1.0, 1.0, -1.0);
    // On the surface's continuation the two ends' jumps cancel, and their mean is what g = 0 leaves.
    const double integral = g == 0.0 ? complete_elliptic(k, 1.0, 1.0, 1.0) : complete_elliptic(k, g * g, 1.0, g);
    field.axial += end * radius / sum * z / S * integral;
  }
  return around_axis(r, rho, {field.radial / pi, field.axial / pi});
}

/// A ring with a unit current. The radial part's K and E are joined in one integral that vanishes with rho: their difference would
/// lose all digits near the axis.
Vec3 unit_coil(const Vec3& r, double radius) {
  const double rho = std::hypot(r[0], r[1]);
  const double z = r[2];
  const double s = std::hypot(radius + rho, z);
  const double d = (radius - rho) * (radius - rho) + z * z;
  const double kc_squared = d / (s * s);
  const double kc = std::sqrt(kc_squared);
  const double K = complete_elliptic(kc, 1.0, 1.0, 1.0);
  const double E = complete_elliptic(kc, 1.0, 1.0, kc_squared);
  const double axial = (K + (radius * radius - rho * rho - z * z) * E / d) / (2.0 * pi * s);
  const double radial = 2.0 * radius * z / (pi * s * s * s) * complete_elliptic(kc, kc_squared, -0.5, 0.5);
  return around_axis(r, rho, {radial, axial});
}

bool depends_on_time(const VectorFormula& formula) {
  for (const std::string& text : formula.text)
    if (Formula(text, {"x", "y", "z", "t"}).uses("t")) return true;
  return false;
}

}  // namespace

Mat3 own_axes(const Vec3& axis, const Vec3& side) {
  const Vec3 z = axis.normalized();
  Vec3 x = side;
  if (x.isZero(0.0)) x = std::abs(z[0]) < std::numbers::sqrt2 / 2.0 ? Vec3::UnitX() : Vec3::UnitY();
  x = (x - x.dot(z) * z).normalized();
  Mat3 axes;
  axes << x, z.cross(x), z;
  return axes;
}

std::optional<Shape> body_of(const FieldSource& source) {
  if (const auto* const box = std::get_if<BoxMagnet>(&source.kind)) {
    const Eigen::AngleAxisd turn(own_axes(box->axis, box->side));
    const auto block = std::make_shared<const Shape>(Shape{Box{-0.5 * box->sizes, 0.5 * box->sizes}});
    return Shape{Placed{block, turn.axis(), turn.angle(), Vec3::Zero(), box->center}};
  }
  if (const auto* const cylinder = std::get_if<CylinderMagnet>(&source.kind)) {
    const Vec3 half = 0.5 * cylinder->length * cylinder->axis.normalized();
    return Shape{Cylinder{cylinder->center - half, cylinder->center + half, cylinder->radius}};
  }
  return std::nullopt;
}

/// A source made ready: its formulas parsed, its axes found, its pose and amplitude those of `time_`.
struct AppliedField::Source {
  FieldSource given;
  Formula amplitude;
  std::optional<VectorField> formula;
  Vec3 center = Vec3::Zero();
  Mat3 axes = Mat3::Identity();
  bool varies = false;
  double factor = 0.0;
  Pose pose;

  explicit Source(const FieldSource& source) : given(source), amplitude(source.amplitude, {"t"}) {
    varies = amplitude.uses("t") || given.motion.moves();
    std::visit(
        [&](const auto& kind) {
          if constexpr (requires { kind.field; }) {
            formula.emplace(kind.field);
            varies = varies || depends_on_time(kind.field);
          } else {
            center = kind.center;
            if constexpr (requires { kind.side; })
              axes = own_axes(kind.axis, kind.side);
            else
              axes = own_axes(kind.axis);
          }
        },
        given.kind);
  }

  /// Where `x` is in the axes of the source, m.
  Vec3 own(const Vec3& x) const { return axes.transpose() * (pose.to_shape(x) - center); }

  Vec3 field(const Vec3& x, double t) {
    if (factor == 0.0) return Vec3::Zero();
    if (formula) return factor * (pose.rotation * (*formula)(pose.to_shape(x), t));
    const Vec3 r = own(x);
    const Vec3 unit = std::visit(
        [&](const auto& kind) -> Vec3 {
          using Kind = std::decay_t<decltype(kind)>;
          if constexpr (std::is_same_v<Kind, Dipole>)
            return kind.moment * unit_dipole(r);
          else if constexpr (std::is_same_v<Kind, BoxMagnet>)
            return kind.remanence / vacuum_permeability * unit_box(r, 0.5 * kind.sizes);
          else if constexpr (std::is_same_v<Kind, CylinderMagnet>)
            return kind.remanence / vacuum_permeability * unit_cylinder(r, kind.radius, 0.5 * kind.length);
          else if constexpr (std::is_same_v<Kind, Coil>)
            return kind.current * unit_coil(r, kind.radius);
          else
            return Vec3::Zero();
        },
        given.kind);
    return factor * (pose.rotation * (axes * unit));
  }

  bool changes(double t1, double t2) {
    if (!varies) return false;
    const double before = amplitude({t1}), after = amplitude({t2});
    if (before != after) return true;
    if (before == 0.0) return false;
    const Pose one = given.motion.pose(t1), other = given.motion.pose(t2);
    if (one.rotation != other.rotation || one.to_shape(center) != other.to_shape(center)) return true;
    if (std::holds_alternative<UniformField>(given.kind))
      return (*formula)(Vec3::Zero(), t1) != (*formula)(Vec3::Zero(), t2);
    const auto* field = std::get_if<FieldFormula>(&given.kind);
    return field && depends_on_time(field->field);
  }
};

AppliedField::AppliedField(const std::vector<FieldSource>& sources) {
  for (const FieldSource& source : sources) sources_.push_back(std::make_unique<Source>(source));
}
AppliedField::AppliedField(AppliedField&&) noexcept = default;
AppliedField& AppliedField::operator=(AppliedField&&) noexcept = default;
AppliedField::~AppliedField() = default;

void AppliedField::set_time(double t) const {
  if (t == time_) return;
  for (const auto& source : sources_) {
    source->factor = source->amplitude({t});
    source->pose = source->given.motion.pose(t);
  }
  time_ = t;
}

Vec3 AppliedField::at(const Vec3& x, double t) const {
  set_time(t);
  Vec3 sum = Vec3::Zero();
  for (const auto& source : sources_) sum += source->field(x, t);
  return sum;
}

bool AppliedField::varies() const {
  for (const auto& source : sources_)
    if (source->varies) return true;
  return false;
}

bool AppliedField::changes(double t1, double t2) const {
  return std::ranges::any_of(sources_, [&](const auto& source) { return source->changes(t1, t2); });
}

}  // namespace bulkley
