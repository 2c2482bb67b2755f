#include "kernel/viscous_force.hpp"

#include <algorithm>
#include <cmath>

#include "base/order_free.hpp"
#include "kernel/batch.hpp"
#include "material/viscous_stress.hpp"

namespace bulkley {

namespace {

// Component a of G is steep in axis a and flat in the others: steep_a flat_b flat_c, whatever the form. `columns`: those of L, then
// those of -weight dev sym L.
template <SplineOrder order>
struct Batch {
  static constexpr int s = stencil_width(order);
  alignas(64) double flat[3][s][batch_size];   // w
  alignas(64) double steep[3][s][batch_size];  // dw/dx, or w (x_i - x) / D
  alignas(64) Quad columns[batch_size][3];
};

struct Arguments {
  CellFrame frame;
  const LocalIndex* row_offsets;
  const LocalIndex* cell;
  FieldColumns<3> position;
  LocalIndex n_particles;
  const double* weights;
  Quad rounding;
  const Node* velocity;
  Node* force;
};

template <SplineOrder order, GradientForm form>
void prepare(const Arguments& arg, LocalIndex p, int b, Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  const double inverse_dx = arg.frame.inverse_cell_size;
  for (int a = 0; a < 3; ++a) {
    const Pack distance = arg.frame.offset_in_stencil(a, arg.position(p, a));
    Pack w[s], d[s];
    spline_weights<order>(distance, w);
    if constexpr (form == GradientForm::mls)
      for (int k = 0; k < s; ++k) d[k] = w[k] * (static_cast<double>(k) - distance) * inverse_second_moment(order);
    else
      spline_derivatives<order>(distance, d);
    for (int k = 0; k < s; ++k) {
      store(&batch.flat[a][k][b], w[k]);
      store(&batch.steep[a][k][b], d[k] * inverse_dx);
    }
  }
}

// The three nested sums are factored by direction: z, then y, then x.
template <SplineOrder order>
void gather(const Arguments& arg, LocalIndex cell, int b, Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  const StencilRows<order, const Node> rows(arg.row_offsets, cell, arg.velocity);
  Quad along[3] = {};
#pragma GCC unroll 4
  for (int i = 0; i < s; ++i) {
    Quad flat_y{}, steep_y{}, steep_z{};
#pragma GCC unroll 4
    for (int j = 0; j < s; ++j) {
      const Node* const row = rows(i, j);
      Quad flat{}, steep{};
#pragma GCC unroll 4
      for (int k = 0; k < s; ++k) {
        const Quad v = load_vector(row[k]);
        flat += batch.flat[2][k][b] * v;
        steep += batch.steep[2][k][b] * v;
      }
      flat_y += batch.flat[1][j][b] * flat;
      steep_y += batch.steep[1][j][b] * flat;
      steep_z += batch.flat[1][j][b] * steep;
    }
    along[0] += batch.steep[0][i][b] * flat_y;
    along[1] += batch.flat[0][i][b] * steep_y;
    along[2] += batch.flat[0][i][b] * steep_z;
  }
  for (int c = 0; c < 3; ++c) batch.columns[b][c] = along[c];
}

// Velocity gradients -> columns of the stress times volume.
template <SplineOrder order>
void to_stress(const Arguments& arg, LocalIndex p, int b, Batch<order>& batch) {
  Tensor<Pack> L;
  for (int c = 0; c < 3; ++c) {
    Pack column[3];
    load_rows(&batch.columns[b][c], 3, column);
    for (int r = 0; r < 3; ++r) L(r, c) = column[r];
  }
  const SymTensor<Pack> rate = shear_rate_tensor(L);
  const Pack factor = -load(arg.weights + p);
  for (int c = 0; c < 3; ++c) {
    Pack rows[4];
    for (int r = 0; r < 3; ++r) rows[r] = factor * rate(r, c);
    rows[3] = broadcast<Pack>(0.0);
    store_quads(rows, &batch.columns[b][c], 3);
  }
}

template <SplineOrder order>
void scatter(const Arguments& arg, LocalIndex cell, int b, const Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  const StencilRows<order, Node> rows(arg.row_offsets, cell, arg.force);
  const Quad* const f = batch.columns[b];
#pragma GCC unroll 4
  for (int i = 0; i < s; ++i)
#pragma GCC unroll 4
    for (int j = 0; j < s; ++j) {
      const double wx = batch.flat[0][i][b], wy = batch.flat[1][j][b];
      const Quad flat = (batch.steep[0][i][b] * wy) * f[0] + (wx * batch.steep[1][j][b]) * f[1];
      const Quad steep = (wx * wy) * f[2];
      Node* const to = rows(i, j);
#pragma GCC unroll 4
      for (int k = 0; k < s; ++k) {
        const Quad contribution = batch.flat[2][k][b] * flat + batch.steep[2][k][b] * steep;
        store_vector(to[k], load_vector(to[k]) + rounded(contribution, arg.rounding));
      }
    }
}

// Flattened: every call below is inlined here.
template <SplineOrder order, GradientForm form>
[[gnu::flatten]] void run(const Arguments& arguments) {
  const Arguments arg = arguments;  // its own copy, which no store to a node can be suspected to change
  Batch<order> batch;
  for (LocalIndex first = 0; first < arg.n_particles; first += batch_size) {
    const int size = static_cast<int>(std::min<LocalIndex>(batch_size, arg.n_particles - first));
    arg.position.prefetch(first + prefetch_distance);
    for (int b = 0; b < size; b += n_lanes) prepare<order, form>(arg, first + b, b, batch);
    for (int b = 0; b < size; ++b) gather<order>(arg, arg.cell[first + b], b, batch);
    for (int b = 0; b < size; b += n_lanes) to_stress<order>(arg, first + b, b, batch);
    for (int b = 0; b < size; ++b) scatter<order>(arg, arg.cell[first + b], b, batch);
  }
}

}  // namespace

double set_viscous_weights(std::span<const double> viscosities, const ParticleSet& particles, std::vector<double>& weights) {
  const double* const J = particles.real(Field::volume_ratio);
  const double* const volume = particles.real(Field::reference_volume);
  const std::uint8_t* const material = particles.material();
  const auto n = static_cast<std::size_t>(particles.size());
  weights.assign(n + ParticleSet::padding, 0.0);
  double largest = 0.0;
  for (std::size_t p = 0; p < n; ++p) {
    weights[p] = 2.0 * viscosities[material[p]] * J[p] * volume[p];
    largest = std::max(largest, weights[p]);
  }
  return largest;
}

// Along each axis the absolute steep weights of a stencil sum to at most 2 / dx, so that ||L|| <= 2 sqrt(3) max|v| / dx; and the
// deviator's symmetric part is no larger than L.
double viscous_force_bound(const GridGeometry& grid, const TransferSettings& transfer, GlobalIndex cell_count,
                           double largest_weight, double largest_speed) {
  const SplineOrder order = grid.order;
  const double slack = 1.0 + 1e-9;  // for the roundings in forming the contributions
  const double stress = largest_weight * 2.0 * std::sqrt(3.0) * largest_speed / grid.cell_size;
  const double ratio = transfer.gradient == GradientForm::mls ? inverse_second_moment(order) * moment_sum_ratio(order)
                                                              : gradient_sum_ratio(order);
  return slack * weight_sum_bound(order) * static_cast<double>(std::max<GlobalIndex>(cell_count, 1)) * stress * ratio /
         grid.cell_size;
}

void viscous_forces(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map,
                    const ParticleSet& particles, const double* weights, double bound, const Node* velocity, Node* force) {
  const double rounding = rounding_constant(bound);
  const Arguments arg{CellFrame(grid),
                      layout.row_offsets().data(),
                      map.cell.data(),
                      {particles, Field::position},
                      particles.size(),
                      weights,
                      Quad{rounding, rounding, rounding, rounding},
                      velocity,
                      force};
  std::fill_n(force, layout.n_nodes(), Node{});
  with_order(grid.order, [&](auto order) {
    if (transfer.gradient == GradientForm::mls)
      run<order(), GradientForm::mls>(arg);
    else
      run<order(), GradientForm::bspline>(arg);
  });
}

void record_viscous_stress(std::span<const double> viscosities, Field gradient, double dt, ParticleSet& particles,
                           ParticleBlock block) {
  const FieldColumns<9> velocity_gradient(particles, gradient);
  const FieldColumns<1> volume_ratio(particles, Field::volume_ratio);
  const MutableColumns<6> viscous_stress(particles, Field::viscous_stress);
  const MutableColumns<1> dissipation(particles, Field::plastic_dissipation);
  const std::uint8_t* const material = particles.material();
  const LocalIndex end = std::min(block.end, particles.size());
  for (LocalIndex p = block.begin; p < end; p += n_lanes) {
    Pack viscosity{};
    for (int lane = 0; lane < n_lanes && p + lane < end; ++lane) viscosity[lane] = viscosities[material[p + lane]];
    Tensor<Pack> L;
    for (int c = 0; c < 9; ++c) L.c[c] = velocity_gradient(p, c);
    const SymTensor<Pack> rate = shear_rate_tensor(L);
    const Pack factor = 2.0 * viscosity * volume_ratio(p);
    for (int c = 0; c < 6; ++c) viscous_stress.store(p, factor * rate.c[c], c);
    dissipation.store(p, dissipation(p) + factor * norm_squared(rate) * dt);
  }
}

}  // namespace bulkley
