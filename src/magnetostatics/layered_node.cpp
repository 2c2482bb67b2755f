#include "magnetostatics/layered_node.hpp"

#include <algorithm>
#include <cmath>

namespace bulkley {

namespace {

// e^2: a lone particle of an eighth of a cell has gradients of at most 0.05.
constexpr double small_gradient_squared = 0.05 * 0.05;
constexpr int layered_steps = 8;
constexpr double layered_converged = 1e-8;  // the step after it would be of the order of its square

// h of |h|^2 = across/(1 + c N_n x)^2 + along/(1 + c N_t x)^2 with x = m(h)/h: by Newton's method from the weak field's.
double inner_field(const Mixture& mixture, double across, double along, double cn, double ct, double weak) {
  // Squares of averages and averages of squares can differ so much at a surface that the sum is negative.
  const double least = 1e-12 * (across + along);
  const auto strength = [&](double x) {
    const double n = 1.0 + cn * x, t = 1.0 + ct * x;
    return std::sqrt(std::max(across / (n * n) + along / (t * t), least));
  };
  double h = strength(weak);
  for (int n = 0; n < layered_steps; ++n) {
    const Magnetisation::Response m = mixture.response(h);
    const double x = m.magnetisation / h, found = strength(x);
    const double by_x = -(across * cn / std::pow(1.0 + cn * x, 3) + along * ct / std::pow(1.0 + ct * x, 3)) / found;
    const double step = (h - found) / (1.0 - by_x * (m.slope - x) / h);
    h -= step;
    if (std::abs(step) < layered_converged * h) break;
  }
  return h;
}

}  // namespace

LayeredNode layered_node(const Mixture& mixture, const Filling& filling, const Mat3& squares) {
  const Vec3& g = filling.gradient;
  const double g2 = g.squaredNorm(), scale = g2 + small_gradient_squared, c = filling.dilution;
  const double rest = small_gradient_squared / 3.0 / scale;  // N across the normal
  const Mat3 N = g * g.transpose() / scale + rest * Mat3::Identity();

  LayeredNode node;
  double x = mixture.initial_susceptibility();
  const double strength2 = squares.trace();
  if (strength2 > 0.0) {
    const double normal = g2 > 0.0 ? g.dot(squares * g) / g2 : 0.0;
    node.inner = inner_field(mixture, normal, strength2 - normal, c * (g2 / scale + rest), c * rest, x);
    x = mixture.at(node.inner) / node.inner;
  }
  const double along = 1.0 / (1.0 + c * rest * x), across = 1.0 / (1.0 + c * (g2 / scale + rest) * x);
  Mat3 dilute = along * Mat3::Identity();  // (1 + c x N)^-1
  if (g2 > 0.0) dilute += (across - along) / g2 * (g * g.transpose());
  node.permeability += filling.total * x * dilute;
  const Mat3 m = x * x * dilute * squares * dilute;  // m m
  node.depolarised = (N * m).trace();
  const Vec3 along_g = m * g;
  node.gradient_slope =
      -c * filling.total * (along_g / scale - g * (g.dot(along_g) / (scale * scale) + rest * m.trace() / scale));
  return node;
}

}  // namespace bulkley
