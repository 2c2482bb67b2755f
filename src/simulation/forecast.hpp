#pragma once
// What a scene will need, estimated from the scene alone: `bulkley check`.

#include <optional>
#include <string>
#include <vector>

#include "balance/partition.hpp"
#include "bulkley/parallel/comm.hpp"
#include "scene/scene.hpp"
#include "simulation/integrator_choice.hpp"
#include "simulation/magnetic_forecast.hpp"
#include "stepping/time_step.hpp"

namespace bulkley {

/// One body at the start of the run. Dimensionless numbers use the largest initial speed U of the body (sqrt(g L) where it
/// starts at rest) and its size L, the largest side of its bounds; NaN where a number has no meaning for the material.
/// A body, or an inflow: with the particles of the whole run, its largest speed and the section's size.
struct BodyForecast {
  std::string name;
  std::string material;
  std::size_t material_index = 0;
  GlobalIndex n_particles = 0;
  double mass = 0.0;        ///< kg
  double speed = 0.0;       ///< U, m/s
  bool at_rest = false;     ///< U is sqrt(g L)
  double size = 0.0;        ///< L, m
  double wave_speed = 0.0;  ///< c at rest, m/s
  double reynolds = 0.0;    ///< rho U^2 / (tau_y + K (U / L)^n)
  double bingham = 0.0;     ///< tau_y / (K (U / L)^n)
  double mach = 0.0;        ///< U / c
};

struct Forecast {
  std::vector<BodyForecast> bodies;  ///< those of the scene, then its inflows
  GlobalIndex n_particles = 0;       ///< at the end, where inflows add to those of the start
  int n_ranks = 1;
  PartitionMethod method = PartitionMethod::uniform;  ///< that divides the work at the start
  std::optional<Boxes> boxes;                         ///< of the grid's nodes, where there are any
  double imbalance = 1.0;                             ///< largest over mean particles per rank at the start
  GlobalIndex largest_share = 0;                      ///< particles of the most loaded rank
  double bytes_per_rank = 0.0;       ///< that the rank with most of them comes to occupy beyond the empty program
  double bytes_per_particle = 0.0;   ///< of all ranks together; NaN without particles
  GlobalIndex checkpoint_bytes = 0;  ///< of one
  GlobalIndex frame_bytes = 0;       ///< of one, without colliders and compression
  GlobalIndex n_frames = 0;
  TimeStepLimit limit{};                   ///< at the start
  double n_steps = 0.0;                    ///< end time over the step that the limits (or the user) allow at the start
  std::optional<IntegratorChoice> choice;  ///< none where the step is fixed
  std::optional<MagneticForecast> magnetic;
  std::vector<std::string> warnings;
};

/// Runs more steps than this are warned of.
inline constexpr double many_steps = 1e6;

/// Wave speed of the undeformed material (T25), m/s. Not collective.
double wave_speed_at_rest(const Material& material);

/// Nothing is run. What the partition decides (boxes, shares, memory) is known on the root alone. Collective.
Forecast forecast(const Comm& comm, const Scene& scene, int n_ranks);

}  // namespace bulkley
