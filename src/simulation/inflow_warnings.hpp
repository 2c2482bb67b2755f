#pragma once
// Inflows that run but will not look as they should, predicted from the scene.

#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace bulkley {

/// A narrower section than this, in particles, is round or square only in name.
inline constexpr double fewest_feed_particles = 8.0;
/// An exit nearer than this to a wall, in cells, has nodes that feed and wall share nearly all of.
inline constexpr double nearest_feed_wall = 4.0;
/// A head so many times as fast as the material in its exit draws the bead so far that its layers share few nodes.
inline constexpr double largest_draw = 2.0;

/// At most one sentence of each kind for each inflow, of the first time at which it holds. `feeds`: of the scene, in its order. Not
/// collective.
std::vector<std::string> inflow_warnings(const Scene& scene, const std::vector<Feed>& feeds);

}  // namespace bulkley
