#pragma once
// Magnetic bodies in a grid, their field and its force, for tests.

#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include "magnetostatics/magnetic_particles.hpp"
#include "support/solver_run.hpp"

namespace bulkley {

inline constexpr double mu0 = vacuum_permeability;
inline constexpr double pi = std::numbers::pi;

inline Magnetisation linear(double susceptibility) { return {Magnetisation::Law::linear, susceptibility}; }

template <class Kind>
FieldSource source_of(Kind kind) {
  FieldSource source;
  source.kind = std::move(kind);
  return source;
}

// Bodies in a grid, with a field applied to them.
struct MagneticSetting {
  SolverScene scene;
  double air = 1.0;
  Vec3 lower = Vec3::Constant(INFINITY), upper = Vec3::Constant(-INFINITY);  // of the bodies
  MagneticsSettings settings;
  std::vector<std::optional<Magnetisation>> magnetisations{linear(1.0), {}};
  std::vector<FieldSource> sources;

  MagneticSetting(const Int3& n_cells, SplineOrder order = SplineOrder::quadratic,
                  const std::array<bool, 3>& periodic = {false, false, false})
      : scene(empty_scene({.order = order}, n_cells, periodic)) {
    settings.tolerance = 1e-6;
    apply({"1e5", "0", "0"});
  }

  double dx() const { return scene.physics.grid.cell_size; }
  Vec3 middle() const { return 0.5 * (scene.physics.grid.lower + scene.physics.grid.upper()); }
  void apply(const std::array<std::string, 3>& formulas) { sources = {source_of(FieldFormula{{formulas}})}; }

  // Eight particles a cell where `inside` says so, on a lattice whose planes are `offset` cells off those of the nodes.
  template <class Inside>
  void fill(const Vec3& offset, std::uint8_t material, Inside inside) {
    const GridGeometry& grid = scene.physics.grid;
    const double spacing = 0.5 * grid.cell_size;
    const Int3 n{2 * grid.n_cells[0], 2 * grid.n_cells[1], 2 * grid.n_cells[2]};
    for (int i = 0; i < n[0]; ++i)
      for (int j = 0; j < n[1]; ++j)
        for (int k = 0; k < n[2]; ++k) {
          Vec3 x = grid.lower + spacing * Vec3(i + 0.5, j + 0.5, k + 0.5) + grid.cell_size * offset;
          for (int a = 0; a < 3; ++a)
            if (x[a] > grid.upper()[a]) x[a] -= (grid.upper() - grid.lower)[a];
          if (!inside(x)) continue;
          add_particle(scene, x);
          scene.particles.material()[scene.particles.size() - 1] = material;
          scene.particles.id()[scene.particles.size() - 1] = scene.particles.size() - 1;
          lower = lower.cwiseMin(x);
          upper = upper.cwiseMax(x);
        }
  }
  void ball(const Vec3& centre, double diameter, const Vec3& offset = Vec3(0.11, 0.27, 0.18), std::uint8_t material = 0) {
    fill(offset, material, [&](const Vec3& x) { return (x - centre).norm() < 0.5 * diameter * dx(); });
  }
};

// What was found, the same on every rank.
struct MagneticFound {
  MagneticReport report;
  double energy = 0.0;
  Vec3 moment = Vec3::Zero(), force = Vec3::Zero();
  double volume = 0.0, mean_strength = 0.0;
  std::vector<double> potential;                              // by node of this rank
  std::map<GlobalIndex, std::array<double, 4>> at_particles;  // force and strength, by id: of this rank
  std::array<double, 3> virial{0.0, 0.0, 0.0};                // sums of F_a (x - middle)_a
};

inline MagneticFound find(const Comm& comm, const MagneticSetting& setting, bool scattered = true) {
  PhaseTimes times;
  const GridGeometry& grid = setting.scene.physics.grid;
  ParticleGrid particles(comm, grid, setting.scene.physics.faces, 2,
                         partition_of(comm, setting.scene, PartitionMethod::hilbert, scattered),
                         share_of(comm, setting.scene.particles, {}), times);
  const AppliedField applied(setting.sources);
  const Vec3 origin = 0.5 * (setting.lower + setting.upper);
  MagneticParticles magnets(comm, magnetic_layout(grid, setting.lower, setting.upper, setting.air), setting.settings, origin,
                            setting.magnetisations, applied);
  MagneticFound found;
  found.report = magnets.solve(0.0, particles);
  found.energy = magnets.field().co_energy();
  found.moment = magnets.field().moment();
  found.potential.assign(magnets.field().potential().begin(), magnets.field().potential().end());
  const ParticleSet& set = particles.particles();
  double sums[8] = {};
  for (LocalIndex p = 0; p < set.size(); ++p) {
    const auto i = static_cast<std::size_t>(p);
    found.at_particles[set.id()[p]] = {magnets.forces(0)[i], magnets.forces(1)[i], magnets.forces(2)[i],
                                       magnets.strengths()[i]};
    const Vec3 x = set.vector(Field::position, p) - setting.middle();
    for (int a = 0; a < 3; ++a) {
      sums[a] += magnets.forces(a)[i];
      sums[3 + a] += magnets.forces(a)[i] * x[a];
    }
    sums[6] += set.real(Field::reference_volume)[p];
    sums[7] += magnets.strengths()[i];
  }
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, sums, 8, MPI_DOUBLE, MPI_SUM, comm.get()));
  for (int a = 0; a < 3; ++a) {
    found.force[a] = sums[a];
    found.virial[static_cast<std::size_t>(a)] = sums[3 + a];
  }
  found.volume = sums[6];
  found.mean_strength = sums[7] / setting.scene.particles.size();
  return found;
}

}  // namespace bulkley
