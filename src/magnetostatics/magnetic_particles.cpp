#include "magnetostatics/magnetic_particles.hpp"

#include <algorithm>
#include <cmath>

#include "kernel/scalar_deposit.hpp"
#include "kernel/scalar_gather.hpp"

namespace bulkley {

namespace {

// The smallest m 2^k >= n with 4 < m <= 8, or n itself where that is small.
int divisible(int n) {
  int unit = 1;
  while (n > 2 * fewest_coarse_cells * unit) unit *= 2;
  return (n + unit - 1) / unit * unit;
}

std::vector<Magnetisation> given(const std::vector<std::optional<Magnetisation>>& magnetisations) {
  std::vector<Magnetisation> result;
  for (const auto& magnetisation : magnetisations)
    if (magnetisation) result.push_back(*magnetisation);
  return result;
}

}  // namespace

FieldLayout magnetic_layout(const GridGeometry& grid, const Vec3& lower, const Vec3& upper, double air) {
  FieldLayout layout;
  layout.geometry = grid;
  const double room = air * (upper - lower).maxCoeff();
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (grid.periodic[a]) continue;
    const double first = grid.node_coordinate(axis, 0), last = grid.node_coordinate(axis, grid.n_nodes(axis) - 1);
    const auto layers = [&](double lacking) {
      return std::max(0, static_cast<int>(std::ceil(lacking * grid.inverse_cell_size() - 1e-9)));
    };
    layout.below[a] = layers(first - (lower[axis] - room));
    layout.above[a] = layers(upper[axis] + room - last);
    const int n_cells = layout.n_nodes(axis) - 1, more = divisible(n_cells) - n_cells;
    layout.below[a] += more / 2;
    layout.above[a] += more - more / 2;
  }
  return layout;
}

MagneticParticles::MagneticParticles(const Comm& comm, const FieldLayout& layout, const MagneticsSettings& settings,
                                     const Vec3& origin, const std::vector<std::optional<Magnetisation>>& magnetisations,
                                     const AppliedField& applied)
    : field_(comm, layout, settings, origin, given(magnetisations), applied) {
  int n = 0;
  for (const auto& magnetisation : magnetisations) magnet_of_.push_back(magnetisation ? n++ : -1);
}

MagneticReport MagneticParticles::solve(double time, ParticleGrid& particles) {
  if (fitted_ != particles.version()) {
    scatter_ = std::make_unique<TileScatter>(particles.comm(), particles.exchange(), field_.grid());
    fitted_ = particles.version();
  }
  const ParticleSet& set = particles.particles();
  const auto n = static_cast<std::size_t>(set.size());
  const double* const reference = set.real(Field::reference_volume);
  const std::uint8_t* const material = set.material();
  const GridGeometry& grid = particles.grid();
  const double cell = grid.cell_size * grid.cell_size * grid.cell_size;
  const auto n_magnets = std::count_if(magnet_of_.begin(), magnet_of_.end(), [](int s) { return s >= 0; });
  pool_.resize(static_cast<std::size_t>(particles.layout().n_nodes()));
  owned_.resize(static_cast<std::size_t>(particles.exchange().n_owned()));

  std::vector<std::vector<double>> content(static_cast<std::size_t>(n_magnets), std::vector<double>(field_.grid().size()));
  volume_.resize(n);
  for (std::size_t s = 0; s < content.size(); ++s) {
    double largest = 0.0;
    for (std::size_t p = 0; p < n; ++p) {
      volume_[p] = magnet_of_[material[p]] == static_cast<int>(s) ? reference[p] / cell : 0.0;
      largest = std::max(largest, volume_[p]);
    }
    scalar_deposit(grid, particles.layout(), set, particles.map(), volume_.data(), max_global(particles.comm(), largest),
                   max_global(particles.comm(), GlobalIndex{particles.map().largest_count()}), pool_.data());
    particles.exchange().add(pool_.data(), owned_.data());
    scatter_->to_field(owned_.data(), content[s].data());
  }

  const MagneticReport report = field_.solve(time, std::move(content));
  if (report.solved) find_forces(particles);
  return report;
}

void MagneticParticles::find_forces(ParticleGrid& particles) {
  const ParticleSet& set = particles.particles();
  const auto n = static_cast<std::size_t>(set.size());
  const double* const reference = set.real(Field::reference_volume);
  const std::uint8_t* const material = set.material();
  strengths_.resize(n);
  for (auto& force : forces_) force.assign(n, 0.0);
  for (auto& gradient : gradient_) gradient.resize(n);
  strength_pool_.resize(pool_.size());
  to_pool(particles, field_.strength(), strength_pool_);
  GatheredValue strength{strength_pool_.data(), strengths_.data()};
  for (std::size_t s = 0; s < field_.n_materials(); ++s) {
    to_pool(particles, field_.energy_slope(s), pool_);
    scalar_gather(particles.grid(), particles.layout(), set, particles.map(), strength,
                  {pool_.data(), {gradient_[0].data(), gradient_[1].data(), gradient_[2].data()}});
    strength = {};
    for (std::size_t a = 0; a < 3; ++a)
      for (std::size_t p = 0; p < n; ++p)
        if (magnet_of_[material[p]] == static_cast<int>(s)) forces_[a][p] = reference[p] * gradient_[a][p];
  }
}

std::vector<double> MagneticParticles::gathered(ParticleGrid& particles, std::span<const double> field) {
  std::vector<double> values(static_cast<std::size_t>(particles.particles().size()));
  to_pool(particles, field, pool_);
  scalar_gather(particles.grid(), particles.layout(), particles.particles(), particles.map(), {pool_.data(), values.data()},
                {});
  return values;
}

void MagneticParticles::show(ParticleGrid& particles) {
  ParticleSet& set = particles.particles();
  if (!set.has(Field::magnetic_field) && !set.has(Field::magnetisation)) return;
  std::array<std::vector<double>, 3> field;
  for (int a = 0; a < 3; ++a) field[static_cast<std::size_t>(a)] = gathered(particles, field_.field_along(a));
  const std::vector<double> inner = gathered(particles, field_.inner_field()),
                            weight = gathered(particles, field_.indicator());
  const std::uint8_t* const material = set.material();
  for (std::size_t p = 0; p < weight.size(); ++p) {
    const Vec3 H = weight[p] > 0.0 ? Vec3(Vec3(field[0][p], field[1][p], field[2][p]) / weight[p]) : Vec3::Zero();
    if (set.has(Field::magnetic_field)) set.set_vector(Field::magnetic_field, static_cast<LocalIndex>(p), H);
    if (!set.has(Field::magnetisation)) continue;
    const int magnet = magnet_of_[material[p]];
    const bool magnetised = magnet >= 0 && H.norm() > 0.0;
    const double strength =
        magnetised ? field_.material(static_cast<std::size_t>(magnet)).at(inner[p] / weight[p]) / H.norm() : 0.0;
    set.set_vector(Field::magnetisation, static_cast<LocalIndex>(p), strength * H);
  }
}

void MagneticParticles::to_pool(ParticleGrid& particles, std::span<const double> field, std::vector<double>& pool) {
  scatter_->to_owned(field.data(), owned_.data());
  particles.exchange().get(owned_.data(), pool.data());
}

std::size_t MagneticParticles::memory() const {
  return field_.memory() + (pool_.capacity() + owned_.capacity() + 8 * volume_.capacity()) * sizeof(double);
}

}  // namespace bulkley
