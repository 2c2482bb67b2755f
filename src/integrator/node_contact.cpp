#include "integrator/node_contact.hpp"

#include <algorithm>

namespace bulkley {

ContactImpulses no_contact_impulses(const Physics& physics) {
  const GridGeometry& grid = physics.grid;
  double density = 1e-300;  // a run without materials has nothing to sum
  for (const NamedMaterial& named : physics.materials)
    density = std::max(density, std::visit([](const auto& law) { return law.density(); }, named.material));
  return {physics.colliders.size(), density * grid.cell_size * grid.cell_size * grid.cell_size,
          (grid.upper() - grid.lower).maxCoeff()};
}

NodeContact::NodeContact(const Physics& physics)
    : physics_(physics), none_(no_contact_impulses(physics)), impulses_(none_) {}

void NodeContact::fit(const Exchange& exchange) {
  const GridGeometry& grid = physics_.grid;
  const auto active = exchange.active_nodes();
  const std::vector<Int3> nodes = exchange.active_positions();
  constraints_ = node_constraints(grid, physics_.faces, physics_.colliders, nodes);
  const auto moves = [](const Collider& collider) { return collider.motion.moves(); };
  if (std::any_of(physics_.colliders.begin(), physics_.colliders.end(), moves))
    moving_constraints_.emplace(grid, physics_.colliders, nodes, std::vector(active.begin(), active.end()), constraints_);
  for (NodeConstraint& constraint : constraints_) constraint.node = active[static_cast<std::size_t>(constraint.node)];
  images_ = node_images(grid, physics_.faces, nodes);
  for (NodeImage& image : images_) {
    image.behind = active[static_cast<std::size_t>(image.behind)];
    image.front = active[static_cast<std::size_t>(image.front)];
  }
}

void NodeContact::apply(double time, double dt, Node* nodes, Node* change, ContactImpulses& received) {
  apply_constraints(constraints_, nodes, change, received);
  if (moving_constraints_) apply_constraints(moving_constraints_->at(time, dt), nodes, change, received);
  unfold_images(images_, nodes, change);
}

double NodeContact::collider_speed(double first, double last) const {
  return bulkley::collider_speed(physics_.grid, physics_.colliders, first, last);
}

ContactImpulses NodeContact::impulses(const Comm& comm) const {
  // Halves of 32 bits, so that sums over ranks cannot overflow; then the carries.
  constexpr std::int64_t low_half = 0xffffffff;
  std::vector<std::int64_t> words = impulses_.words();
  std::vector<std::int64_t> halves;
  for (std::size_t w = 0; w < words.size(); ++w) {
    halves.push_back(words[w] & low_half);
    // The topmost half carries the sign; the others are parts of a sum without one.
    halves.push_back(w % 2 == 1 ? words[w] >> 32 : (words[w] >> 32) & low_half);
  }
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, halves.data(), static_cast<int>(halves.size()), MPI_INT64_T, MPI_SUM, comm.get()));
  for (std::size_t h = 0; h < halves.size(); h += 4) {
    for (std::size_t k = h; k < h + 3; ++k) {
      halves[k + 1] += halves[k] >> 32;
      halves[k] &= low_half;
    }
    words[h / 2] = static_cast<std::int64_t>(static_cast<std::uint64_t>(halves[h + 1]) << 32) | halves[h];
    words[h / 2 + 1] = static_cast<std::int64_t>(static_cast<std::uint64_t>(halves[h + 3]) << 32) | halves[h + 2];
  }
  ContactImpulses total = impulses_;
  total.set_words(words);
  return total;
}

void NodeContact::set_impulses(const Comm& comm, const ContactImpulses& sums) {
  impulses_.clear();
  if (comm.is_root()) impulses_.add(sums);
}

std::size_t NodeContact::memory() const {
  return images_.capacity() * sizeof(NodeImage) + constraints_.capacity() * sizeof(NodeConstraint) +
         (moving_constraints_ ? moving_constraints_->memory() : 0);
}

}  // namespace bulkley
