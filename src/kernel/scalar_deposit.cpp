#include "kernel/scalar_deposit.hpp"

#include <algorithm>

#include "base/order_free.hpp"
#include "kernel/batch.hpp"

namespace bulkley {

namespace {

template <SplineOrder order>
struct Batch {
  static constexpr int s = stencil_width(order);
  alignas(64) double wxy[s * s][batch_size];
  alignas(64) double wz[s][batch_size];
};

template <SplineOrder order>
void prepare(const CellFrame& frame, const FieldColumns<3>& position, LocalIndex p, int b, Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  Pack w[3][s];
  for (int a = 0; a < 3; ++a) spline_weights<order>(frame.offset_in_stencil(a, position(p, a)), w[a]);
  for (int i = 0; i < s; ++i)
    for (int j = 0; j < s; ++j) store(&batch.wxy[i * s + j][b], w[0][i] * w[1][j]);
  for (int k = 0; k < s; ++k) store(&batch.wz[k][b], w[2][k]);
}

template <SplineOrder order>
void scatter(const StencilRows<order, double>& rows, int b, const Batch<order>& batch, double q, double constant) {
  constexpr int s = stencil_width(order);
  for (int i = 0; i < s; ++i)
    for (int j = 0; j < s; ++j) {
      double* const row = rows(i, j);
      const double share = batch.wxy[i * s + j][b] * q;
      for (int k = 0; k < s; ++k) row[k] += rounded(batch.wz[k][b] * share, constant);
    }
}

template <SplineOrder order>
[[gnu::flatten]] void run(const CellFrame& frame, const LocalIndex* row_offsets, const LocalIndex* cell,
                          const ParticleSet& particles, const double* q, double constant, double* pool) {
  const FieldColumns<3> position(particles, Field::position);
  Batch<order> batch;
  const LocalIndex n = particles.size();
  for (LocalIndex first = 0; first < n; first += batch_size) {
    const int size = static_cast<int>(std::min<LocalIndex>(batch_size, n - first));
    position.prefetch(first + prefetch_distance);
    for (int b = 0; b < size; b += n_lanes) prepare<order>(frame, position, first + b, b, batch);
    for (int b = 0; b < size; ++b) scatter<order>({row_offsets, cell[first + b], pool}, b, batch, q[first + b], constant);
  }
}

}  // namespace

double scalar_sum_bound(SplineOrder order, double largest, GlobalIndex cell_count) {
  const double slack = 1.0 + 1e-9;  // for the roundings in forming the contributions
  return slack * weight_sum_bound(order) * static_cast<double>(std::max<GlobalIndex>(cell_count, 1)) * largest;
}

void scalar_deposit(const GridGeometry& grid, const PoolLayout& layout, const ParticleSet& particles, const CellMap& map,
                    const double* q, double largest, GlobalIndex cell_count, double* pool) {
  const double constant = rounding_constant(scalar_sum_bound(grid.order, largest, cell_count));
  std::fill_n(pool, layout.n_nodes(), 0.0);
  with_order(grid.order, [&](auto order) {
    run<order()>(CellFrame(grid), layout.row_offsets().data(), map.cell.data(), particles, q, constant, pool);
  });
}

}  // namespace bulkley
