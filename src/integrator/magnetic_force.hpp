#pragma once
// The force of a scene's magnetic field.

#include "integrator/node_force.hpp"
#include "magnetostatics/magnetic_particles.hpp"

namespace bulkley {

/// What the field was when it was solved for last, and the solutions so far. The same on every rank.
struct MagneticFigures {
  double time = std::numeric_limits<double>::quiet_NaN();  ///< s, of the last solution; NaN before the first
  double energy =
      std::numeric_limits<double>::quiet_NaN();  ///< J, of material and field together, less that of the sources alone
  double source_work = 0.0;                      ///< J, given by sources that changed
  Vec3 force = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());   ///< N, on all particles
  Vec3 moment = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());  ///< A m^2
  GlobalIndex n_solves = 0, n_iterations = 0, n_sweeps = 0;

  /// The columns of history.csv that hold them, in the order of values().
  static const std::vector<std::string>& columns();
  std::vector<double> values() const;
};

/// f_i = sum_p w_ip F_p with the forces F_p of the last solution of the field (G10), which particles carry along as
/// `magnetic_force`, so that translation costs no accuracy. The field is solved for before the first step, and before a step in which
/// the fastest particle would have gone `resolve_distance` since, or `largest_interval` would have passed and a source changes. Every
/// solution starts from the potential of the last one, which checkpoints keep.
class MagneticForce : public NodeForce {
 public:
  MagneticForce(const GridGeometry& grid, const Magnets& magnets);

  const char* name() const override { return "magnetic_field"; }
  void prepare(ParticleGrid& particles, double time, double dt) override;
  ForceField on_particles() const override { return ParticleForce{Field::magnetic_force, largest_}; }
  double wave_speed_squared() const override { return wave_speed_squared_; }
  void accept(double time, double dt) override;
  void save(Reals& reals, Integers& integers) const override;
  void load(const Reals& reals, const Integers& integers) override;
  std::optional<BoxFields> save_fields() const override;
  void load_fields(ParticleGrid& particles, const BoxSource& source) override;
  std::optional<BoxFields> fields(ParticleGrid& particles, double time) override;
  std::vector<double> history() const override { return figures_.values(); }
  std::size_t memory() const override;

 private:
  template <class Force, class Real, class Integer>
  static void each(Force& force, Real real, Integer integer);
  bool due(double time, double dt) const;
  Magnetostatics& field_on(const ParticleGrid& particles);
  MagneticReport find_field(double time, ParticleGrid& particles);
  void solve(double time, ParticleGrid& particles);
  void describe(double time, const ParticleGrid& particles, const MagneticReport& report);

  GridGeometry grid_;
  Magnets magnets_;
  AppliedField applied_;
  std::unique_ptr<MagneticParticles> field_;
  MagneticFigures figures_;
  double travelled_ = 0.0;           ///< m, of the fastest particle since the last solution
  double speed_ = 0.0;               ///< m/s, of the step that is tried
  double largest_ = 0.0;             ///< N, of all particles
  double source_power_ = 0.0;        ///< W, of changing sources, ahead of the last solution by largest_interval
  double wave_speed_squared_ = 0.0;  ///< m^2/s^2
};

}  // namespace bulkley
