#include "bench/count.hpp"

#include "bulkley/particle/particle_set.hpp"

namespace bulkley {

namespace {

// Bytes of one double, read or written back after it was read, and written blindly (its line is read first).
constexpr double pass = 8.0, blind = 16.0;
constexpr double cell = sizeof(LocalIndex);
constexpr double node_bytes = 4 * sizeof(double);
constexpr double lanes = 4.0;  // of a node: momentum or velocity, and mass

int width(const WorkCase& w) { return stencil_width(w.transfer.order); }
bool quadratic(const WorkCase& w) { return w.transfer.order == SplineOrder::quadratic; }
bool split(const WorkCase& w) { return w.transfer.keeps_residual(); }
bool bspline(const WorkCase& w) { return w.transfer.gradient == GradientForm::bspline; }
bool moments(const WorkCase& w) { return w.transfer.affine() || !bspline(w); }
bool both_residuals(const WorkCase& w) { return split(w) && w.transfer.affine(); }

// Of three axes: offset in the stencil, and the weights or their derivatives.
double weight_flops(const WorkCase& w) { return 3.0 * (quadratic(w) ? 4 + 9 : 4 + 20); }
double derivative_flops(const WorkCase& w) { return bspline(w) ? 3.0 * (quadratic(w) ? 4 : 14) : 0.0; }

WorkTerm p2g_particles(const WorkCase& w) {
  // x, v, V, tau or what makes it, b and, unless the cell's mean stress is known, J; and C where it is used.
  const int of_stress = w.stores_stress || w.shares_dilation ? 6 : 7;
  const int n_doubles = 3 + 3 + 1 + of_stress + (w.transfer.affine() ? 9 : 0);
  return {"p2g, particles", n_doubles * pass + cell, 0.0};
}

WorkTerm p2g_coefficients(const WorkCase& w) {
  const double s = width(w);
  double flops = weight_flops(w) + s * s;                    // and the products w_x w_y
  flops += 3 + 1 + 9;                                        // m v, dt V tau
  if (!w.stores_stress) flops += 6 + 6 + (w.shares_dilation ? 3 : 7);  // tau of b and J
  if (w.transfer.affine()) flops += 1 + 9;                   // a = m dx C
  if (!bspline(w)) flops += split(w) ? 9 * 2 : 9;            // the force's part of the impulse, or its addition to a
  if (!split(w) || both_residuals(w)) flops += 9 * 2;        // q = m v - a f
  if (bspline(w)) flops += derivative_flops(w) + 2 * s * s;  // and the products d_x w_y, w_x d_y
  return {"p2g, coefficients", 0.0, flops};
}

WorkTerm p2g_nodes(const WorkCase& w) {
  // A rounded addend, (w_z q + M) - M, and its addition; the next node's q by an increment. A row begins with w_xy q.
  double per_node = (2 + 1 + 1) * lanes, per_row = lanes, per_plane = 0.0;
  if (!split(w) || both_residuals(w)) per_node += lanes, per_row += 2 * lanes, per_plane += lanes;
  if (bspline(w)) {
    per_node += (1 + 2 + 1) * lanes;      // w_z g + d_z g_z, added to the rest
    per_row += (1 + 2 + 1) * lanes;       // g = d_x w_y F_x + w_x d_y F_y, g_z = w_xy F_z
    if (split(w)) per_node += 2 * lanes;  // rounded and added apart
  } else if (split(w)) {
    per_node += (2 + 1 + 1 + 1) * lanes, per_row += 3 * lanes, per_plane += lanes;  // the impulse likewise
  }
  const double s = width(w);
  return {"p2g, nodes", 0.0, s * s * s * per_node + s * s * per_row + s * per_plane};
}

WorkTerm g2p_nodes(const WorkCase& w) {
  // Sums factored by axis. A sum of s products of four lanes, and the first moment of its addends about node 1.
  const double s = width(w);
  const double sum = (2 * s - 1) * lanes, moment = (quadratic(w) ? 2 : 4) * lanes;
  double per_row = sum, per_plane = sum, rest = sum;
  if (moments(w)) per_row += moment, per_plane += moment + sum, rest += moment + 2 * sum;
  if (bspline(w)) per_row += sum, per_plane += 2 * sum, rest += 3 * sum;
  if (split(w)) per_row += sum, per_plane += sum, rest += sum;                                    // the change of velocity
  if (both_residuals(w)) per_row += moment, per_plane += moment + sum, rest += moment + 2 * sum;  // and its moments
  return {"g2p, nodes", 0.0, weight_flops(w) + derivative_flops(w) + s * s * per_row + s * per_plane + rest};
}

WorkTerm g2p_particles(const WorkCase& w) {
  // Reads x, V, id, cell; writes x back, and v and C blindly, but v after reading where the velocity is blended.
  double bytes = (3 + 1 + 1) * pass + cell + 3 * pass + 3 * (split(w) ? 2 * pass : blind);
  double flops = 3 * 2 + (split(w) ? 3 * 4 : 0) + (5 + 17 + 6);  // x += dt v; the blend; norms of v and L and their use
  if (moments(w)) bytes += 9 * blind, flops += 3 + 9 * (2 + 1);  // C = (moments - distance v) / D
  if (bspline(w)) flops += 9;                                    // L, scaled; held for a block, in cache
  // (T9b): q and v; L_0 and R; Q; t; W_0; C off its diagonal and on it, which is read in any case.
  if (both_residuals(w)) flops += 3 * 4 + 9 * 5 + 36 + 31 + 6 + 3 * 34 + 3 * 9;
  return {"g2p, particles", bytes, flops};
}

WorkTerm stress(const WorkCase& w) {
  // What g2p has just read and written is still in cache. Reads b, J, material; writes b and J back; likewise tau
  // where it is stored.
  double bytes = (6 + 1) * pass + 1 + (6 + 1) * pass + (w.stores_stress ? 2 * 6 * pass : 0.0);
  double flops = 12 + 14 + 30 + 75 + 7 + 1;  // 1 + dt L, its determinant, inverse cube root, f b f^T, scaled; J
  flops += 6 + 6 + 7;                        // deviator, tau
  flops += 20 + 12 + 14;                     // wave speed, norm of tau, whether finite
  if (w.flows) {
    bytes += 2 * 2 * pass;  // shear rate and dissipation, read and written back
    flops += 13;            // trial norm
    flops += 2 * 28;        // logarithms
    flops += 2 * 30 + 12;   // exponentials and residual of one Newton step
    flops += 14 + 2 * 12;   // det b = 1: invariants, two Newton steps
    flops += 15;            // scaled deviator, dissipation
  }
  return {"stress", bytes, flops};
}

WorkTerm locate(const WorkCase&) { return {"locate", cell, 3 * 10}; }  // x is in cache; writes the cell back

WorkTerm sort(const WorkCase& w) {
  const ParticleSet particles(w.stores_stress ? OptionalFields{Field::kirchhoff_stress} : OptionalFields{});
  double bytes = 4 * cell;  // reads the cells, writes the order blindly, and the cells in it
  for (const ParticleSet::Column& column : particles.columns())
    if (column.moves) bytes += 3.0 * static_cast<double>(column.element_size) + cell;  // read, written blindly, by the order
  return {"sort", w.sorts_per_step * bytes, 0.0};
}

WorkTerm nodes(const WorkCase& w) {
  // Passes over a node: zeroed blindly in the pool (2); copied blindly to its owner (1 + 2); updated (2); copied back
  // blindly (1 + 2); read by g2p (1).
  const double passes = (2 + (1 + 2) + 2 + (1 + 2) + 1) * (split(w) ? 2.0 : 1.0);
  const double flops = 3 + 1 + 3;  // v = p / m, gravity
  return {"nodes", w.nodes_per_particle * passes * node_bytes, w.nodes_per_particle * flops};
}

WorkTerm cell_means(const WorkCase& w) {
  if (!w.shares_dilation) return {"cell means", 0.0, 0.0};
  // The pressures' pass reads V, J, the cell and stored normal stresses; the dilations' x, V and the cell. A cell's sums, one node's size: set
  // (2), added to (2), divided (2), read by p2g (1); added to (2), divided (2), read by the stress update (1).
  const double s = width(w);
  const double bytes = ((w.stores_stress ? 3 : 0) + 1 + 1) * pass + cell + (3 + 1) * pass + cell + w.nodes_per_particle * 12 * node_bytes;
  // Mean stress and three rounded terms; the slopes, and the sum over the stencil, factored by axis; L and J in the stress update.
  const double trace = (s * s * (2 * s) + s * (2 * s) + 2 * s) * lanes;
  const double flops = (3 + 2 + 3 * 2 + 3) + weight_flops(w) + (bspline(w) ? derivative_flops(w) : 3.0 * s * 3) + trace + 6 + 2 * 7 + 3;
  return {"cell means", bytes, flops};
}

}  // namespace

std::vector<WorkTerm> count_work(const WorkCase& w) {
  return {p2g_particles(w), p2g_coefficients(w), p2g_nodes(w), g2p_nodes(w), g2p_particles(w), stress(w),
          cell_means(w),    locate(w),           sort(w),      nodes(w)};
}

}  // namespace bulkley
