#pragma once
// A force of a scene: what an integrator adds to the internal forces and to gravity, on nodes or on particles.

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "base/named_numbers.hpp"
#include "distribution/particle_grid.hpp"
#include "grid/box_fields.hpp"
#include "integrator/physics.hpp"
#include "kernel/grid_update.hpp"
#include "kernel/p2g.hpp"

namespace bulkley {

/// The owned nodes that particles reach, in a step from `time` to `time` + update.dt.
struct ForcedNodes {
  ParticleGrid& particles;             ///< as they are at the start of the step
  std::span<const LocalIndex> active;  ///< Exchange::active_nodes
  std::span<const Int3> positions;     ///< grid indices of the active nodes
  const GridUpdate& update;            ///< dt, gravity, and the mass below which a node is empty
  double time;                         ///< s
  const Node* momenta;                 ///< {m v, m}, indexed by `active`
  Node* impulses;                      ///< {dt f, -}: the force's share is added here; may be `momenta`
};

class NodeForce {
 public:
  virtual ~NodeForce() = default;

  /// Unique among the forces of a run, [a-z_]: names its numbers in checkpoints.
  virtual const char* name() const = 0;
  /// Before the nodes of a step from `time` to `time` + `dt` are worked out, at each of its trials: what depends on particles alone.
  /// Collective.
  virtual void prepare(ParticleGrid& particles, double time, double dt) { (void)particles, (void)time, (void)dt; }
  /// After `prepare`: the force on each particle, of a force that acts on those; nodes receive it with p2g, and nothing by `add`. Not
  /// collective.
  virtual ForceField on_particles() const { return {}; }
  /// Adds dt f to the nodes that are not empty. A step may be tried several times before it is taken, so that nothing that a
  /// later step depends on may change here. Values that are not finite are counted in `failures`, with the node. Must give
  /// the same bits on any number of ranks, or the integrator says that it does not. Collective.
  virtual void add(const ForcedNodes& nodes, FailureCounts& failures) { (void)nodes, (void)failures; }
  /// The square of the speed of the waves that the force carries, m^2/s^2; it limits dt as that of elastic waves does. Not
  /// collective (the same on every rank).
  virtual double wave_speed_squared() const { return 0.0; }
  /// The step to `time` was taken. Collective.
  virtual void accept(double time, double dt) { (void)time, (void)dt; }
  /// What a restart must know, the same on every rank; `load` gets what `save` gave, without numbers that a checkpoint of
  /// before lacks. Not collective.
  virtual void save(Reals& reals, Integers& integers) const { (void)reals, (void)integers; }
  virtual void load(const Reals& reals, const Integers& integers) { (void)reals, (void)integers; }
  /// Fields on nodes that a restart must know, if any yet, under the force's name; `load_fields` gets them again, or not from a checkpoint
  /// of before. Collective.
  virtual std::optional<BoxFields> save_fields() const { return std::nullopt; }
  virtual void load_fields(ParticleGrid& particles, const BoxSource& source) { (void)particles, (void)source; }
  /// Its fields at `time`, s, of the particles as they are, for frames; none where it has none. Changes nothing that a step depends on.
  /// Collective.
  virtual std::optional<BoxFields> fields(ParticleGrid& particles, double time) {
    return (void)particles, (void)time, std::nullopt;
  }
  /// What it has to tell in history.csv, in the order of the columns that the run has for it. Not collective (the same on every rank).
  virtual std::vector<double> history() const { return {}; }
  /// Bytes on this rank. Not collective.
  virtual std::size_t memory() const { return 0; }
};

using NodeForces = std::vector<std::unique_ptr<NodeForce>>;

/// Those that a scene asks for. Not collective.
NodeForces node_forces_of(const Physics& physics);

/// The numbers of all forces, each as "force.NAME.NUMBER". Not collective.
void save_forces(const NodeForces& forces, Reals& reals, Integers& integers);
/// Gives every force its own among any numbers. Not collective.
void load_forces(NodeForces& forces, const Reals& reals, const Integers& integers);

}  // namespace bulkley
