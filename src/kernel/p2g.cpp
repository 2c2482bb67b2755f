#include "kernel/p2g.hpp"

#include <algorithm>
#include <cstring>
#include <type_traits>

#include "bulkley/base/error.hpp"
#include "bulkley/base/tensor.hpp"
#include "kernel/batch.hpp"

namespace bulkley {

namespace {

// What one particle gives to node (i, j, k) of its stencil: w (q + i a_x + j a_y + k a_z) of momentum and mass; for the MLS
// form of the force an impulse of the same kind, where Impulses says; for the B-spline form (grad w) . F, F the columns of
// -dt V tau. The impulse of a force on the particle itself, dt F_p w, joins the MLS impulse or q.
template <SplineOrder order, class NodeType>
struct Batch {
  static constexpr int s = stencil_width(order);
  static constexpr int n_quads = quads_in<typename VectorOf<NodeType>::type>;
  alignas(64) double wxy[s * s][batch_size];
  alignas(64) double wz[s][batch_size];
  alignas(64) double dxy[2][s * s][batch_size];  // B-spline form: derivatives d_x w_y and w_x d_y
  alignas(64) double dz[s][batch_size];
  alignas(64) Quad momentum[batch_size][4][n_quads];  // q, a_x, a_y, a_z; in second quads those of the MLS impulse
  alignas(64) Quad impulse[batch_size][4];            // B-spline: F_x, F_y, F_z; then dt F_p, unless joined
};

template <class NodeType>
struct Arguments {
  CellFrame frame;
  double cell_size;
  bool affine;
  const LocalIndex* row_offsets;
  const LocalIndex* cell;
  FieldColumns<3> position, velocity;
  FieldColumns<9> affine_velocity;
  MassColumn mass;
  FieldColumns<3> force;  // read where `forced`
  ParticleStress stress;
  CellMeans means;
  LocalIndex n_particles;
  double dt;
  Quad rounding[2];  // M of (T28) for a node's numbers, and for those of an impulse apart
  NodeType* pool;
};

// Weights of n_lanes particles at distances `fx` above their base nodes, at place `b` of the batch.
template <SplineOrder order, GradientForm form, class NodeType>
void prepare_weights(const Pack (&fx)[3], int b, Batch<order, NodeType>& batch) {
  constexpr int s = stencil_width(order);
  Pack w[3][s];
  for (int a = 0; a < 3; ++a) spline_weights<order>(fx[a], w[a]);
  for (int i = 0; i < s; ++i)
    for (int j = 0; j < s; ++j) store(&batch.wxy[i * s + j][b], w[0][i] * w[1][j]);
  for (int k = 0; k < s; ++k) store(&batch.wz[k][b], w[2][k]);
  if constexpr (form == GradientForm::bspline) {
    Pack d[3][s];
    for (int a = 0; a < 3; ++a) spline_derivatives<order>(fx[a], d[a]);
    for (int i = 0; i < s; ++i)
      for (int j = 0; j < s; ++j) {
        store(&batch.dxy[0][i * s + j][b], d[0][i] * w[1][j]);
        store(&batch.dxy[1][i * s + j][b], w[0][i] * d[1][j]);
      }
    for (int k = 0; k < s; ++k) store(&batch.dz[k][b], d[2][k]);
  }
}

// Everything the batch holds of n_lanes particles, first particle `p`, at place `b`.
template <SplineOrder order, GradientForm form, bool forced, Impulses impulses, class NodeType>
void prepare(const Arguments<NodeType>& arg, LocalIndex p, int b, Batch<order, NodeType>& batch) {
  constexpr int n_quads = Batch<order, NodeType>::n_quads;
  constexpr bool two = impulses != Impulses::joined;
  static_assert(two == (n_quads == 2));
  const double dx = arg.cell_size;
  Pack fx[3];
  for (int a = 0; a < 3; ++a) fx[a] = arg.frame.offset_in_stencil(a, arg.position(p, a));
  prepare_weights<order, form>(fx, b, batch);

  const Pack zero = broadcast<Pack>(0.0);
  const Pack volume = arg.mass.volume(p), mass = arg.mass(p);
  const SymTensor<Pack> stress =
      arg.means.any() ? arg.stress.with_mean(p, arg.means.of(&CellSums::stress, p, arg.stress.mean(p))) : arg.stress.of(p);

  // Rows x, y, z and mass of each column. Per cell: dx m C and, for the MLS form, -dt V tau D_p^-1 dx.
  Pack q[4], a[3][4], fq[4], f[3][4];
  q[3] = mass, fq[3] = zero;
  for (int c = 0; c < 3; ++c) a[c][3] = f[c][3] = zero;
  const Pack force = volume * (form == GradientForm::mls ? -arg.dt * inverse_second_moment(order) / dx : -arg.dt / dx);
  const Pack mass_dx = mass * dx;
#pragma GCC unroll 3
  for (int r = 0; r < 3; ++r) {
    q[r] = mass * arg.velocity(p, r);
    fq[r] = zero;
#pragma GCC unroll 3
    for (int c = 0; c < 3; ++c) {
      a[c][r] = arg.affine ? mass_dx * arg.affine_velocity(p, 3 * r + c) : zero;
      f[c][r] = force * stress(r, c);
      if constexpr (form == GradientForm::mls) {
        if constexpr (two) fq[r] -= f[c][r] * fx[c];
        if constexpr (impulses != Impulses::apart) a[c][r] += f[c][r];
      }
      q[r] -= a[c][r] * fx[c];
    }
    if constexpr (forced) {
      const Pack given = arg.dt * arg.force(p, r);
      if constexpr (two) fq[r] += given;
      if constexpr (impulses != Impulses::apart) q[r] += given;
    }
  }
  if constexpr (two && form == GradientForm::mls) {
    store_octs(q, fq, &batch.momentum[b][0][0], 8);
    for (int c = 0; c < 3; ++c) store_octs(a[c], f[c], &batch.momentum[b][1 + c][0], 8);
  } else {
    store_quads(q, &batch.momentum[b][0][0], 4 * n_quads);
    for (int c = 0; c < 3; ++c) store_quads(a[c], &batch.momentum[b][1 + c][0], 4 * n_quads);
  }
  if constexpr (form == GradientForm::bspline) {
    for (int c = 0; c < 3; ++c) store_quads(f[c], &batch.impulse[b][c], 4);
    if constexpr (forced && two) store_quads(fq, &batch.impulse[b][3], 4);
  }
}

template <class Vector, class NodeType>
inline void add_rounded(NodeType& node, Vector contribution, Vector constant) {
  store_vector(node, load_vector<Vector>(node) + rounded(contribution, constant));
}

template <SplineOrder order, GradientForm form, bool forced, Impulses impulses, class NodeType>
void scatter(const Arguments<NodeType>& arg, LocalIndex cell, int b, const Batch<order, NodeType>& batch) {
  constexpr int s = stencil_width(order);
  constexpr bool mls = form == GradientForm::mls;
  using Vector = std::conditional_t<mls, typename VectorOf<NodeType>::type, Quad>;
  const StencilRows<order, NodeType> pool(arg.row_offsets, cell, arg.pool);
  const Vector constant = load_vector<Vector>(arg.rounding);  // of a NodePair the momentum's or both halves
  const auto momentum = [&](int c) { return load_vector<Vector>(batch.momentum[b][c]); };
  const Quad* const f = batch.impulse[b];
  Vector qi = momentum(0);
#pragma GCC unroll 4
  for (int i = 0; i < s; ++i) {
    Vector qj = qi;
#pragma GCC unroll 4
    for (int j = 0; j < s; ++j) {
      const double w = batch.wxy[i * s + j][b];
      NodeType* const to = pool(i, j);
      Vector q = w * qj;  // w_x w_y of node (i, j, 0), and its increment along z
      const Vector qz = w * momentum(3);
      Quad g{}, gz{};  // B-spline: the parts of grad w that w_z and d_z multiply
      Quad given{};    // dt F_p w, where q does not have it or the impulse is told apart
      if constexpr (!mls) {
        g = batch.dxy[0][i * s + j][b] * f[0] + batch.dxy[1][i * s + j][b] * f[1];
        if constexpr (forced && impulses == Impulses::apart) g += w * f[3];
        if constexpr (forced && impulses == Impulses::both) given = w * f[3];
        gz = w * f[2];
      }
#pragma GCC unroll 4
      for (int k = 0; k < s; ++k) {
        const double wz = batch.wz[k][b];
        if constexpr (mls) {
          add_rounded(to[k], wz * q, constant);
        } else if constexpr (impulses == Impulses::apart) {
          add_rounded(to[k].motion, wz * q, constant);
          add_rounded(to[k].change, wz * g + batch.dz[k][b] * gz, arg.rounding[1]);
        } else if constexpr (impulses == Impulses::both) {
          const Quad impulse = wz * g + batch.dz[k][b] * gz;
          add_rounded(to[k].motion, wz * q + impulse, constant);
          if constexpr (forced)
            add_rounded(to[k].change, impulse + wz * given, arg.rounding[1]);
          else
            add_rounded(to[k].change, impulse, arg.rounding[1]);
        } else {
          add_rounded(to[k], wz * q + (wz * g + batch.dz[k][b] * gz), constant);
        }
        q += qz;
      }
      qj += momentum(2);
    }
    qi += momentum(1);
  }
}

// The same for MLS impulses apart from momenta without affine velocities: only the impulses change from node to node, which is less
// work in two quads than in an oct.
template <SplineOrder order>
void scatter_uniform(const Arguments<NodePair>& arg, LocalIndex cell, int b, const Batch<order, NodePair>& batch) {
  constexpr int s = stencil_width(order);
  const StencilRows<order, NodePair> pool(arg.row_offsets, cell, arg.pool);
  const Quad constant = arg.rounding[0], impulse_constant = arg.rounding[1];
  const auto impulse = [&](int c) { return batch.momentum[b][c][1]; };
  const Quad momentum = batch.momentum[b][0][0];
  Quad fi = impulse(0);
#pragma GCC unroll 4
  for (int i = 0; i < s; ++i) {
    Quad fj = fi;
#pragma GCC unroll 4
    for (int j = 0; j < s; ++j) {
      const double w = batch.wxy[i * s + j][b];
      NodePair* const to = pool(i, j);
      const Quad q = w * momentum, fz = w * impulse(3);
      Quad f = w * fj;
#pragma GCC unroll 4
      for (int k = 0; k < s; ++k) {
        const double wz = batch.wz[k][b];
        add_rounded(to[k].motion, wz * q, constant);
        add_rounded(to[k].change, wz * f, impulse_constant);
        f += fz;
      }
      fj += impulse(2);
    }
    fi += impulse(1);
  }
}

// Flattened: every call below is inlined here. `uniform`: by scatter_uniform.
template <SplineOrder order, GradientForm form, bool forced, Impulses impulses, bool uniform, class NodeType>
[[gnu::flatten]] void run(const Arguments<NodeType>& arguments) {
  const Arguments<NodeType> arg = arguments;  // its own copy, which no store to a node can be suspected to change
  Batch<order, NodeType> batch;
  const LocalIndex n = arg.n_particles;
  for (LocalIndex first = 0; first < n; first += batch_size) {
    const int size = static_cast<int>(std::min<LocalIndex>(batch_size, n - first));
    const LocalIndex ahead = first + prefetch_distance;
    arg.position.prefetch(ahead);
    arg.velocity.prefetch(ahead);
    if (arg.affine) arg.affine_velocity.prefetch(ahead);
    arg.stress.prefetch(ahead);
    arg.mass.prefetch(ahead);
    if constexpr (forced) arg.force.prefetch(ahead);
    for (int b = 0; b < size; b += n_lanes) prepare<order, form, forced, impulses>(arg, first + b, b, batch);
    for (int b = 0; b < size; ++b)
      if constexpr (uniform)
        scatter_uniform<order>(arg, arg.cell[first + b], b, batch);
      else
        scatter<order, form, forced, impulses>(arg, arg.cell[first + b], b, batch);
  }
}

template <Impulses impulses, class NodeType>
void run_all(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout,
             const ParticleSet& particles, const CellMap& map, const CellMeans& means, const ForceField& force,
             const SumBounds& sums, double dt, NodeType* pool, const StressOfState& stress) {
  const double m = rounding_constant(sums.mass), q = rounding_constant(sums.momentum), f = rounding_constant(sums.impulse);
  const Arguments<NodeType> arg{CellFrame(grid),
                                grid.cell_size,
                                transfer.affine(),
                                layout.row_offsets().data(),
                                map.cell.data(),
                                {particles, Field::position},
                                {particles, Field::velocity},
                                {particles, Field::affine_velocity},
                                MassColumn(particles),
                                {particles, force ? force->field : Field::velocity},
                                {particles, stress},
                                means,
                                particles.size(),
                                dt,
                                {Quad{q, q, q, m}, Quad{f, f, f, f}},
                                pool};
  std::fill_n(pool, layout.n_nodes(), NodeType{});
  with_order(grid.order, [&](auto order) {
    const auto run_form = [&](auto form) {
      const auto run_with = [&](auto uniform) {
        force ? run<order(), form(), true, impulses, uniform()>(arg) : run<order(), form(), false, impulses, uniform()>(arg);
      };
      if constexpr (impulses == Impulses::apart && form() == GradientForm::mls)
        if (!transfer.affine()) return run_with(std::true_type{});
      run_with(std::false_type{});
    };
    if (transfer.gradient == GradientForm::mls)
      run_form(std::integral_constant<GradientForm, GradientForm::mls>{});
    else
      run_form(std::integral_constant<GradientForm, GradientForm::bspline>{});
  });
}

}  // namespace

SumBounds sum_bounds(const GridGeometry& grid, const TransferSettings& transfer, const StepBounds& bounds, double dt,
                     bool splits, const ForceField& force, bool means) {
  const SplineOrder order = grid.order;
  const double slack = 1.0 + 1e-9;  // for the roundings in forming the contributions
  const double weights =
      slack * weight_sum_bound(order) * static_cast<double>(std::max<GlobalIndex>(bounds.sums.cell_count, 1));
  const double ratio = transfer.gradient == GradientForm::mls ? inverse_second_moment(order) * moment_sum_ratio(order)
                                                              : gradient_sum_ratio(order);
  const double given = force ? dt * force->largest : 0.0;
  // What a cell's particles give in sum with its mean stress, deviators being as they were, is no more than sqrt(2) times what the
  // stresses of each give.
  const double stress = (means ? 1.4142135623730952 : 1.0) * bounds.sums.stress_volume;
  const double impulse = dt * stress * ratio / grid.cell_size + given;
  const double momentum = bounds.sums.momentum + (splits ? 0.0 : impulse);
  return {weights * bounds.sums.mass, weights * momentum, weights * impulse};
}

void p2g(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const ParticleSet& particles,
         const CellMap& map, const SumBounds& sums, double dt, Node* pool, const ForceField& force, const CellMeans& means,
         const StressOfState& stress) {
  run_all<Impulses::joined>(grid, transfer, layout, particles, map, means, force, sums, dt, pool, stress);
}

void p2g(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const ParticleSet& particles,
         const CellMap& map, const SumBounds& sums, double dt, NodePair* pool, const ForceField& force, Impulses impulses,
         const CellMeans& means, const StressOfState& stress) {
  BULKLEY_ASSERT(impulses != Impulses::joined);
  if (impulses == Impulses::both)
    run_all<Impulses::both>(grid, transfer, layout, particles, map, means, force, sums, dt, pool, stress);
  else
    run_all<Impulses::apart>(grid, transfer, layout, particles, map, means, force, sums, dt, pool, stress);
}

}  // namespace bulkley
