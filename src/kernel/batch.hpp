#pragma once
// Shared by the kernels over particles. In p2g and g2p these are processed in batches, first lane-parallel (one pack a time: weights and per-particle
// algebra), then particle by particle with one 4-wide vector {x, y, z, mass} per node.

#include <cmath>
#include <cstring>
#include <type_traits>

#include "bulkley/base/pack.hpp"
#include "kernel/bspline.hpp"
#include "kernel/cells.hpp"

namespace bulkley {

/// The numbers of a NodePair. Sums of both halves cost no more instructions than one where vectors have 64 bytes. Where they do
/// not, GCC keeps a vector of that size in memory, and p2g takes fourteen times as long.
#if defined(__AVX512F__)
using Oct [[gnu::vector_size(64)]] = double;
#else
struct Oct {
  Quad low, high;

  friend Oct operator+(Oct a, Oct b) { return {a.low + b.low, a.high + b.high}; }
  friend Oct operator-(Oct a, Oct b) { return {a.low - b.low, a.high - b.high}; }
  friend Oct operator-(Oct a) { return {-a.low, -a.high}; }
  friend Oct operator*(double factor, Oct a) { return {factor * a.low, factor * a.high}; }
  Oct& operator+=(Oct b) { return *this = *this + b; }
};
#endif

/// The vector that holds a node, and how many quads that is.
template <class NodeType>
struct VectorOf;
template <>
struct VectorOf<Node> {
  using type = Quad;
};
template <>
struct VectorOf<NodePair> {
  using type = Oct;
};
template <class Vector>
inline constexpr int quads_in = sizeof(Vector) / sizeof(Quad);

/// The numbers of `source` from its quad `first_quad` on, as many as the vector holds.
template <class Vector = Quad, int first_quad = 0, class Source>
inline Vector load_vector(const Source& source) {
  static_assert(sizeof(Source) >= sizeof(Vector) + first_quad * sizeof(Quad));
  if constexpr (std::is_class_v<Vector>) {
    return {load_vector<Quad, first_quad>(source), load_vector<Quad, first_quad + 1>(source)};
  } else {
    Vector vector;
    std::memcpy(&vector, reinterpret_cast<const char*>(&source) + first_quad * sizeof(Quad), sizeof vector);
    return vector;
  }
}
template <int first_quad = 0, class Vector, class Target>
inline void store_vector(Target& target, const Vector& vector) {
  static_assert(sizeof(Target) >= sizeof(Vector) + first_quad * sizeof(Quad));
  if constexpr (std::is_class_v<Vector>) {
    store_vector<first_quad>(target, vector.low);
    store_vector<first_quad + 1>(target, vector.high);
  } else {
    std::memcpy(reinterpret_cast<char*>(&target) + first_quad * sizeof(Quad), &vector, sizeof vector);
  }
}

/// Particles a batch: one cache line of every column. Larger batches push the nodes and the columns to come out of the
/// first-level cache.
inline constexpr int batch_size = 8;
static_assert(batch_size % n_lanes == 0 && batch_size <= ParticleSet::padding);

/// How far ahead of the particle at work columns are fetched; the hardware follows fewer streams than there are columns.
inline constexpr LocalIndex prefetch_distance = 2 * batch_size;

/// The columns of one field, read a pack at a time.
template <int n, class Number = const double>
struct FieldColumns {
  Number* column[n];

  template <class Particles>
  FieldColumns(Particles& particles, Field field) {
    for (int c = 0; c < n; ++c) column[c] = particles.real(field, c);
  }
  Pack operator()(LocalIndex p, int c = 0) const { return load(column[c] + p); }
  void store(LocalIndex p, Pack value, int c = 0) const { bulkley::store(column[c] + p, value); }
  /// Asks for the values of the batch that holds particle `p`, which may lie past the end.
  void prefetch(LocalIndex p) const {
    for (int c = 0; c < n; ++c) __builtin_prefetch(column[c] + p);
  }
};
template <int n>
using MutableColumns = FieldColumns<n, double>;

/// A number of its material for each of n_lanes particles from `p` on; lanes past the end have that of any. `values` must outlive this.
class MaterialColumn {
 public:
  MaterialColumn(const ByMaterial& values, const ParticleSet& particles)
      : values_(values.data()), uniform_(values.uniform()), material_(particles.material()) {}

  Pack operator()(LocalIndex p) const {
    if (uniform_) return broadcast<Pack>(values_[0]);
    Pack result;
    for (int lane = 0; lane < n_lanes; ++lane) result[lane] = values_[material_[p + lane]];
    return result;
  }
  /// Of one particle.
  double one(LocalIndex p) const { return values_[material_[p]]; }

 private:
  const double* values_;
  bool uniform_;
  const std::uint8_t* material_;
};

/// ParticleSet::mass, a pack at a time; lanes past the end have none.
class MassColumn {
 public:
  explicit MassColumn(const ParticleSet& particles)
      : density_(particles.densities(), particles), volume_(particles, Field::reference_volume) {}
  Pack operator()(LocalIndex p) const { return density_(p) * volume_(p); }
  /// The reference volume of n_lanes particles.
  Pack volume(LocalIndex p) const { return volume_(p); }
  void prefetch(LocalIndex p) const { volume_.prefetch(p); }

 private:
  MaterialColumn density_;
  FieldColumns<1> volume_;
};

/// {0, 1, ..., n_lanes - 1}.
inline PackMask lane_numbers() {
  PackMask lane{};
  for (int i = 0; i < n_lanes; ++i) lane[i] = i;
  return lane;
}

/// Lanes that hold a particle of this material; lanes from the `n_left`th on hold none. `lane`: lane_numbers.
inline PackMask lanes_of_material(const std::uint8_t* material, std::uint8_t index, PackMask lane, LocalIndex n_left) {
  using Bytes [[gnu::vector_size(n_lanes)]] = std::uint8_t;
  Bytes bytes;
  std::memcpy(&bytes, material, sizeof bytes);
  return (__builtin_convertvector(bytes, PackMask) == index) & (lane < n_left);
}

/// Forces a product to be rounded, so that the compiler cannot fuse it into a following sum: base nodes must come out here
/// exactly as GridGeometry::base_node gives them.
inline void keep_rounded(Pack& value) {
#if defined(__AVX__)
  asm("" : "+x"(value));
#else
  asm("" : "+m"(value));
#endif
}

/// What kernels need of the grid's geometry, ready for use.
struct CellFrame {
  double lower[3];
  double inverse_cell_size;
  double base_shift;
  double node_offset[3];
  double period[3];  ///< cells along a periodic axis, else 0

  explicit CellFrame(const GridGeometry& grid) : inverse_cell_size(grid.inverse_cell_size()), base_shift(grid.base_shift()) {
    for (int a = 0; a < 3; ++a) {
      lower[a] = grid.lower[a];
      node_offset[a] = grid.node_offset(a);
      period[a] = grid.periodic[a] ? grid.n_cells[a] : 0.0;
    }
  }

  /// Coordinates along one axis, in cells from the lower face.
  Pack cell_coordinate(int axis, Pack coordinate) const {
    Pack xi = (coordinate - lower[axis]) * inverse_cell_size;
    keep_rounded(xi);
    return xi;
  }
  /// Distance of each particle above its base node, in cells, along one axis.
  Pack offset_in_stencil(int axis, Pack coordinate) const {
    const Pack xi = cell_coordinate(axis, coordinate);
    return xi - round_down(xi - base_shift);
  }
  /// GridGeometry::base_node of each particle.
  Pack base_node(int axis, Pack coordinate) const {
    Pack base = round_down(cell_coordinate(axis, coordinate) - base_shift) + node_offset[axis];
    if (period[axis] > 0.0) {
      base = select(base < broadcast<Pack>(0.0), base + period[axis], base);
      base = select(base >= broadcast<Pack>(period[axis]), base - period[axis], base);
    }
    return base;
  }
};

/// The nodes of one particle's stencil: `rows(i, j)` points to node (i, j, 0); nodes (i, j, 1), ... follow it.
template <SplineOrder order, class NodeType>
class StencilRows {
 public:
  StencilRows(const LocalIndex* row_offsets, LocalIndex cell, NodeType* pool) {
    constexpr unsigned w = footprint_width(order), t = tile_width;
    const auto c = static_cast<unsigned>(cell);
    offsets_ = row_offsets + std::size_t{c / tile_nodes} * (w * w) + (c / (t * t) % t) * w + c / t % t;
    first_ = pool + c % t;
  }
  NodeType* operator()(int i, int j) const {
    NodeType* row = first_ + offsets_[i * footprint_width(order) + j];
    asm("" : "+r"(row));  // computed once, not again for each of its nodes
    return row;
  }

 private:
  const LocalIndex* offsets_;
  NodeType* first_;
};

/// Transposes four rows of n_lanes numbers into n_lanes quads, `stride` apart: quad p is {row[0][p], ..., row[3][p]}.
inline void store_quads(const Pack (&row)[4], Quad* to, std::ptrdiff_t stride) {
  transpose_rows(row, [&](int p, Quad quad) { to[p * stride] = quad; });
}

/// The same of eight rows into octs, written at once: a load of 64 bytes waits long for two stores of 32.
inline void store_octs(const Pack (&low)[4], const Pack (&high)[4], Quad* to, std::ptrdiff_t stride) {
#if defined(__AVX512F__)
  const Pack rows[8] = {low[0], low[1], low[2], low[3], high[0], high[1], high[2], high[3]};
  Pack pairs[2][4];  // of particles 0 2 4 6 and 1 3 5 7, two rows in each
  for (int k = 0; k < 4; ++k) {
    pairs[0][k] = __builtin_shufflevector(rows[2 * k], rows[2 * k + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    pairs[1][k] = __builtin_shufflevector(rows[2 * k], rows[2 * k + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
  for (int odd = 0; odd < 2; ++odd) {
    const Pack(&x)[4] = pairs[odd];
    const Pack a = __builtin_shufflevector(x[0], x[1], 0, 1, 8, 9, 4, 5, 12, 13);
    const Pack b = __builtin_shufflevector(x[0], x[1], 2, 3, 10, 11, 6, 7, 14, 15);
    const Pack c = __builtin_shufflevector(x[2], x[3], 0, 1, 8, 9, 4, 5, 12, 13);
    const Pack d = __builtin_shufflevector(x[2], x[3], 2, 3, 10, 11, 6, 7, 14, 15);
    const auto put = [&](int particle, Pack value) { std::memcpy(to + particle * stride, &value, sizeof value); };
    put(odd, __builtin_shufflevector(a, c, 0, 1, 2, 3, 8, 9, 10, 11));
    put(odd + 2, __builtin_shufflevector(b, d, 0, 1, 2, 3, 8, 9, 10, 11));
    put(odd + 4, __builtin_shufflevector(a, c, 4, 5, 6, 7, 12, 13, 14, 15));
    put(odd + 6, __builtin_shufflevector(b, d, 4, 5, 6, 7, 12, 13, 14, 15));
  }
#else
  store_quads(low, to, stride);
  store_quads(high, to + 1, stride);
#endif
}

/// The first `n` rows back: row[r][p] = component r of quad p.
template <int n>
inline void load_rows(const Quad* from, std::ptrdiff_t stride, Pack (&row)[n]) {
  Pack rows[4];
  transpose_quads([&](int p) { return from[p * stride]; }, rows);
  for (int r = 0; r < n; ++r) row[r] = rows[r];
}

/// The square of the norm of a vector.
template <int size>
inline Pack squares(const Pack (&values)[size]) {
  Pack sum = values[0] * values[0];
  for (int c = 1; c < size; ++c) sum += values[c] * values[c];
  return sum;
}

/// Merges the roots of the first `n` lanes of `squared` into `extreme`. Reads ids only where a lane may win.
inline void include_lanes(Extreme& extreme, Pack squared, const GlobalIndex* id, int n) {
  const double level = extreme.value * extreme.value * (1.0 - 1e-15);  // lets ties through: the smallest id must win them
  if (!any(squared >= level)) return;
  for (int lane = 0; lane < n; ++lane) extreme.include(std::sqrt(squared[lane]), id[lane]);
}

/// Calls `function` with the spline order as a compile-time constant.
template <class Function>
void with_order(SplineOrder order, Function function) {
  if (order == SplineOrder::quadratic)
    function(std::integral_constant<SplineOrder, SplineOrder::quadratic>{});
  else
    function(std::integral_constant<SplineOrder, SplineOrder::cubic>{});
}

}  // namespace bulkley
