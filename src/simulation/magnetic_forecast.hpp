#pragma once
// What a scene's magnetic field will need and do, estimated from the scene alone.

#include <optional>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace bulkley {

/// A magnetic body in the field of the sources alone, where that is strongest in it over the run.
struct MagneticBodyForecast {
  std::string name;
  double applied = 0.0;        ///< |H_0|, A/m
  double magnetisation = 0.0;  ///< M as that of a ball there: H + M/3 = H_0, A/m
  double traction = 0.0;       ///< mu_0 M^2/2, Pa: the pull on its surface
};

struct MagneticForecast {
  Int3 n_nodes{0, 0, 0}, coarsest{0, 0, 0};  ///< of the field's box, and of its coarsest level
  int n_levels = 0;
  double bytes_per_rank = 0.0;       ///< of the field, on a rank with a share of its nodes
  GlobalIndex checkpoint_bytes = 0;  ///< of the potential
  GlobalIndex frame_bytes = 0;       ///< of output.magnetic_field, in one frame
  double solve_cost = 0.0;           ///< s on one rank
  double steps_a_solve = 0.0;        ///< at the largest speed, also sqrt(mu_0 M^2/rho), and the time step `dt`
  std::vector<MagneticBodyForecast> bodies;
  std::vector<std::string> warnings;
};

/// None without [magnetics]. `speed`: m/s, of the fastest body; `dt`: s. Needs the bodies' meshes. Not collective.
std::optional<MagneticForecast> magnetic_forecast(const Scene& scene, int n_ranks, double speed, double dt);

}  // namespace bulkley
