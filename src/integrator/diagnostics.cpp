#include "integrator/diagnostics.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <variant>
#include <vector>

#include "kernel/batch.hpp"
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

// The terms of so many particles stay in the second-level cache until they are summed.
constexpr int summed_at_once = 512;
using Terms = double[n_terms][summed_at_once];

// elastic_energy of `size` particles from `first` on, and of what fills their last pack.
void elastic_energies(const Physics& physics, const ParticleSet& particles, LocalIndex first, int size, double* energy) {
  const FieldColumns<1> volume(particles, Field::reference_volume);
  const std::uint8_t* const material = particles.material() + first;
  const PackMask lane = lane_numbers();
  for (std::size_t m = 0; m < physics.materials.size(); ++m) {
    const VolumetricLaws& laws = physics.volumetric_laws;
    const double* const stress = !laws.empty() && laws[m] ? particles.real(Field::cell_mean_stress) + first : nullptr;
    std::visit(
        [&](const auto& law) {
          const StateColumns states(law, particles);
          for (int i = 0; i < size; i += n_lanes) {
            const PackMask mine = lanes_of_material(material + i, static_cast<std::uint8_t>(m), lane, size - i);
            if (!any(mine)) continue;
            Pack density = law.energy_density(states.of(first + i, mine));
            if (stress) density += load(stress + i) * load(stress + i) / (2.0 * laws[m]->bulk_modulus);
            store(energy + i, select(mine, volume(first + i) * density, load(energy + i)));
          }
        },
        physics.materials[m].material);
  }
}

// What does not change from block to block.
struct Columns {
  MassColumn masses;
  FieldColumns<3> position, velocity;
  FieldColumns<9> affine;
  FieldColumns<1> ratio, dissipation, shear_rate;
  MaterialColumn flows;

  Columns(const ParticleSet& particles, const ByMaterial& whether_flows)
      : masses(particles),
        position(particles, Field::position),
        velocity(particles, Field::velocity),
        affine(particles, Field::affine_velocity),
        ratio(particles, Field::volume_ratio),
        dissipation(particles, Field::plastic_dissipation),
        shear_rate(particles, Field::plastic_shear_rate),
        flows(whether_flows, particles) {}
};

// All terms but the elastic energy, of n_lanes particles from `p` on, into place i. `inertia`: D of affine_inertia.
void find_terms(const Columns& of, LocalIndex p, int i, double inertia, const Vec3& gravity, Terms& terms) {
  const auto put = [&](int term, Pack value) { store(&terms[term][i], value); };
  const Pack m = of.masses(p), volume = of.masses.volume(p), zero{};
  Pack x[3], v[3], spin[3], affine_square = zero;
  for (int a = 0; a < 3; ++a) {
    x[a] = of.position(p, a);
    v[a] = of.velocity(p, a);
  }
  for (int a = 0; a < 3; ++a) {
    const int b = (a + 1) % 3, c = (a + 2) % 3;
    spin[a] = x[b] * v[c] - x[c] * v[b];
    // B_p = C_p D_p; its axial part belongs to the angular momentum (Jiang et al. 2015).
    if (inertia > 0.0) spin[a] += inertia * of.affine(p, 3 * c + b) - inertia * of.affine(p, 3 * b + c);
  }
  if (inertia > 0.0)
    for (int c = 0; c < 9; ++c) affine_square += of.affine(p, c) * of.affine(p, c);
  put(mass, m);
  for (int a = 0; a < 3; ++a) {
    put(momentum + a, m * v[a]);
    put(angular + a, m * spin[a]);
    put(moment + a, m * x[a]);
  }
  put(kinetic, 0.5 * m * ((v[0] * v[0] + v[1] * v[1] + v[2] * v[2]) + inertia * affine_square));
  put(potential, -m * (gravity[0] * x[0] + gravity[1] * x[1] + gravity[2] * x[2]));
  put(dissipated, volume * of.dissipation(p));
  put(reference, volume);
  const Pack dilation = of.ratio(p) - 1.0, fluid_like = m * of.flows(p);
  put(square_dilation, volume * (dilation * dilation));
  put(fluid, fluid_like);
  put(flowing, select(of.shear_rate(p) > zero, fluid_like, zero));
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

Diagnostics diagnose(const Comm& comm, const Physics& physics, const ParticleSet& particles) {
  std::vector<double> whether_flows;
  for (const NamedMaterial& named : physics.materials) whether_flows.push_back(flows(named.material) ? 1.0 : 0.0);
  const ByMaterial by_material(whether_flows);
  const Columns columns(particles, by_material);
  const double inertia = affine_inertia(physics.grid, physics.transfer);
  const LocalIndex n = particles.size();
  std::array<BinnedSum, n_terms> sums;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const PackMask lane = lane_numbers();
  Pack lower[3], upper[3];
  for (int a = 0; a < 3; ++a) {
    lower[a] = broadcast<Pack>(infinity);
    upper[a] = broadcast<Pack>(-infinity);
  }
  alignas(64) Terms terms = {};
  for (LocalIndex first = 0; first < n; first += summed_at_once) {
    const int size = static_cast<int>(std::min<LocalIndex>(summed_at_once, n - first));
    for (int i = 0; i < size; i += n_lanes) find_terms(columns, first + i, i, inertia, physics.gravity, terms);
    elastic_energies(physics, particles, first, size, terms[elastic]);
    for (std::size_t k = 0; k < n_terms; ++k) sums[k].add({terms[k], static_cast<std::size_t>(size)});
    for (int i = 0; i < size; i += n_lanes)
      for (int a = 0; a < 3; ++a) {
        const Pack x = columns.position(first + i, a);
        upper[a] = select((lane < size - i) & (x > upper[a]), x, upper[a]);
        lower[a] = select((lane < size - i) & (x < lower[a]), x, lower[a]);
      }
  }
  std::array<double, 6> furthest;  // of positions, then of their negatives
  for (std::size_t a = 0; a < 3; ++a) {
    furthest[a] = furthest[3 + a] = -infinity;
    for (int i = 0; i < n_lanes; ++i) {
      furthest[a] = std::max(furthest[a], upper[a][i]);
      furthest[3 + a] = std::max(furthest[3 + a], -lower[a][i]);
    }
  }
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, furthest.data(), static_cast<int>(furthest.size()), MPI_DOUBLE, MPI_MAX, comm.get()));
  merge_global(comm, sums);

  const auto sum = [&](int k) { return sums[static_cast<std::size_t>(k)].value(); };
  const auto vector = [&](int k) { return Vec3(sum(k), sum(k + 1), sum(k + 2)); };
  Diagnostics d;
  d.n_particles = sum_global(comm, GlobalIndex{n});
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
  if (d.n_particles > 0)
    for (int a = 0; a < 3; ++a) {
      d.upper[a] = furthest[static_cast<std::size_t>(a)];
      d.lower[a] = -furthest[static_cast<std::size_t>(a) + 3];
    }
  return d;
}

}  // namespace bulkley
