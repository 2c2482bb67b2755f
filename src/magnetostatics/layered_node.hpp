#pragma once
// Nodes that a surface cuts, as layers along it (docs/theory.md, "Magnetic fields").

#include <span>
#include <vector>

#include "bulkley/base/types.hpp"
#include "magnetics/magnetisation.hpp"

namespace bulkley {

/// The magnetic content of a node: materials by their shares of it.
class Mixture {
 public:
  /// `content`: by material, by node; `total`: their sum at the node, > 0. All must outlive this.
  Mixture(std::span<const Magnetisation> materials, std::span<const std::vector<double>> content, std::size_t node,
          double total)
      : materials_(materials), content_(content), node_(node), total_(total) {}

  double at(double h) const {
    return mean([&](const Magnetisation& m) { return m.at(h); });
  }
  Magnetisation::Response response(double h) const {
    Magnetisation::Response sum{0.0, 0.0};
    for (std::size_t s = 0; s < materials_.size(); ++s) {
      const double share = content_[s][node_] / total_;
      const Magnetisation::Response one = materials_[s].response(h);
      sum.magnetisation += share * one.magnetisation;
      sum.slope += share * one.slope;
    }
    return sum;
  }
  double initial_susceptibility() const {
    return mean([](const Magnetisation& m) { return m.initial_susceptibility(); });
  }

 private:
  template <class Value>
  double mean(Value value) const {
    double sum = 0.0;
    for (std::size_t s = 0; s < materials_.size(); ++s) sum += content_[s][node_] / total_ * value(materials_[s]);
    return sum;
  }

  std::span<const Magnetisation> materials_;
  std::span<const std::vector<double>> content_;
  std::size_t node_;
  double total_;
};

/// How much of a node is filled, and which way that grows.
struct Filling {
  double total = 0.0;                           ///< theta > 0
  double dilution = 0.0, dilution_slope = 0.0;  ///< c(theta)
  Vec3 gradient = Vec3::Zero();                 ///< of theta, a cell
};

/// The field in a node and what it makes of the content.
struct LayeredNode {
  Mat3 permeability = Mat3::Identity();  ///< relative
  double inner = 0.0;                    ///< h, A/m
  double depolarised = 0.0;              ///< m . N m, (A/m)^2
  Vec3 gradient_slope = Vec3::Zero();    ///< of w by the gradient of theta, (A/m)^2
};

/// h + c N m(h) = H with the depolarisation N = (g g + (e^2/3) 1)/(g^2 + e^2), g being the gradient of theta: a layer across g, but
/// spheres where g is small next to e. `squares`: H H, (A/m)^2; zero: of a weak field. Not collective.
LayeredNode layered_node(const Mixture& mixture, const Filling& filling, const Mat3& squares);

}  // namespace bulkley
