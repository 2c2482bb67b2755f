#pragma once
// What `bulkley bench` computes: a ball that is sheared and falls, as fast as a weakly compressible solver is used.

#include <string>

#include "scene/scene.hpp"

namespace bulkley {

/// One scene of the bench.
struct BenchCase {
  GlobalIndex n_particles = 1'000'000;  ///< about how many; at least smallest_ball
  std::string material = "cream";       ///< neo_hookean, or a preset
  TransferSettings transfer;
  Int3 domain{1, 1, 1};  ///< size of the domain, in boxes of the ball along each axis
  /// imex: with the true bulk modulus, bench_bulk_modulus; the motion stays that of the explicit case.
  IntegratorKind integrator = IntegratorKind::explicit_step;
  double mach_number = 0.25;    ///< speed of the fastest particle over the wave speed at rest
  double gravity = 9.81;        ///< m/s^2, down
  bool magnetic_field = false;  ///< uniform, 20 kA/m along x and 10 kA/m along z, on a material whose preset is magnetic
};

inline constexpr GlobalIndex smallest_ball = 11500;  ///< particles; smaller ones touch their box
inline constexpr double ball_radius = 31.0 / 80.0;   ///< of the edge of its box, which is 1 m
inline constexpr double bench_bulk_modulus = 2e9;    ///< Pa, of all materials with integrator imex

/// Cells along an edge of the ball's box.
int cells_along_box(const BenchCase& what);

/// Of the material at its own bulk modulus, which sets the speeds, m/s. Throws UsageError. Not collective.
double bench_wave_speed(const BenchCase& what);

/// The ball, eight particles a cell, in the middle of its box or of a larger domain, but for two cells at most. The fastest particle moves at
/// the case's Mach number: 0.98 of that speed is shear, at the rim, and 0.2 is fall. Throws UsageError. Not collective.
Scene bench_scene(const BenchCase& what);

/// Gives the ball its uniform shear, and the stress of a material that has been sheared so for a while if it flows.
/// Not collective.
void start_shear(const BenchCase& what, const Scene& scene, ParticleSet& particles);

/// Materials that a case may name, for messages. Not collective.
std::string bench_materials();

}  // namespace bulkley
