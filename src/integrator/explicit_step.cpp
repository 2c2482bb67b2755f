#include "integrator/explicit_step.hpp"

#include <algorithm>

#include "integrator/describe_failure.hpp"
#include "kernel/g2p.hpp"
#include "kernel/p2g.hpp"
#include "kernel/stress_update.hpp"

namespace bulkley {

namespace {

// Particles are advanced in blocks whose columns stay in the second-level cache from one kernel to the next.
constexpr LocalIndex block_size = 1024;

// A node with less than this part of the largest possible nodal mass counts as empty: there the rounding of the order-free
// sums nears the velocity itself. No larger than that, for what an empty node received is lost to the particles.
constexpr double empty_mass = 0x1p-48;

}  // namespace

ExplicitStep::ExplicitStep(StepParts& parts)
    : parts_(parts),
      stress_(parts.physics.materials),
      splits_(parts.physics.transfer.keeps_residual()),
      impulses_(splits_                           ? Impulses::apart
                : parts.physics.separate_energies ? Impulses::both
                                                  : Impulses::joined),
      floor_pressure_(parts.physics, block_size),
      crowding_(parts.physics, block_size),
      layers_(parts.physics, block_size),
      received_(parts.contact.no_impulses()) {
  parts_.budget.set_combined(impulses_ == Impulses::joined);
  if (!parts.physics.shares_dilation.empty()) dilation_ = std::make_unique<CellDilation>(parts, stress_);
  if (!parts.physics.volumetric_laws.empty()) pressure_ = std::make_unique<ImplicitPressure>(parts);
  if (!parts.physics.implicit_viscosities.empty()) viscosity_ = std::make_unique<ImplicitViscosity>(parts);
  for (const NamedMaterial& named : parts.physics.materials)
    shear_wave_speed_ = std::max(shear_wave_speed_, shear_wave_speed_at_rest(named.material));
}

StepReport ExplicitStep::step(const StepRequest& request, TimeStepState& state) {
  const TimeStepSettings& settings = parts_.physics.time_stepping;
  const double cell_size = parts_.physics.grid.cell_size;
  ParticleGrid& particles = parts_.particles;
  fit();
  StepReport report;
  StepBounds local;
  const StepBounds before = parts_.with_waves_of_forces(particles.bounds(), request.time);
  const double colliders = collider_speed(before, request.time, request.remaining);
  for (;;) {
    report.plan = plan_step(settings, cell_size, before, colliders, request.remaining, state);
    local = {};
    compute_nodes(request.time, report.plan.dt, report, local);
    if (!report.viscosity.solved || !report.pressure.solved) {
      const ImplicitPart part = report.viscosity.solved ? ImplicitPart::pressure : ImplicitPart::viscosity;
      reject_unsolved(settings, report.plan, part, report.pressure.fault, state);
      ++report.n_rejected;
      continue;
    }
    if (!report.plan.checked) break;
    const StepBounds motion = trial_motion(report.plan, local);
    if (motion.failed()) {  // a smaller step cannot fix it
      report.bounds = motion;
      return report;
    }
    if (is_acceptable(settings, cell_size, report.plan, motion)) break;
    reject_step(settings, report.plan, motion, state);
    ++report.n_rejected;
  }
  parts_.contact.add(received_);
  parts_.budget.accept(particles.particles());
  local.requests.caller.include(request.from_rank);
  const double sum = request.time + report.plan.dt;
  if (parts_.feeds.any())
    parts_.feeds.begin(request.time, report.plan.lands ? request.landing.value_or(sum) : sum, particles.particles(),
                       parts_.contact.no_impulses());
  crowding_.find_moving(request.time, parts_.contact.rigid_bodies());
  nodes_to_particles(report.plan.dt, local);
  report.bounds = particles.finish_move(local);
  if (report.bounds.failed()) return report;
  check_motion(parts_.comm(), settings, cell_size, report.plan.dt, particles.particles(), report.bounds);
  accept_step(settings, report.plan, report.bounds, state);
  for (const auto& force : parts_.forces) force->accept(request.time + report.plan.dt, report.plan.dt);
  if (RigidContact* const bodies = parts_.contact.rigid_bodies())
    bodies->accept(request.time + report.plan.dt, report.plan.dt);
  return report;
}

// Particles -> the velocities of the nodes in every pool. Changes no particle.
void ExplicitStep::compute_nodes(double time, double dt, StepReport& report, StepBounds& local) {
  parts_.prepare_forces(time, dt);
  const ForceField force = parts_.force_on_particles();
  const SumBounds sums = sum_bounds(parts_.physics.grid, parts_.physics.transfer, parts_.particles.bounds(), dt, splits_,
                                    force, dilation_ != nullptr);
  particles_to_nodes(time, dt, sums, force);
  update_nodes(time, {parts_.physics.gravity, dt, empty_mass * sums.mass, impulses_ == Impulses::both}, report, local);
  if (dt > 0.0) crowding_.find_fullness(parts_.particles.exchange().active_nodes(), velocity_.data());
  nodes_to_pools();
}

TimeStepLimit ExplicitStep::dt_limit(const StepBounds& bounds, double time, double remaining) const {
  const StepBounds all = parts_.with_waves_of_forces(bounds, time);
  return time_step_limit(parts_.physics.time_stepping, parts_.physics.grid.cell_size, all,
                         collider_speed(all, time, remaining));
}

// A collider as fast as the material may move as far: until the end of the longest step that the material allows.
double ExplicitStep::collider_speed(const StepBounds& bounds, double time, double remaining) const {
  const TimeStepLimit by_material =
      time_step_limit(parts_.physics.time_stepping, parts_.physics.grid.cell_size, bounds, 0.0);
  return parts_.contact.collider_speed(time, time + std::min(remaining, by_material.dt));
}

// By the particles as they are before the step.
double ExplicitStep::kept_share(double dt) const {
  const Physics& physics = parts_.physics;
  const double cell_size = physics.grid.cell_size;
  const MotionBounds& motion = parts_.particles.bounds().motion;
  // Implicit viscosity crosses cells, too.
  const double crossing = shear_wave_speed_ + (viscosity_ ? viscosity_->kinematic_viscosity() / cell_size : 0.0);
  return physics.transfer.kept_share(dt, physics.transfer.decay_rate(cell_size, motion, crossing));
}

void ExplicitStep::fit() {
  if (!parts_.fit()) return;
  const PhaseTimer timer(parts_.times, Phase::rebuild);
  const auto n_owned = static_cast<std::size_t>(parts_.particles.exchange().n_owned());
  const auto n_pool = static_cast<std::size_t>(parts_.particles.layout().n_nodes());
  const auto zeros = [](auto& nodes, std::size_t n) {
    renew(nodes, n);
    std::ranges::fill(nodes, typename std::decay_t<decltype(nodes)>::value_type{});
  };
  zeros(velocity_, n_owned);
  crowding_.fit(parts_.particles.exchange());
  if (impulses_ != Impulses::joined) {
    zeros(change_, n_owned);
    zeros(pairs_, n_pool);
  }
  if (!splits_) zeros(pool_, n_pool);
}

void ExplicitStep::particles_to_nodes(double time, double dt, const SumBounds& sums, const ForceField& force) {
  ParticleGrid& particles = parts_.particles;
  const auto sum_into = [&](auto* pool, auto... impulses) {
    const PhaseTimer timer(parts_.times, Phase::p2g);
    if (dilation_) dilation_->begin(time, dt);
    p2g(particles.grid(), parts_.physics.transfer, particles.layout(), particles.particles(), particles.map(), sums, dt,
        pool, force, impulses..., dilation_ ? dilation_->means() : CellMeans{}, stress_);
  };
  const bool joined = impulses_ == Impulses::joined;
  if (joined)
    sum_into(pool_.data());
  else
    sum_into(pairs_.data(), impulses_);
  const PhaseTimer timer(parts_.times, Phase::exchange);
  if (joined)
    particles.exchange().add(pool_.data(), velocity_.data());
  else
    particles.exchange().add(pairs_.data(), velocity_.data(), change_.data());
}

// The phases of explicit forces, of viscosity, of the pressure and of contact follow each other.
void ExplicitStep::update_nodes(double time, const GridUpdate& update, StepReport& report, StepBounds& local) {
  Node* const nodes = velocity_.data();
  push_nodes(time, update, local);
  if (update.dt > 0.0) solve_implicit_parts(time, update, report);
  const PhaseTimer timer(parts_.times, Phase::grid_update);
  received_.clear();
  parts_.contact.apply(time, update, parts_.feeds.stretches(), nodes, change(), received_, parts_.budget.contact());
  parts_.budget.after_contact(update, parts_.particles.exchange().active_nodes(), nodes);
}

// Viscosity meets the motion that the pressure of the last step would leave; the pressure then replaces that.
void ExplicitStep::solve_implicit_parts(double time, const GridUpdate& update, StepReport& report) {
  Node* const nodes = velocity_.data();
  report.viscosity = {};
  report.pressure = {};
  if (pressure_) pressure_->begin(time, update, nodes);
  if (viscosity_) {
    const std::span<const Node> predicted = pressure_ ? pressure_->last_impulses(update.dt) : std::span<const Node>();
    report.viscosity = viscosity_->apply(time, update, predicted, nodes, change());
    if (!report.viscosity.solved) return;
    if (pressure_) pressure_->fetch(nodes);
  }
  if (pressure_) report.pressure = pressure_->apply(time, update, report.plan.unclipped, nodes, change());
}

void ExplicitStep::push_nodes(double time, const GridUpdate& update, StepBounds& local) {
  const PhaseTimer timer(parts_.times, Phase::grid_update);
  Node* const nodes = velocity_.data();
  EnergyBudget& budget = parts_.budget;
  const auto active = parts_.particles.exchange().active_nodes();
  budget.begin_trial();
  const double share = kept_share(update.dt);
  budget.contact().set_kept_share(share);
  parts_.add_forces(update, time, nodes, splits_ ? change() : nodes, local.failures);
  if (update.joined) budget.add_forces_to(change(), active);
  parts_.contact.set_kept_share(share);
  parts_.contact.fold(update, nodes, change(), budget.contact());
  budget.before_kick(update, active, nodes, change());
  grid_update(update, active, nodes, change());
}

void ExplicitStep::nodes_to_pools() {
  const PhaseTimer timer(parts_.times, Phase::exchange);
  if (splits_)
    parts_.particles.exchange().get(velocity_.data(), change_.data(), pairs_.data());
  else
    parts_.particles.exchange().get(velocity_.data(), pool_.data());
}

// The motion that the nodes would give the particles, as far as it decides about the step, merged over ranks. One more
// all-reduce, on trial steps and steps at risk.
StepBounds ExplicitStep::trial_motion(const TimeStepPlan& plan, const StepBounds& local) {
  const PhaseTimer timer(parts_.times, Phase::judge);
  const ParticleGrid& particles = parts_.particles;
  StepBounds motion = local;
  const MotionLimits ample = ample_limits(parts_.physics.time_stepping, particles.grid().cell_size, plan);
  const auto measure = [&](const auto* nodes) {
    measure_motion(particles.grid(), parts_.physics.transfer, particles.layout(), particles.map(), nodes,
                   particles.particles(), motion, ample);
  };
  if (splits_)
    measure(pairs_.data());
  else
    measure(pool_.data());
  return particles.reduce(motion);
}

// Nodes -> particles, their stress, and their new cells, block by block.
void ExplicitStep::nodes_to_particles(double dt, StepBounds& local) {
  const Physics& physics = parts_.physics;
  const Field gradient = physics.transfer.needs_velocity_gradient() ? Field::velocity_gradient : Field::affine_velocity;
  ParticleGrid& grid = parts_.particles;
  ParticleSet& particles = grid.particles();
  const TransferSettings& transfer = physics.transfer;
  const double share = kept_share(dt);
  CellMeans means;
  if (dilation_) {
    const PhaseTimer timer(parts_.times, Phase::g2p);
    splits_ ? dilation_->find_dilation(dt, pairs_.data()) : dilation_->find_dilation(dt, pool_.data());
    means = dilation_->means();
  }
  Gathered gathered = crowding_.of_block();
  gathered.kinetic_energy = parts_.budget.room_for_moved(block_size);
  grid.begin_move();
  for (LocalIndex first = 0; first < particles.size(); first += block_size) {
    const ParticleBlock block{first, first + block_size};
    particles.hold_block(block);
    {
      const PhaseTimer timer(parts_.times, Phase::g2p);
      parts_.before_move(block);
      if (splits_)
        g2p(physics.grid, transfer, grid.layout(), grid.map(), dt, share, pairs_.data(), particles, local, block,
            gathered);
      else
        g2p(physics.grid, transfer, grid.layout(), grid.map(), dt, pool_.data(), particles, local, block,
            gathered);
      if (parts_.feeds.any()) parts_.feeds.carry(gradient, particles, local, block);
      floor_pressure_.find(dt, particles, block);
      crowding_.find_voids(particles, block, floor_pressure_.of_block());
      crowding_.spare(parts_.feeds.carried(), block, particles.size());
      parts_.after_move(block);
    }
    if (pressure_) pressure_->keep_volumes(block);
    {
      const PhaseTimer timer(parts_.times, Phase::stress_update);
      if (parts_.feeds.any()) parts_.feeds.hide_spin(gradient, particles);
      layers_.find(particles, block, floor_pressure_.of_block());
      double begin = MPI_Wtime();
      for (std::size_t m = 0; m < physics.materials.size(); ++m) {
        stress_update(physics.materials[m].material, static_cast<std::uint8_t>(m), gradient, dt, particles, local, block,
                      means, crowding_.of_material(m), layers_.of_material(m));
        const double end = MPI_Wtime();
        parts_.material_seconds[m] += end - begin;
        begin = end;
      }
      if (parts_.feeds.any()) parts_.feeds.show_spin(gradient, particles);
      if (parts_.feeds.any() && pressure_) parts_.feeds.show_dilation(particles);
      if (viscosity_) viscosity_->record(gradient, dt, block);
    }
    grid.place(block);
  }
  if (pressure_) pressure_->update_volumes(local);
  parts_.budget.end_step(particles, grid.removed());
  if (!parts_.feeds.any()) return;
  parts_.feeds.finish(grid, local);
  parts_.contact.add(parts_.feeds.received());
}

std::span<const Node> ExplicitStep::node_velocities(double time) {
  fit();
  StepReport report;
  StepBounds none;
  compute_nodes(time, 0.0, report, none);
  return velocity_;
}

std::size_t ExplicitStep::memory() const {
  return (pool_.capacity() + velocity_.capacity() + change_.capacity()) * sizeof(Node) +
         pairs_.capacity() * sizeof(NodePair) + floor_pressure_.memory() + crowding_.memory() + layers_.memory() + (dilation_ ? dilation_->memory() : 0) +
         (pressure_ ? pressure_->memory() : 0) + (viscosity_ ? viscosity_->memory() : 0);
}

}  // namespace bulkley
