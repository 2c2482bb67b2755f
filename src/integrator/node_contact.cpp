#include "integrator/node_contact.hpp"

#include <algorithm>

#include "parallel/reproducible_sum.hpp"

namespace bulkley {

ContactImpulses no_contact_impulses(const Physics& physics) {
  const GridGeometry& grid = physics.grid;
  const double density = std::max(physics.largest_density(), 1e-300);  // a run without materials has nothing to sum
  return {physics.n_obstacles() + n_gauge_entries(physics) + physics.feeds.size(),
          density * grid.cell_size * grid.cell_size * grid.cell_size, (grid.upper() - grid.lower).maxCoeff()};
}

NodeContact::NodeContact(const Physics& physics, const Comm& comm)
    : physics_(physics), none_(no_contact_impulses(physics)), impulses_(none_), gauges_(physics), feeds_(physics) {
  if (physics.rigid_bodies.empty()) return;
  rigid_.emplace(physics, comm);
  rigid_received_ = ContactImpulses(physics.n_obstacles() + physics.rigid_bodies.size(), 1.0, 1.0);
}

void NodeContact::fit(const Exchange& exchange) {
  const GridGeometry& grid = physics_.grid;
  const auto active = exchange.active_nodes();
  const std::vector<Int3> nodes = exchange.active_positions();
  constraints_ = node_constraints(grid, physics_.faces, physics_.colliders, nodes);
  const auto moves = [](const Collider& collider) { return collider.motion.moves(); };
  if (std::any_of(physics_.colliders.begin(), physics_.colliders.end(), moves))
    moving_constraints_.emplace(grid, physics_.colliders, nodes, std::vector(active.begin(), active.end()), constraints_);
  for (NodeConstraint& constraint : constraints_) constraint.node = active[static_cast<std::size_t>(constraint.node)];
  if (rigid_) rigid_->fit(nodes, std::vector(active.begin(), active.end()), constraints_);
  images_ = node_images(grid, physics_.faces, nodes);
  for (NodeImage& image : images_) {
    image.behind = active[static_cast<std::size_t>(image.behind)];
    image.front = active[static_cast<std::size_t>(image.front)];
  }
  if (!physics_.feeds.empty()) feeds_.fit(nodes, std::vector(active.begin(), active.end()), constraints_);
  gauges_.fit(constraints_, images_, nodes, active);
}

void NodeContact::apply(double time, const GridUpdate& update, std::span<const double> stretches, Node* nodes, Node* change,
                        ContactImpulses& received, ContactAccount& account) {
  gauges_.before_constraints(nodes, received);
  account.apply(constraints_, nodes, change, received);
  std::span<const NodeConstraint> moving_ones;
  if (moving_constraints_) {
    const std::vector<NodeConstraint>& moving = moving_constraints_->at(time, update.dt);
    gauges_.before_moving(moving, time, nodes, received);
    account.apply(moving, nodes, change, received);
    moving_ones = moving;
  }
  if (rigid_) merge_bodies(time, update, moving_ones, nodes, change, received, account);
  if (!physics_.feeds.empty()) account.apply(feeds_.at(time, update.dt, stretches, moving_ones), nodes, change, received);
  account.unfold(update, images_, nodes, change);
  gauges_.after_unfold(nodes, update.joined ? nullptr : change, received);
}

// Bodies and the nodes that they hold, then the walls of those nodes once more.
void NodeContact::merge_bodies(double time, const GridUpdate& update, std::span<const NodeConstraint> moving, Node* nodes,
                               Node* change, ContactImpulses& received, ContactAccount& account) {
  rigid_->merge(time, update, moving, nodes);
  rigid_received_.clear();
  account.apply(rigid_->held(), nodes, change, rigid_received_);
  account.apply(rigid_->walls_again(), nodes, change, received);
}

void NodeContact::fold_later(Node* impulses) {
  gauges_.before_later_fold(impulses);
  fold_impulses(images_, impulses);
}

double NodeContact::collider_speed(double first, double last) const {
  double fastest = bulkley::collider_speed(physics_.grid, physics_.colliders, first, last);
  if (rigid_) fastest = std::max(fastest, rigid_->speed_bound(last - first));
  for (const Feed& feed : physics_.feeds)
    if (first < feed.end() && last >= feed.start()) fastest = std::max(fastest, feed.speed_bound(first, last));
  return fastest;
}

ContactImpulses NodeContact::impulses(const Comm& comm) const { return sum_global(comm, impulses_); }

void NodeContact::set_impulses(const Comm& comm, const ContactImpulses& sums) {
  impulses_.clear();
  if (comm.is_root()) impulses_.add(sums);
}

std::size_t NodeContact::memory() const {
  return (rigid_ ? rigid_->memory() : 0) + gauges_.memory() + feeds_.memory() + images_.capacity() * sizeof(NodeImage) +
         constraints_.capacity() * sizeof(NodeConstraint) + (moving_constraints_ ? moving_constraints_->memory() : 0);
}

}  // namespace bulkley
