#include "kernel/g2p.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <type_traits>

#include "bulkley/base/error.hpp"
#include "kernel/batch.hpp"

namespace bulkley {

namespace {

// Per particle: weights, and sums over the stencil. Column c of `moment` is sum w v (node - 1)_c, taken about node 1 of the
// stencil; column c of `gradient` is sum dw/dxi_c v.
template <SplineOrder order>
struct Batch {
  static constexpr int s = stencil_width(order);
  Pack distance[3][batch_size / n_lanes];  // of the particle above its base node, in cells
  alignas(64) double w[3][s][batch_size];
  alignas(64) double d[3][s][batch_size];  // dw/dxi
  alignas(64) Quad velocity[batch_size];
  alignas(64) Quad moment[batch_size][3];
  alignas(64) Quad gradient[batch_size][3];
  alignas(64) Quad change[batch_size];
};

// Node k's share of a sum of t, and of one of (k - 1) t. The first share sets the sum.
inline void add_share(Quad& sum, int k, Quad t) { sum = k == 0 ? t : sum + t; }
inline void add_moment(Quad& sum, int k, Quad t) {
  if (k == 0) sum = -t;
  if (k == 2) sum += t;
  if (k == 3) sum += t + t;
}

template <SplineOrder order, bool gradients>
void prepare(const CellFrame& frame, const FieldColumns<3>& position, LocalIndex p, int b, Batch<order>& batch) {
  constexpr int s = stencil_width(order);
#pragma GCC unroll 3
  for (int a = 0; a < 3; ++a) {
    const Pack fx = frame.offset_in_stencil(a, position(p, a));
    batch.distance[a][b / n_lanes] = fx;
    Pack w[s];
    spline_weights<order>(fx, w);
    for (int k = 0; k < s; ++k) store(&batch.w[a][k][b], w[k]);
    if constexpr (gradients) {
      Pack d[s];
      spline_derivatives<order>(fx, d);
      for (int k = 0; k < s; ++k) store(&batch.d[a][k][b], d[k]);
    }
  }
}

// The three nested sums are factored by direction: z, then y, then x.
template <SplineOrder order, bool moments, bool gradients, bool changes>
void gather(const LocalIndex* row_offsets, const Node* velocity, std::ptrdiff_t change_offset, LocalIndex cell, int b,
            Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  const StencilRows<order, const Node> rows(row_offsets, cell, velocity);
  Quad v{}, m[3] = {}, g[3] = {}, h{};
#pragma GCC unroll 4
  for (int i = 0; i < s; ++i) {
    Quad vy{}, my{}, mz{}, gy{}, gz{}, hy{};
#pragma GCC unroll 4
    for (int j = 0; j < s; ++j) {
      const Node* const row = rows(i, j);
      Quad vz{}, slope{}, derivative{}, hz{};
#pragma GCC unroll 4
      for (int k = 0; k < s; ++k) {
        const double w = batch.w[2][k][b];
        const Quad node = load_quad(row[k]);
        const Quad t = w * node;
        add_share(vz, k, t);
        if constexpr (moments) add_moment(slope, k, t);
        if constexpr (gradients) add_share(derivative, k, batch.d[2][k][b] * node);
        if constexpr (changes) add_share(hz, k, w * load_quad(shifted(row, change_offset)[k]));
      }
      const double w = batch.w[1][j][b];
      const Quad t = w * vz;
      add_share(vy, j, t);
      if constexpr (moments) {
        add_moment(my, j, t);
        add_share(mz, j, w * slope);
      }
      if constexpr (gradients) {
        add_share(gy, j, batch.d[1][j][b] * vz);
        add_share(gz, j, w * derivative);
      }
      if constexpr (changes) add_share(hy, j, w * hz);
    }
    const double w = batch.w[0][i][b];
    const Quad t = w * vy;
    add_share(v, i, t);
    if constexpr (moments) {
      add_moment(m[0], i, t);
      add_share(m[1], i, w * my);
      add_share(m[2], i, w * mz);
    }
    if constexpr (gradients) {
      add_share(g[0], i, batch.d[0][i][b] * vy);
      add_share(g[1], i, w * gy);
      add_share(g[2], i, w * gz);
    }
    if constexpr (changes) add_share(h, i, w * hy);
  }
  batch.velocity[b] = v;
  for (int c = 0; c < 3; ++c) {
    if constexpr (moments) batch.moment[b][c] = m[c];
    if constexpr (gradients) batch.gradient[b][c] = g[c];
  }
  if constexpr (changes) batch.change[b] = h;
}

template <int size>
Pack squares(const Pack (&values)[size]) {
  Pack sum = values[0] * values[0];
  for (int c = 1; c < size; ++c) sum += values[c] * values[c];
  return sum;
}

struct Arguments {
  CellFrame frame;
  double cell_size;
  TransferSettings transfer;
  const LocalIndex* row_offsets;
  const LocalIndex* cell;
  double dt;
  const Node* velocity;
  std::ptrdiff_t change_offset;  // from `velocity`, see offset_between
};

// What the nodes give to n_lanes particles, from the sums of the batch: v, C_p and L_p (row-major).
struct Motion {
  Pack velocity[3];
  Pack affine[9];
  Pack gradient[9];
};

template <bool moments, bool gradients, SplineOrder order>
Motion motion_of(const Arguments& arg, int b, const Batch<order>& batch) {
  const double inverse_dx = arg.frame.inverse_cell_size;
  Motion motion;
  load_rows(&batch.velocity[b], 1, motion.velocity);
#pragma GCC unroll 3
  for (int c = 0; c < 3; ++c) {
    Pack column[3];
    if constexpr (moments) {
      load_rows(&batch.moment[b][c], 3, column);
      const Pack distance = batch.distance[c][b / n_lanes] - 1.0;  // above node 1
      for (int r = 0; r < 3; ++r)
        motion.affine[3 * r + c] = (column[r] - distance * motion.velocity[r]) * (inverse_second_moment(order) * inverse_dx);
    }
    if constexpr (gradients) {
      load_rows(&batch.gradient[b][c], 3, column);
      for (int r = 0; r < 3; ++r) motion.gradient[3 * r + c] = column[r] * inverse_dx;
    }
  }
  if constexpr (!gradients)
    for (int c = 0; c < 9; ++c) motion.gradient[c] = motion.affine[c];
  if constexpr (moments) {
    const double zeta = arg.transfer.affine() ? arg.transfer.affine_damping : 0.0;
    if (zeta > 0.0) {
      const Motion whole = motion;
      for (int r = 0; r < 3; ++r)
        for (int c = 0; c < 3; ++c)
          motion.affine[3 * r + c] =
              (1.0 - zeta) * whole.affine[3 * r + c] + (0.5 * zeta) * (whole.affine[3 * r + c] - whole.affine[3 * c + r]);
    }
  }
  return motion;
}

// Calls `visit(first particle, place in batch, lanes, batch)` for all packs of the block, after their sums are gathered.
template <SplineOrder order, bool moments, bool gradients, bool changes, class Visit>
[[gnu::flatten]] void for_each_pack(const Arguments& arguments, const ParticleSet& set, ParticleBlock block, Visit visit) {
  const Arguments arg = arguments;  // its own copy, which no store can be suspected to change
  Batch<order> batch;
  const FieldColumns<3> position(set, Field::position);
  const LocalIndex end = std::min(block.end, set.size());
  for (LocalIndex first = block.begin; first < end; first += batch_size) {
    const int size = static_cast<int>(std::min<LocalIndex>(batch_size, end - first));
    position.prefetch(first + prefetch_distance);
    for (int b = 0; b < size; b += n_lanes) prepare<order, gradients>(arg.frame, position, first + b, b, batch);
    for (int b = 0; b < size; ++b)
      gather<order, moments, gradients, changes>(arg.row_offsets, arg.velocity, arg.change_offset, arg.cell[first + b], b,
                                                 batch);
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

// Columns that g2p reads and writes, and the largest values it meets.
template <SplineOrder order, bool moments, bool gradients, bool changes>
class Update {
 public:
  Update(const Arguments& arg, ParticleSet& set)
      : arg_(arg),
        id_(set.id()),
        mass_(set, Field::mass),
        position_(set, Field::position),
        velocity_(set, Field::velocity),
        affine_velocity_(set, Field::affine_velocity) {
    if (set.has(Field::velocity_gradient)) velocity_gradient_.emplace(set, Field::velocity_gradient);
  }

  void operator()(LocalIndex p, int b, int n, const Batch<order>& batch) {
    mass_.prefetch(p + prefetch_distance);
    velocity_.prefetch(p + prefetch_distance);
    if constexpr (moments) affine_velocity_.prefetch(p + prefetch_distance);
    Motion motion = motion_of<moments, gradients>(arg_, b, batch);
    const double fraction = arg_.transfer.flip_fraction();
    Pack change[3];
    if constexpr (changes) load_rows(&batch.change[b], 1, change);
    for (int r = 0; r < 3; ++r) {
      Pack& v = motion.velocity[r];
      position_.store(p, position_(p, r) + arg_.dt * v, r);
      if constexpr (changes) v = (1.0 - fraction) * v + fraction * (velocity_(p, r) + change[r]);
      velocity_.store(p, v, r);
    }
    if constexpr (moments)
      for (int c = 0; c < 9; ++c) affine_velocity_.store(p, motion.affine[c], c);
    if (velocity_gradient_)
      for (int c = 0; c < 9; ++c) velocity_gradient_->store(p, motion.gradient[c], c);

    const Pack speed_squared = squares(motion.velocity);
    Pack reach = square_root(speed_squared);
    if constexpr (moments)
      if (arg_.transfer.affine()) reach += square_root(squares(motion.affine)) * (moment_sum_ratio(order) * arg_.cell_size);
    include_lanes(speed_, speed_squared, id_ + p, n);
    include_lanes(velocity_gradient_extreme_, squares(motion.gradient), id_ + p, n);
    // Lanes past the end hold no particle and no mass.
    mass_max_ = maximum(mass_max_, mass_(p));
    momentum_max_ = maximum(momentum_max_, mass_(p) * reach);
  }

  void merge_into(StepBounds& bounds) const {
    bounds.motion.speed.merge(speed_);
    bounds.motion.velocity_gradient.merge(velocity_gradient_extreme_);
    for (int lane = 0; lane < n_lanes; ++lane) {
      bounds.sums.mass.include(mass_max_[lane]);
      bounds.sums.momentum.include(momentum_max_[lane]);
    }
  }

 private:
  const Arguments& arg_;
  const GlobalIndex* id_;
  FieldColumns<1> mass_;
  MutableColumns<3> position_, velocity_;
  MutableColumns<9> affine_velocity_;
  std::optional<MutableColumns<9>> velocity_gradient_;
  Extreme speed_, velocity_gradient_extreme_;
  Pack mass_max_{}, momentum_max_{};
};

template <SplineOrder order, bool moments, bool gradients, bool changes>
[[gnu::flatten]] void update_all(const Arguments& arg, ParticleSet& particles, ParticleBlock block, StepBounds& bounds) {
  Update<order, moments, gradients, changes> update(arg, particles);
  for_each_pack<order, moments, gradients, changes>(
      arg, particles, block, [&](LocalIndex p, int b, int n, const auto& batch) { update(p, b, n, batch); });
  update.merge_into(bounds);
}

}  // namespace

void g2p(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map, double dt,
         const Node* velocity, const Node* change, ParticleSet& particles, StepBounds& bounds, ParticleBlock block) {
  BULKLEY_ASSERT(transfer.needs_velocity_gradient() == particles.has(Field::velocity_gradient));
  const bool changes = transfer.flip_fraction() > 0.0;
  const Arguments arg{CellFrame(grid), grid.cell_size,
                      transfer,        layout.row_offsets().data(),
                      map.cell.data(), dt,
                      velocity,        changes ? offset_between(velocity, change) : 0};
  with_sums(grid, transfer, [&](auto order, auto moments, auto gradients) {
    changes ? update_all<order(), moments(), gradients(), true>(arg, particles, block, bounds)
            : update_all<order(), moments(), gradients(), false>(arg, particles, block, bounds);
  });
}

void measure_motion(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map,
                    const Node* velocity, const ParticleSet& particles, StepBounds& bounds) {
  const Arguments arg{
      CellFrame(grid), grid.cell_size, transfer, layout.row_offsets().data(), map.cell.data(), 0.0, velocity, 0};
  const GlobalIndex* id = particles.id();
  with_sums(grid, transfer, [&](auto order, auto moments, auto gradients) {
    const auto visit = [&](LocalIndex p, int b, int n, const auto& batch) {
      const Motion motion = motion_of<moments(), gradients()>(arg, b, batch);
      const Pack gradient_squared = squares(motion.gradient);
      include_lanes(bounds.motion.speed, squares(motion.velocity), id + p, n);
      include_lanes(bounds.motion.velocity_gradient, gradient_squared, id + p, n);
      if (!any(gradient_squared - gradient_squared != broadcast<Pack>(0.0))) return;  // neither infinite nor NaN
      for (int lane = 0; lane < n; ++lane)
        if (!std::isfinite(gradient_squared[lane])) {
          ++bounds.failures.n_not_finite;
          bounds.failures.failed_id.include(id[p + lane]);
        }
    };
    for_each_pack<order(), moments(), gradients(), false>(arg, particles, {}, visit);
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
    include_lanes(bounds.motion.speed, speed_squared, id, n);
    include_lanes(bounds.motion.velocity_gradient, affine_squared, id, n);
    for (int lane = 0; lane < n; ++lane) {
      bounds.sums.mass.include(mass[lane]);
      bounds.sums.momentum.include(mass[lane] * reach[lane]);
    }
  }
}

}  // namespace bulkley
