#include "integrator/magnetic_force.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "parallel/reproducible_sum.hpp"

namespace bulkley {

const std::vector<std::string>& MagneticFigures::columns() {
  static const std::vector<std::string> names = {
      "magnetic_field_time [s]",   "magnetic_energy [J]",  "magnetic_source_work [J]",  "magnetic_force_x [N]",
      "magnetic_force_y [N]",      "magnetic_force_z [N]", "magnetic_moment_x [A m^2]", "magnetic_moment_y [A m^2]",
      "magnetic_moment_z [A m^2]", "magnetic_solves",      "magnetic_iterations",       "magnetic_sweeps"};
  return names;
}

std::vector<double> MagneticFigures::values() const {
  return {time,
          energy,
          source_work,
          force[0],
          force[1],
          force[2],
          moment[0],
          moment[1],
          moment[2],
          static_cast<double>(n_solves),
          static_cast<double>(n_iterations),
          static_cast<double>(n_sweeps)};
}

MagneticForce::MagneticForce(const GridGeometry& grid, const Magnets& magnets)
    : grid_(grid), magnets_(magnets), applied_(magnets.settings.sources) {}

bool MagneticForce::due(double time, double dt) const {
  const MagneticsSettings& settings = magnets_.settings;
  if (figures_.n_solves == 0) return true;
  if (figures_.time == time) return false;  // of an earlier trial of this step
  if (travelled_ + speed_ * dt > settings.resolve_distance * grid_.cell_size) return true;
  return settings.largest_interval > 0.0 && time + dt - figures_.time > settings.largest_interval &&
         applied_.changes(figures_.time, time + dt);
}

void MagneticForce::prepare(ParticleGrid& particles, double time, double dt) {
  speed_ = particles.bounds().motion.speed.value;
  if (due(time, dt)) solve(time, particles);
}

// The field's nodes, made when they are needed first. Collective.
Magnetostatics& MagneticForce::field_on(const ParticleGrid& particles) {
  if (!field_) {
    const Vec3 middle = 0.5 * (magnets_.lower + magnets_.upper);
    field_ = std::make_unique<MagneticParticles>(
        particles.comm(), magnetic_layout(grid_, magnets_.lower, magnets_.upper, magnets_.settings.air), magnets_.settings,
        magnets_.settings.origin.value_or(middle), magnets_.magnetisations, applied_);
  }
  return field_->field();
}

// Throws RunError where there is no solution.
MagneticReport MagneticForce::find_field(double time, ParticleGrid& particles) {
  field_on(particles);
  const MagneticReport report = field_->solve(time, particles);
  if (!report.solved)
    throw RunError(fmt::format(
        "the magnetic field at t = {:.6g} s is not found in {} iterations: the residual is {:.2g} of the right side, "
        "the largest relative permeability {:.3g}; choose a larger magnetics.tolerance or a finer grid",
        time, report.n_iterations, report.residual, report.largest_permeability));
  if (!report.settled)
    throw RunError(fmt::format(
        "the magnetic field at t = {:.6g} s is not found in {} sweeps: a permeability still changes by {:.2g}, the largest "
        "is {:.3g}; choose a larger magnetics.picard_limit or magnetics.picard_tolerance",
        time, report.n_sweeps, report.change, report.largest_permeability));
  return report;
}

void MagneticForce::solve(double time, ParticleGrid& particles) {
  const MagneticReport report = find_field(time, particles);
  ParticleSet& set = particles.particles();
  for (int a = 0; a < 3; ++a)
    std::copy(field_->forces(a).begin(), field_->forces(a).end(), set.real(Field::magnetic_force, a));
  if (set.has(Field::magnetic_field_strength))
    std::copy(field_->strengths().begin(), field_->strengths().end(), set.real(Field::magnetic_field_strength));
  field_->show(particles);
  describe(time, particles, report);
  travelled_ = 0.0;
}

// Magnetic stiffness is of the order of mu_0 M^2 (1 + chi/3).
void MagneticForce::describe(double time, const ParticleGrid& particles, const MagneticReport& report) {
  const Comm& comm = particles.comm();
  Magnetostatics& field = field_->field();
  double largest = 0.0;
  for (int a = 0; a < 3; ++a) {
    for (const double f : field_->forces(a)) largest = std::max(largest, std::abs(f));
    figures_.force[a] = reproducible_sum(comm, field_->forces(a));
  }
  largest_ = max_global(comm, largest);

  std::vector<double> strongest(magnets_.magnetisations.size(), 0.0);
  const std::uint8_t* const material = particles.particles().material();
  const Densities& densities = particles.particles().densities();
  for (std::size_t p = 0; p < field_->strengths().size(); ++p)
    strongest[material[p]] = std::max(strongest[material[p]], field_->strengths()[p]);
  double square = 0.0;
  for (std::size_t m = 0; m < strongest.size(); ++m) {
    if (!magnets_.magnetisations[m]) continue;
    const double M = magnets_.magnetisations[m]->at(strongest[m]);
    const double stiffening = 1.0 + magnets_.magnetisations[m]->initial_susceptibility() / 3.0;
    square = std::max(square, vacuum_permeability * M * M * stiffening / densities[static_cast<std::uint8_t>(m)]);
  }
  wave_speed_squared_ = max_global(comm, square);

  figures_.energy = 0.0 - field.co_energy();  // never -0
  figures_.moment = field.moment();
  // The mean of what M before and M now make of the sources' change; that of before is known as a rate alone.
  if (figures_.n_solves > 0)
    figures_.source_work += 0.5 * (source_power_ * (time - figures_.time) - field.source_work(figures_.time));
  const double interval = magnets_.settings.largest_interval;
  source_power_ = interval > 0.0 ? field.source_work(time + interval) / interval : 0.0;
  figures_.time = time;
  ++figures_.n_solves;
  figures_.n_iterations += report.n_iterations;
  figures_.n_sweeps += report.n_sweeps;
}

std::optional<BoxFields> MagneticForce::fields(ParticleGrid& particles, double time) {
  Magnetostatics& field = field_on(particles);
  const std::vector<double> start = field.potential();
  find_field(time, particles);
  BoxFields shown = field.shown();
  field.set_potential(start);  // a run with frames keeps the bits of one without
  return shown;
}

std::optional<BoxFields> MagneticForce::save_fields() const {
  if (figures_.n_solves == 0) return {};
  BoxFields box = field_->field().box();
  box.fields = {
      {"potential", "A", "phi of the last solution, from which the next one starts", {field_->field().potential()}}};
  return box;
}

void MagneticForce::load_fields(ParticleGrid& particles, const BoxSource& source) {
  if (figures_.n_solves == 0) return;
  Magnetostatics& field = field_on(particles);
  BoxFields box = field.box();
  box.fields = {{"potential", "A", "", {field.potential()}}};
  if (source(box)) field.set_potential(std::move(box.fields[0].components[0]));
}

void MagneticForce::accept(double, double dt) { travelled_ += speed_ * dt; }

// `real(name, number)` and `integer(name, number)` of all that a restart must know; `force`: this, constant or not.
template <class Force, class Real, class Integer>
void MagneticForce::each(Force& force, Real real, Integer integer) {
  auto& figures = force.figures_;
  integer("n_solves", figures.n_solves);
  integer("n_iterations", figures.n_iterations);
  integer("n_sweeps", figures.n_sweeps);
  real("travelled", force.travelled_);
  real("largest", force.largest_);
  real("wave_speed_squared", force.wave_speed_squared_);
  real("source_power", force.source_power_);
  real("time", figures.time);
  real("energy", figures.energy);
  real("source_work", figures.source_work);
  for (int a = 0; a < 3; ++a) {
    real(fmt::format("force_{}", "xyz"[a]), figures.force[a]);
    real(fmt::format("moment_{}", "xyz"[a]), figures.moment[a]);
  }
}

void MagneticForce::save(Reals& reals, Integers& integers) const {
  if (figures_.n_solves == 0) return;
  each(
      *this, [&](const std::string& name, double value) { reals[name] = value; },
      [&](const std::string& name, GlobalIndex value) { integers[name] = value; });
}

void MagneticForce::load(const Reals& reals, const Integers& integers) {
  if (!integers.contains("n_solves")) return;
  each(
      *this, [&](const std::string& name, double& value) { value = reals.at(name); },
      [&](const std::string& name, GlobalIndex& value) { value = integers.at(name); });
}

std::size_t MagneticForce::memory() const { return field_ ? field_->memory() : 0; }

}  // namespace bulkley
