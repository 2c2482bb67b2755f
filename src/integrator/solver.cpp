#include "integrator/solver.hpp"

#include <algorithm>
#include <cmath>

#include "integrator/describe_failure.hpp"
#include "integrator/explicit_step.hpp"
#include "kernel/measure_particles.hpp"
#include "kernel/stress_update.hpp"

namespace bulkley {

namespace {

const std::string rigid_prefix = "force.rigid_bodies.", feed_prefix = "force.inflows.";  // no force has these names

template <class Number>
std::map<std::string, Number> without_prefix(const std::map<std::string, Number>& numbers, const std::string& prefix) {
  std::map<std::string, Number> result;
  for (const auto& [name, number] : numbers)
    if (name.starts_with(prefix)) result[name.substr(prefix.size())] = number;
  return result;
}

// Wave speed, viscosity and stress bounds of particles as they are, without a step.
void measure_state(const std::vector<NamedMaterial>& materials, const ParticleSet& particles, StepBounds& bounds) {
  const StressOfState of_state(materials);
  const ParticleStress stress(particles, of_state);
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    double rounding = 0.0;
    const double J = particles.real(Field::volume_ratio)[p];
    const GlobalIndex id = particles.id()[p];
    std::visit(
        [&](const auto& law) {
          const double speed_squared = law.wave_speed_squared(particle_state(law, particles, p));
          bounds.motion.wave_speed.include(std::sqrt(speed_squared), id);
          rounding = stress_rounding * law.density() * speed_squared;
          if (law.viscosity() > 0.0) bounds.motion.viscosity.include(J * law.viscosity() / law.density(), id);
        },
        materials[particles.material()[p]].material);
    bounds.sums.stress_volume.include(particles.real(Field::reference_volume)[p] *
                                      std::hypot(std::sqrt(norm_squared(stress.of_one(p))), rounding));
    bounds.totals.smallest_volume_ratio.include(J);
    bounds.totals.largest_volume_ratio.include(J);
  }
}

// The bounds that the first step needs, from the particles as they were seeded. `present`: those after they were
// distributed.
StepBounds measured_start(const Physics& physics, const ParticleSet& particles, const StepBounds& present) {
  StepBounds local;
  measure_particles(physics.grid, physics.transfer, particles, local);
  measure_state(physics.materials, particles, local);
  local.sums.cell_count = present.sums.cell_count;
  local.totals.n_particles.value = particles.size();
  local.transport.largest_share.value = particles.size();
  return local;
}

}  // namespace

std::unique_ptr<Integrator> integrator_of(StepParts& parts) { return std::make_unique<ExplicitStep>(parts); }

Solver::Solver(const Comm& comm, Physics physics, Partition partition, ParticleSet particles,
               std::optional<StepBounds> bounds)
    : Solver(comm, physics, std::move(partition), std::move(particles), bounds, node_forces_of(physics), integrator_of) {}

Solver::Solver(const Comm& comm, Physics physics, Partition partition, ParticleSet particles,
               std::optional<StepBounds> bounds, NodeForces forces, const MakeIntegrator& make_integrator)
    : physics_(std::move(physics)),
      grid_(comm, physics_.grid, physics_.faces, static_cast<int>(physics_.materials.size()), std::move(partition),
            std::move(particles), times_),
      parts_(physics_, grid_, std::move(forces), times_),
      integrator_(make_integrator(parts_)) {
  if (grid_.bounds().failed()) report_failure(grid_.bounds());
  grid_.set_bounds(bounds ? *bounds : grid_.reduce(measured_start(physics_, grid_.particles(), grid_.bounds())));
}

StepReport Solver::step(const StepRequest& request, TimeStepState& state) {
  try {
    StepReport report = integrator_->step(request, state);
    if (report.bounds.failed()) report_failure(report.bounds);
    return report;
  } catch (const NoStep& reason) {  // the same on every rank
    throw_failure(grid_.comm(), particles(), physics_.materials, reason);
  }
}

void Solver::report_failure(const StepBounds& bounds) const {
  throw_failure(grid_.comm(), physics_.grid, particles(), physics_.materials, bounds);
}

GlobalIndex Solver::adopt(Partition partition) {
  const GlobalIndex n_moved = grid_.adopt(std::move(partition));
  integrator_->fit();
  return n_moved;
}

std::vector<Node> Solver::node_values(double time) {
  if (!node_grid_) node_grid_.emplace(grid_.comm(), node_fields(physics_.grid));
  if (scatter_version_ != grid_.version()) {
    to_node_grid_.emplace(grid_.comm(), exchange(), *node_grid_);
    scatter_version_ = grid_.version();
  }
  const std::span<const Node> nodes = integrator_->node_velocities(time);
  std::vector<Node> values(static_cast<std::size_t>(node_grid_->n_owned()));
  to_node_grid_->to_field(reinterpret_cast<const double*>(nodes.data()), reinterpret_cast<double*>(values.data()));
  return values;
}

std::optional<BoxFields> Solver::force_fields(double time) {
  for (const auto& force : parts_.forces)
    if (auto fields = force->fields(grid_, time)) return fields;
  return {};
}

std::vector<BoxFields> Solver::save_force_fields() const {
  std::vector<BoxFields> all;
  for (const auto& force : parts_.forces)
    if (auto fields = force->save_fields()) all.push_back(std::move(*fields));
  return all;
}

void Solver::load_force_fields(const BoxSource& source) {
  for (const auto& force : parts_.forces) force->load_fields(grid_, source);
}

std::vector<double> Solver::force_history() const {
  std::vector<double> values;
  for (const auto& force : parts_.forces) {
    const std::vector<double> own = force->history();
    values.insert(values.end(), own.begin(), own.end());
  }
  return values;
}

void Solver::save_forces(Reals& reals, Integers& integers) const {
  bulkley::save_forces(parts_.forces, reals, integers);
  Reals bodies;
  if (const RigidContact* const rigid = parts_.contact.rigid_bodies()) rigid->save(bodies);
  for (const auto& [name, number] : bodies) reals[rigid_prefix + name] = number;
  Reals feed_reals;
  Integers feed_integers;
  parts_.feeds.save(grid_.comm(), feed_reals, feed_integers);
  for (const auto& [name, number] : feed_reals) reals[feed_prefix + name] = number;
  for (const auto& [name, number] : feed_integers) integers[feed_prefix + name] = number;
}

void Solver::load_forces(const Reals& reals, const Integers& integers) {
  bulkley::load_forces(parts_.forces, reals, integers);
  if (RigidContact* const rigid = parts_.contact.rigid_bodies()) rigid->load(without_prefix(reals, rigid_prefix));
  parts_.feeds.load(grid_.comm(), without_prefix(reals, feed_prefix), without_prefix(integers, feed_prefix));
}

GlobalIndex Solver::halo_bytes() const {
  const std::size_t once = exchange().sent_by_add().bytes + exchange().sent_by_get().bytes;
  return integrator_->n_exchanges() * static_cast<GlobalIndex>(once);
}

}  // namespace bulkley
