#include "kernel/cell_means.hpp"

#include <algorithm>
#include <type_traits>

#include "base/order_free.hpp"
#include "kernel/batch.hpp"

namespace bulkley {

namespace {

// M of (T28) for the sums of a cell whose terms are at most `largest`; at least four of them, as (T28) asks.
double constant_of(const CellSumBounds& bounds, double largest) {
  constexpr double slack = 1.0 + 1e-9;  // for the roundings in forming the terms
  return rounding_constant(slack * largest * static_cast<double>(std::max<GlobalIndex>(bounds.n_terms, 4)));
}

// Weights and slopes of a batch of particles; a slope is what a node's velocity counts in the derivative along its axis, in cells.
template <SplineOrder order>
struct Batch {
  static constexpr int s = stencil_width(order);
  alignas(64) double w[3][s][batch_size];
  alignas(64) double d[3][s][batch_size];
  alignas(64) Quad trace[batch_size];  // dx dv_c/dx_c by component
};

template <SplineOrder order, GradientForm form>
void prepare(const CellFrame& frame, const FieldColumns<3>& position, LocalIndex p, int b, Batch<order>& batch) {
  constexpr int s = stencil_width(order);
#pragma GCC unroll 3
  for (int a = 0; a < 3; ++a) {
    const Pack fx = frame.offset_in_stencil(a, position(p, a));
    Pack w[s], d[s];
    spline_weights<order>(fx, w);
    if constexpr (form == GradientForm::bspline)
      spline_derivatives<order>(fx, d);
    else
      for (int k = 0; k < s; ++k) d[k] = inverse_second_moment(order) * w[k] * (static_cast<double>(k) - fx);
    for (int k = 0; k < s; ++k) {
      store(&batch.w[a][k][b], w[k]);
      store(&batch.d[a][k][b], d[k]);
    }
  }
}

// {weight, weight, weight, -} but the slope in the lane `axis`: what velocity components count along that axis.
template <int axis>
inline Quad factor(double weight, double slope) {
  const Quad w = weight - Quad{}, d = slope - Quad{};
  return __builtin_shufflevector(w, d, axis == 0 ? 4 : 0, axis == 1 ? 5 : 1, axis == 2 ? 6 : 2, 3);
}

// Of a particle.
template <SplineOrder order, class NodeType>
Quad trace_of(const LocalIndex* row_offsets, const NodeType* nodes, LocalIndex cell, int b, const Batch<order>& batch) {
  constexpr int s = stencil_width(order);
  const StencilRows<order, const NodeType> rows(row_offsets, cell, nodes);
  Quad z[s];
#pragma GCC unroll 4
  for (int k = 0; k < s; ++k) z[k] = factor<2>(batch.w[2][k][b], batch.d[2][k][b]);
  Quad sum{};
#pragma GCC unroll 4
  for (int i = 0; i < s; ++i) {
    Quad plane{};
#pragma GCC unroll 4
    for (int j = 0; j < s; ++j) {
      const NodeType* const row = rows(i, j);
      Quad line{};
#pragma GCC unroll 4
      for (int k = 0; k < s; ++k) line += z[k] * load_vector<Quad, 0>(row[k]);
      plane += factor<1>(batch.w[1][j][b], batch.d[1][j][b]) * line;
    }
    sum += factor<0>(batch.w[0][i][b], batch.d[0][i][b]) * plane;
  }
  return sum;
}

template <SplineOrder order, GradientForm form, class NodeType>
[[gnu::flatten]] void add_dilations(const GridGeometry& grid, const LocalIndex* row_offsets, const LocalIndex* cell,
                                    const NodeType* nodes, const ParticleSet& particles, CellGroups groups, double constant,
                                    double largest, CellSums* sums) {
  const CellFrame frame(grid);
  const FieldColumns<3> position(particles, Field::position);
  const FieldColumns<1> volume(particles, Field::reference_volume);
  const Pack most = broadcast<Pack>(largest), round = broadcast<Pack>(constant);
  const LocalIndex n = particles.size();
  Batch<order> batch;
  for (LocalIndex first = 0; first < n; first += batch_size) {
    const int size = static_cast<int>(std::min<LocalIndex>(batch_size, n - first));
    position.prefetch(first + prefetch_distance);
    for (int b = 0; b < size; b += n_lanes) prepare<order, form>(frame, position, first + b, b, batch);
    for (int b = 0; b < size; ++b) batch.trace[b] = trace_of<order>(row_offsets, nodes, cell[first + b], b, batch);
    for (int b = 0; b < size; b += n_lanes) {
      Pack along[3];
      load_rows(&batch.trace[b], 1, along);
      // NaN becomes a number: what is not finite is for g2p and the stress update to tell.
      const Pack trace = minimum(frame.inverse_cell_size * ((along[0] + along[1]) + along[2]), most);
      alignas(64) double terms[n_lanes];
      store(terms, rounded(volume(first + b) * maximum(trace, -most), round));
      for (int lane = 0; lane < std::min(n_lanes, size - b); ++lane)
        if (const LocalIndex group = groups[static_cast<std::size_t>(first + b + lane)]; group >= 0)
          sums[group].dilation += terms[lane];
    }
  }
}

template <class NodeType>
void find_all(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout, const CellMap& map,
              const NodeType* nodes, const ParticleSet& particles, CellGroups groups, const CellSumBounds& bounds, double dt,
              std::span<CellSums> sums) {
  const double largest = 1.0 / dt, constant = constant_of(bounds, bounds.volume * largest);
  with_order(grid.order, [&](auto order) {
    const auto add = [&](auto form) {
      add_dilations<order(), form()>(grid, layout.row_offsets().data(), map.cell.data(), nodes, particles, groups, constant,
                                     largest, sums.data());
    };
    if (transfer.gradient == GradientForm::mls)
      add(std::integral_constant<GradientForm, GradientForm::mls>{});
    else
      add(std::integral_constant<GradientForm, GradientForm::bspline>{});
  });
  for (CellSums& cell : sums)
    if (cell.volume > 0.0) cell.dilation /= cell.volume;
}

}  // namespace

[[gnu::flatten]] void sum_stress(const ParticleSet& particles, CellGroups groups, const CellSumBounds& bounds,
                                 std::span<CellSums> sums, const StressOfState& of_state) {
  const ParticleStress stress(particles, of_state);
  const FieldColumns<1> volume(particles, Field::reference_volume), ratio(particles, Field::volume_ratio);
  const double v = constant_of(bounds, bounds.volume), t = constant_of(bounds, bounds.stress),
               j = constant_of(bounds, bounds.volume * bounds.ratio);
  std::ranges::fill(sums, CellSums{});
  const LocalIndex n = particles.size();
  for (LocalIndex p = 0; p < n; p += n_lanes) {
    stress.prefetch_mean(p + prefetch_distance);
    volume.prefetch(p + prefetch_distance);
    ratio.prefetch(p + prefetch_distance);
    const Pack V = volume(p);
    const Pack terms[4] = {rounded(V, broadcast<Pack>(v)), rounded(V * stress.mean(p), broadcast<Pack>(t)),
                           rounded(V * ratio(p), broadcast<Pack>(j)), broadcast<Pack>(0.0)};
    alignas(64) Quad quads[n_lanes];
    store_quads(terms, quads, 1);
    const int size = static_cast<int>(std::min<LocalIndex>(n_lanes, n - p));
    for (int lane = 0; lane < size; ++lane)
      if (const LocalIndex group = groups[static_cast<std::size_t>(p + lane)]; group >= 0) {
        CellSums& cell = sums[static_cast<std::size_t>(group)];
        store_vector(cell, load_vector<Quad>(cell) + quads[lane]);
      }
  }
}

void take_means_of_stress(std::span<CellSums> sums) {
  for (CellSums& cell : sums)
    if (cell.volume > 0.0) {
      cell.stress /= cell.volume;
      cell.ratio /= cell.volume;
    }
}

void find_mean_dilation(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout,
                        const CellMap& map, const Node* nodes, const ParticleSet& particles, CellGroups groups,
                        const CellSumBounds& bounds, double dt, std::span<CellSums> sums) {
  find_all(grid, transfer, layout, map, nodes, particles, groups, bounds, dt, sums);
}

void find_mean_dilation(const GridGeometry& grid, const TransferSettings& transfer, const PoolLayout& layout,
                        const CellMap& map, const NodePair* nodes, const ParticleSet& particles, CellGroups groups,
                        const CellSumBounds& bounds, double dt, std::span<CellSums> sums) {
  find_all(grid, transfer, layout, map, nodes, particles, groups, bounds, dt, sums);
}

}  // namespace bulkley
