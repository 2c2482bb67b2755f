#pragma once
// The kernel that a textbook gives: the yardstick that the real step is timed against in the same run.
//
// APIC with the MLS form and quadratic splines in three dimensions, one particle after the other, all of a particle in one
// structure, a dense grid, no vector code, no sorting, no order-free sums. The law is the neo-Hookean one of the real code,
// with the deformation gradient F as its state.

#include <vector>

#include "bulkley/base/types.hpp"

namespace bulkley {

struct NaiveParticle {
  double x[3], v[3];
  double C[9], F[9];  ///< row-major
};

/// An elastic ball in a unit box with sticky walls, sheared (25 1/s) and falling (2 m/s) under gravity; E = 1e5 Pa,
/// nu = 0.3, 1000 kg/m^3, dt = a tenth of dx / c. By default 998 592 particles.
class NaiveKernel {
 public:
  /// `radius`: of the ball, m; at least 2 cells from the walls of the box. `particles_per_cell`: 1, 8, 27 or 64, on a
  /// lattice jittered by up to 0.4 of its spacing. Throws UsageError otherwise.
  explicit NaiveKernel(int n_cells = 80, double radius = 31.0 / 80.0, int particles_per_cell = 8);

  /// One step; returns the wall time it took, s.
  double step();

  GlobalIndex size() const { return static_cast<GlobalIndex>(particles_.size()); }
  const std::vector<NaiveParticle>& particles() const { return particles_; }
  double time_step() const { return dt_; }
  double particle_volume() const { return volume_; }
  double particle_mass() const { return mass_; }
  double bulk_modulus() const { return bulk_modulus_; }
  double shear_modulus() const { return shear_modulus_; }
  double gravity() const { return gravity_; }  ///< along -z, m/s^2

 private:
  struct GridNode {
    double v[3];  ///< momentum, then velocity
    double m;
  };
  void seed(double radius);
  void p2g();
  void grid_update();
  void g2p();
  GridNode& node(int i, int j, int k) { return grid_[(static_cast<std::size_t>(i) * n_ + j) * n_ + k]; }

  int n_;              ///< cells per axis, and nodes: the last cells stay empty
  int lattice_width_;  ///< k of k^3 particles per cell
  double dx_, inverse_dx_, dt_;
  double volume_, mass_, bulk_modulus_, shear_modulus_, gravity_;
  std::vector<NaiveParticle> particles_;  ///< in the order of their cells at the start
  std::vector<GridNode> grid_;            ///< n^3 nodes, z fastest
};

}  // namespace bulkley
