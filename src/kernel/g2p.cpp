#include "bulkley/kernel/g2p.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "batch.hpp"
#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

// Sums over the stencil: sum w v, and per axis b sum w v (xi_i - xi_p)_b and sum dw/dxi_b v (rows r of column b at 3 r + b).
template <SplineOrder order>
struct Batch {
  static constexpr int s = stencil_width(order);
  alignas(64) double w[3][s][batch_size];
  alignas(64) double slope[3][s][batch_size];  // w (node - fx), or dw/dxi, or both in turn
  alignas(64) double d[3][s][batch_size];
  alignas(64) double velocity[3][batch_size];
  alignas(64) double moment[9][batch_size];
  alignas(64) double gradient[9][batch_size];
  alignas(64) double change[3][batch_size];
};

inline void store_rows(double (&to)[3][batch_size], int b, Quad q) {
  for (int r = 0; r < 3; ++r) to[r][b] = q[r];
}
inline void store_column(double (&to)[9][batch_size], int column, int b, Quad q) {
  for (int r = 0; r < 3; ++r) to[3 * r + column][b] = q[r];
}

template <SplineOrder order, bool moments, bool gradients>
void prepare(const GridGeometry& grid, const ParticleSet& set, LocalIndex p, int b, Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  for (int a = 0; a < 3; ++a) {
    const Pack fx = offset_in_stencil(grid, a, load(set.real(Field::position, a) + p));
    Pack w[s];
    spline_weights<order>(fx, w);
    for (int k = 0; k < s; ++k) {
      store(&batch.w[a][k][b], w[k]);
      if constexpr (moments) store(&batch.slope[a][k][b], w[k] * (static_cast<double>(k) - fx));
    }
    if constexpr (gradients) {
      Pack d[s];
      spline_derivatives<order>(fx, d);
      for (int k = 0; k < s; ++k) store(&batch.d[a][k][b], d[k]);
    }
  }
}

// The three nested sums are factored by direction: z, then y, then x.
template <SplineOrder order, bool moments, bool gradients>
void gather(const LocalIndex* row_offsets, const Node* nodes, LocalIndex cell, int b, Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  const StencilRows<order> rows(row_offsets, cell);
  Quad v{}, m[3] = {}, g[3] = {};
#pragma GCC unroll 4
  for (int i = 0; i < s; ++i) {
    Quad vy{}, my{}, mz{}, gy{}, gz{};
#pragma GCC unroll 4
    for (int j = 0; j < s; ++j) {
      const Node* row = nodes + rows(i, j);
      Quad sum{}, slope{}, derivative{};
#pragma GCC unroll 4
      for (int k = 0; k < s; ++k) {
        const Quad node = load_quad(row[k]);
        sum += batch.w[2][k][b] * node;
        if constexpr (moments) slope += batch.slope[2][k][b] * node;
        if constexpr (gradients) derivative += batch.d[2][k][b] * node;
      }
      const double wy = batch.w[1][j][b];
      vy += wy * sum;
      if constexpr (moments) {
        my += batch.slope[1][j][b] * sum;
        mz += wy * slope;
      }
      if constexpr (gradients) {
        gy += batch.d[1][j][b] * sum;
        gz += wy * derivative;
      }
    }
    const double wx = batch.w[0][i][b];
    v += wx * vy;
    if constexpr (moments) {
      m[0] += batch.slope[0][i][b] * vy;
      m[1] += wx * my;
      m[2] += wx * mz;
    }
    if constexpr (gradients) {
      g[0] += batch.d[0][i][b] * vy;
      g[1] += wx * gy;
      g[2] += wx * gz;
    }
  }
  store_rows(batch.velocity, b, v);
  for (int c = 0; c < 3; ++c) {
    if constexpr (moments) store_column(batch.moment, c, b, m[c]);
    if constexpr (gradients) store_column(batch.gradient, c, b, g[c]);
  }
}

template <SplineOrder order>
void gather_change(const LocalIndex* row_offsets, const Node* nodes, LocalIndex cell, int b, Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  const StencilRows<order> rows(row_offsets, cell);
  Quad v{};
  for (int i = 0; i < s; ++i)
    for (int j = 0; j < s; ++j) {
      const double wij = batch.w[0][i][b] * batch.w[1][j][b];
      for (int k = 0; k < s; ++k) v += (wij * batch.w[2][k][b]) * load_quad(nodes[rows(i, j) + k]);
    }
  store_rows(batch.change, b, v);
}

// Largest value of a pack, remembered with the particle's id. Only the `n` first lanes count.
void include_lanes(Extreme& extreme, Pack squared, const GlobalIndex* id, int n) {
  const double level = extreme.value * extreme.value * (1.0 - 1e-15);  // lets ties through: the smallest id must win them
  if (!any(squared >= level)) return;
  for (int lane = 0; lane < n; ++lane) extreme.include(std::sqrt(squared[lane]), id[lane]);
}

double largest_lane(Pack values, int n) {
  double result = 0.0;
  for (int lane = 0; lane < n; ++lane) result = std::max(result, values[lane]);
  return result;
}

template <int size>
Pack squares(const Pack (&values)[size]) {
  Pack sum = values[0] * values[0];
  for (int c = 1; c < size; ++c) sum += values[c] * values[c];
  return sum;
}

struct Arguments {
  const GridGeometry& grid;
  const TransferSettings& transfer;
  const PoolLayout& layout;
  const CellMap& map;
  double dt;
  const Node* velocity;
  const Node* change;
};

// L_p and C_p of n_lanes particles, from the sums of the batch.
template <bool moments, bool gradients, SplineOrder order>
void velocity_gradients(const Arguments& arg, int b, const Batch<order>& batch, Pack (&affine)[9], Pack (&gradient)[9]) {
  const double inverse_dx = arg.grid.inverse_cell_size();
  if constexpr (moments)
    for (int c = 0; c < 9; ++c) affine[c] = load(&batch.moment[c][b]) * (inverse_second_moment(order) * inverse_dx);
  for (int c = 0; c < 9; ++c) {
    if constexpr (gradients)
      gradient[c] = load(&batch.gradient[c][b]) * inverse_dx;
    else
      gradient[c] = affine[c];
  }
  const double zeta = arg.transfer.affine() ? arg.transfer.affine_damping : 0.0;
  if constexpr (moments)
    if (zeta > 0.0) {
      Pack damped[9];
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
          damped[3 * r + c] = (1.0 - zeta) * affine[3 * r + c] + (0.5 * zeta) * (affine[3 * r + c] - affine[3 * c + r]);
      for (int c = 0; c < 9; ++c) affine[c] = damped[c];
    }
}

template <SplineOrder order, bool moments, bool gradients>
void update(const Arguments& arg, LocalIndex p, int b, int n, const Batch<order>& batch, ParticleSet& set,
            StepBounds& bounds) {
  const double fraction = arg.transfer.flip_fraction();
  const GlobalIndex* id = set.id() + p;
  Pack v[3], affine[9], gradient[9];
  velocity_gradients<moments, gradients>(arg, b, batch, affine, gradient);
  for (int r = 0; r < 3; ++r) {
    const Pack pic = load(&batch.velocity[r][b]);
    double* x = set.real(Field::position, r) + p;
    double* velocity = set.real(Field::velocity, r) + p;
    store(x, load(x) + arg.dt * pic);
    v[r] = pic;
    if (fraction > 0.0) v[r] = (1.0 - fraction) * pic + fraction * (load(velocity) + load(&batch.change[r][b]));
    store(velocity, v[r]);
  }
  if constexpr (moments)
    for (int c = 0; c < 9; ++c) store(set.real(Field::affine_velocity, c) + p, affine[c]);
  if (set.has(Field::velocity_gradient))
    for (int c = 0; c < 9; ++c) store(set.real(Field::velocity_gradient, c) + p, gradient[c]);

  const Pack speed_squared = squares(v);
  Pack reach = square_root(speed_squared);
  if (arg.transfer.affine()) {
    if constexpr (moments) reach += square_root(squares(affine)) * (moment_sum_ratio(order) * arg.grid.cell_size);
  }
  const Pack mass = load(set.real(Field::mass) + p);
  include_lanes(bounds.speed, speed_squared, id, n);
  include_lanes(bounds.velocity_gradient, squares(gradient), id, n);
  bounds.mass = std::max(bounds.mass, largest_lane(mass, n));
  bounds.momentum = std::max(bounds.momentum, largest_lane(mass * reach, n));
}

// Runs `visit(first particle, place in batch, lanes, batch)` over all packs, after their sums are gathered.
template <SplineOrder order, bool moments, bool gradients, class Visit>
void for_each_pack(const Arguments& arg, const ParticleSet& set, Visit visit) {
  Batch<order> batch;
  const LocalIndex* row_offsets = arg.layout.row_offsets().data();
  const LocalIndex n = set.size();
  for (LocalIndex first = 0; first < n; first += batch_size) {
    const int size = static_cast<int>(std::min<LocalIndex>(batch_size, n - first));
    for (int b = 0; b < size; b += n_lanes) prepare<order, moments, gradients>(arg.grid, set, first + b, b, batch);
    for (int b = 0; b < size; ++b)
      gather<order, moments, gradients>(row_offsets, arg.velocity, arg.map.cell[first + b], b, batch);
    if (arg.change)
      for (int b = 0; b < size; ++b) gather_change<order>(row_offsets, arg.change, arg.map.cell[first + b], b, batch);
    for (int b = 0; b < size; b += n_lanes) visit(first + b, b, std::min(n_lanes, size - b), batch);
  }
}

// Calls `function(order, moments, gradients)` with compile-time constants for what the transfer needs.
template <class Function>
void with_sums(const GridGeometry& grid, const TransferSettings& transfer, Function function) {
  with_order(grid.order, [&](auto order) {
    if (transfer.gradient == GradientForm::mls)
      function(order, std::true_type{}, std::false_type{});
    else if (transfer.affine())
      function(order, std::true_type{}, std::true_type{});
    else
      function(order, std::false_type{}, std::true_type{});
  });
}

}  // namespace

void g2p(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map, double dt,
         const Node* velocity, const Node* change, ParticleSet& particles, StepBounds& bounds) {
  BULKLEY_ASSERT(transfer.needs_velocity_gradient() == particles.has(Field::velocity_gradient));
  const Arguments arg{grid, transfer, layout, map, dt, velocity, transfer.flip_fraction() > 0.0 ? change : nullptr};
  with_sums(grid, transfer, [&](auto order, auto moments, auto gradients) {
    for_each_pack<order(), moments(), gradients()>(arg, particles, [&](LocalIndex p, int b, int n, const auto& batch) {
      update<order(), moments(), gradients()>(arg, p, b, n, batch, particles, bounds);
    });
  });
}

void measure_motion(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map,
                    const Node* velocity, const ParticleSet& particles, StepBounds& bounds) {
  const Arguments arg{grid, transfer, layout, map, 0.0, velocity, nullptr};
  const GlobalIndex* id = particles.id();
  with_sums(grid, transfer, [&](auto order, auto moments, auto gradients) {
    for_each_pack<order(), moments(), gradients()>(arg, particles, [&](LocalIndex p, int b, int n, const auto& batch) {
      Pack v[3], affine[9], gradient[9];
      velocity_gradients<moments(), gradients()>(arg, b, batch, affine, gradient);
      for (int r = 0; r < 3; ++r) v[r] = load(&batch.velocity[r][b]);
      const Pack gradient_squared = squares(gradient);
      include_lanes(bounds.speed, squares(v), id + p, n);
      include_lanes(bounds.velocity_gradient, gradient_squared, id + p, n);
      for (int lane = 0; lane < n; ++lane)
        if (!std::isfinite(gradient_squared[lane])) {
          ++bounds.n_not_finite;
          bounds.failed_id = std::min(bounds.failed_id, id[p + lane]);
        }
    });
  });
}

void measure_particles(const GridGeometry& grid, const TransferSettings& transfer, const ParticleSet& particles,
                       StepBounds& bounds) {
  const LocalIndex count = particles.size();
  for (LocalIndex p = 0; p < count; p += n_lanes) {
    const int n = static_cast<int>(std::min<LocalIndex>(n_lanes, count - p));
    const GlobalIndex* id = particles.id() + p;
    Pack v[3], affine[9];
    for (int r = 0; r < 3; ++r) v[r] = load(particles.real(Field::velocity, r) + p);
    for (int c = 0; c < 9; ++c) affine[c] = load(particles.real(Field::affine_velocity, c) + p);
    const Pack speed_squared = squares(v), affine_squared = squares(affine);
    Pack reach = square_root(speed_squared);
    if (transfer.affine()) reach += square_root(affine_squared) * (moment_sum_ratio(grid.order) * grid.cell_size);
    const Pack mass = load(particles.real(Field::mass) + p);
    include_lanes(bounds.speed, speed_squared, id, n);
    include_lanes(bounds.velocity_gradient, affine_squared, id, n);
    bounds.mass = std::max(bounds.mass, largest_lane(mass, n));
    bounds.momentum = std::max(bounds.momentum, largest_lane(mass * reach, n));
  }
}

}  // namespace bulkley
