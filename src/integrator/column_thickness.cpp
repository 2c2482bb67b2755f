#include "integrator/column_thickness.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace bulkley {

namespace {

constexpr double units_per_cell = 0x1p40;

int cell_of(const GridGeometry& grid, int axis, double coordinate) {
  const double cell = std::floor((coordinate - grid.lower[axis]) * grid.inverse_cell_size());
  return std::clamp(static_cast<int>(cell), 0, grid.n_cells[static_cast<std::size_t>(axis)] - 1);
}

}  // namespace

double thickness_decile(const Comm& comm, const GridGeometry& grid, const Vec3& gravity, const ParticleSet& particles,
                        const Vec3& lower, const Vec3& upper) {
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  int along = 0;
  if (!(gravity.cwiseAbs().maxCoeff(&along) > 0.0)) return unknown;
  const int a = (along + 1) % 3, b = (along + 2) % 3;
  const int first_a = cell_of(grid, a, lower[a]), first_b = cell_of(grid, b, lower[b]);
  const int n_a = cell_of(grid, a, upper[a]) - first_a + 1, n_b = cell_of(grid, b, upper[b]) - first_b + 1;
  std::vector<GlobalIndex> columns(static_cast<std::size_t>(n_a) * static_cast<std::size_t>(n_b), 0);
  const double scale = units_per_cell * std::pow(grid.inverse_cell_size(), 3);
  const double *const at_a = particles.real(Field::position, a), *const at_b = particles.real(Field::position, b);
  const double* const volume = particles.real(Field::reference_volume);
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    const int i = cell_of(grid, a, at_a[p]) - first_a;
    const int j = cell_of(grid, b, at_b[p]) - first_b;
    columns[static_cast<std::size_t>(i) * static_cast<std::size_t>(n_b) + static_cast<std::size_t>(j)] +=
        static_cast<GlobalIndex>(std::nearbyint(scale * volume[p]));
  }
  BULKLEY_MPI(MPI_Reduce(comm.is_root() ? MPI_IN_PLACE : columns.data(), columns.data(), static_cast<int>(columns.size()),
                         MPI_INT64_T, MPI_SUM, 0, comm.get()));
  if (!comm.is_root()) return unknown;
  std::erase(columns, 0);
  std::sort(columns.begin(), columns.end());
  GlobalIndex total = 0, below = 0;
  for (const GlobalIndex column : columns) total += column;
  for (const GlobalIndex column : columns)
    if ((below += column) >= total / 10) return static_cast<double>(column) / units_per_cell;
  return unknown;
}

}  // namespace bulkley
