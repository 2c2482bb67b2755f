#include "integrator/feed_particles.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "integrator/gauge_contact.hpp"
#include "kernel/bspline.hpp"
#include "kernel/measure_particles.hpp"
#include "kernel/stress_update.hpp"
#include "parallel/reproducible_sum.hpp"

namespace bulkley {

namespace {

Mat3 cross_matrix(const Vec3& w) {
  Mat3 m;
  m << 0.0, -w[2], w[1], w[2], 0.0, -w[0], -w[1], w[0], 0.0;
  return m;
}

void set_gradient(ParticleSet& particles, Field field, LocalIndex p, const Mat3& gradient) {
  for (int c = 0; c < 9; ++c) particles.real(field, c)[p] = gradient(c / 3, c % 3);
}

/// Of a carried particle, as the stress update sees it, and as it moves.
Mat3 hidden_gradient(const Feed& feed, const NozzleState& nozzle, const Feed::Point& point) {
  return feed.is_plug() ? Mat3(Mat3::Zero()) : feed.shear(nozzle, point);
}

Mat3 full_gradient(const Feed& feed, const NozzleState& nozzle, const Feed::Point& point) {
  const Mat3 spin = cross_matrix(nozzle.spin);
  return feed.is_plug() ? spin : Mat3(spin + feed.shear(nozzle, point));
}

Mat3 gradient_of(const ParticleSet& particles, Field field, LocalIndex p) {
  Mat3 gradient;
  for (int c = 0; c < 9; ++c) gradient(c / 3, c % 3) = particles.real(field, c)[p];
  return gradient;
}

/// With an implicit pressure, that of a material; null else.
const VolumetricLaw* volumetric_law_of(const Physics& physics, std::size_t material) {
  if (physics.volumetric_laws.empty() || !physics.volumetric_laws[material]) return nullptr;
  return &*physics.volumetric_laws[material];
}

void append(const ParticleSet& from, ParticleSet& to) {
  const LocalIndex before = to.size();
  to.resize(ParticleSet::checked_size(GlobalIndex{before} + from.size()));
  for (std::size_t c = 0; c < to.columns().size(); ++c) {
    if (!to.columns()[c].moves) continue;
    const std::size_t bytes = to.columns()[c].element_size;
    std::memcpy(to.data(c) + static_cast<std::size_t>(before) * bytes, from.data(c),
                static_cast<std::size_t>(from.size()) * bytes);
  }
}

}  // namespace

void append_layers(const Physics& physics, std::size_t feed_number, const NozzleState& nozzle, const Feed::Front& first,
                   const Feed::Front& last, const TileMap& map, int rank, ParticleSet& particles, StepBounds& local) {
  const Feed& feed = physics.feeds[feed_number];
  const Inflow& inflow = feed.inflow();
  const double ratio = nozzle.stretch * inflow.volume_ratio;
  struct Newborn {
    Vec3 position;
    GlobalIndex id;
    const Feed::Point* point;
  };
  std::vector<Newborn> newborn;
  for (const Feed::Point& point : feed.points())
    for (GlobalIndex k = feed.n_layers(first, point) + 1; feed.is_within(last, k, point); ++k)
      if (const Vec3 x = feed.position(nozzle, k, point); map.owner(physics.grid.tile_of(x)) == rank)
        newborn.push_back({x, feed.id_of(k, point), &point});
  if (newborn.empty()) return;
  std::ranges::sort(newborn, {}, &Newborn::id);  // by layers
  ParticleSet born(particles.optional_fields(), particles.densities());
  born.resize(ParticleSet::checked_size(static_cast<GlobalIndex>(newborn.size())));
  for (LocalIndex p = 0; p < born.size(); ++p) {
    const Newborn& one = newborn[static_cast<std::size_t>(p)];
    born.set_vector(Field::position, p, one.position);
    born.set_vector(Field::velocity, p, feed.velocity(nozzle, one.position, one.point->share));
    set_gradient(born, Field::affine_velocity, p, hidden_gradient(feed, nozzle, *one.point));
    for (int c = 0; c < 3; ++c) born.real(Field::left_cauchy_green, c)[p] = 1.0;
    born.real(Field::volume_ratio)[p] = ratio;
    if (const VolumetricLaw* law = volumetric_law_of(physics, inflow.material_index))
      born.real(Field::cell_mean_stress)[p] = law->stress(ratio);
    born.real(Field::reference_volume)[p] = feed.particle_volume();
    born.material()[p] = inflow.material_index;
    born.id()[p] = one.id;
  }
  const Material& material = physics.materials[inflow.material_index].material;
  set_internal_variables(material, inflow.material_index, born);
  constexpr double moment = 1e-12;  // s: the stress of b and J, which nothing deforms
  stress_update(material, inflow.material_index, Field::affine_velocity, moment, born, local);
  for (LocalIndex p = 0; p < born.size(); ++p)
    set_gradient(born, Field::affine_velocity, p, full_gradient(feed, nozzle, *newborn[static_cast<std::size_t>(p)].point));
  measure_particles(physics.grid, physics.transfer, born, local);
  append(born, particles);
}

void append_first_layers(const Physics& physics, const TileMap& map, int rank, ParticleSet& particles) {
  StepBounds unused;
  for (std::size_t f = 0; f < physics.feeds.size(); ++f)
    append_layers(physics, f, physics.feeds[f].at(0.0), {}, physics.feeds[f].born(0.0), map, rank, particles, unused);
}

void include_feeds(const Physics& physics, double time, StepBounds& bounds) {
  for (const Feed& feed : physics.feeds) {
    if (time >= feed.end()) continue;
    std::visit(
        [&](const auto& law) {
          bounds.motion.wave_speed.include(std::sqrt(law.wave_speed_squared(state_at_rest(law))), -1);
          if (law.viscosity() > 0.0) bounds.motion.viscosity.include(law.viscosity() / law.density(), -1);
        },
        physics.materials[feed.inflow().material_index].material);
  }
}

void FeedParticles::begin(double time, double end, const ParticleSet& particles, const ContactImpulses& none) {
  received_ = none;
  end_ = end;
  dt_ = end - time;
  carried_.assign(static_cast<std::size_t>(particles.size()), 0);
  now_.clear();
  left_.clear();
  for (std::size_t f = 0; f < physics_.feeds.size(); ++f) {
    const Feed& feed = physics_.feeds[f];
    const bool runs = feed.runs(time);
    now_.push_back({feed.at(end, stretches_[f]), runs, runs && end >= feed.end(), feed.released(time), feed.born(time),
                    feed.born(end), feed.released(end)});
  }
}

void FeedParticles::add_momentum(std::size_t feed, const Vec3& momentum) {
  received_.add(physics_.n_obstacles() + n_gauge_entries(physics_) + feed, momentum, Vec3::Zero());
}

void FeedParticles::hold(std::size_t f, LocalIndex p, Field gradient, ParticleSet& particles, StepBounds& local) {
  const Feed& feed = physics_.feeds[f];
  const Now& now = now_[f];
  const GlobalIndex id = particles.id()[p], k = feed.layer_of(id);
  const ParticleEnergies before = budget_.energies_of(particles, p);
  const Feed::Point& point = feed.point_of(id);
  const Vec3 x = feed.position(now.end, k, point), v = feed.velocity(now.end, x, point.share);
  const Mat3 affine = full_gradient(feed, now.end, point);
  if (feed.inflow().pressure.is_measured) particles.real(Field::volume_ratio)[p] = now.end.stretch;
  const double mass = particles.mass(p);
  if (!physics_.volumetric_laws.empty())
    dilation_of_held_.push_back((Mat3::Identity() + dt_ * gradient_of(particles, gradient, p)).determinant());
  add_momentum(f, mass * (v - particles.vector(Field::velocity, p)));
  particles.set_vector(Field::position, p, x);
  particles.set_vector(Field::velocity, p, v);
  set_gradient(particles, Field::affine_velocity, p, affine);
  if (particles.has(Field::velocity_gradient))
    set_gradient(particles, Field::velocity_gradient, p, hidden_gradient(feed, now.end, point));
  const ParticleEnergies after = budget_.energies_of(particles, p);
  budget_.add_carried(f, {after.kinetic - before.kinetic, after.elastic - before.elastic});
  const double turned =
      physics_.transfer.affine() ? affine.norm() * moment_sum_ratio(physics_.grid.order) * physics_.grid.cell_size : 0.0;
  local.motion.speed.include(v.norm(), id);
  local.sums.momentum.include(mass * (v.norm() + turned));
  held_.push_back(p);
  feed_of_held_.push_back(f);
  carried_[static_cast<std::size_t>(p)] = 1;
}

void FeedParticles::carry(Field gradient, ParticleSet& particles, StepBounds& local, ParticleBlock block) {
  held_.clear();
  feed_of_held_.clear();
  dilation_of_held_.clear();
  const LocalIndex end = std::min(block.end, particles.size());
  for (std::size_t f = 0; f < physics_.feeds.size(); ++f) {
    const Feed& feed = physics_.feeds[f];
    const Now& now = now_[f];
    if (!now.runs) continue;
    const Bounds box = feed.bounds(now.end, 0.0, -feed.length());
    for (LocalIndex p = block.begin; p < end; ++p) {
      const GlobalIndex id = particles.id()[p];
      if (feed.owns(id) && !feed.is_within(now.released, feed.layer_of(id), feed.point_of(id))) {
        if (!now.stops)
          hold(f, p, gradient, particles, local);
        else if (!feed.is_within(now.last_released, feed.layer_of(id), feed.point_of(id)))
          left_.push_back(p);
        continue;
      }
      if (now.stops) continue;
      const Vec3 x = particles.vector(Field::position, p);
      if ((x.array() < box.lower.array()).any() || (x.array() > box.upper.array()).any()) continue;
      if (!feed.holds(now.end, x, 0.0, -feed.length())) continue;
      ++pushed_back_[f];
      particles.set_vector(Field::position, p, x - (x - now.end.position).dot(now.end.axis) * now.end.axis);
    }
  }
}

void FeedParticles::hide_spin(Field gradient, ParticleSet& particles) {
  if (gradient == Field::affine_velocity) set_gradients_of_held(hidden_gradient, gradient, particles);
}

void FeedParticles::show_spin(Field gradient, ParticleSet& particles) {
  if (gradient == Field::affine_velocity) set_gradients_of_held(full_gradient, gradient, particles);
}

void FeedParticles::set_gradients_of_held(GradientOf gradient_of, Field field, ParticleSet& particles) {
  for (std::size_t n = 0; n < held_.size(); ++n) {
    const NozzleState& nozzle = now_[feed_of_held_[n]].end;
    const Feed& feed = physics_.feeds[feed_of_held_[n]];
    if (nozzle.spin.isZero(0.0)) continue;  // the two are the same
    set_gradient(particles, field, held_[n], gradient_of(feed, nozzle, feed.point_of(particles.id()[held_[n]])));
  }
}

void FeedParticles::show_dilation(ParticleSet& particles) {
  for (std::size_t n = 0; n < held_.size(); ++n) particles.real(Field::volume_ratio)[held_[n]] *= dilation_of_held_[n];
}

void FeedParticles::finish(ParticleGrid& grid, StepBounds& local) {
  ParticleSet& particles = grid.particles();
  measure_pressures(grid.comm(), particles);
  for (const LocalIndex p : left_)
    for (std::size_t f = 0; f < physics_.feeds.size(); ++f)
      if (physics_.feeds[f].owns(particles.id()[p])) {
        const ParticleEnergies energies = budget_.energies_of(particles, p);
        budget_.add_fed(f, {-energies.kinetic, -energies.elastic});
        add_momentum(f, -particles.mass(p) * particles.vector(Field::velocity, p));
      }
  grid.drop(left_);
  const LocalIndex before = particles.size();
  for (std::size_t f = 0; f < physics_.feeds.size(); ++f) {
    const LocalIndex first = particles.size();
    append_layers(physics_, f, now_[f].end, now_[f].born, now_[f].last_born, grid.partition().map, grid.comm().rank(),
                  particles, local);
    for (LocalIndex p = first; p < particles.size(); ++p) {
      budget_.add_fed(f, budget_.energies_of(particles, p));
      add_momentum(f, particles.mass(p) * particles.vector(Field::velocity, p));
    }
  }
  if (particles.size() > before) grid.place_added(before);
}

// The mean of J over a cell in front of the exit, by volume; a material that holds tension does not pull the feed out.
void FeedParticles::measure_pressures(const Comm& comm, const ParticleSet& particles) {
  const double dx = physics_.grid.cell_size;
  for (std::size_t f = 0; f < physics_.feeds.size(); ++f) {
    const Feed& feed = physics_.feeds[f];
    const NozzleState& nozzle = now_[f].end;
    if (!feed.inflow().pressure.is_measured || !now_[f].runs) continue;
    NozzleState ahead = nozzle;
    ahead.position += dx * nozzle.axis;
    const Bounds box = feed.bounds(ahead, 0.0, -dx);
    std::vector<double> volumes, ratios;
    for (LocalIndex p = 0; p < static_cast<LocalIndex>(carried_.size()); ++p) {
      if (carried_[static_cast<std::size_t>(p)]) continue;
      const Vec3 x = particles.vector(Field::position, p);
      if ((x.array() < box.lower.array()).any() || (x.array() > box.upper.array()).any()) continue;
      if (!feed.holds(ahead, x, 0.0, -dx)) continue;
      volumes.push_back(particles.real(Field::reference_volume)[p]);
      ratios.push_back(volumes.back() * particles.real(Field::volume_ratio)[p]);
    }
    const double volume = reproducible_sum(comm, volumes), current = reproducible_sum(comm, ratios);
    if (!(volume > 0.0 && std::isfinite(current))) continue;
    const double smoothing = 4.0 * dx / feed.inflow().wave_speed;  // s
    stretches_[f] = std::min(1.0, stretches_[f] + dt_ / (smoothing + dt_) * (current / volume - stretches_[f]));
  }
}

std::vector<GlobalIndex> FeedParticles::pushed_back(const Comm& comm) const {
  std::vector<GlobalIndex> sums;
  for (const GlobalIndex n : pushed_back_) sums.push_back(sum_global(comm, n));
  return sums;
}

void FeedParticles::save(const Comm& comm, Reals& reals, Integers& integers) const {
  const std::vector<GlobalIndex> pushed = pushed_back(comm);
  for (std::size_t f = 0; f < physics_.feeds.size(); ++f) {
    integers[fmt::format("{}.pushed_back", f)] = pushed[f];
    reals[fmt::format("{}.stretch", f)] = stretches_[f];
  }
}

void FeedParticles::load(const Comm& comm, const Reals& reals, const Integers& integers) {
  for (std::size_t f = 0; f < physics_.feeds.size(); ++f) {
    const auto pushed = integers.find(fmt::format("{}.pushed_back", f));
    const auto stretch = reals.find(fmt::format("{}.stretch", f));
    pushed_back_[f] = comm.is_root() && pushed != integers.end() ? pushed->second : 0;
    stretches_[f] = stretch != reals.end() && physics_.feeds[f].inflow().pressure.is_measured ? stretch->second : 1.0;
  }
}

}  // namespace bulkley
