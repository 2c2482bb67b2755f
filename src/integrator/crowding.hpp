#pragma once
// Particles that crowd, or leave a floor bare, without their volume ratios' knowledge (docs/theory.md, "Crowding" and "Voids at
// floors"): how much material is around each of them, over what has room there.

#include <vector>

#include "distribution/exchange.hpp"
#include "grid/floors.hpp"
#include "integrator/physics.hpp"
#include "integrator/rigid_contact.hpp"
#include "kernel/g2p.hpp"
#include "kernel/node_volume.hpp"
#include "kernel/stress_update.hpp"

namespace bulkley {

class Crowding {
 public:
  /// `physics` must outlive this. Fluids whose volume is a matter of cells take part. Particles come in blocks of `block_size`.
  Crowding(const Physics& physics, LocalIndex block_size);

  /// Finds the nodes near walls and behind them of new pools. Not collective.
  void fit(const Exchange& exchange);
  /// {-, m} of the owned nodes `active` -> {-, m over what the node has room for}, in materials of the largest density of all; nodes
  /// behind faces as those in front of them. Not collective.
  void find_fullness(std::span<const LocalIndex> active, Node* nodes) const;

  /// Where g2p leaves the fullness around the particles of a block; nowhere if no material takes part. Not collective.
  Gathered of_block();
  /// With `close_voids`: where moving colliders are at `time`, s, and rigid bodies, if there are any. Not collective.
  void find_moving(double time, const RigidContact* bodies);
  /// With `close_voids`: finds how much is missing around particles of a block that press on a floor within a cell of them, a face on
  /// which their weight lies, by the block's `pressures` (FloorPressure); nothing near what moves. Once g2p has left what it gathers and
  /// moved them. Not collective.
  void find_voids(const ParticleSet& particles, ParticleBlock block, const double* pressures);
  /// Takes out of a block what inflows carry: `carried` by particle, or null. Not collective.
  void spare(const char* carried, ParticleBlock block, LocalIndex n_particles);
  /// For the stress update of a material; nothing if it takes no part. Not collective.
  Room of_material(std::size_t m) const;

  std::size_t memory() const {
    std::size_t reals = fullness_.capacity() + voids_.capacity();
    for (const std::vector<double>& slopes : slopes_) reals += slopes.capacity();
    return near_walls_.capacity() * sizeof(NodeVolume) + behind_walls_.capacity() * sizeof(MirrorPair) +
           reals * sizeof(double) + takes_part_.capacity();
  }

 private:
  /// A collider that moves.
  struct Moving {
    const Shape& shape;
    Pose pose;
  };

  bool near_moving(const Vec3& x) const;

  const Physics& physics_;
  std::vector<char> takes_part_;        ///< by material
  std::vector<double> fullness_;        ///< of the particles of a block; empty if no material takes part
  std::vector<double> slopes_[3];       ///< likewise, per cell; empty along axes without floors
  std::vector<double> voids_;           ///< likewise; empty without `close_voids` or floors
  std::vector<double> lightness_;       ///< by material, the largest density over its own
  std::vector<Floor> floors_;           ///< where voids are closed
  std::vector<Moving> moving_;          ///< of `find_moving`, as the two below
  std::vector<Pose> body_poses_;
  const RigidContact* bodies_ = nullptr;
  std::vector<NodeVolume> near_walls_;    ///< owned nodes
  std::vector<MirrorPair> behind_walls_;  ///< likewise
  double inverse_full_mass_;              ///< of a node far from walls, 1/kg
};

}  // namespace bulkley
