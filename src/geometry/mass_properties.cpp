#include "geometry/mass_properties.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "geometry/mesh_solid.hpp"

namespace bulkley {

namespace {

constexpr double pi = std::numbers::pi;

/// The inertia of a second moment, integral of r r^T.
Mat3 inertia_of(const Mat3& second) { return second.trace() * Mat3::Identity() - second; }

/// Of a body of revolution about `axis`, with the second moments along it and across it.
MassProperties of_revolution(double volume, const Vec3& center, const Vec3& axis, double along, double across) {
  const Vec3 n = axis.normalized();
  const Mat3 nn = n * n.transpose();
  return {volume, center, inertia_of(along * nn + across * (Mat3::Identity() - nn))};
}

std::optional<MassProperties> properties(const Box& box) {
  const Vec3 size = box.upper - box.lower;
  const double volume = size.prod();
  const Mat3 second = (volume / 12.0 * size.cwiseProduct(size)).asDiagonal();
  return MassProperties{volume, 0.5 * (box.lower + box.upper), inertia_of(second)};
}

std::optional<MassProperties> properties(const Ellipsoid& ellipsoid) {
  const double volume = 4.0 / 3.0 * pi * ellipsoid.radii.prod();
  const Mat3 second = (volume / 5.0 * ellipsoid.radii.cwiseProduct(ellipsoid.radii)).asDiagonal();
  return MassProperties{volume, ellipsoid.center, inertia_of(second)};
}

std::optional<MassProperties> properties(const Sphere& sphere) {
  return properties(Ellipsoid{sphere.center, Vec3::Constant(sphere.radius)});
}

std::optional<MassProperties> properties(const Cylinder& cylinder) {
  const Vec3 axis = cylinder.end - cylinder.start;
  const double h = axis.norm(), r = cylinder.radius, volume = pi * r * r * h;
  return of_revolution(volume, 0.5 * (cylinder.start + cylinder.end), axis, volume * h * h / 12.0, volume * r * r / 4.0);
}

std::optional<MassProperties> properties(const Capsule& capsule) {
  const Vec3 axis = capsule.end - capsule.start, middle = 0.5 * (capsule.start + capsule.end);
  const double h = axis.norm(), r = capsule.radius;
  const double shaft = pi * r * r * h, ball = 4.0 / 3.0 * pi * r * r * r;
  // Two half balls whose flat sides are h / 2 from the middle: <(h/2 + z)^2> with <z> = 3 r / 8, <z^2> = r^2 / 5.
  const double along = shaft * h * h / 12.0 + ball * (h * h / 4.0 + 3.0 * h * r / 8.0 + r * r / 5.0);
  const double across = shaft * r * r / 4.0 + ball * r * r / 5.0;
  return of_revolution(shaft + ball, middle, h > 0.0 ? axis : Vec3(Vec3::UnitZ()), along, across);
}

std::optional<MassProperties> properties(const Mesh& mesh) {
  if (!mesh.solid) return std::nullopt;
  MassProperties result = mass_properties(mesh.solid->mesh());
  if (result.volume < 0.0) result = {-result.volume, result.center, -result.inertia};  // a mesh that faces inwards
  return result;
}

std::optional<MassProperties> properties(const Placed& placed) {
  const std::optional<MassProperties> part = mass_properties(*placed.part);
  if (!part) return std::nullopt;
  const Mat3 turn = Eigen::AngleAxisd(placed.angle, placed.axis.normalized()).toRotationMatrix();
  return MassProperties{part->volume, turn * (part->center - placed.origin) + placed.origin + placed.translation,
                        turn * part->inertia * turn.transpose()};
}

std::optional<MassProperties> properties(const Plane&) { return std::nullopt; }
std::optional<MassProperties> properties(const Union&) { return std::nullopt; }
std::optional<MassProperties> properties(const Difference&) { return std::nullopt; }
std::optional<MassProperties> properties(const Complement&) { return std::nullopt; }

}  // namespace

MassProperties mass_properties(const TriangleMesh& mesh) {
  MassProperties result;
  if (mesh.triangles.empty()) return result;
  // Far from the origin, tetrahedra from there would cancel.
  const Vec3 origin = mesh.vertices[static_cast<std::size_t>(mesh.triangles.front()[0])];
  double volume = 0.0;
  Vec3 first = Vec3::Zero();
  Mat3 second = Mat3::Zero();
  for (const Int3& t : mesh.triangles) {
    const auto corner = [&](std::size_t c) { return Vec3(mesh.vertices[static_cast<std::size_t>(t[c])] - origin); };
    const Vec3 a = corner(0), b = corner(1), c = corner(2), sum = a + b + c;
    const double tetrahedron = a.dot(b.cross(c)) / 6.0;
    volume += tetrahedron;
    first += tetrahedron / 4.0 * sum;
    second += tetrahedron / 20.0 * (sum * sum.transpose() + a * a.transpose() + b * b.transpose() + c * c.transpose());
  }
  if (volume == 0.0) return result;
  const Vec3 center = first / volume;
  return {volume, origin + center, inertia_of(second - volume * center * center.transpose())};
}

std::optional<MassProperties> mass_properties(const Shape& shape) {
  return std::visit([](const auto& kind) { return properties(kind); }, shape.kind);
}

PrincipalFrame principal_frame(const Mat3& inertia) {
  // A ball, or a body along the axes, keeps them: no rounding may turn it.
  const Mat3 diagonal = inertia.diagonal().asDiagonal();
  const double largest = inertia.cwiseAbs().maxCoeff();
  const bool is_diagonal = (inertia - diagonal).cwiseAbs().maxCoeff() <= 1e-14 * largest;
  const Eigen::SelfAdjointEigenSolver<Mat3> solver(is_diagonal ? diagonal : inertia);
  PrincipalFrame frame{solver.eigenvectors(), solver.eigenvalues()};
  if (frame.axes.determinant() < 0.0) frame.axes.col(0) = -frame.axes.col(0);
  return frame;
}

bool are_moments(const Vec3& moments) {
  return moments.allFinite() && moments[0] > 0.0 && moments[0] + moments[1] >= moments[2] * (1.0 - 1e-9);
}

}  // namespace bulkley
