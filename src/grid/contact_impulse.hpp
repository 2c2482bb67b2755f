#pragma once
// What the material does to the colliders: sums of impulses whose bits depend neither on their order nor on the number of
// ranks.
//
// The unit is 2^-70 of the momentum of a full cell at 1 m/s, the same for a whole run, with room for 2^57 such momenta.

#include <cstdint>
#include <span>
#include <vector>

#include "bulkley/base/types.hpp"
#include "grid/exact_sums.hpp"

namespace bulkley {

class ContactImpulses {
 public:
  ContactImpulses() = default;
  /// `cell_mass`: about the mass of a full cell, kg; `length`: about the size of the domain, m. Both choose the units only
  /// and must be the same on every rank and in every part of a run.
  ContactImpulses(std::size_t n_colliders, double cell_mass, double length);

  std::size_t n_colliders() const { return impulses_.size() / 3; }
  /// Adds `impulse` (kg m/s) that the material gives to a collider at `arm` (m) from its centre. What is not finite is left
  /// out: the step that it belongs to fails.
  void add(std::size_t collider, const Vec3& impulse, const Vec3& arm);
  void add(const ContactImpulses& other);
  void clear();

  Vec3 impulse(std::size_t collider) const;          ///< kg m/s
  Vec3 angular_impulse(std::size_t collider) const;  ///< kg m^2/s, about the collider's centre of each step

  /// All sums as 64-bit words, low and high of each in turn; `set_words` takes them back. For checkpoints and messages.
  std::vector<std::int64_t> words() const;
  void set_words(std::span<const std::int64_t> words);

 private:
  ExactSums impulses_, angular_impulses_;  ///< three a collider
};

}  // namespace bulkley
