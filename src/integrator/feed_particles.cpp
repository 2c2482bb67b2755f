#include "integrator/feed_particles.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstring>

#include "integrator/gauge_contact.hpp"
#include "kernel/bspline.hpp"
#include "kernel/g2p.hpp"
#include "kernel/stress_update.hpp"

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

void append(const ParticleSet& from, ParticleSet& to) {
  const LocalIndex before = to.size();
  to.resize(ParticleSet::checked_size(GlobalIndex{before} + from.size()));
  for (std::size_t c = 0; c < to.columns().size(); ++c) {
    const std::size_t bytes = to.columns()[c].element_size;
    std::memcpy(to.data(c) + static_cast<std::size_t>(before) * bytes, from.data(c),
                static_cast<std::size_t>(from.size()) * bytes);
  }
}

}  // namespace

void append_layers(const Physics& physics, std::size_t feed_number, double time, GlobalIndex first, GlobalIndex last,
                   const TileMap& map, int rank, ParticleSet& particles, StepBounds& local) {
  if (last <= first) return;
  const Feed& feed = physics.feeds[feed_number];
  const Inflow& inflow = feed.inflow();
  const NozzleState nozzle = feed.at(time);
  struct Newborn {
    Vec3 position;
    GlobalIndex id;
  };
  std::vector<Newborn> newborn;
  for (GlobalIndex k = first + 1; k <= last; ++k)
    for (const Feed::Point& point : feed.points())
      if (const Vec3 x = feed.position(nozzle, k, point); map.owner(physics.grid.tile_of(x)) == rank)
        newborn.push_back({x, feed.id_of(k, point)});
  if (newborn.empty()) return;
  ParticleSet born(particles.optional_fields());
  born.resize(ParticleSet::checked_size(static_cast<GlobalIndex>(newborn.size())));
  for (LocalIndex p = 0; p < born.size(); ++p) {
    const Newborn& one = newborn[static_cast<std::size_t>(p)];
    born.set_vector(Field::position, p, one.position);
    born.set_vector(Field::velocity, p, feed.velocity(nozzle, one.position));
    for (int c = 0; c < 3; ++c) born.real(Field::left_cauchy_green, c)[p] = 1.0;
    born.real(Field::volume_ratio)[p] = inflow.volume_ratio;
    born.real(Field::mass)[p] = inflow.density * feed.particle_volume();
    born.real(Field::reference_volume)[p] = feed.particle_volume();
    born.material()[p] = inflow.material_index;
    born.id()[p] = one.id;
  }
  const Material& material = physics.materials[inflow.material_index].material;
  set_internal_variables(material, inflow.material_index, born);
  constexpr double moment = 1e-12;  // s: the stress of b and J, which nothing deforms
  stress_update(material, inflow.material_index, Field::affine_velocity, moment, born, local);
  for (LocalIndex p = 0; p < born.size(); ++p) set_gradient(born, Field::affine_velocity, p, cross_matrix(nozzle.spin));
  measure_particles(physics.grid, physics.transfer, born, local);
  append(born, particles);
}

void append_first_layers(const Physics& physics, const TileMap& map, int rank, ParticleSet& particles) {
  StepBounds unused;
  for (std::size_t f = 0; f < physics.feeds.size(); ++f)
    append_layers(physics, f, 0.0, 0, physics.feeds[f].n_born(0.0), map, rank, particles, unused);
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

void FeedParticles::begin(double time, double end, const ContactImpulses& none) {
  received_ = none;
  end_ = end;
  now_.clear();
  left_.clear();
  for (const Feed& feed : physics_.feeds) {
    const bool runs = feed.runs(time);
    now_.push_back({feed.at(end), runs, runs && end >= feed.end(), feed.n_released(time), feed.n_born(time),
                    feed.n_born(end), feed.n_released(end)});
  }
}

void FeedParticles::add_momentum(std::size_t feed, const Vec3& momentum) {
  received_.add(physics_.n_obstacles() + n_gauge_entries(physics_) + feed, momentum, Vec3::Zero());
}

void FeedParticles::hold(std::size_t f, LocalIndex p, ParticleSet& particles, StepBounds& local) {
  const Feed& feed = physics_.feeds[f];
  const Now& now = now_[f];
  const GlobalIndex id = particles.id()[p], k = feed.layer_of(id);
  const ParticleEnergies before = budget_.energies_of(particles, p);
  const Vec3 x = feed.position(now.end, k, feed.point_of(id)), v = feed.velocity(now.end, x);
  const Mat3 spin = cross_matrix(now.end.spin);
  const double mass = particles.real(Field::mass)[p];
  add_momentum(f, mass * (v - particles.vector(Field::velocity, p)));
  particles.set_vector(Field::position, p, x);
  particles.set_vector(Field::velocity, p, v);
  set_gradient(particles, Field::affine_velocity, p, spin);
  if (particles.has(Field::velocity_gradient)) set_gradient(particles, Field::velocity_gradient, p, Mat3::Zero());
  budget_.add_carried(f, budget_.energies_of(particles, p).kinetic - before.kinetic);
  const double spun =
      physics_.transfer.affine() ? spin.norm() * moment_sum_ratio(physics_.grid.order) * physics_.grid.cell_size : 0.0;
  local.motion.speed.include(v.norm(), id);
  local.sums.momentum.include(mass * (v.norm() + spun));
  held_.push_back(p);
  feed_of_held_.push_back(f);
}

void FeedParticles::carry(ParticleSet& particles, StepBounds& local, ParticleBlock block) {
  held_.clear();
  feed_of_held_.clear();
  const LocalIndex end = std::min(block.end, particles.size());
  for (std::size_t f = 0; f < physics_.feeds.size(); ++f) {
    const Feed& feed = physics_.feeds[f];
    const Now& now = now_[f];
    if (!now.runs) continue;
    const Bounds box = feed.bounds(now.end, 0.0, -feed.length());
    for (LocalIndex p = block.begin; p < end; ++p) {
      const GlobalIndex id = particles.id()[p];
      if (feed.owns(id) && feed.layer_of(id) > now.released) {
        if (!now.stops)
          hold(f, p, particles, local);
        else if (feed.layer_of(id) > now.last_released)
          left_.push_back(p);
        continue;
      }
      if (now.stops) continue;
      const Vec3 x = particles.vector(Field::position, p);
      if ((x.array() < box.lower.array()).any() || (x.array() > box.upper.array()).any()) continue;
      if (feed.holds(now.end, x, 0.0, -feed.length()))
        particles.set_vector(Field::position, p, x - (x - now.end.position).dot(now.end.axis) * now.end.axis);
    }
  }
}

void FeedParticles::hide_spin(Field gradient, ParticleSet& particles) {
  if (gradient != Field::affine_velocity) return;
  for (std::size_t n = 0; n < held_.size(); ++n)
    if (!now_[feed_of_held_[n]].end.spin.isZero(0.0)) set_gradient(particles, gradient, held_[n], Mat3::Zero());
}

void FeedParticles::show_spin(Field gradient, ParticleSet& particles) {
  if (gradient != Field::affine_velocity) return;
  for (std::size_t n = 0; n < held_.size(); ++n)
    if (const Vec3& spin = now_[feed_of_held_[n]].end.spin; !spin.isZero(0.0))
      set_gradient(particles, gradient, held_[n], cross_matrix(spin));
}

void FeedParticles::finish(ParticleGrid& grid, StepBounds& local) {
  ParticleSet& particles = grid.particles();
  for (const LocalIndex p : left_)
    for (std::size_t f = 0; f < physics_.feeds.size(); ++f)
      if (physics_.feeds[f].owns(particles.id()[p])) {
        const ParticleEnergies energies = budget_.energies_of(particles, p);
        budget_.add_fed(f, {-energies.kinetic, -energies.elastic});
        add_momentum(f, -particles.real(Field::mass)[p] * particles.vector(Field::velocity, p));
      }
  grid.drop(left_);
  const LocalIndex before = particles.size();
  for (std::size_t f = 0; f < physics_.feeds.size(); ++f) {
    const LocalIndex first = particles.size();
    append_layers(physics_, f, end_, now_[f].born, now_[f].last_born, grid.partition().map, grid.comm().rank(), particles,
                  local);
    for (LocalIndex p = first; p < particles.size(); ++p) {
      budget_.add_fed(f, budget_.energies_of(particles, p));
      add_momentum(f, particles.real(Field::mass)[p] * particles.vector(Field::velocity, p));
    }
  }
  if (particles.size() > before) grid.place_added(before);
}

}  // namespace bulkley
