#pragma once
// The Material Point Method as plainly as it can be written: one process, one particle at a time, all nodes of the grid.
//
// The truth that the real step is compared with. It shares no kernel and no constitutive law with the program, only the
// grid's description and the wall rules; every formula is the textbook one, and roots are bisected to the last bit.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "grid/boundary.hpp"
#include "kernel/transfer.hpp"

namespace bulkley {

struct ReferenceParticle {
  Vec3 x = Vec3::Zero(), v = Vec3::Zero();
  Mat3 C = Mat3::Zero();      ///< B D^-1, computed in every scheme, used by APIC
  Mat3 L = Mat3::Zero();      ///< velocity gradient of the last step, 1/s
  Mat3 b = Mat3::Identity();  ///< isochoric elastic left Cauchy-Green tensor
  double J = 1.0;
  double m = 0.0;            ///< kg
  double V = 0.0;            ///< reference volume, m^3
  Mat3 tau = Mat3::Zero();   ///< Kirchhoff stress, Pa
  double shear_rate = 0.0;   ///< plastic, sqrt(2) gamma, 1/s
  double dissipation = 0.0;  ///< J/m^3, so far
  int material = 0;
  GlobalIndex id = 0;
};

/// Neo-Hookean elasticity (Simo; Yue et al. 2015), with Herschel-Bulkley flow in Yue's own constants if `flows`.
struct ReferenceMaterial {
  double bulk_modulus = 0.0;   ///< kappa, Pa
  double shear_modulus = 0.0;  ///< mu, Pa
  bool flows = false;
  double sigma_Y = 0.0;  ///< Pa
  double eta = 0.0;      ///< Pa s^h
  double h = 1.0;
};

/// Where an increasing function changes sign between `low` (negative) and `high`, to the last bit.
template <class Function>
double bisect(const Function& f, double low, double high) {
  for (double middle = 0.5 * (low + high); low < middle && middle < high; middle = 0.5 * (low + high))
    (f(middle) < 0.0 ? low : high) = middle;
  return high;
}

/// Advances J, b and tau of one particle over dt under its velocity gradient L (Herschel-Bulkley: backward Euler, det b = 1
/// restored exactly). Throws std::runtime_error if det(1 + dt L) <= 0.
inline void advance_state(const ReferenceMaterial& law, double dt, ReferenceParticle& p) {
  const double mu = law.shear_modulus;
  const Mat3 one = Mat3::Identity();
  const Mat3 f = one + dt * p.L;
  if (!(f.determinant() > 0.0)) throw std::runtime_error("particle " + std::to_string(p.id) + " is inverted");
  p.J *= f.determinant();
  const Mat3 f_bar = std::pow(f.determinant(), -1.0 / 3.0) * f;
  const Mat3 trial = f_bar * p.b * f_bar.transpose();
  const double mean = trial.trace() / 3.0;
  const Mat3 trial_deviator = trial - mean * one;
  p.b = trial;
  p.shear_rate = 0.0;

  const double s_trial = mu * trial_deviator.norm();
  // The flow curve is one of the Cauchy stress: in the Kirchhoff stress s both of its constants are J times as large.
  const double radius = std::sqrt(2.0 / 3.0) * p.J * law.sigma_Y, eta = p.J * law.eta;
  if (law.flows && s_trial > radius) {
    // Overstress y = s - radius: y - (s_trial - radius) + 2 mu mean dt (y / eta)^(1/h) = 0.
    const double excess = s_trial - radius;
    const auto overstress = [&](double t) { return t - excess + 2.0 * mu * mean * dt * std::pow(t / eta, 1.0 / law.h); };
    const double y = eta == 0.0 ? 0.0 : bisect(overstress, 0.0, excess);
    const Mat3 e = ((radius + y) / s_trial) * trial_deviator;
    // Spherical part: det(e + x 1) = 1, the largest root.
    const double J2 = 0.5 * e.squaredNorm();
    const auto excess_volume = [&](double t) { return t * (t * t - J2) + e.determinant() - 1.0; };
    const double x = bisect(excess_volume, std::max(1.0, std::sqrt(J2 / 3.0)), mean);
    p.b = e + x * one;
    p.shear_rate = std::sqrt(2.0) * (excess - y) / (2.0 * mu * mean * dt);
    // Stress at the end times the strain taken away: x^3 - (e:e/2) x + det e = 1 gives dx for a change of e along itself.
    const double scale = e.norm() > 0.0 ? (trial_deviator.norm() - e.norm()) / e.norm() : 0.0;
    const double dx = scale * (x * e.squaredNorm() - 3.0 * e.determinant()) / (3.0 * x * x - 0.5 * e.squaredNorm());
    p.dissipation += 1.5 * mu * dx;
  }
  p.tau = 0.5 * law.bulk_modulus * (p.J * p.J - 1.0) * one + mu * (p.b - p.b.trace() / 3.0 * one);
}

/// Everything that does not change during a run.
struct ReferenceScene {
  GridGeometry grid;
  TransferSettings transfer;
  Vec3 gravity = Vec3::Zero();
  Faces faces;
  std::vector<Collider> colliders;
  std::vector<ReferenceMaterial> materials;
};

struct ReferenceNode {
  double m = 0.0;
  Vec3 momentum = Vec3::Zero(), force = Vec3::Zero();
  Vec3 v_old = Vec3::Zero(), v = Vec3::Zero();
};

class ReferenceMpm {
 public:
  ReferenceMpm(ReferenceScene scene, std::vector<ReferenceParticle> start)
      : particles(std::move(start)), scene_(std::move(scene)) {
    const GridGeometry& g = scene_.grid;
    if (g.order != scene_.transfer.order) throw std::invalid_argument("grid and transfer disagree on the spline order");
    std::vector<Int3> indices;
    for (int i = 0; i < g.n_nodes(0); ++i)
      for (int j = 0; j < g.n_nodes(1); ++j)
        for (int k = 0; k < g.n_nodes(2); ++k) indices.push_back({i, j, k});
    nodes.resize(indices.size());
    for (const Int3& n : indices)
      position.push_back({g.node_coordinate(0, n[0]), g.node_coordinate(1, n[1]), g.node_coordinate(2, n[2])});
    constraints_ = node_constraints(g, scene_.faces, scene_.colliders, indices);
  }

  /// One explicit step. Throws std::runtime_error if a particle inverts or leaves through a face that is no outflow.
  void step(double dt) {
    p2g();
    grid_update(dt);
    g2p(dt);
    for (ReferenceParticle& p : particles) advance_state(scene_.materials.at(static_cast<std::size_t>(p.material)), dt, p);
    advect(dt);
  }

  void p2g() {
    nodes.assign(nodes.size(), ReferenceNode{});
    for (const ReferenceParticle& p : particles) {
      for (const Entry& e : stencil(p.x)) {
        ReferenceNode& node = nodes[e.node];
        const Vec3 v = scene_.transfer.affine() ? Vec3(p.v + p.C * e.offset) : p.v;
        node.m += e.w * p.m;
        node.momentum += e.w * p.m * v;
        node.force -= p.V * p.tau * (bspline() ? e.gradient : Vec3(e.w * e.offset / second_moment()));
      }
    }
  }

  void grid_update(double dt) {
    for (ReferenceNode& node : nodes) node.force += node.m * scene_.gravity;
    for_images(
        [](const Face& face, int axis, ReferenceNode& behind, ReferenceNode& front) {
          front.momentum += mirrored(face, axis, behind.momentum - behind.m * face.velocity) + behind.m * face.velocity;
          front.force += mirrored(face, axis, behind.force);
          front.m += behind.m;
          behind = ReferenceNode{};
        },
        {0, 1, 2});
    double largest = 0.0;
    for (const ReferenceParticle& p : particles) largest = std::max(largest, p.m);
    for (ReferenceNode& node : nodes) {
      if (node.m <= empty_node * largest) continue;
      node.v_old = node.momentum / node.m;
      node.v = node.v_old + dt * node.force / node.m;
    }
    for (const NodeConstraint& c : constraints_) {
      ReferenceNode& node = nodes[static_cast<std::size_t>(c.node)];
      node.v = constrained_velocity(c, node.v);
    }
    for_images(
        [](const Face& face, int axis, ReferenceNode& behind, const ReferenceNode& front) {
          behind.v_old = mirrored(face, axis, front.v_old - face.velocity) + face.velocity;
          behind.v = mirrored(face, axis, front.v - face.velocity) + face.velocity;
        },
        {2, 1, 0});
  }

  /// A vector in the mirror that a sticky or slip face is.
  static Vec3 mirrored(const Face& face, int axis, Vec3 v) {
    if (face.kind == FaceKind::sticky) return -v;
    v[axis] = -v[axis];
    return v;
  }

  /// `action(face, axis, behind, front)` for all pairs of nodes one cell behind and in front of a sticky or slip face.
  template <class Action>
  void for_images(const Action& action, const Int3& axes) {
    for (const int axis : axes)
      for (int side = 0; side < 2; ++side) {
        const Face& face = scene_.faces[static_cast<std::size_t>(2 * axis + side)];
        if (face.kind != FaceKind::sticky && face.kind != FaceKind::slip) continue;
        const double wall = side == 0 ? scene_.grid.lower[axis] : scene_.grid.upper()[axis];
        const double one_behind = wall + (side == 0 ? -1.0 : 1.0) * scene_.grid.cell_size;
        std::size_t stride = 1;
        for (int a = axis + 1; a < 3; ++a) stride *= static_cast<std::size_t>(scene_.grid.n_nodes(a));
        for (std::size_t n = 0; n < nodes.size(); ++n)
          if (std::abs(position[n][axis] - one_behind) < 0.1 * scene_.grid.cell_size)
            action(face, axis, nodes[n], nodes[side == 0 ? n + 2 * stride : n - 2 * stride]);
      }
  }

  /// Velocities, C and L; positions stay, but what they will advance with is kept in `v_pic`.
  void g2p(double dt) {
    v_pic.clear();
    for (ReferenceParticle& p : particles) {
      Vec3 pic = Vec3::Zero(), change = Vec3::Zero();
      Mat3 B = Mat3::Zero(), B_of_change = Mat3::Zero(), gradient = Mat3::Zero();
      for (const Entry& e : stencil(p.x)) {
        const ReferenceNode& node = nodes[e.node];
        pic += e.w * node.v;
        change += e.w * (node.v - node.v_old);
        B += e.w * node.v * e.offset.transpose();
        B_of_change += e.w * (node.v - node.v_old) * e.offset.transpose();
        gradient += node.v * e.gradient.transpose();
      }
      const TransferSettings& t = scene_.transfer;
      const double alpha = t.damping_time > 0.0                ? std::exp(-dt / t.damping_time)
                           : t.scheme == TransferScheme::flip  ? 1.0
                           : t.scheme == TransferScheme::blend ? t.flip_ratio
                                                               : 0.0;
      const double zeta = t.scheme == TransferScheme::apic ? t.affine_damping : 0.0;
      const Mat3 C = B / second_moment();
      const Vec3 residual = p.v - (pic - change);
      p.v = pic + alpha * residual;
      p.L = bspline() ? gradient : C;
      if (t.scheme == TransferScheme::moment_flip) {
        const Mat3 L0 = (B - B_of_change) / second_moment(), W0 = skew(L0), R = p.C - L0;
        const Mat3 Q = sym(L0 * L0);
        const double along = R.cwiseProduct(Q).sum();
        const double time = along > 0.0 ? std::min(along / Q.squaredNorm(), dt) : 0.0;
        p.C = C + alpha * (R - time * Q) +
              dt * alpha *
                  (-sym(R * W0) + skew(R * L0.transpose()) - skew(residual * change.transpose()) / second_moment());
      } else {
        p.C = (1.0 - zeta) * C + 0.5 * zeta * (C - C.transpose());
      }
      v_pic.push_back(pic);
    }
  }

  static Mat3 sym(const Mat3& A) { return 0.5 * (A + A.transpose()); }
  static Mat3 skew(const Mat3& A) { return 0.5 * (A - A.transpose()); }

  /// x += dt v_pic, then the faces: periodic ones wrap, walls put a particle back onto their plane, outflows remove it.
  void advect(double dt) {
    const Vec3 lower = scene_.grid.lower, upper = scene_.grid.upper();
    std::vector<ReferenceParticle> staying;
    for (std::size_t n = 0; n < particles.size(); ++n) {
      ReferenceParticle& p = particles[n];
      p.x += dt * v_pic[n];
      bool stays = true;
      for (int a = 0; a < 3; ++a) {
        if (scene_.grid.periodic[static_cast<std::size_t>(a)]) {
          if (p.x[a] < lower[a]) p.x[a] += upper[a] - lower[a];
          if (p.x[a] >= upper[a]) p.x[a] -= upper[a] - lower[a];
        } else if (p.x[a] < lower[a] || p.x[a] > upper[a]) {
          const bool below = p.x[a] < lower[a];
          const FaceKind kind = scene_.faces[static_cast<std::size_t>(2 * a + (below ? 0 : 1))].kind;
          if (kind == FaceKind::open) throw std::runtime_error("particle " + std::to_string(p.id) + " left the domain");
          if (kind == FaceKind::outflow) stays = false;
          p.x[a] = below ? lower[a] : upper[a];
        }
      }
      if (stays) staying.push_back(p);
    }
    particles = std::move(staying);
  }

  std::vector<ReferenceParticle> particles;
  std::vector<ReferenceNode> nodes;  ///< all nodes of the grid, z fastest
  std::vector<Vec3> position;        ///< of the nodes, m
  std::vector<Vec3> v_pic;           ///< of the particles, from the last g2p
  double empty_node = 1e-12;         ///< nodes lighter than this times the heaviest particle count as empty

  /// D = Dx^2 / 4 (quadratic) or Dx^2 / 3 (cubic).
  double second_moment() const {
    const double dx = scene_.grid.cell_size;
    return dx * dx / (cubic() ? 3.0 : 4.0);
  }

  struct Entry {
    std::size_t node;
    double w;
    Vec3 gradient;  ///< of w in x_p, 1/m
    Vec3 offset;    ///< x_i - x_p, m
  };
  /// All nodes that a particle at x reaches.
  std::vector<Entry> stencil(const Vec3& x) const {
    const GridGeometry& grid = scene_.grid;
    const double dx = grid.cell_size;
    const int width = cubic() ? 4 : 3;
    const Vec3 xi = (x - grid.lower) / dx;
    int first[3];
    for (int a = 0; a < 3; ++a) first[a] = static_cast<int>(std::floor(cubic() ? xi[a] - 1.0 : xi[a] - 0.5));
    std::vector<Entry> result;
    for (int i = 0; i < width; ++i)
      for (int j = 0; j < width; ++j)
        for (int k = 0; k < width; ++k) {
          const int g[3] = {first[0] + i, first[1] + j, first[2] + k};
          double N[3], dN[3];
          for (int a = 0; a < 3; ++a) spline(xi[a] - g[a], N[a], dN[a]);
          Entry e;
          e.node = node_index(g);
          e.w = N[0] * N[1] * N[2];
          e.gradient = Vec3(dN[0] * N[1] * N[2], N[0] * dN[1] * N[2], N[0] * N[1] * dN[2]) / dx;
          e.offset = dx * (Vec3(g[0], g[1], g[2]) - xi);
          result.push_back(e);
        }
    return result;
  }

 private:
  bool cubic() const { return scene_.transfer.order == SplineOrder::cubic; }
  bool bspline() const { return scene_.transfer.gradient == GradientForm::bspline; }

  /// N(u) and dN/du of the B-spline.
  void spline(double u, double& N, double& dN) const {
    const double a = std::abs(u), sign = u < 0.0 ? -1.0 : 1.0;
    if (cubic()) {
      N = a < 1.0 ? 0.5 * a * a * a - a * a + 2.0 / 3.0 : std::pow(2.0 - a, 3) / 6.0;
      dN = a < 1.0 ? u * (1.5 * a - 2.0) : -0.5 * sign * (2.0 - a) * (2.0 - a);
    } else {
      N = a < 0.5 ? 0.75 - u * u : 0.5 * (1.5 - a) * (1.5 - a);
      dN = a < 0.5 ? -2.0 * u : u - 1.5 * sign;
    }
  }

  /// Index of the node at lower + g dx, wrapped along periodic axes.
  std::size_t node_index(const int g[3]) const {
    const GridGeometry& grid = scene_.grid;
    std::size_t index = 0;
    for (int a = 0; a < 3; ++a) {
      const int n = grid.n_nodes(a);
      const int i = grid.periodic[static_cast<std::size_t>(a)] ? ((g[a] % n) + n) % n : g[a] + grid.node_offset(a);
      if (i < 0 || i >= n) throw std::runtime_error("a stencil leaves the grid");
      index = index * static_cast<std::size_t>(n) + static_cast<std::size_t>(i);
    }
    return index;
  }

  ReferenceScene scene_;
  std::vector<NodeConstraint> constraints_;
};

}  // namespace bulkley
