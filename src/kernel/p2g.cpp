#include "bulkley/kernel/p2g.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "batch.hpp"
#include "bulkley/base/tensor.hpp"

namespace bulkley {

namespace {

// What one particle gives to the nodes: w (q + i a_x + j a_y + k a_z) to node (i, j, k) of its stencil, plus, for the
// B-spline form of the force, the gradient of w contracted with the columns of F.
template <int n_columns>
struct Columns {
  alignas(64) double c[4 * n_columns][batch_size];

  Quad quad(int column, int p) const {
    return Quad{c[4 * column][p], c[4 * column + 1][p], c[4 * column + 2][p], c[4 * column + 3][p]};
  }
  void set(int column, int row, int p, Pack value) { store(&c[4 * column + row][p], value); }
};

template <SplineOrder order>
struct Batch {
  static constexpr int s = stencil_width(order);
  alignas(64) double w[3][s][batch_size];
  alignas(64) double d[3][s][batch_size];  // derivatives, B-spline form only
  Columns<4> linear;                       // q, a_x, a_y, a_z of mass and momentum (and of the impulse, unless split)
  Columns<4> impulse;                      // MLS, split: q, a_x, a_y, a_z; B-spline: F_x, F_y, F_z
};

inline void add_rounded(Node& node, Quad contribution, Quad constant) {
  const Quad sum = load_quad(node) + rounded(contribution, constant);
  std::memcpy(node.c, &sum, sizeof sum);
}

struct Arguments {
  const GridGeometry& grid;
  const TransferSettings& transfer;
  const PoolLayout& layout;
  const ParticleSet& particles;
  const CellMap& map;
  double dt;
  Quad pool_constant;
  Quad impulse_constant;
  Node* pool;
  Node* impulse;
};

// Weights and the linear forms of n_lanes particles, first particle `p`, at place `b` of the batch.
template <SplineOrder order, GradientForm form, bool split>
void prepare(const Arguments& arg, LocalIndex p, int b, Batch<order>& batch) {
  const ParticleSet& set = arg.particles;
  const double dx = arg.grid.cell_size;
  constexpr int s = stencil_width(order);
  Pack fx[3];
  for (int a = 0; a < 3; ++a) {
    fx[a] = offset_in_stencil(arg.grid, a, load(set.real(Field::position, a) + p));
    Pack w[s];
    spline_weights<order>(fx[a], w);
    for (int k = 0; k < s; ++k) store(&batch.w[a][k][b], w[k]);
    if constexpr (form == GradientForm::bspline) {
      Pack d[s];
      spline_derivatives<order>(fx[a], d);
      for (int k = 0; k < s; ++k) store(&batch.d[a][k][b], d[k]);
    }
  }
  const Pack mass = load(set.real(Field::mass) + p);
  const Pack volume = load(set.real(Field::reference_volume) + p);
  SymTensor<Pack> stress;
  for (int c = 0; c < 6; ++c) stress.c[c] = load(set.real(Field::kirchhoff_stress, c) + p);

  // Per cell: dx m C and, for the MLS form, -dt V tau D_p^-1 dx.
  const bool affine = arg.transfer.affine();
  const Pack force = volume * (-arg.dt * inverse_second_moment(order) / dx);
  for (int r = 0; r < 3; ++r) {
    Pack q = mass * load(set.real(Field::velocity, r) + p);
    Pack impulse = broadcast<Pack>(0.0);
    for (int c = 0; c < 3; ++c) {
      Pack a = affine ? mass * dx * load(set.real(Field::affine_velocity, 3 * r + c) + p) : broadcast<Pack>(0.0);
      if constexpr (form == GradientForm::mls) {
        const Pack f = force * stress(r, c);
        if constexpr (split) {
          impulse -= f * fx[c];
          batch.impulse.set(1 + c, r, b, f);
        } else {
          a += f;
        }
      } else {
        batch.impulse.set(c, r, b, volume * (-arg.dt / dx) * stress(r, c));
      }
      q -= a * fx[c];
      batch.linear.set(1 + c, r, b, a);
    }
    batch.linear.set(0, r, b, q);
    if constexpr (form == GradientForm::mls && split) batch.impulse.set(0, r, b, impulse);
  }
  const Pack zero = broadcast<Pack>(0.0);
  batch.linear.set(0, 3, b, mass);
  for (int c = 1; c < 4; ++c) batch.linear.set(c, 3, b, zero);
  for (int c = 0; c < 4; ++c) batch.impulse.set(c, 3, b, zero);
}

template <SplineOrder order, GradientForm form, bool split>
void scatter(const Arguments& arg, LocalIndex cell, int b, const Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  const StencilRows<order> rows(arg.layout.row_offsets().data(), cell);
  const Quad ax = batch.linear.quad(1, b), ay = batch.linear.quad(2, b), az = batch.linear.quad(3, b);
  Quad qi = batch.linear.quad(0, b);
  Quad fi{}, fx{}, fy{}, fz{};
  if constexpr (form == GradientForm::bspline) {
    fx = batch.impulse.quad(0, b), fy = batch.impulse.quad(1, b), fz = batch.impulse.quad(2, b);
  } else if constexpr (split) {
    fi = batch.impulse.quad(0, b), fx = batch.impulse.quad(1, b), fy = batch.impulse.quad(2, b),
    fz = batch.impulse.quad(3, b);
  }
#pragma GCC unroll 4
  for (int i = 0; i < s; ++i) {
    Quad qj = qi, fj = fi;
#pragma GCC unroll 4
    for (int j = 0; j < s; ++j) {
      const LocalIndex row = rows(i, j);
      const double wij = batch.w[0][i][b] * batch.w[1][j][b];
      Quad qk = qj, fk = fj;
      Quad across{};  // the part of grad w . F that shares w_z
      double along = 0.0;
      if constexpr (form == GradientForm::bspline) {
        across = (batch.d[0][i][b] * batch.w[1][j][b]) * fx + (batch.w[0][i][b] * batch.d[1][j][b]) * fy;
        along = wij;
      }
#pragma GCC unroll 4
      for (int k = 0; k < s; ++k) {
        const double wz = batch.w[2][k][b];
        Quad contribution = (wij * wz) * qk;
        if constexpr (form == GradientForm::bspline) {
          const Quad impulse = wz * across + (along * batch.d[2][k][b]) * fz;
          if constexpr (split)
            add_rounded(arg.impulse[row + k], impulse, arg.impulse_constant);
          else
            contribution += impulse;
        } else if constexpr (split) {
          add_rounded(arg.impulse[row + k], (wij * wz) * fk, arg.impulse_constant);
          fk += fz;
        }
        add_rounded(arg.pool[row + k], contribution, arg.pool_constant);
        qk += az;
      }
      qj += ay;
      fj += fy;
    }
    qi += ax;
    fi += fx;
  }
}

template <SplineOrder order, GradientForm form, bool split>
void run(const Arguments& arg) {
  Batch<order> batch;
  const LocalIndex n = arg.particles.size();
  for (LocalIndex first = 0; first < n; first += batch_size) {
    const int size = static_cast<int>(std::min<LocalIndex>(batch_size, n - first));
    for (int b = 0; b < size; b += n_lanes) prepare<order, form, split>(arg, first + b, b, batch);
    for (int b = 0; b < size; ++b) scatter<order, form, split>(arg, arg.map.cell[first + b], b, batch);
  }
}

}  // namespace

SumBounds sum_bounds(const GridGeometry& grid, const TransferSettings& transfer, const StepBounds& bounds, double dt) {
  const SplineOrder order = grid.order;
  const double slack = 1.0 + 1e-9;  // for the roundings in forming the contributions
  const double weights = slack * weight_sum_bound(order) * static_cast<double>(std::max<GlobalIndex>(bounds.cell_count, 1));
  const double ratio = transfer.gradient == GradientForm::mls ? inverse_second_moment(order) * moment_sum_ratio(order)
                                                              : gradient_sum_ratio(order);
  const double impulse = dt * bounds.stress_volume * ratio / grid.cell_size;
  const double momentum = bounds.momentum + (transfer.flip_fraction() > 0.0 ? 0.0 : impulse);
  return {weights * bounds.mass, weights * momentum, weights * impulse};
}

void p2g(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const ParticleSet& particles,
         const CellMap& map, const SumBounds& sums, double dt, Node* pool, Node* impulse) {
  const bool split = transfer.flip_fraction() > 0.0;
  BULKLEY_ASSERT(split == (impulse != nullptr) || particles.size() == 0);
  const double m = rounding_constant(sums.mass), q = rounding_constant(sums.momentum), f = rounding_constant(sums.impulse);
  const Arguments arg{grid, transfer, layout, particles, map, dt, Quad{q, q, q, m}, Quad{f, f, f, m}, pool, impulse};
  std::fill_n(pool, layout.n_nodes(), Node{});
  if (split) std::fill_n(impulse, layout.n_nodes(), Node{});
  with_order(grid.order, [&](auto order) {
    if (transfer.gradient == GradientForm::mls)
      split ? run<order(), GradientForm::mls, true>(arg) : run<order(), GradientForm::mls, false>(arg);
    else
      split ? run<order(), GradientForm::bspline, true>(arg) : run<order(), GradientForm::bspline, false>(arg);
  });
}

}  // namespace bulkley
