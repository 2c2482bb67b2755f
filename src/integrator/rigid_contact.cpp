#include "integrator/rigid_contact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "geometry/mesh_shape.hpp"
#include "parallel/reproducible_sum.hpp"
#include "stepping/failure.hpp"

namespace bulkley {

namespace {

constexpr double deepest_overlap = 1.0;  // cells; deeper is no collision any more
// Of (T-R1), to find which nodes separate. Two to six are the rule.
constexpr int most_passes = 30;
constexpr double settled_change = 1e-13;  // of a motion from one pass to the next, over the motion

Vec6 joined(const Vec3& of_translation, const Vec3& of_rotation) {
  Vec6 both;
  both.head<3>() = of_translation;
  both.tail<3>() = of_rotation;
  return both;
}

std::optional<VectorField> field_of(const VectorFormula& formula) {
  return formula.given() ? std::optional<VectorField>(formula) : std::nullopt;
}

/// About the mass of a full cell, kg: the unit of sums.
double mass_of_a_cell(const Physics& physics) {
  return std::max(physics.largest_density(), 1e-300) * std::pow(physics.grid.cell_size, 3);
}

}  // namespace

RigidContact::RigidContact(const Physics& physics, const Comm& comm)
    : physics_(physics),
      comm_(comm),
      bodies_(physics.rigid_bodies),
      collisions_(physics.grid, physics.faces, physics.colliders, bodies_, starts_),
      accounts_(bodies_.size()),
      trials_(bodies_.size()),
      sums_(no_sums()),
      any_separates_(
          std::ranges::any_of(bodies_, [](const RigidBody& body) { return body.contact == Contact::separating; })) {
  for (RigidBody& body : bodies_) {
    starts_.push_back(start_of(body, physics.grid.cell_size));
    drives_.push_back({field_of(body.force), field_of(body.torque)});
    states_.push_back(starts_.back().state);
    body.shape = sampled_for_contact(body.shape, physics.grid.cell_size);
  }
}

void RigidContact::fit(std::vector<Int3> nodes, std::vector<LocalIndex> places, std::span<const NodeConstraint> walls) {
  nodes_ = std::move(nodes);
  places_ = std::move(places);
  walls_.assign(walls.begin(), walls.end());
  const LocalIndex last = places_.empty() ? 0 : *std::max_element(places_.begin(), places_.end());
  stuck_.assign(static_cast<std::size_t>(last) + 1, 0);
  for (const NodeConstraint& wall : walls_)
    if (wall.contact == Contact::sticky) stuck_[static_cast<std::size_t>(wall.node)] = 1;
}

ExactSums RigidContact::no_sums() const { return {n_sums * bodies_.size(), mass_of_a_cell(physics_)}; }

// Where volumes are those of cells, bodies reach as far as makes a plane act where it is, in the mean over where nodes
// lie: 0.15 cells less than sticky colliders.
double RigidContact::reach(const RigidBody& body) const {
  return physics_.keeps_volume_of_cells() ? 0.6 * physics_.grid.cell_size : reach_of_hold(physics_.grid, body);
}

// Of a body's surface; infinite where that is farther away than `clearance` by the body's size.
double RigidContact::distance_within(double clearance, std::size_t body, const Vec3& x, const Pose& pose) const {
  const Vec3 arm = nearest_arm(physics_.grid, states_[body].center, x);
  if (!(arm.norm() <= starts_[body].reach + clearance)) return std::numeric_limits<double>::infinity();
  return signed_distance(bodies_[body].shape, pose, states_[body].center + arm);
}

bool RigidContact::any_within(double clearance, const Vec3& x, std::span<const Pose> poses) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (distance_within(clearance, b, x, poses[b]) < clearance) return true;
  return false;
}

// A node within the reach of several bodies is of the one in which it is deepest.
std::optional<NodeConstraint> RigidContact::held_at(const Vec3& x, std::span<const Pose> poses) const {
  double deepest = std::numeric_limits<double>::infinity();
  std::optional<std::size_t> owner;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const double hold = reach(bodies_[b]), distance = distance_within(hold, b, x, poses[b]);
    if (distance <= hold && distance < deepest) {
      deepest = distance;
      owner = b;
    }
  }
  if (!owner) return std::nullopt;
  const RigidBody& body = bodies_[*owner];
  const Vec3 arm = nearest_arm(physics_.grid, states_[*owner].center, x);
  return NodeConstraint{-1,
                        body.contact,
                        body.material_friction,
                        outward_normal(body.shape, poses[*owner], states_[*owner].center + arm),
                        Vec3::Zero(),
                        static_cast<std::int32_t>(physics_.n_obstacles() + *owner),
                        arm};
}

// What a sticky wall holds is the wall's.
void RigidContact::find_held(std::span<const NodeConstraint> moving, double smallest_mass, const Node* nodes) {
  held_.clear();
  std::vector<std::uint8_t> stuck = stuck_;
  for (const NodeConstraint& wall : moving)
    if (wall.contact == Contact::sticky) stuck[static_cast<std::size_t>(wall.node)] = 1;
  const std::vector<Pose> poses = this->poses();
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const auto place = static_cast<std::size_t>(places_[n]);
    if (stuck[place] || !(nodes[place].c[3] > smallest_mass)) continue;
    std::optional<NodeConstraint> constraint = held_at(physics_.grid.node_position(nodes_[n]), poses);
    if (!constraint) continue;
    constraint->node = places_[n];
    held_.push_back(*constraint);
  }
}

void RigidContact::find_walls_again(std::span<const NodeConstraint> moving) {
  again_.clear();
  std::vector<std::uint8_t> is_held(stuck_.size(), 0);
  for (const NodeConstraint& constraint : held_) is_held[static_cast<std::size_t>(constraint.node)] = 1;
  for (const std::span<const NodeConstraint> walls : {std::span<const NodeConstraint>(walls_), moving})
    for (const NodeConstraint& wall : walls)
      if (is_held[static_cast<std::size_t>(wall.node)]) again_.push_back(wall);
}

// m J^T N J and m J^T N v of a node, N = a n n^T + b (1 - n n^T) with the shares a and b, lengths in units of the body's reach.
void RigidContact::add_node(const NodeConstraint& constraint, Share share, const Node& node, ExactSums& sums) const {
  const std::size_t body = body_of(constraint);
  const Vec3 arm = constraint.arm / scale(body), velocity = vector_of(node);
  const auto add_direction = [&](const Vec3& direction, double part) {
    const Vec6 row = joined(direction, arm.cross(direction));
    const double mass = part * node.c[3], along = direction.dot(velocity);
    std::size_t sum = n_sums * body;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j <= i; ++j) sums.add(sum++, mass * row[i] * row[j]);
    for (int i = 0; i < 6; ++i) sums.add(sum++, mass * row[i] * along);
  };
  if (share.tangential > 0.0)
    for (int a = 0; a < 3; ++a) add_direction(Vec3::Unit(a), share.tangential);
  if (share.normal > share.tangential) add_direction(constraint.normal, share.normal - share.tangential);
}

Vec3 RigidContact::body_velocity(const NodeConstraint& constraint, const std::vector<Vec6>& motions) const {
  const std::size_t body = body_of(constraint);
  const Vec6& u = motions[body];
  return RigidVelocity{u.head<3>(), u.tail<3>() / scale(body), Vec3::Zero()}.at(constraint.arm);
}

// Coulomb: of the slip the body takes what friction x |normal impulse| stops.
RigidContact::Share RigidContact::share_of(const NodeConstraint& constraint, const Node& node,
                                           const std::vector<Vec6>& motions) const {
  if (constraint.contact != Contact::separating) return share_in_contact(constraint);
  const Vec3 relative = vector_of(node) - body_velocity(constraint, motions);
  const double normal_speed = relative.dot(constraint.normal);
  if (normal_speed >= 0.0) return {0.0, 0.0};
  const double stopped = -constraint.friction * normal_speed, slip = (relative - normal_speed * constraint.normal).norm();
  if (stopped == 0.0) return share_in_contact(constraint);
  return {1.0, stopped >= slip ? 1.0 : stopped / slip};
}

RigidContact::Pushed RigidContact::pushed(std::size_t b, double time, const GridUpdate& update) {
  const RigidMass& mass = starts_[b].mass;
  const auto& guide = starts_[b].guide;
  const auto confine = [&](RigidState& state) {
    if (guide) set_rate(mass, *guide, rate_of(mass, *guide, state), state);
  };
  const auto read = [&](std::optional<VectorField>& field, const char* what) -> Vec3 {
    if (!field) return Vec3::Zero();
    const Vec3 value = (*field)(Vec3::Zero(), time + 0.5 * update.dt);
    if (!value.allFinite())
      throw StepFailure(fmt::format("the {} of rigid body '{}' is ({}, {}, {}) at {:.6g} s", what, bodies_[b].name, value[0],
                                    value[1], value[2], time + 0.5 * update.dt),
                        states_[b].center);
    return value;
  };
  RigidState state = states_[b];
  state.momentum += update.dt * mass.mass * update.gravity;
  confine(state);
  const double falling = kinetic_energy(mass, state), gravity_work = falling - kinetic_energy(mass, states_[b]);
  const Vec3 force = update.dt * read(drives_[b].force, "force"), torque = update.dt * read(drives_[b].torque, "torque");
  state.momentum += force;
  state.angular_momentum += torque;
  confine(state);
  return {state, update.dt * mass.mass * update.gravity + force, torque, gravity_work,
          kinetic_energy(mass, state) - falling};
}

MergedBody RigidContact::merged(std::size_t b, const Pushed& pushed, double dt, const ExactSums& sums) const {
  MergedBody body;
  std::size_t sum = n_sums * b;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) body.shared(i, j) = body.shared(j, i) = sums.value(sum++);
  for (int i = 0; i < 6; ++i) body.given[i] = sums.value(sum++);
  const RigidState& state = pushed.state;
  const auto& guide = starts_[b].guide;
  const double length = scale(b), stiffness = bodies_[b].spring;
  const bool winds = guide && guide->point;
  body.length = length;
  body.all = body.shared;
  body.all.topLeftCorner<3, 3>() += starts_[b].mass.mass * Mat3::Identity();
  body.all.bottomRightCorner<3, 3>() += world_inertia(starts_[b].mass, state) / (length * length);
  const Vec3 away = winds ? Vec3(Vec3::Zero()) : Vec3(state.center - starts_[b].state.center);
  if (!winds) body.all.topLeftCorner<3, 3>() += dt * dt * stiffness * Mat3::Identity();
  body.own = joined(state.momentum, state.angular_momentum / length);
  body.pull = joined(-dt * stiffness * away, Vec3::Zero());
  if (!guide) return body;
  const RigidVelocity unit = unit_velocity(*guide, state);
  body.freedom = joined(unit.velocity, length * unit.angular_velocity);
  body.winding = winds ? dt * stiffness : 0.0;
  body.wound = state.turn;
  body.dt = dt;
  return body;
}

std::vector<MergedBody> RigidContact::merged(double time, const GridUpdate& update, const ExactSums& sums) {
  std::vector<MergedBody> all;
  for (std::size_t b = 0; b < bodies_.size(); ++b) all.push_back(merged(b, pushed(b, time, update), update.dt, sums));
  return all;
}

// (T-R1) with the shares of its own solution. Where nodes may separate, those of the solution before, until that repeats. Whatever the
// shares, bodies get what nodes lose, and no energy comes of it.
std::vector<Vec6> RigidContact::find_motions(const std::vector<Pushed>& pushed, double dt, const Node* nodes) {
  std::vector<Vec6> motions;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidVelocity u = velocity(starts_[b].mass, pushed[b].state);
    motions.push_back(joined(u.velocity, scale(b) * u.angular_velocity));
  }
  bool settled = false;
  for (int pass = 1; !settled; ++pass) {
    shares_.clear();
    sums_.clear();
    for (const NodeConstraint& constraint : held_) {
      Share share = share_of(constraint, nodes[constraint.node], motions);
      if (pass > most_passes && share.tangential < 1.0) share.tangential = 0.0;  // so that constraints can state it exactly
      shares_.push_back(share);
      add_node(constraint, share, nodes[constraint.node], sums_);
    }
    merged_sums_ = sum_global(comm_, sums_);
    settled = !any_separates_ || pass > most_passes;
    bool all_same = true;
    for (std::size_t b = 0; b < bodies_.size(); ++b) {
      const Vec6 next = merged(b, pushed[b], dt, merged_sums_).velocity();
      all_same = all_same && (next - motions[b]).norm() <= settled_change * next.norm();
      motions[b] = next;
    }
    settled = settled || all_same;
  }
  return motions;
}

// Of the held nodes those that touch, with constraints that take the shares found.
void RigidContact::keep_contacts(const std::vector<Vec6>& motions, const Node* nodes) {
  std::size_t n_kept = 0;
  for (std::size_t n = 0; n < held_.size(); ++n) {
    const Share share = shares_[n];
    if (share.normal == 0.0) continue;
    NodeConstraint constraint = held_[n];
    constraint.velocity = body_velocity(constraint, motions);
    if (constraint.contact == Contact::separating) {
      const Vec3 relative = vector_of(nodes[constraint.node]) - constraint.velocity;
      const double normal_speed = relative.dot(constraint.normal);
      const double slip = (relative - normal_speed * constraint.normal).norm();
      const bool slides = share.tangential > 0.0 && share.tangential < 1.0 && normal_speed < 0.0;
      if (slides)
        constraint.friction = share.tangential * slip / -normal_speed;
      else
        constraint.contact = share.tangential == 1.0 ? Contact::sticky : Contact::slip;
    }
    held_[n_kept++] = constraint;
  }
  held_.erase(held_.begin() + static_cast<std::ptrdiff_t>(n_kept), held_.end());
}

// The body gets what the nodes lose.
void RigidContact::try_motion(std::size_t b, const Pushed& driven, double dt) {
  const RigidMass& mass = starts_[b].mass;
  const double stiffness = bodies_[b].spring, length = scale(b);
  const RigidState& before = driven.state;
  const MergedBody body = merged(b, driven, dt, merged_sums_);
  const Vec6 u = body.velocity(), impulse = body.given - body.shared * u;
  const bool winds = body.freedom && starts_[b].guide->point;
  const Vec3 stretch = winds ? Vec3::Zero() : Vec3((before.center - starts_[b].state.center) + dt * u.head<3>());
  const double wound = winds ? -body.winding * (body.wound + dt * body.rate()) * body.rate() : 0.0;
  const double spring_work = wound - dt * stiffness * stretch.dot(u.head<3>());
  RigidState after = before;
  after.momentum = mass.mass * u.head<3>();
  after.angular_momentum = world_inertia(mass, before) * u.tail<3>() / length;
  if (!body.freedom) {  // the same but for rounding; exactly what the nodes lose
    after.momentum = before.momentum + impulse.head<3>() + Vec3(-dt * stiffness * stretch);
    after.angular_momentum = before.angular_momentum + length * impulse.tail<3>();
  }
  Trial& trial = trials_[b];
  trial.gravity_work = driven.gravity_work;
  trial.applied_work = driven.applied_work + spring_work;
  trial.merging_loss = kinetic_energy(mass, before) + spring_work + impulse.dot(u) - kinetic_energy(mass, after);
  trial.momentum = after.momentum;
  trial.angular_momentum = after.angular_momentum;
  trial.impulse = impulse.head<3>();
  trial.angular_impulse = length * impulse.tail<3>();
  if (body.freedom) {  // what nothing else has given
    const Vec3 spring = -dt * stiffness * stretch;
    const double winding = winds ? -body.winding * (body.wound + dt * body.rate()) : 0.0;
    trial.guide_impulse =
        after.momentum - states_[b].momentum - driven.impulse - trial.impulse - (winds ? Vec3::Zero() : spring);
    trial.guide_angular_impulse = after.angular_momentum - states_[b].angular_momentum - driven.angular_impulse -
                                  trial.angular_impulse - winding * starts_[b].guide->direction;
  }
}

void RigidContact::merge(double time, const GridUpdate& update, std::span<const NodeConstraint> moving, const Node* nodes) {
  find_held(moving, update.smallest_mass, nodes);
  std::vector<Pushed> driven;
  for (std::size_t b = 0; b < bodies_.size(); ++b) driven.push_back(pushed(b, time, update));
  const std::vector<Vec6> motions = find_motions(driven, update.dt, nodes);
  for (std::size_t b = 0; b < bodies_.size(); ++b) try_motion(b, driven[b], update.dt);
  keep_contacts(motions, nodes);
  find_walls_again(moving);
}

void RigidContact::accept(double time, double dt) {
  const std::vector<RigidState> before = states_;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    states_[b].momentum = trials_[b].momentum;
    states_[b].angular_momentum = trials_[b].angular_momentum;
  }
  std::vector<CollisionEffect> collisions = collisions_.collide(time - dt, dt, before, states_);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Trial& trial = trials_[b];
    Account& account = accounts_[b];
    account.impulse += trial.impulse;
    account.angular_impulse += trial.angular_impulse;
    account.duration += dt;
    account.gravity_work += trial.gravity_work;
    account.applied_work += trial.applied_work;
    account.merging_loss += trial.merging_loss;
    account.guide_impulse += trial.guide_impulse;
    account.guide_angular_impulse += trial.guide_angular_impulse;
    const RigidState still = states_[b];
    advance(starts_[b].mass, starts_[b].guide, dt, states_[b]);
    if (starts_[b].guide) {  // it leads the body round its axis
      account.guide_impulse += states_[b].momentum - still.momentum;
      account.guide_angular_impulse += states_[b].angular_momentum - still.angular_momentum;
    }
  }
  collisions_.push_out(dt, states_, collisions);
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    accounts_[b].collision_impulse += collisions[b].impulse;
    accounts_[b].collision_work += collisions[b].work;
  }
  const double allowed = deepest_overlap * physics_.grid.cell_size;
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    if (const auto obstacle = obstacle_of(physics_.grid, physics_.colliders, bodies_, starts_, states_, b, time, allowed))
      throw StepFailure(fmt::format("rigid body '{}' reaches into {} by more than {:g} cells: it is squeezed between things "
                                    "that do not give way, or leaves the domain where there is no wall",
                                    bodies_[b].name, *obstacle, deepest_overlap),
                        states_[b].center);
}

double RigidContact::speed_bound(double duration) const {
  double fastest = 0.0;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const RigidVelocity now = velocity(starts_[b].mass, states_[b]);
    fastest = std::max(
        fastest, now.velocity.norm() + now.angular_velocity.norm() * starts_[b].reach + duration * physics_.gravity.norm());
  }
  return fastest;
}

std::vector<RigidVelocity> RigidContact::velocities() const {
  std::vector<RigidVelocity> all;
  for (std::size_t b = 0; b < bodies_.size(); ++b) all.push_back(velocity(starts_[b].mass, states_[b]));
  return all;
}

std::vector<Pose> RigidContact::poses() const {
  std::vector<Pose> poses;
  for (std::size_t b = 0; b < bodies_.size(); ++b) poses.push_back(pose_of(starts_[b], states_[b]));
  return poses;
}

std::vector<std::string> RigidContact::columns() {
  std::vector<std::string> columns;
  for (const auto& [quantity, unit] : {std::pair{"position", "m"},
                                       {"velocity", "m/s"},
                                       {"spin", "rad/s"},
                                       {"force", "N"},
                                       {"torque", "N m"},
                                       {"collision_force", "N"},
                                       {"guide_force", "N"},
                                       {"guide_torque", "N m"}})
    for (const char* axis : {"x", "y", "z"}) columns.push_back(fmt::format("{}_{} [{}]", quantity, axis, unit));
  columns.emplace_back("turn [rad]");
  for (const char* energy : {"kinetic_energy", "gravity_work", "applied_work", "merging_loss", "collision_work"})
    columns.push_back(fmt::format("{} [J]", energy));
  return columns;
}

std::vector<std::vector<double>> RigidContact::history() const {
  std::vector<std::vector<double>> rows;
  for (std::size_t b = 0; b < bodies_.size(); ++b) {
    const Account& account = accounts_[b];
    const RigidVelocity now = velocity(starts_[b].mass, states_[b]);
    const double per_second = account.duration > 0.0 ? 1.0 / account.duration : 0.0;
    std::vector<double>& row = rows.emplace_back();
    for (const Vec3& v : {states_[b].center, now.velocity, now.angular_velocity, Vec3(per_second * account.impulse),
                          Vec3(per_second * account.angular_impulse), Vec3(per_second * account.collision_impulse),
                          Vec3(per_second * account.guide_impulse), Vec3(per_second * account.guide_angular_impulse)})
      for (int a = 0; a < 3; ++a) row.push_back(v[a]);
    row.push_back(states_[b].turn);
    row.push_back(kinetic_energy(starts_[b].mass, states_[b]));
    row.push_back(account.gravity_work);
    row.push_back(account.applied_work);
    row.push_back(account.merging_loss);
    row.push_back(account.collision_work);
  }
  return rows;
}

void RigidContact::begin_history() {
  for (Account& account : accounts_) {
    for (Vec3* impulse : {&account.impulse, &account.angular_impulse, &account.collision_impulse, &account.guide_impulse,
                          &account.guide_angular_impulse})
      *impulse = Vec3::Zero();
    account.duration = 0.0;
  }
}

// One list of numbers serves both directions.
void RigidContact::for_each_number(auto& state, auto& account, const auto& visit) {
  const auto visit_vector = [&](const std::string& name, auto& vector) {
    for (int a = 0; a < 3; ++a) visit(fmt::format("{}.{}", name, a), vector[a]);
  };
  visit_vector("center", state.center);
  for (int c = 0; c < 4; ++c) visit(fmt::format("rotation.{}", c), state.rotation.coeffs()[c]);
  visit_vector("momentum", state.momentum);
  visit_vector("angular_momentum", state.angular_momentum);
  visit("turn", state.turn);
  visit_vector("impulse", account.impulse);
  visit_vector("angular_impulse", account.angular_impulse);
  visit("duration", account.duration);
  visit("gravity_work", account.gravity_work);
  visit("applied_work", account.applied_work);
  visit("merging_loss", account.merging_loss);
  visit_vector("collision_impulse", account.collision_impulse);
  visit("collision_work", account.collision_work);
  visit_vector("guide_impulse", account.guide_impulse);
  visit_vector("guide_angular_impulse", account.guide_angular_impulse);
}

void RigidContact::save(Reals& reals) const {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    for_each_number(states_[b], accounts_[b],
                    [&](const std::string& name, double number) { reals[fmt::format("{}.{}", b, name)] = number; });
}

void RigidContact::load(const Reals& reals) {
  for (std::size_t b = 0; b < bodies_.size(); ++b)
    for_each_number(states_[b], accounts_[b], [&](const std::string& name, double& number) {
      if (const auto found = reals.find(fmt::format("{}.{}", b, name)); found != reals.end()) number = found->second;
    });
}

std::size_t RigidContact::memory() const {
  return nodes_.capacity() * sizeof(Int3) + places_.capacity() * sizeof(LocalIndex) + stuck_.capacity() +
         (walls_.capacity() + held_.capacity() + again_.capacity()) * sizeof(NodeConstraint) +
         shares_.capacity() * sizeof(Share);
}

}  // namespace bulkley
