#pragma once
// The particles of inflows: born behind the exit, carried by formula, released at it (docs/theory.md, "Inflow").

#include <vector>

#include "distribution/particle_grid.hpp"
#include "grid/contact_impulse.hpp"
#include "integrator/energy_budget.hpp"
#include "integrator/physics.hpp"

namespace bulkley {

/// Appends the particles of the layers first < k <= last of a feed as they are at `time` whose tiles belong to `rank`; `local`
/// learns of them. Not collective.
void append_layers(const Physics& physics, std::size_t feed, double time, GlobalIndex first, GlobalIndex last,
                   const TileMap& map, int rank, ParticleSet& particles, StepBounds& local);

/// Appends all that the feeds hold at the time 0. Not collective.
void append_first_layers(const Physics& physics, const TileMap& map, int rank, ParticleSet& particles);

/// `bounds` with what enters while feeds run: its waves, viscosity and speed limit the step that it enters in. Not collective.
void include_feeds(const Physics& physics, double time, StepBounds& bounds);

class FeedParticles {
 public:
  /// Both must outlive this.
  FeedParticles(const Physics& physics, EnergyBudget& budget) : physics_(physics), budget_(budget) {}

  bool any() const { return !physics_.feeds.empty(); }

  /// Within a step that is taken, in this order; `carry` and `hide_spin`, `show_spin` for each block. Not collective.
  void begin(double time, double end, const ContactImpulses& none);
  /// After g2p: particles of the feeds get the place and velocity of the formulas; what has come back into a feed goes to the exit.
  void carry(ParticleSet& particles, StepBounds& local, ParticleBlock block);
  /// Around the stress update, which must not see that a feed turns: it has the stress that it was born with.
  void hide_spin(Field gradient, ParticleSet& particles);
  void show_spin(Field gradient, ParticleSet& particles);
  /// Births, and the end of what is left of a feed. Before ParticleGrid::finish_move. Not collective.
  void finish(ParticleGrid& grid, StepBounds& local);

  /// What the material has received apart from nodes, in the entries of no_contact_impulses.
  const ContactImpulses& received() const { return received_; }

 private:
  /// A feed in the present step.
  struct Now {
    NozzleState end;        ///< of the step
    bool runs;              ///< at the start of the step
    bool stops;             ///< before its end
    GlobalIndex released;   ///< layers at the start of the step
    GlobalIndex born;       ///< likewise
    GlobalIndex last_born;  ///< at the end of the step
    GlobalIndex last_released;
  };
  void add_momentum(std::size_t feed, const Vec3& momentum);
  void hold(std::size_t feed, LocalIndex p, ParticleSet& particles, StepBounds& local);

  const Physics& physics_;
  EnergyBudget& budget_;
  ContactImpulses received_;
  double end_ = 0.0;
  std::vector<Now> now_;
  std::vector<LocalIndex> held_;  ///< of the present block
  std::vector<std::size_t> feed_of_held_;
  std::vector<LocalIndex> left_;  ///< particles of feeds that end in this step
};

}  // namespace bulkley
