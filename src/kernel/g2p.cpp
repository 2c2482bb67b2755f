#include "kernel/g2p.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <type_traits>

#include "bulkley/base/error.hpp"
#include "bulkley/base/tensor.hpp"
#include "kernel/batch.hpp"
#include "kernel/calm_tiles.hpp"

namespace bulkley {

namespace {

// What particles keep of their residual, the motion that the grid does not see.
enum class Kept { nothing, velocity, moments };
template <Kept kept>
using NodeOf = std::conditional_t<kept == Kept::nothing, Node, NodePair>;

// Per particle: weights, and sums over the stencil. Column c of `moment` is sum w v (node - 1)_c, taken about node 1 of the
// stencil; column c of `gradient` is sum dw/dxi_c v. Second quads: the same of the change of v.
template <SplineOrder order, class NodeType>
struct Batch {
  static constexpr int s = stencil_width(order);
  static constexpr int n_quads = quads_in<typename VectorOf<NodeType>::type>;
  Pack distance[3][batch_size / n_lanes];  // of the particle above its base node, in cells
  alignas(64) double w[3][s][batch_size];
  alignas(64) double d[3][s][batch_size];  // dw/dxi
  alignas(64) Quad velocity[batch_size][n_quads];
  alignas(64) Quad moment[batch_size][3][n_quads];
  alignas(64) Quad gradient[batch_size][3][n_quads];
};

// Node k's share of a sum of t, and of one of (k - 1) t. The first share sets the sum.
template <class Vector>
inline void add_share(Vector& sum, int k, Vector t) {
  sum = k == 0 ? t : sum + t;
}
template <class Vector>
inline void add_moment(Vector& sum, int k, Vector t) {
  if (k == 0) sum = -t;
  if (k == 2) sum += t;
  if (k == 3) sum += t + t;
}

template <bool gradients, SplineOrder order, class NodeType>
void prepare(const CellFrame& frame, const FieldColumns<3>& position, LocalIndex p, int b, Batch<order, NodeType>& batch) {
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

// Sums over a stencil, of nodes or of their quads from `first_quad` on, as many as a Vector holds. The three nested sums are
// factored by direction: z, then y, then x.
template <class Vector, int first_quad, bool moments, bool gradients, SplineOrder order, class NodeType>
void gather(const LocalIndex* row_offsets, const NodeType* nodes, LocalIndex cell, int b, Batch<order, NodeType>& batch) {
  constexpr int s = stencil_width(order);
  const StencilRows<order, const NodeType> rows(row_offsets, cell, nodes);
  Vector v{}, m[3] = {}, g[3] = {};
#pragma GCC unroll 4
  for (int i = 0; i < s; ++i) {
    Vector vy{}, my{}, mz{}, gy{}, gz{};
#pragma GCC unroll 4
    for (int j = 0; j < s; ++j) {
      const NodeType* const row = rows(i, j);
      Vector vz{}, slope{}, derivative{};
#pragma GCC unroll 4
      for (int k = 0; k < s; ++k) {
        const double w = batch.w[2][k][b];
        const Vector node = load_vector<Vector, first_quad>(row[k]);
        const Vector t = w * node;
        add_share(vz, k, t);
        if constexpr (moments) add_moment(slope, k, t);
        if constexpr (gradients) {
          const Vector u = batch.d[2][k][b] * node;
          add_share(derivative, k, u);
        }
      }
      const double w = batch.w[1][j][b];
      const Vector t = w * vz;
      add_share(vy, j, t);
      if constexpr (moments) {
        add_moment(my, j, t);
        const Vector u = w * slope;
        add_share(mz, j, u);
      }
      if constexpr (gradients) {
        const Vector u = batch.d[1][j][b] * vz, x = w * derivative;
        add_share(gy, j, u);
        add_share(gz, j, x);
      }
    }
    const double w = batch.w[0][i][b];
    const Vector t = w * vy;
    add_share(v, i, t);
    if constexpr (moments) {
      add_moment(m[0], i, t);
      const Vector u = w * my, x = w * mz;
      add_share(m[1], i, u);
      add_share(m[2], i, x);
    }
    if constexpr (gradients) {
      const Vector u = batch.d[0][i][b] * vy, x = w * gy, y = w * gz;
      add_share(g[0], i, u);
      add_share(g[1], i, x);
      add_share(g[2], i, y);
    }
  }
  store_vector<first_quad>(batch.velocity[b], v);
#pragma GCC unroll 3
  for (int c = 0; c < 3; ++c) {
    if constexpr (moments) store_vector<first_quad>(batch.moment[b][c], m[c]);
    if constexpr (gradients) store_vector<first_quad>(batch.gradient[b][c], g[c]);
  }
}

template <class NodeType>
struct Arguments {
  CellFrame frame;
  double cell_size;
  TransferSettings transfer;
  const LocalIndex* row_offsets;
  const LocalIndex* cell;
  double dt;
  double kept_share;  // of the residual
  const NodeType* nodes;
  double inertia = 0.0;  // of affine motion
  Gathered gathered = {};
};

// What the nodes give to n_lanes particles, from the sums of the batch: v, C_p and L_p (row-major).
struct Motion {
  Pack velocity[3];
  Pack affine[9];
  Pack gradient[9];
};

template <bool moments, bool gradients, SplineOrder order, class NodeType>
Motion motion_of(const Arguments<NodeType>& arg, int b, const Batch<order, NodeType>& batch) {
  constexpr int n_quads = Batch<order, NodeType>::n_quads;
  const double inverse_dx = arg.frame.inverse_cell_size;
  Motion motion;
  load_rows(&batch.velocity[b][0], n_quads, motion.velocity);
#pragma GCC unroll 3
  for (int c = 0; c < 3; ++c) {
    Pack column[3];
    if constexpr (moments) {
      load_rows(&batch.moment[b][c][0], 3 * n_quads, column);
      const Pack distance = batch.distance[c][b / n_lanes] - 1.0;  // above node 1
      for (int r = 0; r < 3; ++r)
        motion.affine[3 * r + c] = (column[r] - distance * motion.velocity[r]) * (inverse_second_moment(order) * inverse_dx);
    }
    if constexpr (gradients) {
      load_rows(&batch.gradient[b][c][0], 3 * n_quads, column);
      for (int r = 0; r < 3; ++r) motion.gradient[3 * r + c] = column[r] * inverse_dx;
    }
  }
  if constexpr (!gradients)
    for (int c = 0; c < 9; ++c) motion.gradient[c] = motion.affine[c];
  if constexpr (moments) {
    const double zeta = arg.transfer.scheme == TransferScheme::apic ? arg.transfer.affine_damping : 0.0;
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

// sym(L L) of a row-major matrix.
SymTensor<Pack> symmetric_square(const Pack (&l)[9]) {
  SymTensor<Pack> square{l[0] * l[0], l[4] * l[4], l[8] * l[8]};
#pragma GCC unroll 3
  for (int r = 0; r < 3; ++r) {
    const int c = (r + 1) % 3, k = (r + 2) % 3;
    const Pack product = l[3 * r + c] * l[3 * c + r];
    square.c[r] += product;
    square.c[c] += product;
    square.c[symmetric_index(r, c)] = 0.5 * ((l[3 * r + c] + l[3 * c + r]) * (l[4 * r] + l[4 * c]) +
                                             (l[3 * r + k] * l[3 * k + c] + l[3 * c + k] * l[3 * k + r]));
  }
  return square;
}

// The time t of (T9b). The motion leaves the residual dt Q, Q = sym(L0 L0), in a step, for the gradient of a moving field changes
// by -L L. t Q is what `residual` has of it, and no more; a particle whose field no other shares has no residual, and keeps its motion.
Pack time_of_drift(const Pack (&residual)[9], const SymTensor<Pack>& square, double dt) {
  Pack along = broadcast<Pack>(0.0);
#pragma GCC unroll 3
  for (int r = 0; r < 3; ++r) {
    const int c = (r + 1) % 3;
    along += residual[4 * r] * square.c[r] + (residual[3 * r + c] + residual[3 * c + r]) * square(r, c);
  }
  const Pack norm = broadcast<Pack>(std::numeric_limits<double>::min()) + norm_squared(square);
  return maximum(broadcast<Pack>(0.0), minimum(along / norm, broadcast<Pack>(dt)));
}

// The residuals of v_p and C_p that particles keep over the step, and what carries them with the flow (T9b). On entry `velocity`
// and `affine` are those of the particles, `motion` what the nodes give.
template <SplineOrder order>
void keep_residual(const Arguments<NodePair>& arg, int b, const Batch<order, NodePair>& batch, Pack (&velocity)[3],
                   Pack (&affine)[9], const Motion& motion) {
  const double inverse_dx = arg.frame.inverse_cell_size, inverse_moment = inverse_second_moment(order) * inverse_dx;
  const double share = arg.kept_share, dt = arg.dt;
  Pack change[3], q[3], before[9], residual[9];  // of velocity; q; L0; R
  load_rows(&batch.velocity[b][1], 2, change);
#pragma GCC unroll 3
  for (int r = 0; r < 3; ++r) {
    q[r] = velocity[r] - (motion.velocity[r] - change[r]);
    velocity[r] = motion.velocity[r] + share * q[r];
  }
#pragma GCC unroll 3
  for (int c = 0; c < 3; ++c) {
    Pack column[3];
    load_rows(&batch.moment[b][c][1], 6, column);
    const Pack distance = batch.distance[c][b / n_lanes] - 1.0;
#pragma GCC unroll 3
    for (int r = 0; r < 3; ++r) {
      before[3 * r + c] = motion.affine[3 * r + c] - (column[r] - distance * change[r]) * inverse_moment;
      residual[3 * r + c] = affine[3 * r + c] - before[3 * r + c];
    }
  }
  // Symmetric: taken off R it leaves the spin, and so angular momentum, as it is.
  const SymTensor<Pack> square = symmetric_square(before);
  const Pack drift = share * time_of_drift(residual, square, dt);
  const double inverse_d = inverse_moment * inverse_dx, half = 0.5 * dt * share;
  Pack spin[9];  // W0, off its diagonal
#pragma GCC unroll 3
  for (int r = 0; r < 3; ++r) {
    const int c = (r + 1) % 3;
    spin[3 * r + c] = 0.5 * (before[3 * r + c] - before[3 * c + r]);
    spin[3 * c + r] = -spin[3 * r + c];
  }
#pragma GCC unroll 3
  for (int r = 0; r < 3; ++r) {
    const int c = (r + 1) % 3, k = (r + 2) % 3;
    // R W0 on the diagonal, 2 sym(R W0) and 2 skew(R L0^T - q (S dv)^T / D) beside it
    const Pack along = residual[3 * r + c] * spin[3 * c + r] + residual[3 * r + k] * spin[3 * k + r];
    const Pack turned = (residual[4 * r] - residual[4 * c]) * spin[3 * r + c] + residual[3 * r + k] * spin[3 * k + c] +
                        residual[3 * c + k] * spin[3 * k + r];
    Pack torque = inverse_d * (q[c] * change[r] - q[r] * change[c]);
    for (int j = 0; j < 3; ++j) torque += residual[3 * r + j] * before[3 * c + j] - residual[3 * c + j] * before[3 * r + j];
    const Pack both = -(drift * square(r, c) + half * turned);
    affine[4 * r] = motion.affine[4 * r] + share * residual[4 * r] - (drift * square.c[r] + (dt * share) * along);
    affine[3 * r + c] = motion.affine[3 * r + c] + share * residual[3 * r + c] + (both + half * torque);
    affine[3 * c + r] = motion.affine[3 * c + r] + share * residual[3 * c + r] + (both - half * torque);
  }
}

struct All {
  bool operator()(LocalIndex, int) const { return true; }
};

// Calls `visit(first particle, place in batch, lanes, batch)` for all packs of the block, after their sums are gathered; not for
// batches that `wanted(first particle, particles)` leaves out.
template <SplineOrder order, bool moments, bool gradients, Kept kept, class NodeType, class Visit, class Wanted = All>
[[gnu::flatten]] void for_each_pack(const Arguments<NodeType>& arguments, const ParticleSet& set, ParticleBlock block,
                                    Visit visit, Wanted wanted = {}) {
  const Arguments<NodeType> arg = arguments;  // its own copy, which no store can be suspected to change
  Batch<order, NodeType> batch;
  const FieldColumns<3> position(set, Field::position);
  const LocalIndex end = std::min(block.end, set.size());
  for (LocalIndex first = block.begin; first < end; first += batch_size) {
    const int size = static_cast<int>(std::min<LocalIndex>(batch_size, end - first));
    if (!wanted(first, size)) continue;
    position.prefetch(first + prefetch_distance);
    for (int b = 0; b < size; b += n_lanes) prepare<gradients>(arg.frame, position, first + b, b, batch);
    for (int b = 0; b < size; ++b) {
      const LocalIndex cell = arg.cell[first + b];
      if constexpr (kept == Kept::moments) {
        gather<Oct, 0, moments, gradients>(arg.row_offsets, arg.nodes, cell, b, batch);
      } else {
        gather<Quad, 0, moments, gradients>(arg.row_offsets, arg.nodes, cell, b, batch);
        if constexpr (kept == Kept::velocity) gather<Quad, 1, false, false>(arg.row_offsets, arg.nodes, cell, b, batch);
      }
    }
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
template <SplineOrder order, bool moments, bool gradients, Kept kept>
class Update {
 public:
  Update(const Arguments<NodeOf<kept>>& arg, ParticleSet& set)
      : arg_(arg),
        id_(set.id()),
        mass_(set),
        position_(set, Field::position),
        velocity_(set, Field::velocity),
        affine_velocity_(set, Field::affine_velocity) {
    if (set.has(Field::velocity_gradient)) velocity_gradient_.emplace(set, Field::velocity_gradient);
  }

  void operator()(LocalIndex p, LocalIndex place, int b, int n, const Batch<order, NodeOf<kept>>& batch) {
    leave_gathered(place, b, batch);
    mass_.prefetch(p + prefetch_distance);
    velocity_.prefetch(p + prefetch_distance);
    if constexpr (moments) affine_velocity_.prefetch(p + prefetch_distance);
    Motion motion = motion_of<moments, gradients>(arg_, b, batch);
    const double fraction = arg_.kept_share;
    Pack change[3];
    if constexpr (kept == Kept::velocity) load_rows(&batch.velocity[b][1], 2, change);
    for (int r = 0; r < 3; ++r) {
      Pack& v = motion.velocity[r];
      position_.store(p, position_(p, r) + arg_.dt * v, r);
      if constexpr (kept == Kept::velocity) v = (1.0 - fraction) * v + fraction * (velocity_(p, r) + change[r]);
      if constexpr (kept != Kept::moments) velocity_.store(p, v, r);
    }
    if constexpr (kept == Kept::moments) {
      Pack v[3], affine[9];
      for (int r = 0; r < 3; ++r) v[r] = velocity_(p, r);
      for (int c = 0; c < 9; ++c) affine[c] = affine_velocity_(p, c);
      keep_residual<order>(arg_, b, batch, v, affine, motion);
      for (int r = 0; r < 3; ++r) velocity_.store(p, motion.velocity[r] = v[r], r);
      for (int c = 0; c < 9; ++c) motion.affine[c] = affine[c];
    }
    if constexpr (moments)
      for (int c = 0; c < 9; ++c) affine_velocity_.store(p, motion.affine[c], c);
    if (velocity_gradient_)
      for (int c = 0; c < 9; ++c) velocity_gradient_->store(p, motion.gradient[c], c);

    const Pack speed_squared = squares(motion.velocity);
    Pack reach = square_root(speed_squared), kinetic = speed_squared;
    if constexpr (moments)
      if (arg_.transfer.affine()) {
        const Pack affine_squared = squares(motion.affine);
        reach += square_root(affine_squared) * (moment_sum_ratio(order) * arg_.cell_size);
        kinetic += arg_.inertia * affine_squared;
      }
    include_lanes(speed_, speed_squared, id_ + p, n);
    include_lanes(velocity_gradient_extreme_, squares(motion.gradient), id_ + p, n);
    // Lanes past the end hold no particle and no mass.
    const Pack mass = mass_(p);
    mass_max_ = maximum(mass_max_, mass);
    momentum_max_ = maximum(momentum_max_, mass * reach);
    if (arg_.gathered.kinetic_energy) store(arg_.gathered.kinetic_energy + place, 0.5 * mass * kinetic);
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
  // The nodes' fourth number and its slopes.
  void leave_gathered(LocalIndex place, int b, const Batch<order, NodeOf<kept>>& batch) {
    constexpr int n_quads = Batch<order, NodeOf<kept>>::n_quads;
    const Gathered& to = arg_.gathered;
    if (!to.value) return;
    Pack rows[4];
    load_rows(&batch.velocity[b][0], n_quads, rows);
    const Pack value = rows[3];
    store(to.value + place, value);
    for (int a = 0; a < 3; ++a) {
      if (!to.slope[a]) continue;
      load_rows(moments ? &batch.moment[b][a][0] : &batch.gradient[b][a][0], 3 * n_quads, rows);
      if constexpr (moments) rows[3] = inverse_second_moment(order) * (rows[3] - (batch.distance[a][b / n_lanes] - 1.0) * value);
      store(to.slope[a] + place, rows[3]);
    }
  }

  const Arguments<NodeOf<kept>>& arg_;
  const GlobalIndex* id_;
  MassColumn mass_;
  MutableColumns<3> position_, velocity_;
  MutableColumns<9> affine_velocity_;
  std::optional<MutableColumns<9>> velocity_gradient_;
  Extreme speed_, velocity_gradient_extreme_;
  Pack mass_max_{}, momentum_max_{};
};

template <SplineOrder order, bool moments, bool gradients, Kept kept>
[[gnu::flatten]] void update_all(const Arguments<NodeOf<kept>>& arg, ParticleSet& particles, ParticleBlock block,
                                 StepBounds& bounds) {
  Update<order, moments, gradients, kept> update(arg, particles);
  for_each_pack<order, moments, gradients, kept>(arg, particles, block, [&](LocalIndex p, int b, int n, const auto& batch) {
    update(p, p - block.begin, b, n, batch);
  });
  update.merge_into(bounds);
}

template <class NodeType>
void measure_all(const Arguments<NodeType>& arg, const ParticleSet& particles, const GridGeometry& grid,
                 const PoolLayout& layout, const MotionLimits& ample, StepBounds& bounds) {
  const GlobalIndex* id = particles.id();
  with_sums(grid, arg.transfer, [&](auto order, auto moments, auto gradients) {
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
    CalmTiles<order(), NodeType> calm(grid, layout, arg.cell, arg.nodes, particles.size(), ample);
    const auto wanted = [&](LocalIndex first, int size) { return !calm.hold(first, size); };
    for_each_pack<order(), moments(), gradients(), Kept::nothing>(arg, particles, {}, visit, wanted);
  });
}

template <class NodeType>
Arguments<NodeType> arguments(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout,
                              const CellMap& map, double dt, double kept_share, const NodeType* nodes,
                              const Gathered& gathered = {}) {
  const double inertia = affine_inertia(grid, transfer);
  return {CellFrame(grid), grid.cell_size, transfer, layout.row_offsets().data(), map.cell.data(), dt,
          kept_share,      nodes,          inertia,  gathered};
}

}  // namespace

void g2p(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map, double dt,
         const Node* nodes, ParticleSet& particles, StepBounds& bounds, ParticleBlock block, const Gathered& gathered) {
  BULKLEY_ASSERT(!transfer.keeps_residual());
  BULKLEY_ASSERT(transfer.needs_velocity_gradient() == particles.has(Field::velocity_gradient));
  const auto arg = arguments(grid, transfer, layout, map, dt, 0.0, nodes, gathered);
  with_sums(grid, transfer, [&](auto order, auto moments, auto gradients) {
    update_all<order(), moments(), gradients(), Kept::nothing>(arg, particles, block, bounds);
  });
}

void g2p(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map, double dt,
         double kept_share, const NodePair* nodes, ParticleSet& particles, StepBounds& bounds, ParticleBlock block,
         const Gathered& gathered) {
  BULKLEY_ASSERT(transfer.keeps_residual());
  BULKLEY_ASSERT(transfer.needs_velocity_gradient() == particles.has(Field::velocity_gradient));
  const auto arg = arguments(grid, transfer, layout, map, dt, kept_share, nodes, gathered);
  with_sums(grid, transfer, [&](auto order, auto moments, auto gradients) {
    if constexpr (moments())
      if (transfer.affine()) return update_all<order(), true, gradients(), Kept::moments>(arg, particles, block, bounds);
    update_all<order(), moments(), gradients(), Kept::velocity>(arg, particles, block, bounds);
  });
}

void measure_motion(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map,
                    const Node* nodes, const ParticleSet& particles, StepBounds& bounds, const MotionLimits& ample) {
  measure_all(arguments(grid, transfer, layout, map, 0.0, 0.0, nodes), particles, grid, layout, ample, bounds);
}

void measure_motion(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map,
                    const NodePair* nodes, const ParticleSet& particles, StepBounds& bounds, const MotionLimits& ample) {
  measure_all(arguments(grid, transfer, layout, map, 0.0, 0.0, nodes), particles, grid, layout, ample, bounds);
}

}  // namespace bulkley
