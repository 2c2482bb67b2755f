#pragma once
// The particles of inflows: born behind the exit, carried by formula, released at it (docs/theory.md, "Inflow").

#include <span>
#include <vector>

#include "base/named_numbers.hpp"
#include "distribution/particle_grid.hpp"
#include "grid/contact_impulse.hpp"
#include "integrator/energy_budget.hpp"
#include "integrator/physics.hpp"

namespace bulkley {

/// Appends the particles that are within the front `last` of a feed and not within `first`, as they are with its nozzle in the state
/// `nozzle`, whose tiles belong to `rank`; `local` learns of them. Not collective.
void append_layers(const Physics& physics, std::size_t feed, const NozzleState& nozzle, const Feed::Front& first,
                   const Feed::Front& last, const TileMap& map, int rank, ParticleSet& particles, StepBounds& local);

/// Appends all that the feeds hold at the time 0. Not collective.
void append_first_layers(const Physics& physics, const TileMap& map, int rank, ParticleSet& particles);

/// `bounds` with what enters while feeds run: its waves, viscosity and speed limit the step that it enters in. Not collective.
void include_feeds(const Physics& physics, double time, StepBounds& bounds);

/// Calls visit(feed, p) for the particles that feeds carry at `time`. Not collective.
template <class Visit>
void for_each_carried(const Physics& physics, double time, const ParticleSet& particles, Visit visit) {
  for (std::size_t f = 0; f < physics.feeds.size(); ++f) {
    const Feed& feed = physics.feeds[f];
    if (!feed.runs(time)) continue;
    const Feed::Front released = feed.released(time);
    for (LocalIndex p = 0; p < particles.size(); ++p)
      if (const GlobalIndex id = particles.id()[p];
          feed.owns(id) && !feed.is_within(released, feed.layer_of(id), feed.point_of(id)))
        visit(f, p);
  }
}

class FeedParticles {
 public:
  /// Both must outlive this.
  FeedParticles(const Physics& physics, EnergyBudget& budget)
      : physics_(physics), budget_(budget), pushed_back_(physics.feeds.size(), 0), stretches_(physics.feeds.size(), 1.0) {}

  bool any() const { return !physics_.feeds.empty(); }

  /// Within a step that is taken, in this order; `carry` to `show_dilation` for each block. Not collective.
  void begin(double time, double end, const ParticleSet& particles, const ContactImpulses& none);
  /// After g2p, which has left velocity gradients in the field `gradient`: particles of the feeds get the place and velocity of the
  /// formulas; what has come back into a feed goes to the exit.
  void carry(Field gradient, ParticleSet& particles, StepBounds& local, ParticleBlock block);
  /// Around the stress update, which must not see that a feed turns: it has the stress that it was born with, or of its profile.
  void hide_spin(Field gradient, ParticleSet& particles);
  void show_spin(Field gradient, ParticleSet& particles);
  /// With an implicit pressure, after the stress update: J of carried particles as the nodes would change it, which their cells must
  /// know; update_volumes puts it back.
  void show_dilation(ParticleSet& particles);
  /// By particle, whether it is carried, for update_volumes; null where there are no inflows.
  const char* carried() const { return any() ? carried_.data() : nullptr; }
  /// Births, the end of what is left of a feed, and the pressures that are measured. Before ParticleGrid::finish_move. Collective.
  void finish(ParticleGrid& grid, StepBounds& local);

  /// What the material has received apart from nodes, in the entries of no_contact_impulses.
  const ContactImpulses& received() const { return received_; }

  /// By feed, NozzleState::stretch: J in front of the exit at the end of the step before, smoothed, where the scene has the pressure
  /// measured; 1 elsewhere.
  std::span<const double> stretches() const { return stretches_; }
  /// By feed, how often a particle that came back into it was put back to the exit, over all ranks. Collective.
  std::vector<GlobalIndex> pushed_back(const Comm& comm) const;

  /// What a restart must find again. `save` is collective; after `load` the root has the counts.
  void save(const Comm& comm, Reals& reals, Integers& integers) const;
  void load(const Comm& comm, const Reals& reals, const Integers& integers);

 private:
  /// A feed in the present step.
  struct Now {
    NozzleState end;        ///< of the step
    bool runs;              ///< at the start of the step
    bool stops;             ///< before its end
    Feed::Front released;   ///< at the start of the step
    Feed::Front born;       ///< likewise
    Feed::Front last_born;  ///< at the end of the step
    Feed::Front last_released;
  };
  void measure_pressures(const Comm& comm, const ParticleSet& particles);
  using GradientOf = Mat3 (*)(const Feed& feed, const NozzleState& nozzle, const Feed::Point& point);
  void set_gradients_of_held(GradientOf gradient_of, Field field, ParticleSet& particles);
  void add_momentum(std::size_t feed, const Vec3& momentum);
  void hold(std::size_t feed, LocalIndex p, Field gradient, ParticleSet& particles, StepBounds& local);

  const Physics& physics_;
  EnergyBudget& budget_;
  std::vector<GlobalIndex> pushed_back_;  ///< by this rank
  std::vector<double> stretches_;
  ContactImpulses received_;
  double end_ = 0.0, dt_ = 0.0;
  std::vector<Now> now_;
  std::vector<LocalIndex> held_;  ///< of the present block
  std::vector<std::size_t> feed_of_held_;
  std::vector<double> dilation_of_held_;  ///< det (1 + dt L) of g2p; only with an implicit pressure
  std::vector<char> carried_;             ///< by particle
  std::vector<LocalIndex> left_;          ///< particles of feeds that end in this step
};

}  // namespace bulkley
