#include "integrator/diagnostics.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>

#include "kernel/bspline.hpp"
#include "kernel/stress_update.hpp"
#include "parallel/reproducible_sum.hpp"

namespace bulkley {

namespace {

enum Term {
  mass,
  momentum,
  angular = momentum + 3,
  kinetic = angular + 3,
  elastic,
  potential,
  dissipated,
  moment,
  flowing = moment + 3,
  fluid,
  reference,
  square_dilation,
  n_terms
};
using Terms = std::array<double, n_terms>;

Terms terms_of(const Physics& physics, const ParticleSet& set, LocalIndex p) {
  const double m = set.mass(p), volume = set.real(Field::reference_volume)[p];
  const Vec3 x = set.vector(Field::position, p), v = set.vector(Field::velocity, p);
  Vec3 spin = x.cross(v);
  double affine_square = 0.0;
  const double d = affine_inertia(physics.grid, physics.transfer);
  if (d > 0.0) {
    // B_p = C_p D_p; its axial part belongs to the angular momentum (Jiang et al. 2015).
    auto b = [&](int r, int c) { return d * set.real(Field::affine_velocity, 3 * r + c)[p]; };
    for (int c = 0; c < 9; ++c) affine_square += std::pow(set.real(Field::affine_velocity, c)[p], 2);
    spin += Vec3(b(2, 1) - b(1, 2), b(0, 2) - b(2, 0), b(1, 0) - b(0, 1));
  }
  const bool fluid_like = bulkley::flows(physics.materials[set.material()[p]].material);
  Terms t{};
  t[mass] = m;
  for (int a = 0; a < 3; ++a) {
    t[momentum + a] = m * v[a];
    t[angular + a] = m * spin[a];
    t[moment + a] = m * x[a];
  }
  t[kinetic] = 0.5 * m * (v.squaredNorm() + d * affine_square);
  t[elastic] = elastic_energy(physics, set, p);
  t[potential] = -m * physics.gravity.dot(x);
  t[dissipated] = volume * set.real(Field::plastic_dissipation)[p];
  t[fluid] = fluid_like ? m : 0.0;
  t[reference] = volume;
  t[square_dilation] = volume * std::pow(set.real(Field::volume_ratio)[p] - 1.0, 2);
  t[flowing] = fluid_like && set.real(Field::plastic_shear_rate)[p] > 0.0 ? m : 0.0;
  return t;
}

}  // namespace

double elastic_energy(const Physics& physics, const ParticleSet& particles, LocalIndex p) {
  const std::uint8_t m = particles.material()[p];
  double density = std::visit([&](const auto& law) { return law.energy_density(particle_state(law, particles, p)); },
                              physics.materials[m].material);
  const VolumetricLaws& laws = physics.volumetric_laws;
  if (!laws.empty() && laws[m]) {
    const double stress = particles.real(Field::cell_mean_stress)[p];
    density += stress * stress / (2.0 * laws[m]->bulk_modulus);
  }
  return particles.real(Field::reference_volume)[p] * density;
}

double affine_inertia(const GridGeometry& grid, const TransferSettings& transfer) {
  return transfer.affine() ? grid.cell_size * grid.cell_size / inverse_second_moment(grid.order) : 0.0;
}

Diagnostics diagnose(const Comm& comm, const Physics& physics, const ParticleSet& particles) {
  const LocalIndex n = particles.size();
  std::vector<double> terms;  // a row a particle
  terms.reserve(static_cast<std::size_t>(n) * n_terms);
  // Maxima of |term|, then of +-position, in one reduction.
  std::array<double, n_terms + 6> largest;
  largest.fill(0.0);
  std::fill(largest.begin() + n_terms, largest.end(), -std::numeric_limits<double>::infinity());
  for (LocalIndex p = 0; p < n; ++p) {
    const Terms row = terms_of(physics, particles, p);
    terms.insert(terms.end(), row.begin(), row.end());
    for (int k = 0; k < n_terms; ++k) largest[k] = std::max(largest[k], std::abs(row[k]));
    for (int a = 0; a < 3; ++a) {
      const double x = particles.real(Field::position, a)[p];
      largest[n_terms + a] = std::max(largest[n_terms + a], x);
      largest[n_terms + 3 + a] = std::max(largest[n_terms + 3 + a], -x);
    }
  }
  BULKLEY_MPI(
      MPI_Allreduce(MPI_IN_PLACE, largest.data(), static_cast<int>(largest.size()), MPI_DOUBLE, MPI_MAX, comm.get()));
  const GlobalIndex n_global = sum_global(comm, n);

  const std::vector<double> sums = sums_within(comm, terms, {largest.data(), n_terms}, n_global);
  auto sum = [&](int k) { return sums[static_cast<std::size_t>(k)]; };
  auto vector = [&](int k) { return Vec3(sum(k), sum(k + 1), sum(k + 2)); };
  Diagnostics d;
  d.n_particles = n_global;
  d.mass = sum(mass);
  d.momentum = vector(momentum);
  d.angular_momentum = vector(angular);
  d.kinetic_energy = sum(kinetic);
  d.elastic_energy = sum(elastic);
  d.gravitational_energy = sum(potential);
  d.dissipated_energy = sum(dissipated);
  if (d.mass > 0.0) d.center_of_mass = vector(moment) / d.mass;
  if (sum(fluid) > 0.0) d.yielded_fraction = sum(flowing) / sum(fluid);
  if (sum(reference) > 0.0) d.volume_error = std::sqrt(sum(square_dilation) / sum(reference));
  if (n_global > 0)
    for (int a = 0; a < 3; ++a) {
      d.upper[a] = largest[n_terms + a];
      d.lower[a] = -largest[n_terms + 3 + a];
    }
  return d;
}

}  // namespace bulkley
