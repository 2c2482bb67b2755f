#include <fmt/format.h>

#include <algorithm>

#include "bulkley/base/error.hpp"
#include "geometry/mesh_shape.hpp"
#include "scene/scene.hpp"

namespace bulkley {

namespace {

constexpr int n_looks = 1000;  // times at which a nozzle that moves is looked at

bool is_outside(const GridGeometry& grid, const Vec3& x) {
  return (x - grid.lower).minCoeff() < 0.0 || (grid.upper() - x).minCoeff() < 0.0;
}

/// What is wrong with a feed that is outside the domain or touches something; empty when nothing is. `time`: where all things are.
std::string feed_fault(const Scene& scene, const std::vector<Feed>& feeds, std::size_t f, double time) {
  const double dx = scene.grid.cell_size;
  const Feed& feed = feeds[f];
  const NozzleState nozzle = feed.at(time);
  const auto in_feed = [&](const Feed::Point& point, double along) -> Vec3 {
    return nozzle.position + nozzle.rotation * point.offset + along * nozzle.axis;
  };
  for (const Feed::Point& point : feed.points()) {
    const Vec3 front = in_feed(point, 0.0), back = in_feed(point, -feed.length());
    for (const Vec3& x : {front, back})
      if (is_outside(scene.grid, x))
        return fmt::format("reaches outside the domain at ({:.6g}, {:.6g}, {:.6g}) m: its feed takes {:g} m behind the exit",
                           x[0], x[1], x[2], feed.length());
    for (const Collider& collider : scene.colliders)
      if (signed_distance(collider.shape, collider.motion.pose(time), front) < -0.5 * dx)
        return fmt::format("has its exit inside collider '{}'", collider.name);
    for (std::size_t other = 0; other < f; ++other)
      for (const Vec3& x : {front, back})
        if (feeds[other].holds(feeds[other].at(time), x, 0.0, -feeds[other].length()))
          return fmt::format("overlaps inflow '{}'", feeds[other].inflow().name);
  }
  return {};
}

/// What is too near in front of the exit; empty when nothing is.
std::string gap_fault(const Scene& scene, const Feed& feed, double time) {
  const double dx = scene.grid.cell_size;
  const NozzleState nozzle = feed.at(time);
  const Vec3 exit = nozzle.position + nozzle.rotation * feed.middle(), ahead = exit + (2.0 - 1e-9) * dx * nozzle.axis;
  for (int axis = 0; axis < 3; ++axis) {
    const bool below = ahead[axis] < scene.grid.lower[axis];
    if (scene.grid.periodic[static_cast<std::size_t>(axis)] || (!below && ahead[axis] <= scene.grid.upper()[axis])) continue;
    const double gap = below ? exit[axis] - scene.grid.lower[axis] : scene.grid.upper()[axis] - exit[axis];
    return fmt::format("has its exit {:.3g} m from a face of the domain; it must be at least 2 cells, {:g} m", gap,
                       2.0 * dx);
  }
  for (const Collider& collider : scene.colliders)
    for (const double cells : {0.5, 1.0, 1.5, 2.0 - 1e-9})
      if (signed_distance(collider.shape, collider.motion.pose(time), exit + cells * dx * nozzle.axis) < 0.0)
        return fmt::format("has collider '{}' in front of its exit; there must be at least 2 cells, {:g} m, between them",
                           collider.name, 2.0 * dx);
  return {};
}

/// What stands in the feed at the start; empty when nothing does.
std::string start_fault(const Scene& scene, const Feed& feed) {
  if (feed.start() > 0.0) return {};
  const NozzleState nozzle = feed.at(0.0);
  for (const Feed::Point& point : feed.points())
    for (const double along : {-0.5 * scene.grid.cell_size, -feed.length()}) {
      const Vec3 x = nozzle.position + nozzle.rotation * point.offset + along * nozzle.axis;
      for (const Body& body : scene.bodies)
        if (contains(body.shape, x))
          return fmt::format("has its feed inside body '{}'; seed the body outside of it", body.name);
      for (const RigidBody& body : scene.rigid_bodies)
        if (contains(body.shape, x)) return fmt::format("has its feed inside rigid body '{}'", body.name);
    }
  return {};
}

}  // namespace

void check_inflows(const Scene& scene) {
  const double end_time = scene.time_stepping.end_time;
  std::string faults;
  const std::vector<Feed> feeds = feeds_of(scene.grid, scene.inflows, scene.bodies.size(), end_time);
  const bool all_rest = std::none_of(scene.colliders.begin(), scene.colliders.end(),
                                     [](const Collider& collider) { return collider.motion.moves(); });
  for (std::size_t f = 0; f < feeds.size(); ++f) {
    const Feed& feed = feeds[f];
    const Inflow& inflow = feed.inflow();
    const bool moves = !inflow.key_frames.empty() || inflow.motion.moves();
    std::string fault = start_fault(scene, feed);
    const double last = std::min(feed.end(), end_time);
    const int n_times = (moves || !all_rest || feeds.size() > 1) && last > feed.start() ? n_looks : 0;
    for (int n = 0; n <= n_times && fault.empty(); ++n) {
      const double time = n == 0 ? feed.start() : feed.start() + (last - feed.start()) * n / n_times;
      fault = feed_fault(scene, feeds, f, time);
      if (fault.empty()) fault = gap_fault(scene, feed, time);
      if (!fault.empty() && time > 0.0) fault += fmt::format(" at t = {:g} s", time);
    }
    if (fault.empty()) continue;
    faults += fmt::format("{}{}{}inflow '{}' {}", faults.empty() ? "" : "\n", inflow.place, inflow.place.empty() ? "" : ": ",
                          inflow.name, fault);
  }
  if (!faults.empty()) throw UsageError(faults);
}

}  // namespace bulkley
