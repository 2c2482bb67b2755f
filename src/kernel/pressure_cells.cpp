#include "kernel/pressure_cells.hpp"

#if defined(__AVX__)
#include <immintrin.h>
#endif

#include <algorithm>
#include <cmath>

#include "kernel/batch.hpp"

namespace bulkley {

void group_by_cell(const VolumetricLaws& laws, const ParticleSet& particles, std::span<const LocalIndex> cell_of,
                   std::span<const LocalIndex> number_of, LocalIndex n_cells, CellParticles& result) {
  const std::uint8_t* const material = particles.material();
  const GlobalIndex* const id = particles.id();
  const auto cell = [&](LocalIndex p) {
    return laws[material[p]] ? number_of[static_cast<std::size_t>(cell_of[static_cast<std::size_t>(p)])] : -1;
  };
  result.first.assign(static_cast<std::size_t>(n_cells) + 1, 0);
  LocalIndex* const first = result.first.data();
  for (LocalIndex p = 0; p < particles.size(); ++p)
    if (const LocalIndex c = cell(p); c >= 0) ++first[c + 1];
  for (LocalIndex c = 0; c < n_cells; ++c) first[c + 1] += first[c];
  std::vector<LocalIndex> end(result.first.begin(), result.first.end() - 1);  // of those that are in place
  result.particle.resize(static_cast<std::size_t>(first[n_cells]));
  LocalIndex* const member = result.particle.data();
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    const LocalIndex c = cell(p);
    if (c < 0) continue;
    LocalIndex at = end[static_cast<std::size_t>(c)]++;
    for (; at > first[c] && id[member[at - 1]] > id[p]; --at) member[at] = member[at - 1];
    member[at] = p;
  }
}

namespace {

struct Weights {
  double w[3][4], d[3][4];  // and their derivatives, 1/m
  double r[3][4];           // from the particle to the nodes, m
};

template <SplineOrder order>
Weights weights_of(const GridGeometry& grid, const Vec3& position) {
  constexpr int s = stencil_width(order);
  Weights weights;
  const double inverse = grid.inverse_cell_size();
  for (int a = 0; a < 3; ++a) {
    const double xi = (position[a] - grid.lower[a]) * inverse;
    const double fx = xi - std::floor(xi - grid.base_shift());
    double w[s], d[s];
    spline_weights<order>(fx, w);
    spline_derivatives<order>(fx, d);
    for (int k = 0; k < s; ++k) {
      weights.w[a][k] = w[k];
      weights.d[a][k] = d[k] * inverse;
      weights.r[a][k] = (k - fx) * grid.cell_size;
    }
  }
  return weights;
}

template <SplineOrder order, GradientForm form>
void add_row(const GridGeometry& grid, const Vec3& position, double volume, Node* gradient) {
  constexpr int s = stencil_width(order);
  const Weights at = weights_of<order>(grid, position);
  const double second = inverse_second_moment(order) / (grid.cell_size * grid.cell_size);
  for (int i = 0; i < s; ++i)
    for (int j = 0; j < s; ++j) {
      const double wx = volume * at.w[0][i], wy = at.w[1][j];
      // {x, y, z, 0} = flat w_z + steep d_z, or in the MLS form w {r_x, r_y, r_z} / D
      const double w = second * (wx * wy);
      const Quad flat = form == GradientForm::mls ? Quad{w * at.r[0][i], w * at.r[1][j], 0.0, 0.0}
                                                  : Quad{volume * at.d[0][i] * wy, wx * at.d[1][j], 0.0, 0.0};
      const Quad steep{0.0, 0.0, form == GradientForm::mls ? w : wx * wy, 0.0};
      for (int k = 0; k < s; ++k) {
        Node& node = gradient[(i * s + j) * s + k];
        const double dz = form == GradientForm::mls ? at.w[2][k] * at.r[2][k] : at.d[2][k];
        store_vector(node, load_vector(node) + (flat * at.w[2][k] + steep * dz));
      }
    }
}

}  // namespace

void fill_cell(const GridGeometry& grid, GradientForm form, const VolumetricLaws& laws, const ParticleSet& particles,
               std::span<const LocalIndex> members, PressureCell& cell, Node* gradient) {
  const int s = stencil_width(grid.order);
  std::fill_n(gradient, s * s * s, Node{});
  cell = {};
  cell.parts = true;
  double start = 0.0;
  for (const LocalIndex p : members) {
    const VolumetricLaw& law = *laws[particles.material()[p]];
    const double volume = particles.real(Field::reference_volume)[p], J = particles.real(Field::volume_ratio)[p];
    const double compliance = volume / law.slope(J);
    cell.volume += volume;
    cell.mass += particles.real(Field::mass)[p];
    cell.compliance += compliance;
    cell.target += compliance * law.stress(J);
    cell.parts = cell.parts && !law.tension;
    start += volume * particles.real(Field::cell_mean_stress)[p];
    with_order(grid.order, [&](auto order) {
      const Vec3 position = particles.vector(Field::position, p);
      if (form == GradientForm::mls)
        add_row<order(), GradientForm::mls>(grid, position, volume * J, gradient);
      else
        add_row<order(), GradientForm::bspline>(grid, position, volume * J, gradient);
    });
  }
  cell.start = start / cell.volume;
}

namespace {

inline Quad entry(const Node& node) { return load_vector(node); }
inline Quad entry(const ShortNode& node) {
#if defined(__AVX__)
  return _mm256_cvtps_pd(_mm_loadu_ps(node.c));  // of which GCC 12 makes two conversions otherwise
#else
  using Short [[gnu::vector_size(16)]] = float;
  Short vector;
  std::memcpy(&vector, node.c, sizeof vector);
  return __builtin_convertvector(vector, Quad);
#endif
}

template <int n, class Entry>
void add_all(const Entry* gradient, const LocalIndex* node, std::span<const double> pressure, Node* sums) {
  for (const double p : pressure) {
#pragma GCC unroll 64
    for (int a = 0; a < n; ++a) {
      Node& sum = sums[node[a]];
      store_vector(sum, load_vector(sum) + entry(gradient[a]) * p);
    }
    gradient += n;
    node += n;
  }
}

template <class Entry>
void add_all(const PressureRows& rows, const Entry* gradient, std::span<const double> pressure, Node* sums) {
  if (rows.n_stencil == 27)
    add_all<27>(gradient, rows.node.data(), pressure, sums);
  else
    add_all<64>(gradient, rows.node.data(), pressure, sums);
}

template <int n, class Entry>
double rate_of(const Entry* gradient, const LocalIndex* node, const Node* velocity) {
  Quad sum{};
#pragma GCC unroll 64
  for (int a = 0; a < n; ++a) sum += entry(gradient[a]) * load_vector(velocity[node[a]]);
  return sum[0] + sum[1] + sum[2];
}

template <class Entry>
double rate_of(const PressureRows& rows, const Entry* gradient, LocalIndex cell, const Node* velocity) {
  const std::size_t first = static_cast<std::size_t>(cell) * static_cast<std::size_t>(rows.n_stencil);
  const LocalIndex* const node = rows.node.data() + first;
  return rows.n_stencil == 27 ? rate_of<27>(gradient + first, node, velocity)
                              : rate_of<64>(gradient + first, node, velocity);
}

}  // namespace

void round_rows(PressureRows& rows) {
  rows.rounded.resize(rows.gradient.size());
  for (std::size_t k = 0; k < rows.gradient.size(); ++k)
    for (int a = 0; a < 4; ++a) rows.rounded[k].c[a] = static_cast<float>(rows.gradient[k].c[a]);
}

void add_gradients(const PressureRows& rows, std::span<const double> pressure, Node* sums) {
  add_all(rows, rows.gradient.data(), pressure, sums);
}
void add_rounded_gradients(const PressureRows& rows, std::span<const double> pressure, Node* sums) {
  add_all(rows, rows.rounded.data(), pressure, sums);
}

double volume_rate(const PressureRows& rows, LocalIndex cell, const Node* velocity) {
  return rate_of(rows, rows.gradient.data(), cell, velocity);
}
double rounded_volume_rate(const PressureRows& rows, LocalIndex cell, const Node* velocity) {
  return rate_of(rows, rows.rounded.data(), cell, velocity);
}

void update_volumes(const VolumetricLaws& laws, const VolumeUpdate& update, std::span<const LocalIndex> members,
                    double pressure, bool parted, ParticleSet& particles) {
  double* const J = particles.real(Field::volume_ratio);
  double* const pressures = particles.real(Field::cell_mean_stress);
  const double* const V = particles.real(Field::reference_volume);
  const std::uint8_t* const material = particles.material();
  for (const LocalIndex p : members) pressures[p] = pressure;
  if (!parted) {
    double dilation = 0.0, compliance = 0.0;
    for (const LocalIndex p : members) {
      dilation += V[p] * (J[p] - update.before[p]);
      compliance += V[p] / laws[material[p]]->slope(update.before[p]);
    }
    const double stress = dilation / compliance;  // by which that of every particle grows
    for (const LocalIndex p : members) J[p] = update.before[p] + stress / laws[material[p]]->slope(update.before[p]);
  }
  if (parted || update.relaxation == 0.0) return;
  // Each material once, at its first particle.
  for (std::size_t first = 0; first < members.size(); ++first) {
    const std::uint8_t m = material[members[first]];
    const auto same = [&](LocalIndex p) { return material[p] == m; };
    if (std::any_of(members.begin(), members.begin() + static_cast<std::ptrdiff_t>(first), same)) continue;
    double volume = 0.0, current = 0.0;
    for (const LocalIndex p : members.subspan(first))
      if (same(p)) {
        volume += V[p];
        current += V[p] * J[p];
      }
    const double mean = current / volume;
    for (const LocalIndex p : members.subspan(first))
      if (same(p)) J[p] += update.relaxation * (mean - J[p]);
  }
}

}  // namespace bulkley
