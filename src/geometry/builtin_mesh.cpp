#include "geometry/builtin_mesh.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "bulkley/base/error.hpp"
#include "geometry/isosurface.hpp"

namespace bulkley {

namespace {

/// A capsule whose radius goes from one value to another, or a flattened one: a limb. Lengths in cm.
struct Limb {
  Vec3 start, end;
  double start_radius, end_radius;
  Vec3 stretch = Vec3::Ones();  ///< of its cross section along x, y, z
  double blend = 0.5;           ///< how softly it joins the others
};

double distance(const Limb& limb, const Vec3& x) {
  const Vec3 along = (limb.end - limb.start).cwiseQuotient(limb.stretch);
  const Vec3 from_start = (x - limb.start).cwiseQuotient(limb.stretch);
  const double t = std::clamp(from_start.dot(along) / std::max(along.squaredNorm(), 1e-12), 0.0, 1.0);
  const double radius = limb.start_radius + t * (limb.end_radius - limb.start_radius);
  return ((from_start - t * along).norm() - radius) * limb.stretch.minCoeff();
}

/// The smaller of two distances with a rounded corner of width `blend` between them.
double smooth_minimum(double a, double b, double blend) {
  const double overlap = std::max(blend - std::abs(a - b), 0.0) / blend;
  return std::min(a, b) - 0.25 * blend * overlap * overlap;
}

/// One step of Newton's method along the gradient, no longer than `longest`: takes the lattice's facets away where the
/// surface is smooth.
template <class Function>
Vec3 moved_to_surface(const Function& f, const Vec3& x, double longest) {
  const double step = 0.01 * longest;
  Vec3 gradient;
  for (int a = 0; a < 3; ++a) gradient[a] = (f(x + step * Vec3::Unit(a)) - f(x - step * Vec3::Unit(a))) / (2.0 * step);
  const double move = f(x) / std::max(gradient.norm(), 0.1);
  return x - std::clamp(move, -longest, longest) * gradient.normalized();
}

struct Figure {
  std::string name;
  std::vector<Limb> limbs;
  Vec3 lower, upper;  ///< cm
  double spacing;     ///< cm
};

Limb ball(const Vec3& center, double radius, const Vec3& stretch = Vec3::Ones(), double blend = 0.5) {
  return {center, center, radius, radius, stretch, blend};
}

/// The limb and its mirror image on the other side, z < 0.
void add_pair(std::vector<Limb>& limbs, Limb limb) {
  limbs.push_back(limb);
  limb.start[2] *= -1.0;
  limb.end[2] *= -1.0;
  limbs.push_back(limb);
}

Figure hare() {
  std::vector<Limb> l;
  l.push_back(ball({1.2, 4.3, 0.0}, 3.6, {1.15, 1.0, 0.95}));                           // rump
  l.push_back({{0.8, 5.2, 0.0}, {-2.4, 6.4, 0.0}, 3.0, 2.3, {1, 1, 0.95}, 1.5});        // trunk
  l.push_back({{-2.4, 6.4, 0.0}, {-3.8, 9.2, 0.0}, 2.0, 1.5, {1, 1, 1}, 1.2});          // neck
  l.push_back(ball({-4.4, 10.2, 0.0}, 1.95, {1.1, 1.0, 0.9}, 0.8));                     // head
  l.push_back({{-5.0, 9.9, 0.0}, {-6.5, 9.4, 0.0}, 1.35, 0.75, {1, 1, 1}, 0.8});        // muzzle
  l.push_back(ball({4.9, 3.6, 0.0}, 1.25, Vec3::Ones(), 0.4));                          // tail
  add_pair(l, ball({1.6, 3.0, 2.5}, 2.2, {1.15, 1.1, 0.7}, 0.6));                       // haunch
  add_pair(l, {{2.4, 0.75, 2.6}, {-1.4, 0.65, 2.7}, 0.85, 0.65, {1, 1, 1}, 0.6});       // hind foot
  add_pair(l, {{-2.7, 5.2, 1.3}, {-3.4, 1.2, 1.4}, 1.05, 0.7, {1, 1, 1}, 0.8});         // foreleg
  add_pair(l, {{-3.4, 0.9, 1.4}, {-4.5, 0.65, 1.4}, 0.75, 0.6, {1, 1, 1}, 0.5});        // forefoot
  add_pair(l, {{-3.7, 11.6, 0.8}, {-2.2, 14.8, 1.6}, 0.65, 0.9, {1.1, 1, 0.8}, 0.6});   // ear
  add_pair(l, {{-2.2, 14.8, 1.6}, {-1.5, 16.6, 1.8}, 0.9, 0.55, {1.1, 1, 0.8}, 0.02});  // its tip
  add_pair(l, ball({-5.2, 10.7, 1.35}, 0.42, Vec3::Ones(), 0.15));                      // eye
  return {"hare", l, {-8.0, -0.6, -5.0}, {7.0, 17.5, 5.0}, 0.28};
}

Figure dragon() {
  std::vector<Limb> l;
  const auto chain = [&](const std::vector<Vec3>& points, const std::vector<double>& radii, const Vec3& stretch,
                         double blend) {
    for (std::size_t n = 0; n + 1 < points.size(); ++n)
      l.push_back({points[n], points[n + 1], radii[n], radii[n + 1], stretch, blend});
  };
  // From the tail's tip over the arched back to the head.
  const std::vector<Vec3> spine = {{9.4, 7.6, 0.6},  {10.2, 6.0, 0.2}, {9.9, 4.2, -0.3}, {8.3, 3.0, -0.4}, {6.2, 3.2, 0.0},
                                   {4.0, 4.9, 0.3},  {1.6, 6.0, 0.3},  {-0.9, 5.3, 0.0}, {-3.1, 4.4, 0.0}, {-5.0, 5.3, 0.0},
                                   {-5.9, 7.4, 0.0}, {-6.3, 9.4, 0.0}, {-7.2, 10.8, 0.0}};
  const std::vector<double> girth = {0.2, 0.45, 0.7, 0.95, 1.35, 1.75, 1.9, 1.85, 1.75, 1.45, 1.2, 1.05, 1.15};
  chain(spine, girth, {1.0, 1.0, 1.0}, 0.15);
  chain({{-7.2, 10.9, 0.0}, {-8.6, 10.7, 0.0}, {-9.9, 10.1, 0.0}}, {1.2, 0.95, 0.7}, {1.0, 1.0, 0.9}, 0.5);  // upper jaw
  chain({{-7.0, 10.1, 0.0}, {-8.9, 9.2, 0.0}}, {0.75, 0.4}, {1.0, 1.0, 1.0}, 0.3);                           // lower jaw
  add_pair(l, {{-6.9, 11.7, 0.5}, {-4.9, 13.4, 1.1}, 0.42, 0.16, {1, 1, 1}, 0.3});                           // horn
  add_pair(l, ball({-8.0, 11.6, 0.75}, 0.38, Vec3::Ones(), 0.15));                                           // eye
  const auto leg = [&](const Vec3& hip, double forward, double thick) {
    const Vec3 knee = hip + Vec3(0.9 * forward, -1.7, 0.9), foot(hip[0] - 0.3, 0.75, hip[2] + 0.9);
    add_pair(l, {hip, knee, 1.25 * thick, 0.85 * thick, {1, 1, 1}, 0.6});
    add_pair(l, {knee, foot, 0.8 * thick, 0.6 * thick, {1, 1, 1}, 0.4});
    for (const double side : {-0.6, 0.0, 0.6}) add_pair(l, {foot, foot + Vec3(-1.3, -0.3, side), 0.5, 0.3, {1, 1, 1}, 0.3});
  };
  leg({4.4, 4.3, 1.2}, -1.0, 1.1);
  leg({-3.3, 3.9, 1.2}, 1.0, 0.95);
  for (std::size_t n = 2; n + 1 < spine.size(); ++n)  // a ridge of spines along the back
    for (const double t : {0.25, 0.75}) {
      const Vec3 along = (spine[n + 1] - spine[n]).normalized();
      Vec3 away = Vec3(along[1], -along[0], 0.0);  // to the outer side of the curve from tail to head
      const double radius = (1.0 - t) * girth[n] + t * girth[n + 1];
      const Vec3 foot = (1.0 - t) * spine[n] + t * spine[n + 1] + 0.8 * radius * away;
      l.push_back({foot, foot + (0.35 + 0.35 * radius) * away + 0.3 * -along, 0.5, 0.28, {1, 1, 0.8}, 0.3});
    }
  return {"dragon", l, {-11.5, -0.6, -4.5}, {12.0, 14.5, 4.5}, 0.26};
}

const std::vector<Figure>& figures() {
  static const std::vector<Figure> all = {hare(), dragon()};
  return all;
}

}  // namespace

const std::vector<std::string>& builtin_meshes() {
  static const std::vector<std::string> names = [] {
    std::vector<std::string> result;
    for (const Figure& figure : figures()) result.push_back(figure.name);
    return result;
  }();
  return names;
}

TriangleMesh builtin_mesh(const std::string& name) {
  const auto figure = std::find_if(figures().begin(), figures().end(), [&](const Figure& f) { return f.name == name; });
  if (figure == figures().end())
    throw UsageError(fmt::format("is no figure of the program; there are: {}{}", builtin_prefix,
                                 fmt::join(builtin_meshes(), fmt::format(", {}", builtin_prefix))));
  const auto blended = [&](const Vec3& x) {
    double nearest = 1e3;
    for (const Limb& limb : figure->limbs) nearest = smooth_minimum(nearest, distance(limb, x), limb.blend);
    return nearest;
  };
  TriangleMesh mesh = isosurface(blended, figure->lower, figure->upper, figure->spacing);
  for (Vec3& v : mesh.vertices) v = 0.01 * moved_to_surface(blended, v, 0.1 * figure->spacing);
  return mesh;
}

}  // namespace bulkley
