#include "integrator/gauge_contact.hpp"

#include <algorithm>
#include <optional>
#include <set>

namespace bulkley {

namespace {

Vec3 inward(FaceName face) {
  const int f = static_cast<int>(face);
  return (f % 2 == 0 ? 1.0 : -1.0) * Vec3::Unit(f / 2);
}

/// The wall normal to `axis` that a node is on or behind.
std::optional<FaceName> face_over(const Physics& physics, int axis, const Int3& node) {
  const auto a = static_cast<std::size_t>(axis);
  const int i = node[a] - physics.grid.node_offset(axis);
  const std::size_t f = 2 * a + (i > 0 ? 1 : 0);
  if ((i > 0 && i < physics.grid.n_cells[a]) || !behaviour(physics.faces[f].kind).contact) return std::nullopt;
  return static_cast<FaceName>(f);
}

}  // namespace

void GaugeContact::fit(std::span<const NodeConstraint> constraints, std::span<const NodeImage> images,
                       const std::vector<Int3>& nodes, std::span<const LocalIndex> active) {
  constraints_.clear();
  images_.clear();
  shares_.clear();
  copied_.clear();
  if (physics_.gauges.empty()) return;
  fit_constraints(constraints, nodes, active);
  fit_images(images, nodes, active);
  copy_.resize(copied_.size());
  copied_impulse_.resize(copied_.size());
  behind_.resize(images_.size());
}

void GaugeContact::add_shares_on_face(FaceName face, const Vec3& components, const Int3& node) {
  for (std::size_t g = 0; g < physics_.gauges.size(); ++g) {
    const Gauge& gauge = physics_.gauges[g];
    if (gauge.face != face) continue;
    const double part = face_share(physics_.grid, gauge, node);
    if (part > 0.0) shares_.push_back({static_cast<std::uint32_t>(g), part, components, inward(face)});
  }
}

// What acts on a node through one face. A sticky face takes all components; in an edge, a component belongs to the face that
// it is normal to, or else pressure on that face would count as shear on this one.
GaugeContact::Range GaugeContact::shares_on_faces(FaceName face, const Int3& node) {
  const auto first = static_cast<std::uint32_t>(shares_.size());
  const auto own_axis = static_cast<int>(face) / 2;
  Vec3 own = Vec3::Ones();
  if (behaviour(physics_.faces[static_cast<std::size_t>(face)].kind).contact == Contact::sticky)
    for (int axis = 0; axis < 3; ++axis) {
      const std::optional<FaceName> other = axis == own_axis ? std::nullopt : face_over(physics_, axis, node);
      if (!other) continue;
      add_shares_on_face(*other, Vec3::Unit(axis), node);
      own[axis] = 0.0;
    }
  add_shares_on_face(face, own, node);
  return {first, static_cast<std::uint32_t>(shares_.size()) - first};
}

GaugeContact::Range GaugeContact::shares_on_collider(const NodeConstraint& constraint) {
  Range range{static_cast<std::uint32_t>(shares_.size()), 0};
  for (std::size_t g = 0; g < physics_.gauges.size(); ++g) {
    const Gauge& gauge = physics_.gauges[g];
    if (gauge.collider_number != constraint.collider) continue;
    const Collider& collider = collider_of(gauge);
    const Vec3 x = collider.motion.center + constraint.arm;
    const double part = collider_share(physics_.grid, gauge, collider, Pose{}, x);
    if (part > 0.0) shares_.push_back({static_cast<std::uint32_t>(g), part, Vec3::Ones(), constraint.normal});
  }
  range.count = static_cast<std::uint32_t>(shares_.size()) - range.first;
  return range;
}

void GaugeContact::fit_constraints(std::span<const NodeConstraint> constraints, const std::vector<Int3>& nodes,
                                   std::span<const LocalIndex> active) {
  for (auto first = constraints.begin(); first != constraints.end();) {
    const auto other_node = [&](const NodeConstraint& c) { return c.node != first->node; };
    const auto last = std::find_if(first, constraints.end(), other_node);
    const auto place =
        static_cast<std::size_t>(std::lower_bound(active.begin(), active.end(), first->node) - active.begin());
    const std::size_t n_before = constraints_.size();
    bool is_watched = false;
    for (auto c = first; c != last; ++c) {
      const Range shares =
          c->collider < 0 ? shares_on_faces(static_cast<FaceName>(face_of(*c)), nodes[place]) : shares_on_collider(*c);
      constraints_.push_back({*c, shares});
      is_watched = is_watched || shares.count > 0;
    }
    if (!is_watched) constraints_.resize(n_before);
    first = last;
  }
}

void GaugeContact::fit_images(std::span<const NodeImage> images, const std::vector<Int3>& nodes,
                              std::span<const LocalIndex> active) {
  const auto node_at = [&](LocalIndex place) {
    return nodes[static_cast<std::size_t>(std::lower_bound(active.begin(), active.end(), place) - active.begin())];
  };
  // From the last on: what is folded onto a node that is folded itself later belongs to what that one folds.
  std::set<LocalIndex> folded_later;
  for (std::size_t k = images.size(); k-- > 0;) {
    const NodeImage& image = images[k];
    const Int3 behind = node_at(image.behind);
    const Range shares = shares_on_faces(static_cast<FaceName>(image.face), behind);
    if (shares.count == 0 && !folded_later.contains(image.front)) continue;
    folded_later.insert(image.behind);
    images_.push_back({image, image, shares});
  }
  std::reverse(images_.begin(), images_.end());
  for (const WatchedImage& watched : images_)
    for (const LocalIndex node : {watched.image.behind, watched.image.front}) copied_.push_back(node);
  std::sort(copied_.begin(), copied_.end());
  copied_.erase(std::unique(copied_.begin(), copied_.end()), copied_.end());
  const auto in_copy = [&](LocalIndex node) {
    return static_cast<LocalIndex>(std::lower_bound(copied_.begin(), copied_.end(), node) - copied_.begin());
  };
  for (WatchedImage& watched : images_) {
    watched.in_copy.behind = in_copy(watched.image.behind);
    watched.in_copy.front = in_copy(watched.image.front);
  }
}

void GaugeContact::add(const Share& share, const Vec3& impulse, ContactImpulses& received) const {
  const std::size_t entry = physics_.n_obstacles() + share.gauge;
  const Vec3 part = share.part * impulse.cwiseProduct(share.components);
  received.add(entry, part, Vec3::Zero());
  received.add(entry + physics_.gauges.size(), Vec3(-share.normal.dot(part), 0.0, 0.0), Vec3::Zero());
}

void GaugeContact::before_fold(const GridUpdate& update, const Node* nodes, const Node* impulse) {
  for (std::size_t n = 0; n < copied_.size(); ++n) {
    copy_[n] = nodes[copied_[n]];
    if (impulse) copied_impulse_[n] = impulse[copied_[n]];
  }
  Node* const forces = impulse ? copied_impulse_.data() : nullptr;
  for (std::size_t k = 0; k < images_.size(); ++k) {
    const NodeImage& image = images_[k].in_copy;
    const Node& node = copy_[static_cast<std::size_t>(image.behind)];
    Behind& behind = behind_[k];
    behind.mass = node.c[3];
    behind.impulse = behind.mass * update.dt * update.gravity;
    if (forces) behind.impulse += vector_of(forces[image.behind]);
    behind.momentum = vector_of(node) + behind.impulse;
    fold_images(update, {&image, 1}, copy_.data(), forces);
  }
}

void GaugeContact::before_later_fold(const Node* impulses) {
  for (std::size_t n = 0; n < copied_.size(); ++n) copy_[n] = impulses[copied_[n]];
  for (std::size_t k = 0; k < images_.size(); ++k) {
    const NodeImage& image = images_[k].in_copy;
    const Vec3 impulse = vector_of(copy_[static_cast<std::size_t>(image.behind)]);
    behind_[k].impulse += impulse;
    behind_[k].momentum += impulse;
    fold_impulses({&image, 1}, copy_.data());
  }
}

void GaugeContact::before_constraints(const Node* nodes, ContactImpulses& received) const {
  LocalIndex node = -1;
  Vec3 velocity = Vec3::Zero();
  for (const WatchedConstraint& watched : constraints_) {
    const NodeConstraint& constraint = watched.constraint;
    if (constraint.node != node) velocity = vector_of(nodes[node = constraint.node]);
    const Vec3 after = constrained_velocity(constraint, velocity);
    const double mass = nodes[node].c[3];
    for (std::uint32_t s = 0; s < watched.shares.count && mass > 0.0; ++s)
      add(shares_[watched.shares.first + s], mass * (velocity - after), received);
    velocity = after;
  }
}

// The shares that `fit` found for a constraint by what does not move.
GaugeContact::Range GaugeContact::shares_of(const NodeConstraint& constraint) const {
  const auto before = [](const WatchedConstraint& a, const NodeConstraint& b) { return a.constraint.node < b.node; };
  auto found = std::lower_bound(constraints_.begin(), constraints_.end(), constraint, before);
  for (; found != constraints_.end() && found->constraint.node == constraint.node; ++found)
    if (found->constraint.collider == constraint.collider && found->constraint.normal == constraint.normal)
      return found->shares;
  return {};
}

void GaugeContact::before_moving(std::span<const NodeConstraint> constraints, double time, const Node* nodes,
                                 ContactImpulses& received) const {
  const std::vector<Gauge>& gauges = physics_.gauges;
  if (gauges.empty()) return;
  std::vector<Pose> poses(gauges.size());
  for (std::size_t g = 0; g < gauges.size(); ++g)
    if (gauges[g].collider_number >= 0) poses[g] = collider_of(gauges[g]).motion.pose(time);
  LocalIndex node = -1;
  Vec3 velocity = Vec3::Zero();
  for (const NodeConstraint& constraint : constraints) {
    if (constraint.node != node) velocity = vector_of(nodes[node = constraint.node]);
    const Vec3 after = constrained_velocity(constraint, velocity);
    const double mass = nodes[node].c[3];
    const Vec3 impulse = mass * (velocity - after);
    velocity = after;
    if (!(mass > 0.0)) continue;
    const int number = constraint.collider;
    if (number >= static_cast<int>(physics_.colliders.size())) continue;  // a feed
    if (number < 0 || !physics_.colliders[static_cast<std::size_t>(number)].motion.moves()) {
      const Range shares = shares_of(constraint);
      for (std::uint32_t s = 0; s < shares.count; ++s) add(shares_[shares.first + s], impulse, received);
      continue;
    }
    for (std::size_t g = 0; g < gauges.size(); ++g) {
      if (gauges[g].collider_number != number) continue;
      const Collider& collider = collider_of(gauges[g]);
      const Vec3 x = poses[g].to_world(collider.motion.center) + constraint.arm;
      const double part = collider_share(physics_.grid, gauges[g], collider, poses[g], x);
      if (part > 0.0) add({static_cast<std::uint32_t>(g), part, Vec3::Ones(), constraint.normal}, impulse, received);
    }
  }
}

// Of the pair of a node behind the wall and its image, what the wall takes is (1 - R) times what the node behind loses (T13d).
void GaugeContact::after_unfold(const Node* nodes, const Node* change, ContactImpulses& received) const {
  for (std::size_t k = 0; k < images_.size(); ++k) {
    const WatchedImage& watched = images_[k];
    const Behind& behind = behind_[k];
    if (watched.shares.count == 0 || !(behind.mass > 0.0)) continue;
    Vec3 lost = behind.momentum - behind.mass * vector_of(nodes[watched.image.behind]);
    if (change)
      lost = (1.0 - kept_share_) * lost +
             kept_share_ * (behind.impulse - behind.mass * vector_of(change[watched.image.behind]));
    const Vec3 impulse = (Vec3::Ones() - watched.image.sign).cwiseProduct(lost);
    for (std::uint32_t s = 0; s < watched.shares.count; ++s) add(shares_[watched.shares.first + s], impulse, received);
  }
}

std::size_t GaugeContact::memory() const {
  return constraints_.capacity() * sizeof(WatchedConstraint) + images_.capacity() * sizeof(WatchedImage) +
         shares_.capacity() * sizeof(Share) + (copy_.capacity() + copied_impulse_.capacity()) * sizeof(Node) +
         copied_.capacity() * sizeof(LocalIndex) + behind_.capacity() * sizeof(Behind);
}

}  // namespace bulkley
