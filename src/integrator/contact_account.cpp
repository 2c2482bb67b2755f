#include "integrator/contact_account.hpp"

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

/// What the motion of the wall adds to the velocity behind it, m/s.
Vec3 added_behind(const NodeImage& image) { return (Vec3::Ones() - image.sign).cwiseProduct(image.velocity); }

std::size_t place_of(const NodeConstraint& constraint) {
  return static_cast<std::size_t>(constraint.collider < 0 ? face_of(constraint)
                                                          : static_cast<int>(n_faces) + constraint.collider);
}

}  // namespace

void ContactAccount::clear() {
  for (Place& place : places_) {
    place.energy.clear();
    place.work.clear();
  }
  for (std::vector<double>* addends : {&before_, &after_, &kicks_, &gravity_}) addends->clear();
  behind_.clear();
  for (const LocalIndex node : kicked_) number_[static_cast<std::size_t>(node)] = -1;
  kicked_.clear();
  kick_.clear();
}

// Only a wall that moves does work here: at one at rest, what is behind has the energy of its image in front.
void ContactAccount::fold(const GridUpdate& update, std::span<const NodeImage> images, Node* nodes, Node* impulse) {
  const Vec3 fall = update.dt * update.gravity;
  for (const NodeImage& image : images) {
    Folded folded{nodes[image.behind].c[3], Vec3::Zero(), Vec3::Zero()};
    if (image.velocity.isZero(0.0)) {
      fold_images(update, {&image, 1}, nodes, impulse);
      behind_.push_back(folded);
      continue;
    }
    // With impulses known apart: of the momenta before them. In one: of all.
    const Vec3 weight = impulse ? Vec3::Zero() : fall;
    const auto momentum = [&](LocalIndex n) -> Vec3 {
      return vector_of(nodes[n]) + nodes[n].c[3] * weight - (update.joined ? vector_of(impulse[n]) : Vec3::Zero());
    };
    folded.momentum = momentum(image.behind);
    const Vec3 before = momentum(image.front) + folded.momentum;
    const Vec3 kick = impulse ? Vec3(vector_of(impulse[image.behind]) + folded.mass * fall) : Vec3::Zero();
    fold_images(update, {&image, 1}, nodes, impulse);
    folded.given = momentum(image.front) - before;
    behind_.push_back(folded);
    if (!impulse) continue;
    // The impulse behind pushes against the motion of the wall, which the one in front no longer shows.
    const double turned = added_behind(image).dot(kick);
    Place& place = places_[static_cast<std::size_t>(image.face)];
    kicks_.push_back(turned);
    place.energy.push_back(-turned);
    place.work.push_back(-turned);
  }
}

Vec3 ContactAccount::kick_of(LocalIndex node, const Node* change) {
  const auto n = static_cast<std::size_t>(node);
  if (n >= number_.size()) number_.resize(n + 1, -1);
  if (number_[n] < 0) {
    number_[n] = static_cast<LocalIndex>(kicked_.size());
    kicked_.push_back(node);
    kick_.push_back(vector_of(change[node]));
  }
  return kick_[static_cast<std::size_t>(number_[n])];
}

// A node goes from v0 by impulses to v0 + kick and by contact to v1. The work of each is taken along (v0 + v1) / 2, so that
// forces in balance do none. Where v0 is not known it is taken along v1.
void ContactAccount::apply(std::span<const NodeConstraint> constraints, Node* nodes, Node* change,
                           ContactImpulses& received) {
  for (const NodeConstraint& constraint : constraints) {
    const Node& node = nodes[constraint.node];
    const double mass = node.c[3];
    const Vec3 before = vector_of(node);
    const Vec3 kick = change && mass > 0.0 ? kick_of(constraint.node, change) : Vec3::Zero();
    apply_constraints({&constraint, 1}, nodes, change, received);
    const Vec3 after = vector_of(node);
    if (!(mass > 0.0) || before == after) continue;
    const Vec3 impulse = mass * (after - before);
    Place& place = places_[place_of(constraint)];
    place.energy.push_back(change ? 0.5 * impulse.dot(before + after - kick) : impulse.dot(after));
    if (change) kicks_.push_back(0.5 * impulse.dot(kick));
    if (!constraint.velocity.isZero(0.0)) place.work.push_back(impulse.dot(constraint.velocity));
  }
}

// The wall turns the velocities behind about its own. Apart from impulses, the particles follow the change of the nodes in the
// step, and only the share of their velocity that is replaced also what the fold has done to the velocities before.
void ContactAccount::unfold(const GridUpdate& update, std::span<const NodeImage> images, Node* nodes, Node* change) {
  BULKLEY_ASSERT(behind_.size() == images.size());
  const Vec3 fall = update.dt * update.gravity;
  for (std::size_t i = images.size(); i-- > 0;) {
    const NodeImage& image = images[i];
    unfold_images({&image, 1}, nodes, change);
    const Folded& folded = behind_[i];
    const double mass = folded.mass;
    if (!(mass > 0.0)) continue;
    const Vec3 behind = vector_of(nodes[image.behind]), front = vector_of(nodes[image.front]);
    gravity_.push_back(mass * fall.dot(behind - front));
    if (image.velocity.isZero(0.0)) continue;
    Place& place = places_[static_cast<std::size_t>(image.face)];
    const double energy = 0.5 * mass * (behind - front).dot(behind + front);
    after_.push_back(energy);
    if (!change) {
      place.energy.push_back(added_behind(image).dot(mass * behind - folded.momentum));
      place.work.push_back(image.velocity.dot(folded.given + mass * (behind - front)));
      continue;
    }
    const Vec3 front_before = front - vector_of(change[image.front]);
    const Vec3 behind_before = behind - vector_of(change[image.behind]);
    const double energy_before = 0.5 * mass * (behind_before - front_before).dot(behind_before + front_before);
    const double replaced = (1.0 - kept_share_) * image.velocity.dot(folded.given + mass * (behind_before - front_before));
    before_.push_back(-energy_before);
    before_.push_back(replaced);
    for (const double part : {energy, -energy_before, replaced}) place.energy.push_back(part);
    place.work.push_back(mass * image.velocity.dot((behind - front) - (behind_before - front_before)));
    place.work.push_back(replaced);
  }
}

std::size_t ContactAccount::memory() const {
  std::size_t numbers = before_.capacity() + after_.capacity() + kicks_.capacity() + gravity_.capacity() +
                        7 * behind_.capacity() + 3 * kick_.capacity();
  for (const Place& place : places_) numbers += place.energy.capacity() + place.work.capacity();
  return numbers * sizeof(double) + (kicked_.capacity() + number_.capacity()) * sizeof(LocalIndex);
}

}  // namespace bulkley
