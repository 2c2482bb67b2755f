#include "kernel/scalar_gather.hpp"

#include <algorithm>

#include "kernel/batch.hpp"

namespace bulkley {

namespace {

template <SplineOrder order>
struct Batch {
  static constexpr int s = stencil_width(order);
  alignas(64) double w[3][s][batch_size];
  alignas(64) double d[3][s][batch_size];  // dw/dx
};

template <SplineOrder order>
void prepare(const CellFrame& frame, const FieldColumns<3>& position, LocalIndex p, int b, Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  for (int a = 0; a < 3; ++a) {
    const Pack distance = frame.offset_in_stencil(a, position(p, a));
    Pack w[s], d[s];
    spline_weights<order>(distance, w);
    spline_derivatives<order>(distance, d);
    for (int k = 0; k < s; ++k) {
      store(&batch.w[a][k][b], w[k]);
      store(&batch.d[a][k][b], d[k] * frame.inverse_cell_size);
    }
  }
}

// The three nested sums are factored by direction: z, then y, then x.
template <SplineOrder order>
double value_at(const StencilRows<order, const double>& rows, int b, const Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  double value = 0.0;
  for (int i = 0; i < s; ++i) {
    double value_y = 0.0;
    for (int j = 0; j < s; ++j) {
      const double* const row = rows(i, j);
      double value_z = 0.0;
      for (int k = 0; k < s; ++k) value_z += batch.w[2][k][b] * row[k];
      value_y += batch.w[1][j][b] * value_z;
    }
    value += batch.w[0][i][b] * value_y;
  }
  return value;
}

struct Gradient {
  double along[3] = {};
};

template <SplineOrder order>
Gradient gradient_at(const StencilRows<order, const double>& rows, int b, const Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  Gradient gradient;
  for (int i = 0; i < s; ++i) {
    double value_y = 0.0, along_y = 0.0, along_z = 0.0;
    for (int j = 0; j < s; ++j) {
      const double* const row = rows(i, j);
      double value_z = 0.0, slope = 0.0;
      for (int k = 0; k < s; ++k) {
        value_z += batch.w[2][k][b] * row[k];
        slope += batch.d[2][k][b] * row[k];
      }
      value_y += batch.w[1][j][b] * value_z;
      along_y += batch.d[1][j][b] * value_z;
      along_z += batch.w[1][j][b] * slope;
    }
    gradient.along[0] += batch.d[0][i][b] * value_y;
    gradient.along[1] += batch.w[0][i][b] * along_y;
    gradient.along[2] += batch.w[0][i][b] * along_z;
  }
  return gradient;
}

template <SplineOrder order>
[[gnu::flatten]] void run(const CellFrame& frame, const LocalIndex* row_offsets, const LocalIndex* cell,
                          const ParticleSet& particles, const GatheredValue& value, const GatheredGradient& gradient) {
  const FieldColumns<3> position(particles, Field::position);
  Batch<order> batch;
  const LocalIndex n = particles.size();
  for (LocalIndex first = 0; first < n; first += batch_size) {
    const int size = static_cast<int>(std::min<LocalIndex>(batch_size, n - first));
    position.prefetch(first + prefetch_distance);
    for (int b = 0; b < size; b += n_lanes) prepare<order>(frame, position, first + b, b, batch);
    for (int b = 0; b < size; ++b) {
      const LocalIndex p = first + b;
      if (value.nodes) value.to[p] = value_at<order>({row_offsets, cell[p], value.nodes}, b, batch);
      if (!gradient.nodes) continue;
      const Gradient found = gradient_at<order>({row_offsets, cell[p], gradient.nodes}, b, batch);
      for (std::size_t axis = 0; axis < 3; ++axis) gradient.to[axis][p] = found.along[axis];
    }
  }
}

}  // namespace

void scalar_gather(const GridGeometry& grid, const PoolLayout& layout, const ParticleSet& particles, const CellMap& map,
                   const GatheredValue& value, const GatheredGradient& gradient) {
  with_order(grid.order, [&](auto order) {
    run<order()>(CellFrame(grid), layout.row_offsets().data(), map.cell.data(), particles, value, gradient);
  });
}

}  // namespace bulkley
