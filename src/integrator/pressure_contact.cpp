#include "integrator/pressure_contact.hpp"

#include <algorithm>
#include <ranges>

#include "kernel/batch.hpp"

namespace bulkley {

namespace {

void set_vector_of(Node& node, const Vec3& value) { std::copy_n(value.data(), 3, node.c); }

}  // namespace

void PressureContact::fit(const CellGrid& cells) {
  find(cells.complete_positions(), cells.complete_nodes());
  std::vector<CellGrid::Copy> joined;
  for (const NodeImage& image : all_images_) joined.push_back({image.behind, image.front});
  waves_ = CellWaves(cells, joined);
  all_repeated_.assign(cells.repeated().begin(), cells.repeated().end());
  sort_by_wave();
}

void PressureContact::fit(const std::vector<Int3>& positions, std::span<const LocalIndex> nodes, LocalIndex n_nodes) {
  find(positions, nodes);
  waves_ = CellWaves(n_nodes);
  all_repeated_.clear();
  sort_by_wave();
  numbers_.select_all(n_nodes);
  select();
}

void PressureContact::select(const CellGrid& cells, std::span<char> takes_part) {
  const auto mark = [&](LocalIndex from, LocalIndex to) {
    if (takes_part[static_cast<std::size_t>(from)]) takes_part[static_cast<std::size_t>(to)] = 1;
  };
  // Axis after axis, as impulses are folded.
  for (const CellGrid::Copy& copy : all_repeated_) mark(copy.node, copy.other);
  for (const NodeImage& image : all_images_) mark(image.behind, image.front);
  numbers_.select(cells, takes_part);
  is_owned_.assign(static_cast<std::size_t>(numbers_.size()), 0);
  for (const CellGrid::Copy& copy : numbers_.owned()) is_owned_[static_cast<std::size_t>(copy.node)] = 1;
  select();
}

void PressureContact::find(const std::vector<Int3>& positions, std::span<const LocalIndex> nodes) {
  all_nodes_.assign(nodes.begin(), nodes.end());
  const auto number = [&](LocalIndex n) { return all_nodes_[static_cast<std::size_t>(n)]; };
  fixed_ = node_constraints(physics_.grid, physics_.faces, physics_.colliders, positions);
  moving_.reset();
  const auto moves = [](const Collider& collider) { return collider.motion.moves(); };
  if (std::any_of(physics_.colliders.begin(), physics_.colliders.end(), moves))
    moving_.emplace(physics_.grid, physics_.colliders, positions, all_nodes_, fixed_);
  for (NodeConstraint& constraint : fixed_) constraint.node = number(constraint.node);
  if (!physics_.feeds.empty()) feeds_.fit(positions, all_nodes_, fixed_);
  all_images_ = node_images(physics_.grid, physics_.faces, positions);
  for (NodeImage& image : all_images_) {
    image.behind = number(image.behind);
    image.front = number(image.front);
  }
}

void PressureContact::sort_by_wave() {
  const auto sort = [&](auto& things, auto node_of) {
    std::stable_sort(things.begin(), things.end(),
                     [&](const auto& a, const auto& b) { return waves_.of_node(node_of(a)) < waves_.of_node(node_of(b)); });
  };
  sort(all_nodes_, [](LocalIndex node) { return node; });
  sort(all_repeated_, [](const CellGrid::Copy& copy) { return copy.node; });
  sort(all_images_, [](const NodeImage& image) { return image.front; });
}

void PressureContact::select() {
  wave_of_.resize(static_cast<std::size_t>(numbers_.size()));
  for (LocalIndex node = 0; node < waves_.n_nodes(); ++node)
    if (const LocalIndex n = numbers_.number(node); n >= 0) wave_of_[static_cast<std::size_t>(n)] = waves_.of_node(node);
  end_of_wave_.resize(static_cast<std::size_t>(waves_.size()));
  for (LocalIndex w = 0; w < waves_.size(); ++w)
    end_of_wave_[static_cast<std::size_t>(w)] = numbers_.number_before(waves_.end_of_nodes(w));
  const auto renumber = [&](LocalIndex& node) { return (node = numbers_.number(node)) >= 0; };
  const auto select = [&](const auto& all, auto& selected, auto renumbered, auto node_of) {
    selected.things.clear();
    for (auto thing : all)
      if (renumbered(thing)) selected.things.push_back(thing);
    selected.ranges.assign(waves_.size(), selected.things.size(),
                           [&](std::size_t k) { return wave_of(node_of(selected.things[k])); });
  };
  select(all_nodes_, nodes_, renumber, [](LocalIndex node) { return node; });
  select(
      all_repeated_, repeated_, [&](CellGrid::Copy& copy) { return renumber(copy.node) && renumber(copy.other); },
      [](const CellGrid::Copy& copy) { return copy.node; });
  select(
      all_images_, images_, [&](NodeImage& image) { return renumber(image.behind) && renumber(image.front); },
      [](const NodeImage& image) { return image.front; });
}

Mat3 held_part(const NodeConstraint& body) {
  if (body.contact == Contact::sticky) return Mat3::Identity();
  return body.normal * body.normal.transpose();
}

void PressureContact::begin(double time, double dt, std::span<const double> stretches, const Node* velocity,
                            std::span<const NodeConstraint> bodies) {
  std::span<const NodeConstraint> moving;
  if (moving_) moving = moving_->at(time, dt);
  std::vector<NodeConstraint> fed;
  if (!physics_.feeds.empty()) fed = feeds_.at(time, dt, stretches, moving);
  std::vector<const NodeConstraint*> all;  // those of feeds first: what they hold no wall moves
  for (const std::span<const NodeConstraint> some :
       {std::span<const NodeConstraint>(fed), std::span<const NodeConstraint>(fixed_), moving})
    for (const NodeConstraint& constraint : some)
      if (numbers_.number(constraint.node) >= 0) all.push_back(&constraint);
  std::stable_sort(all.begin(), all.end(), [&](const auto* a, const auto* b) {
    return std::pair(waves_.of_node(a->node), a->node) < std::pair(waves_.of_node(b->node), b->node);
  });
  constraints_.clear();
  held_.things.clear();
  std::vector<HeldNode>& held_nodes = held_.things;
  for (const NodeConstraint* constraint : all) {
    const LocalIndex node = numbers_.number(constraint->node);
    if (held_nodes.empty() || held_nodes.back().node != node)
      held_nodes.push_back({node, constraints_.size(), constraints_.size(), Mat3::Identity(), Vec3::Zero(), -1});
    HeldNode& held = held_nodes.back();
    // A node under several constraints has each of them twice.
    const auto same = [&](const Constraint& other) {
      return other.contact == constraint->contact && other.normal == constraint->normal &&
             other.velocity == constraint->velocity;
    };
    if (std::any_of(constraints_.begin() + static_cast<std::ptrdiff_t>(held.first), constraints_.end(), same)) continue;
    const Vec3 towards = vector_of(velocity[node]) - constraint->velocity;
    const bool in_force = constraint->contact != Contact::separating || towards.dot(constraint->normal) < 0.0;
    constraints_.push_back({constraint->contact, in_force, constraint->normal, constraint->velocity});
    held.end = constraints_.size();
  }
  join(bodies, velocity);
  for (HeldNode& held : held_nodes) project(held);
  held_.ranges.assign(waves_.size(), held_nodes.size(), [&](std::size_t k) { return wave_of(held_nodes[k].node); });
}

void PressureContact::join(std::span<const NodeConstraint> bodies, const Node* velocity) {
  body_nodes_.clear();
  if (bodies.empty()) return;
  std::vector<HeldNode>& held_nodes = held_.things;
  std::vector<const NodeConstraint*> of_node(static_cast<std::size_t>(numbers_.size()), nullptr);
  for (const NodeConstraint& body : bodies) of_node[static_cast<std::size_t>(body.node)] = &body;
  for (const HeldNode& held : held_nodes) {
    const auto sticks = [](const Constraint& wall) { return wall.contact == Contact::sticky; };
    const auto first = constraints_.begin() + static_cast<std::ptrdiff_t>(held.first),
               end = constraints_.begin() + static_cast<std::ptrdiff_t>(held.end);
    const NodeConstraint*& body = of_node[static_cast<std::size_t>(held.node)];
    if (body && std::any_of(first, end, sticks)) body = nullptr;
  }
  std::vector<std::uint8_t> has_walls(of_node.size(), 0);
  for (const HeldNode& held : held_nodes) has_walls[static_cast<std::size_t>(held.node)] = 1;
  const std::size_t none = constraints_.size();
  for (const NodeConstraint& body : bodies)
    if (!has_walls[static_cast<std::size_t>(body.node)])
      held_nodes.push_back({body.node, none, none, Mat3::Identity(), Vec3::Zero(), -1});
  const auto place = [&](const HeldNode& held) { return std::pair(wave_of(held.node), held.node); };
  std::sort(held_nodes.begin(), held_nodes.end(), [&](const HeldNode& a, const HeldNode& b) { return place(a) < place(b); });
  for (std::size_t h = 0; h < held_nodes.size(); ++h) {
    const NodeConstraint* const body = of_node[static_cast<std::size_t>(held_nodes[h].node)];
    if (!body) continue;
    held_nodes[h].body = static_cast<std::ptrdiff_t>(body_nodes_.size());
    const double away = (vector_of(velocity[body->node]) - body->velocity).dot(body->normal);
    body_nodes_.push_back({*body, h, Mat3::Identity(), body->contact != Contact::separating || away < 0.0});
  }
}

void PressureContact::project(HeldNode& held) {
  project_walls(held);
  if (held.body < 0) return;
  BodyNode& body = body_nodes_[static_cast<std::size_t>(held.body)];
  body.walls = held.projection;
  if (!body.in_force) return;
  held.projection = body.walls * (Mat3::Identity() - held_part(body.constraint)) * body.walls;
}

// P = 1 - sum e e^T over the normals in force, made orthogonal one after the other, and the offset that gives the velocities
// along them.
void PressureContact::project_walls(HeldNode& held) const {
  held.projection = Mat3::Identity();
  held.offset = Vec3::Zero();
  for (std::size_t k = held.first; k < held.end; ++k) {
    const Constraint& constraint = constraints_[k];
    if (!constraint.in_force) continue;
    if (constraint.contact == Contact::sticky) {
      held.projection = Mat3::Zero();
      held.offset = constraint.velocity;
      return;
    }
    const Vec3 rest = held.projection * constraint.normal;
    const double length = rest.norm();
    if (length < 1e-3) continue;  // held already
    const Vec3 e = rest / length;
    const double lacking = constraint.normal.dot(constraint.velocity - held.offset) / length;
    held.projection -= e * e.transpose();
    held.offset += lacking * e;
  }
}

void PressureContact::hold_by_walls(Node* velocity) const {
  for (const HeldNode& held : held_.things) {
    Node& node = velocity[held.node];
    set_vector_of(node, walls_of(held) * vector_of(node) + held.offset);
  }
}

// As NodeContact does it: the node's share of the body, then its walls once more.
void PressureContact::hold_by_body(const BodyNode& body, const Vec3& velocity, Node* nodes) const {
  Node& node = nodes[body.constraint.node];
  const Vec3 before = vector_of(node);
  set_vector_of(node,
                body.walls * (before + held_part(body.constraint) * (velocity - before)) + held_.things[body.held].offset);
}

void PressureContact::complete(Node* velocity) const {
  unfold_images(images(), velocity, nullptr);
  repeat(repeated(), velocity);
}

void PressureContact::spread(const double* scale, LocalIndex wave, Node* impulses) const {
  const std::span<const CellGrid::Copy> repeated = repeated_.of(wave);
  const std::span<const NodeImage> images = images_.of(wave);
  fold_repeated(repeated, impulses);
  fold_impulses(images, impulses);
  for (const LocalIndex n : nodes_.of(wave)) store_vector(impulses[n], load_vector(impulses[n]) * scale[n]);
  for (const HeldNode& held : held_.of(wave)) {
    Node& node = impulses[held.node];
    set_vector_of(node, held.projection * vector_of(node));
  }
  for (const NodeImage& image : std::views::reverse(images))
    for (int a = 0; a < 3; ++a) impulses[image.behind].c[a] = image.sign[a] * impulses[image.front].c[a];
  repeat(repeated, impulses);
}

std::vector<PressureContact::Source> PressureContact::sources(std::size_t n_nodes) const {
  std::vector<Source> result;
  result.reserve(n_nodes);
  for (std::size_t n = 0; n < n_nodes; ++n) result.push_back({static_cast<LocalIndex>(n), Vec3::Ones()});
  for (const NodeImage& image : std::views::reverse(images())) {
    const Source front = result[static_cast<std::size_t>(image.front)];
    result[static_cast<std::size_t>(image.behind)] = {front.node, image.sign.cwiseProduct(front.sign)};
  }
  for (const CellGrid::Copy& copy : repeated())
    result[static_cast<std::size_t>(copy.node)] = result[static_cast<std::size_t>(copy.other)];
  return result;
}

void PressureContact::weaken(Node* scales) const {
  for (const HeldNode& held : held_.things)
    for (int a = 0; a < 3; ++a) scales[held.node].c[a] *= held.projection(a, a);
  repeat(repeated(), scales);
}

bool PressureContact::revise_body(BodyNode& body, const Vec3& velocity, double tolerance,
                                  std::span<const RigidVelocity> bodies) const {
  const NodeConstraint& constraint = body.constraint;
  if (constraint.contact != Contact::separating) return false;
  const std::size_t number = static_cast<std::size_t>(constraint.collider) - physics_.n_obstacles();
  const double away = (velocity - bodies[number].at(constraint.arm)).dot(constraint.normal);
  if (body.in_force ? away <= tolerance : away >= -tolerance) return false;
  body.in_force = !body.in_force;
  return true;
}

GlobalIndex PressureContact::revise(const double* scale, const Node* free, double tolerance,
                                    std::span<const RigidVelocity> bodies) {
  GlobalIndex n_changed = 0;
  for (HeldNode& held : held_.things) {
    if (scale[held.node] == 0.0) continue;
    const Vec3 u = vector_of(free[held.node]);
    const Vec3 v = walls_of(held) * u + held.offset;
    bool revised = false;
    for (std::size_t k = held.first; k < held.end; ++k) {
      Constraint& constraint = constraints_[k];
      if (constraint.contact != Contact::separating) continue;
      const double speed = constraint.normal.dot((constraint.in_force ? u : v) - constraint.velocity);
      if (constraint.in_force ? speed <= tolerance : speed >= -tolerance) continue;
      constraint.in_force = !constraint.in_force;
      revised = true;
      n_changed += owns(held.node);
    }
    if (held.body >= 0 && revise_body(body_nodes_[static_cast<std::size_t>(held.body)], v, tolerance, bodies)) {
      revised = true;
      n_changed += owns(held.node);
    }
    if (revised) project(held);
  }
  return n_changed;
}

std::size_t PressureContact::memory() const {
  return (all_nodes_.capacity() + nodes_.things.capacity() + wave_of_.capacity() + end_of_wave_.capacity()) *
             sizeof(LocalIndex) +
         is_owned_.capacity() + waves_.memory() + numbers_.memory() + fixed_.capacity() * sizeof(NodeConstraint) +
         (all_images_.capacity() + images_.things.capacity()) * sizeof(NodeImage) +
         (all_repeated_.capacity() + repeated_.things.capacity()) * sizeof(CellGrid::Copy) +
         constraints_.capacity() * sizeof(Constraint) + held_.things.capacity() * sizeof(HeldNode) +
         body_nodes_.capacity() * sizeof(BodyNode) + feeds_.memory() + (moving_ ? moving_->memory() : 0);
}

}  // namespace bulkley
