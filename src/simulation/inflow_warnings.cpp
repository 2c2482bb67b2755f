#include "simulation/inflow_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <variant>

#include "geometry/mesh_shape.hpp"

namespace bulkley {

namespace {

constexpr int n_looks = 1000;  // times at which a nozzle that moves is looked at

bool is_wall(const Scene& scene, const Vec3& x, double time) {
  for (int axis = 0; axis < 3; ++axis) {
    if (scene.grid.periodic[static_cast<std::size_t>(axis)]) continue;
    const std::size_t face = 2 * static_cast<std::size_t>(axis);
    if (x[axis] < scene.grid.lower[axis] && behaviour(scene.faces[face].kind).contact) return true;
    if (x[axis] > scene.grid.upper()[axis] && behaviour(scene.faces[face + 1].kind).contact) return true;
  }
  return std::ranges::any_of(scene.colliders, [&](const Collider& collider) {
    return signed_distance(collider.shape, collider.motion.pose(time), x) < 0.0;
  });
}

/// Cells from the exit to a wall in front of it, if that is too near.
std::optional<double> near_wall(const Scene& scene, const Feed& feed, double time) {
  const NozzleState nozzle = feed.at(time);
  const Vec3 exit = nozzle.position + nozzle.rotation * feed.middle();
  const auto is_wall_at = [&](double cells) {
    return is_wall(scene, exit + cells * scene.grid.cell_size * nozzle.axis, time);
  };
  double far = 0.25;
  while (far < nearest_feed_wall - 1e-9 && !is_wall_at(far)) far += 0.25;
  if (far >= nearest_feed_wall - 1e-9) return std::nullopt;
  for (double width = 0.125; width > 1e-3; width *= 0.5)
    if (is_wall_at(far - width)) far -= width;
  return far;
}

}  // namespace

std::vector<std::string> inflow_warnings(const Scene& scene, const std::vector<Feed>& feeds) {
  std::vector<std::string> warnings;
  for (const Feed& feed : feeds) {
    const Inflow& inflow = feed.inflow();
    const double width = narrowest_side(scene.grid, inflow) / (feed.layer_height() / inflow.volume_ratio);
    if (width < fewest_feed_particles * (1.0 - 1e-9))
      warnings.push_back(
          fmt::format("inflow '{}' is {:.2g} particles wide: with fewer than {:g} its section is coarse; more "
                      "particles_per_cell or smaller "
                      "cells refine it",
                      inflow.name, width, fewest_feed_particles));
    bool warned_of_wall = false, warned_of_draw = false;
    const double last = std::min(feed.end(), scene.time_stepping.end_time);
    for (int n = 0; n <= n_looks && last > feed.start(); ++n) {
      const double time = feed.start() + (last - feed.start()) * n / n_looks;
      const NozzleState nozzle = feed.at(time);
      const std::string when = time > 0.0 ? fmt::format(" at t = {:.3g} s", time) : std::string();
      if (const auto gap = warned_of_wall ? std::nullopt : near_wall(scene, feed, time)) {
        warned_of_wall = true;
        warnings.push_back(
            fmt::format("inflow '{}' has a wall {:.2g} cells in front of its exit{}; with fewer than {:g} the "
                        "wall slows down what leaves the exit",
                        inflow.name, *gap, when, nearest_feed_wall));
      }
      const double across = (nozzle.velocity - nozzle.velocity.dot(nozzle.axis) * nozzle.axis).norm();
      if (!warned_of_draw && nozzle.speed > 0.0 && across >= largest_draw * nozzle.speed) {
        warned_of_draw = true;
        warnings.push_back(
            fmt::format("inflow '{}' moves {:.2g} times as fast as the material in its exit{}: from {:g} on the "
                        "bead is drawn until it may tear",
                        inflow.name, across / nozzle.speed, when, largest_draw));
      }
    }
  }
  return warnings;
}

}  // namespace bulkley
