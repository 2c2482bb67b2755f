#include "bench_count.hpp"

#include "bulkley/particle/particle_set.hpp"

namespace bulkley {

namespace {

// Bytes of one double, read or written back after it was read, and written blindly (its line is read first).
constexpr double pass = 8.0, blind = 16.0;
constexpr double cell = sizeof(LocalIndex);
constexpr double node = 4 * sizeof(double);
constexpr double lanes = 4.0;  // of a node: momentum or velocity, and mass

int width(const WorkCase& w) { return stencil_width(w.transfer.order); }
bool split(const WorkCase& w) { return w.transfer.flip_fraction() > 0.0; }
bool bspline(const WorkCase& w) { return w.transfer.gradient == GradientForm::bspline; }
bool moments(const WorkCase& w) { return w.transfer.affine() || !bspline(w); }

// Of three axes: offset in the stencil, and the weights or their derivatives.
double weight_flops(const WorkCase& w) { return 3.0 * (w.transfer.order == SplineOrder::quadratic ? 4 + 9 : 4 + 20); }
double derivative_flops(const WorkCase& w) {
  return !bspline(w) ? 0.0 : 3.0 * (w.transfer.order == SplineOrder::quadratic ? 4 : 14);
}

WorkTerm p2g(const WorkCase& w) {
  // x, v, tau, m, V, and C where it is used.
  const int n_doubles = 3 + 3 + 6 + 1 + 1 + (w.transfer.affine() ? 9 : 0);
  return {"p2g, particles", n_doubles * pass + cell, 0.0};
}

WorkTerm p2g_coefficients(const WorkCase& w) {
  double flops = weight_flops(w) + derivative_flops(w) + 3;                        // m v
  if (w.transfer.affine()) flops += 9 * (2 + 2);                                   // a = m dx C, q -= a f
  flops += 9 * (bspline(w) ? 2 : 2 + (split(w) || !w.transfer.affine() ? 2 : 0));  // V tau; its part of q or of the impulse
  return {"p2g, coefficients", 0.0, flops};
}

WorkTerm p2g_nodes(const WorkCase& w) {
  // Rounded addend fma(w, q, M) - M and its addition; then the next node's q by increment.
  const double add = lanes * (2 + 1 + 1), increment = lanes;
  double per_node = 1 + add + increment, per_row = 1 + increment, per_plane = increment;
  if (bspline(w)) {
    per_node += lanes * (1 + 2) + 1;                 // w_z F_xy + w d_z F_z
    per_row += 2 + lanes * (1 + 2);                  // F_xy = d_x w_y F_x + w_x d_y F_y
    per_node += split(w) ? add - 2 * lanes : lanes;  // rounded and added apart, or to the other part
  } else if (split(w)) {
    per_node += add + increment, per_row += increment, per_plane += increment;
  }
  const double s = width(w);
  return {"p2g, nodes", 0.0, s * s * s * per_node + s * s * per_row + s * per_plane};
}

WorkTerm g2p_nodes(const WorkCase& w) {
  // Sums factored by axis: each is a fused product and sum of four lanes.
  const double fma = 2 * lanes, sums = (moments(w) ? 1 : 0) + (bspline(w) ? 1 : 0);
  const double s = width(w);
  double flops = s * s * s * fma * (1 + sums) + s * s * fma * (1 + 2 * sums) + s * fma * (1 + 3 * sums);
  if (split(w)) flops += s * s * s * (1 + fma) + s * s;  // the velocity change, not factored
  flops += weight_flops(w) + derivative_flops(w) + (moments(w) ? 3 * s * 2 : 0.0);
  return {"g2p, nodes", 0.0, flops};
}

WorkTerm g2p_particles(const WorkCase& w) {
  // Reads x, m, id, cell; writes x back, and v and C (and L) blindly, but v after reading where the velocity is blended.
  double bytes = (3 + 1 + 1) * pass + cell + 3 * pass + 3 * (split(w) ? 2 * pass : blind);
  double flops = 3 * 2 + (split(w) ? 3 * 4 : 0) + (5 + 17 + 6);  // x += dt v; the blend; norms of v and L and their use
  if (moments(w)) bytes += 9 * blind, flops += 9;
  if (bspline(w)) bytes += 9 * blind, flops += 9;
  return {"g2p, particles", bytes, flops};
}

WorkTerm stress(const WorkCase& w) {
  // What g2p has just written is still in cache. Reads b, J, V, material; writes b, J back, tau and the shear rate blindly.
  double bytes = (6 + 1 + 1) * pass + 1 + (6 + 1) * pass + (6 + 1) * blind;
  double flops = 12 + 14 + 30 + 75 + 7 + 1;  // 1 + dt L, its determinant, inverse cube root, f b f^T, scaled; J
  flops += 6 + 6 + 7;                        // deviator, tau
  flops += 20 + 12 + 14;                     // wave speed, norm of tau, whether finite
  if (w.flows) {
    bytes += 2 * pass;     // dissipation, read and written back
    flops += 13;           // trial norm
    flops += 2 * 28;       // logarithms
    flops += 2 * 30 + 12;  // exponentials and residual of one Newton step
    flops += 14 + 2 * 12;  // det b = 1: invariants, two Newton steps
    flops += 15;           // scaled deviator, dissipation
  }
  return {"stress", bytes, flops};
}

WorkTerm locate(const WorkCase&) { return {"locate", cell, 3 * 3}; }  // x is in cache; writes the cell back

WorkTerm sort(const WorkCase& w) {
  const ParticleSet particles(w.transfer.needs_velocity_gradient());
  double bytes = 4 * cell;  // reads the cells, writes the order blindly, and the cells in it
  for (const ParticleSet::Column& column : particles.columns())
    if (column.moves) bytes += 3.0 * static_cast<double>(column.element_size) + cell;  // read, written blindly, by the order
  return {"sort", w.sorts_per_step * bytes, 0.0};
}

WorkTerm nodes(const WorkCase& w) {
  // Passes over a node: zeroed blindly in the pool (2); read by the exchange and added to the zeroed owner (1 + 2 + 2);
  // updated (2); read and copied back blindly (1 + 2); read by g2p (1).
  const double passes = (2 + (1 + 2 + 2) + 2 + (1 + 2) + 1) * (split(w) ? 2.0 : 1.0);
  const double flops = lanes + 3 + 1 + 3;  // sum, v = p / m, gravity
  return {"nodes", w.nodes_per_particle * passes * node, w.nodes_per_particle * flops};
}

}  // namespace

std::vector<WorkTerm> count_work(const WorkCase& w) {
  return {p2g(w),    p2g_coefficients(w), p2g_nodes(w), g2p_nodes(w), g2p_particles(w),
          stress(w), locate(w),           sort(w),      nodes(w)};
}

}  // namespace bulkley
