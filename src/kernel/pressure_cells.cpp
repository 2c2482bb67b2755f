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

// A row of B along z is {F_x Z_0, F_y Z_1, F_z Z_2} with F of its x and y and Z of the node: of the splines and their
// derivatives, or in the MLS form of the splines and the distances from the particle over their second moment.
template <SplineOrder order, GradientForm form>
void add_row(const GridGeometry& grid, const Vec3& position, double volume, Node* gradient) {
  constexpr int s = stencil_width(order);
  constexpr bool mls = form == GradientForm::mls;
  double w[3][s], d[3][s];
  const double inverse = grid.inverse_cell_size();
  for (int a = 0; a < 3; ++a) {
    const double xi = (position[a] - grid.lower[a]) * inverse;
    const double fx = xi - std::floor(xi - grid.base_shift());
    spline_weights<order>(fx, w[a]);
    if (mls)
      for (int k = 0; k < s; ++k) d[a][k] = w[a][k] * (k - fx);
    else
      spline_derivatives<order>(fx, d[a]);
  }
  const double scale = volume * inverse * (mls ? inverse_second_moment(order) : 1.0);
  Quad along_z[s];
  for (int k = 0; k < s; ++k) along_z[k] = Quad{w[2][k], w[2][k], d[2][k], 0.0};
  for (int i = 0; i < s; ++i) {
    const double W = scale * w[0][i], D = scale * d[0][i];
    for (int j = 0; j < s; ++j, gradient += s) {
      const Quad row{D * w[1][j], W * d[1][j], W * w[1][j], 0.0};
      for (int k = 0; k < s; ++k) store_vector(gradient[k], load_vector(gradient[k]) + row * along_z[k]);
    }
  }
}

template <SplineOrder order, GradientForm form>
void fill(const GridGeometry& grid, const VolumetricLaws& laws, const ParticleSet& particles,
          std::span<const LocalIndex> members, PressureCell& cell, Node* gradient) {
  const std::uint8_t* const material = particles.material();
  const double* const V = particles.real(Field::reference_volume);
  const double* const ratio = particles.real(Field::volume_ratio);
  const double* const last = particles.real(Field::cell_mean_stress);
  const double* const x[3] = {particles.real(Field::position, 0), particles.real(Field::position, 1),
                              particles.real(Field::position, 2)};
  constexpr int s = stencil_width(order);
  std::fill_n(gradient, s * s * s, Node{});
  cell = {};
  cell.parts = true;
  double start = 0.0;
  for (const LocalIndex p : members) {
    const VolumetricLaw& law = *laws[material[p]];
    const double J = ratio[p], compliance = V[p] / law.slope(J);
    cell.volume += V[p];
    cell.mass += particles.densities()[material[p]] * V[p];
    cell.compliance += compliance;
    cell.target += compliance * law.stress(J);
    cell.parts = cell.parts && !law.tension;
    start += V[p] * last[p];
    if (last[p] == 0.0) cell.parted_volume += V[p];
    add_row<order, form>(grid, {x[0][p], x[1][p], x[2][p]}, V[p] * J, gradient);
  }
  cell.start = start / cell.volume;
}

}  // namespace

void fill_cell(const GridGeometry& grid, GradientForm form, const VolumetricLaws& laws, const ParticleSet& particles,
               std::span<const LocalIndex> members, PressureCell& cell, Node* gradient) {
  with_order(grid.order, [&](auto order) {
    if (form == GradientForm::mls)
      fill<order(), GradientForm::mls>(grid, laws, particles, members, cell, gradient);
    else
      fill<order(), GradientForm::bspline>(grid, laws, particles, members, cell, gradient);
  });
}

void PressureRows::resize(LocalIndex n) {
  const auto n_cells = static_cast<std::size_t>(n);
  renew(first, n_cells * static_cast<std::size_t>(n_rows()));
  renew(gradient, n_cells * static_cast<std::size_t>(n_stencil()));
  renew(rounded, 3 * gradient.size() + 1);
}

void PressureRows::round(LocalIndex cell) {
  const auto n = static_cast<std::size_t>(n_stencil()), begin = static_cast<std::size_t>(cell) * n;
  for (std::size_t k = begin; k < begin + n; ++k)
    for (std::size_t a = 0; a < 3; ++a) rounded[3 * k + a] = static_cast<float>(gradient[k].c[a]);
}

namespace {

// Cells by which rows are fetched before they are needed: they come in order, but a page at a time, and each is read once.
constexpr std::size_t cells_ahead = 16;

// The entries of consecutive nodes, each {x, y, z, undefined}.
struct Exact {
  const Node* at;
  static constexpr std::size_t bytes = sizeof(Node);
  Quad operator[](int k) const { return load_vector(at[k]); }
  Exact operator+(std::size_t n) const { return {at + n}; }
};
struct Rounded {
  const float* at;
  static constexpr std::size_t bytes = 3 * sizeof(float);
  Quad operator[](int k) const {
#if defined(__AVX__)
    return _mm256_cvtps_pd(_mm_loadu_ps(at + 3 * k));  // of which GCC 12 makes two conversions otherwise
#else
    using Short [[gnu::vector_size(16)]] = float;
    Short vector;
    std::memcpy(&vector, at + 3 * k, sizeof vector);
    return __builtin_convertvector(vector, Quad);
#endif
  }
  Rounded operator+(std::size_t n) const { return {at + 3 * n}; }
};

template <int n_stencil, class Entries>
inline void fetch_ahead(const Entries& gradient) {
  const auto* const begin = reinterpret_cast<const char*>((gradient + cells_ahead * n_stencil).at);
  for (std::size_t byte = 0; byte < n_stencil * Entries::bytes; byte += 64) __builtin_prefetch(begin + byte);
}

template <int width, class Entries>
void add_all(const PressureRows& rows, Entries gradient, LocalIndex begin, LocalIndex end, const double* pressure,
             Node* sums) {
  constexpr std::size_t n_rows = width * width;
  const LocalIndex* first = rows.first.data() + static_cast<std::size_t>(begin) * n_rows;
  gradient = gradient + static_cast<std::size_t>(begin) * (n_rows * width);
  for (LocalIndex c = begin; c < end; ++c) {
    const double p = pressure[c];
    fetch_ahead<width * width * width>(gradient);
#pragma GCC unroll 16
    for (int r = 0; r < width * width; ++r, ++first, gradient = gradient + width) {
      Node* const sum = sums + *first;
#pragma GCC unroll 4
      for (int k = 0; k < width; ++k) store_vector(sum[k], load_vector(sum[k]) + gradient[k] * p);
    }
  }
}

template <int width, class Entries>
void find_rates(const PressureRows& rows, Entries begin, std::span<const LocalIndex> cells, const Node* velocity,
                double* rates) {
  constexpr int n_rows = width * width;
  for (const LocalIndex c : cells) {
    const LocalIndex* const first = rows.first.data() + static_cast<std::size_t>(c) * n_rows;
    const Entries gradient = begin + static_cast<std::size_t>(c) * (n_rows * width);
    fetch_ahead<width * width * width>(gradient);
    Quad sums[width] = {};  // one for each place in a row, so that none waits for another
#pragma GCC unroll 16
    for (int r = 0; r < n_rows; ++r) {
      const Node* const v = velocity + first[r];
#pragma GCC unroll 4
      for (int k = 0; k < width; ++k) sums[k] += gradient[r * width + k] * load_vector(v[k]);
    }
    Quad sum = sums[0] + sums[1];
    for (int k = 2; k < width; ++k) sum += sums[k];
    rates[c] = sum[0] + sum[1] + sum[2];
  }
}

// Calls with the width of stencils as a constant, and with the entries of the first cell.
template <class Work>
void with_entries(const PressureRows& rows, RowEntries entries, Work work) {
  const auto with_width = [&](auto width) {
    if (entries == RowEntries::exact)
      work(width, Exact{rows.gradient.data()});
    else
      work(width, Rounded{rows.rounded.data()});
  };
  if (rows.width == 3)
    with_width(std::integral_constant<int, 3>{});
  else
    with_width(std::integral_constant<int, 4>{});
}

}  // namespace

void add_gradients(const PressureRows& rows, RowEntries entries, LocalIndex begin, LocalIndex end, const double* pressure,
                   Node* sums) {
  with_entries(rows, entries, [&](auto width, auto gradient) {
    add_all<decltype(width)::value>(rows, gradient, begin, end, pressure, sums);
  });
}

void volume_rates(const PressureRows& rows, RowEntries entries, std::span<const LocalIndex> cells, const Node* velocity,
                  double* rates) {
  with_entries(rows, entries, [&](auto width, auto gradient) {
    find_rates<decltype(width)::value>(rows, gradient, cells, velocity, rates);
  });
}

double diagonal_of(const PressureRows& rows, LocalIndex cell, const Node* scales) {
  Quad sum{};
  const LocalIndex* const first =
      rows.first.data() + static_cast<std::size_t>(cell) * static_cast<std::size_t>(rows.n_rows());
  const Rounded gradient =
      Rounded{rows.rounded.data()} + static_cast<std::size_t>(cell) * static_cast<std::size_t>(rows.n_stencil());
  for (int r = 0; r < rows.n_rows(); ++r)
    for (int k = 0; k < rows.width; ++k) {
      const Quad B = gradient[r * rows.width + k];
      sum += load_vector(scales[first[r] + k]) * (B * B);
    }
  return sum[0] + sum[1] + sum[2];
}

void update_volumes(const VolumetricLaws& laws, const VolumeUpdate& update, std::span<const LocalIndex> members,
                    double pressure, bool parted, ParticleSet& particles) {
  double* const J = particles.real(Field::volume_ratio);
  double* const pressures = particles.real(Field::cell_mean_stress);
  const double* const V = particles.real(Field::reference_volume);
  const std::uint8_t* const material = particles.material();
  const auto carried = [&](LocalIndex p) { return update.carried && update.carried[p]; };
  for (const LocalIndex p : members) pressures[p] = pressure;
  if (!parted) {
    double dilation = 0.0, compliance = 0.0;
    for (const LocalIndex p : members) {
      dilation += V[p] * (J[p] - update.before[p]);
      if (!carried(p)) compliance += V[p] / laws[material[p]]->slope(update.before[p]);
    }
    if (compliance == 0.0) compliance = 1.0;      // all are carried
    const double stress = dilation / compliance;  // by which that of every particle grows
    for (const LocalIndex p : members) J[p] = update.before[p] + stress / laws[material[p]]->slope(update.before[p]);
  }
  for (const LocalIndex p : members)
    if (carried(p)) J[p] = update.before[p];
  if (parted || update.relaxation == 0.0) return;
  // Each material once, at its first particle.
  for (std::size_t first = 0; first < members.size(); ++first) {
    const std::uint8_t m = material[members[first]];
    const auto same = [&](LocalIndex p) { return material[p] == m && !carried(p); };
    if (!same(members[first]) || std::any_of(members.begin(), members.begin() + static_cast<std::ptrdiff_t>(first), same))
      continue;
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
