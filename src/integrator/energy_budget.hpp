#pragma once
// Where the energy of a run goes: sums over all steps, measured between the stages of each (docs/theory.md, "Energy budget").
//
// Every sum is a BinnedSum: exact enough that the difference of large numbers is right, and the same bits for any order and
// any number of ranks. Each rank keeps its own; only what is written is merged.

#include <array>
#include <span>
#include <string>
#include <vector>

#include "base/binned_sum.hpp"
#include "bulkley/parallel/comm.hpp"
#include "integrator/contact_account.hpp"
#include "integrator/diagnostics.hpp"
#include "integrator/physics.hpp"

namespace bulkley {

/// Sums since the budget began, J, over all ranks.
struct EnergyTotals {
  double to_grid = 0.0;    ///< kinetic energy lost from particles to nodes; with `combined`, to nodes after impulses
  double kicks = 0.0;      ///< work of all impulses but contact on the nodes; with `combined` 0
  double from_grid = 0.0;  ///< kinetic energy lost from nodes to particles
  double gravity = 0.0;    ///< work of gravity along the motion at the end of the steps
  double removed_kinetic = 0.0, removed_elastic = 0.0;  ///< of particles that were removed
  double removed_dissipation = 0.0;                     ///< what their laws had dissipated
  std::vector<double> forces;                           ///< work of each node force, likewise along the final motion
  std::vector<double> fed_kinetic, fed_elastic;         ///< brought in by each inflow
  std::vector<double> contact_energy, contact_work;     ///< by place of contact: see ContactAccount::Place
  bool combined = false;  ///< momenta and impulses are summed in one: velocities before impulses are not known
};

/// What the account measures changes against.
struct EnergyStart {
  double kinetic = 0.0, elastic = 0.0, dissipated = 0.0;  ///< J
};

/// The account: losses count as positive, works as what the material receives. All J, since the budget began.
struct EnergyAccount {
  double kinetic = 0.0, elastic = 0.0;  ///< changes
  double dissipated = 0.0;              ///< by the laws, that of removed particles included
  double gravity = 0.0;
  std::vector<double> forces;
  double to_grid = 0.0, time_integration = 0.0;  ///< NaN where only their sum is known
  double to_grid_and_integration = 0.0;
  double from_grid = 0.0;
  double removed = 0.0;                            ///< kinetic and elastic, of removed particles
  double removed_dissipation = 0.0;                ///< what of `dissipated` their laws had done
  std::vector<double> contact_loss, contact_work;  ///< by place of contact
  std::vector<double> fed;                         ///< kinetic and elastic, brought in by each inflow
  double residual = 0.0;                           ///< what is left of the sum of all; rounding
};

/// `now`: of the particles as they are. Not collective.
EnergyAccount energy_account(const EnergyTotals& totals, const EnergyStart& start, const Diagnostics& now);

/// Of one particle, J.
struct ParticleEnergies {
  double kinetic, elastic;
};

class EnergyBudget {
 public:
  /// `physics` must outlive this.
  EnergyBudget(const Physics& physics, std::size_t n_forces);

  /// Whether the integrator knows the sum of momenta and impulses alone (EnergyTotals::combined). Not collective.
  void set_combined(bool combined) { combined_ = combined; }

  /// Within a step, and again for every trial of it, in this order. Not collective.
  void begin_trial();
  /// Force number `force` is about to add to `impulses`, and has done so.
  void before_force(std::span<const LocalIndex> active, const Node* impulses);
  void after_force(std::size_t force, std::span<const LocalIndex> active, const Node* impulses);
  /// Adds what all forces have added to `impulses`. Not collective.
  void add_forces_to(Node* impulses, std::span<const LocalIndex> active) const;
  /// For NodeContact.
  ContactAccount& contact() { return contact_; }
  /// Folded momenta and impulses, before grid_update; `impulse` is null where combined. Where nodes hold the impulses as well
  /// (`update.joined`), `add_forces_to` has completed them.
  void before_kick(const GridUpdate& update, std::span<const LocalIndex> active, const Node* nodes, const Node* impulse);
  /// Folded impulses that come after the node update; `nodes` before them.
  void later_kick(const GridUpdate& update, std::span<const LocalIndex> active, const Node* nodes, const Node* impulses);
  /// Velocities after contact.
  void after_contact(const GridUpdate& update, std::span<const LocalIndex> active, const Node* nodes);

  /// The trial was taken; `particles` are still those before it. Then all blocks of particles with their new velocities, then
  /// those that will be removed. Not collective.
  void accept(const ParticleSet& particles);
  /// Around the motion of a block, where a force acts on particles: the work of force number `force`, which `field` holds, N.
  void before_move(const ParticleSet& particles, ParticleBlock block);
  void add_force_work(std::size_t force, Field field, const ParticleSet& particles, ParticleBlock block);
  /// Where g2p leaves the kinetic energies of a block of at most `size` particles, and that it has done so for that many.
  double* room_for_moved(LocalIndex size);
  void add_moved(LocalIndex size);
  void end_step(const ParticleSet& particles, std::span<const LocalIndex> removed);

  /// Of particle p, for the next two. Not collective.
  ParticleEnergies energies_of(const ParticleSet& particles, LocalIndex p) const;
  /// After g2p of its block: a feed has changed the energies of a particle by those. Not collective.
  void add_carried(std::size_t feed, const ParticleEnergies& changes);
  /// After end_step: a feed has brought in a particle with these energies, or with their opposites taken one out. Not collective.
  void add_fed(std::size_t feed, const ParticleEnergies& energies);

  /// Sums of all ranks. Collective.
  std::vector<BinnedSum> sums(const Comm& comm) const;
  EnergyTotals totals(const Comm& comm) const;
  /// The same as words for a checkpoint, and back: true if there are as many as this run has. Not collective, but `words`.
  std::vector<std::int64_t> words(const Comm& comm) const;
  bool set_words(const Comm& comm, std::span<const std::int64_t> words);

  std::size_t memory() const;

 private:
  enum Term : std::size_t {
    kinetic,  // of the particles as they are
    to_grid,
    kicks,
    from_grid,
    gravity,
    removed_kinetic,
    removed_elastic,
    removed_dissipation,
    n_terms
  };
  std::size_t force_term(std::size_t force) const { return n_terms + force; }
  std::size_t fed_term(std::size_t feed) const {
    return energy_term(n_faces + physics_.n_obstacles() + physics_.rigid_bodies.size()) + 2 * feed;
  }
  std::size_t energy_term(std::size_t place) const { return n_terms + n_forces_ + 2 * place; }

  const Physics& physics_;
  std::size_t n_forces_;
  double inertia_;
  bool combined_ = false;
  bool knows_kinetic_ = false;
  std::vector<BinnedSum> sums_, trial_;
  ContactAccount contact_;
  std::vector<Vec3> impulse_before_;               // of active nodes
  std::vector<std::vector<Vec3>> force_impulses_;  // by force on nodes, of active nodes
  std::array<std::vector<double>, 3> start_;       // of a block: positions before its motion
  std::vector<double> moved_;                      // likewise: kinetic energies after it
};

}  // namespace bulkley
