#pragma once
// Films that the cells do not resolve, predicted from the scene.

#include <string>
#include <vector>

#include "scene/scene.hpp"
#include "simulation/forecast.hpp"

namespace bulkley {

/// Fewer cells than this across a film do not resolve it.
inline constexpr double fewest_film_cells = 4.0;

/// A sentence for each yield-stress fluid that gravity alone would spread on a floor to a film of fewer cells. `bodies`: of
/// the scene, in its order. A floor is the face that gravity is normal to, if it is a wall, or a plane as a collider; where
/// an obstacle may hold the fluid (a complement, difference or mesh), nothing is said. Not collective.
std::vector<std::string> film_warnings(const Scene& scene, const std::vector<BodyForecast>& bodies);

}  // namespace bulkley
