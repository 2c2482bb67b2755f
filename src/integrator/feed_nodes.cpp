#include "integrator/feed_nodes.hpp"

#include <Eigen/Geometry>
#include <algorithm>

namespace bulkley {

namespace {

constexpr double held_reach = 0.75;   // of a cell, across the section, as for sticky colliders
constexpr double reach_behind = 1.5;  // cells behind the feed: the stencils of its last particles

}  // namespace

std::vector<FeedNodes::Walled> FeedNodes::walled_by(std::span<const NodeConstraint> constraints) {
  std::vector<Walled> walled;
  for (const NodeConstraint& constraint : constraints)
    if (constraint.collider >= 0 && constraint.contact == Contact::sticky)
      walled.push_back({constraint.node, constraint.velocity});
  std::stable_sort(walled.begin(), walled.end(), [](const Walled& a, const Walled& b) { return a.place < b.place; });
  return walled;
}

void FeedNodes::fit(std::vector<Int3> nodes, std::vector<LocalIndex> places, std::span<const NodeConstraint> fixed) {
  nodes_ = std::move(nodes);
  places_ = std::move(places);
  fixed_ = walled_by(fixed);
}

std::vector<NodeConstraint> FeedNodes::at(double time, double dt, std::span<const double> stretches,
                                          std::span<const NodeConstraint> moving) const {
  std::vector<NodeConstraint> result;
  const GridGeometry& grid = physics_.grid;
  const double dx = grid.cell_size;
  const std::vector<Walled> moving_walls = walled_by(moving);
  const auto wall_at = [&](LocalIndex place) -> const Walled* {
    for (const std::vector<Walled>* walls : {&moving_walls, &fixed_}) {
      const auto found =
          std::lower_bound(walls->begin(), walls->end(), place, [](const Walled& w, LocalIndex p) { return w.place < p; });
      if (found != walls->end() && found->place == place) return &*found;
    }
    return nullptr;
  };
  for (std::size_t f = 0; f < physics_.feeds.size(); ++f) {
    const Feed& feed = physics_.feeds[f];
    if (!feed.runs(time)) continue;
    const NozzleState nozzle = feed.at(time, stretches[f]),
                      middle = feed.at(std::min(time + 0.5 * dt, feed.end()), stretches[f]);
    const double from = -feed.length() - reach_behind * dx;
    const Bounds box = feed.bounds(nozzle, held_reach * dx, from);
    for (std::size_t n = 0; n < nodes_.size(); ++n) {
      const Vec3 x = grid.node_position(nodes_[n]);
      if ((x.array() < box.lower.array()).any() || (x.array() > box.upper.array()).any()) continue;
      if (!feed.holds(nozzle, x, held_reach * dx, from)) continue;
      Vec3 velocity = feed.velocity(middle, x, feed.share_at(nozzle, x));
      // A node of the tube moves with the share of its cell that is bore, so that the volume that flows is right. A profile has none at the
      // edge to share.
      if (const Walled* wall = wall_at(places_[n])) {
        const double depth = -feed.distance_to_edge(nozzle, x) / dx;
        const double share = feed.is_plug() ? std::clamp(0.5 + depth, 0.0, 1.0) : depth > 0.0 ? 1.0 : 0.0;
        velocity = wall->velocity + share * (velocity - wall->velocity);
      }
      result.push_back({places_[n], Contact::sticky, 0.0, nozzle.axis, velocity,
                        static_cast<std::int32_t>(physics_.colliders.size() + f), x - nozzle.position});
    }
  }
  return result;
}

std::size_t FeedNodes::memory() const {
  return nodes_.capacity() * sizeof(Int3) + places_.capacity() * sizeof(LocalIndex) + fixed_.capacity() * sizeof(Walled);
}

}  // namespace bulkley
