#include "integrator/energy_budget.hpp"

#include <algorithm>
#include <limits>
#include <numeric>
#include <variant>

#include "bulkley/base/error.hpp"
#include "bulkley/base/pack.hpp"
#include "kernel/stress_update.hpp"
#include "parallel/reproducible_sum.hpp"

namespace bulkley {

namespace {

// Addends of nodes are formed in blocks that BinnedSum reads from the first-level cache.
constexpr std::size_t sum_block = 1024;
using Block = double[sum_block];

double kinetic_energy(const ParticleSet& particles, LocalIndex p, double inertia) {
  double affine = 0.0;
  if (inertia > 0.0)
    for (int c = 0; c < 9; ++c) {
      const double value = particles.real(Field::affine_velocity, c)[p];
      affine += value * value;
    }
  return 0.5 * particles.mass(p) * (particles.vector(Field::velocity, p).squaredNorm() + inertia * affine);
}

// Calls fill(at, i) for n_lanes nodes of `active` after the other, `at` being where their numbers begin, for gather_rows, and i the place of
// the first in its block; then done(size) for the block. Lanes past the end repeat the last node.
template <class Fill, class Done>
[[gnu::flatten]] void by_blocks(std::span<const LocalIndex> active, Fill fill, Done done) {
  for (std::size_t first = 0; first < active.size(); first += sum_block) {
    const auto block = active.subspan(first, std::min(sum_block, active.size() - first));
    for (std::size_t i = 0; i < block.size(); i += n_lanes) {
      PackMask at{};
      for (std::size_t lane = 0; lane < n_lanes; ++lane) at[lane] = 4 * std::int64_t{block[std::min(i + lane, block.size() - 1)]};
      fill(at, i);
    }
    done(block.size());
  }
}

// Of nodes that move; 0 for the others.
Pack inverse_of(Pack mass, double smallest_mass) {
  const PackMask moves = mass > broadcast<Pack>(smallest_mass);
  return select(moves, 1.0 / select(moves, mass, broadcast<Pack>(1.0)), Pack{});
}

}  // namespace

EnergyAccount energy_account(const EnergyTotals& totals, const EnergyStart& start, const Diagnostics& now) {
  EnergyAccount account;
  account.kinetic = now.kinetic_energy - start.kinetic;
  account.elastic = now.elastic_energy - start.elastic;
  account.dissipated = now.dissipated_energy + totals.removed_dissipation - start.dissipated;
  account.removed_dissipation = totals.removed_dissipation;
  account.gravity = totals.gravity;
  account.forces = totals.forces;
  account.removed = totals.removed_kinetic + totals.removed_elastic;
  account.from_grid = totals.from_grid;
  const double received = std::accumulate(totals.forces.begin(), totals.forces.end(), totals.gravity);
  double kept = account.elastic + totals.removed_elastic + account.dissipated, fed = 0.0;
  for (std::size_t f = 0; f < totals.fed_kinetic.size(); ++f) {
    fed += totals.fed_kinetic[f];
    kept -= totals.fed_elastic[f];
    account.fed.push_back(totals.fed_kinetic[f] + totals.fed_elastic[f]);
  }
  const double left_over = received - kept - totals.kicks;
  constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  account.to_grid = totals.combined ? unknown : totals.to_grid;
  account.time_integration = totals.combined ? unknown : left_over;
  account.to_grid_and_integration = totals.to_grid + left_over;
  double contact = 0.0;
  for (std::size_t k = 0; k < totals.contact_energy.size(); ++k) {
    contact += totals.contact_energy[k];
    account.contact_work.push_back(totals.contact_work[k]);
    account.contact_loss.push_back(totals.contact_work[k] - totals.contact_energy[k]);
  }
  // The kinetic energy of the particles, against what all stages did to it.
  account.residual =
      account.kinetic + totals.removed_kinetic + totals.to_grid + totals.from_grid - totals.kicks - contact - fed;
  return account;
}

EnergyBudget::EnergyBudget(const Physics& physics, std::size_t n_forces)
    : physics_(physics),
      n_forces_(n_forces),
      inertia_(affine_inertia(physics.grid, physics.transfer)),
      sums_(n_terms + n_forces + 2 * (n_faces + physics.n_obstacles() + physics.rigid_bodies.size() + physics.feeds.size())),
      trial_(sums_.size()),
      contact_(physics.n_obstacles() + physics.rigid_bodies.size()),
      force_impulses_(n_forces) {}

void EnergyBudget::begin_trial() {
  std::fill(trial_.begin(), trial_.end(), BinnedSum{});
  contact_.clear();
  for (std::vector<Vec3>& impulses : force_impulses_) impulses.clear();
}

void EnergyBudget::before_force(std::span<const LocalIndex> active, const Node* impulses) {
  impulse_before_.clear();
  for (const LocalIndex n : active) impulse_before_.emplace_back(impulses[n].c[0], impulses[n].c[1], impulses[n].c[2]);
}

void EnergyBudget::after_force(std::size_t force, std::span<const LocalIndex> active, const Node* impulses) {
  std::vector<Vec3>& given = force_impulses_[force];
  given.clear();
  for (std::size_t a = 0; a < active.size(); ++a) {
    const double* now = impulses[active[a]].c;
    given.push_back(Vec3(now[0], now[1], now[2]) - impulse_before_[a]);
  }
}

void EnergyBudget::add_forces_to(Node* impulses, std::span<const LocalIndex> active) const {
  for (const std::vector<Vec3>& given : force_impulses_)
    for (std::size_t k = 0; k < given.size(); ++k)
      for (int a = 0; a < 3; ++a) impulses[active[k]].c[a] += given[k][a];
}

void EnergyBudget::before_kick(const GridUpdate& update, std::span<const LocalIndex> active, const Node* nodes,
                               const Node* impulse) {
  BULKLEY_ASSERT(active.empty() || combined_ == (impulse == nullptr));
  if (combined_) return;
  const Vec3 fall = update.dt * update.gravity;
  alignas(sizeof(Pack)) Block before, kick;
  by_blocks(
      active,
      [&](PackMask at, std::size_t i) {
        Pack q[4], f[4];
        gather_rows(nodes->c, at, q);
        gather_rows(impulse->c, at, f);
        const Pack mass = q[3];
        Pack energy{}, work{};
        for (int a = 0; a < 3; ++a) {
          const Pack start = update.joined ? q[a] - f[a] : q[a];
          const Pack given = f[a] + mass * fall[a];
          energy += start * start;
          work += given * (start + 0.5 * given);
        }
        const Pack inverse = inverse_of(mass, update.smallest_mass);
        store(before + i, -0.5 * energy * inverse);
        store(kick + i, work * inverse);
      },
      [&](std::size_t size) {
        trial_[to_grid].add({before, size});
        trial_[kicks].add({kick, size});
      });
}

void EnergyBudget::later_kick(const GridUpdate& update, std::span<const LocalIndex> active, const Node* nodes,
                              const Node* impulses) {
  if (combined_) return;
  alignas(sizeof(Pack)) Block kick;
  by_blocks(
      active,
      [&](PackMask at, std::size_t i) {
        Pack v[4], f[4];
        gather_rows(nodes->c, at, v);
        gather_rows(impulses->c, at, f);
        const Pack inverse = inverse_of(v[3], update.smallest_mass);
        Pack work{};
        for (int a = 0; a < 3; ++a) work += f[a] * (v[a] + 0.5 * inverse * f[a]);
        store(kick + i, select(inverse > Pack{}, work, Pack{}));
      },
      [&](std::size_t size) {
        trial_[kicks].add({kick, size});
      });
}

void EnergyBudget::after_contact(const GridUpdate& update, std::span<const LocalIndex> active, const Node* nodes) {
  const Vec3 fall = update.dt * update.gravity;
  const bool falls = !fall.isZero(0.0);
  alignas(sizeof(Pack)) Block energy, work;
  by_blocks(
      active,
      [&](PackMask at, std::size_t i) {
        Pack v[4];
        gather_rows(nodes->c, at, v);
        store(energy + i, (0.5 * v[3]) * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
        if (falls) store(work + i, v[3] * (v[0] * fall[0] + v[1] * fall[1] + v[2] * fall[2]));
      },
      [&](std::size_t size) {
        trial_[from_grid].add({energy, size});
        if (falls) trial_[gravity].add({work, size});
      });
  trial_[to_grid].add(contact_.before());
  trial_[from_grid].add(contact_.after());
  trial_[kicks].add(contact_.kicks());
  trial_[gravity].add(contact_.gravity());
  for (std::size_t k = 0; k < contact_.places().size(); ++k) {
    trial_[energy_term(k)].add(contact_.places()[k].energy);
    trial_[energy_term(k) + 1].add(contact_.places()[k].work);
    if (combined_) trial_[to_grid].merge(trial_[energy_term(k)]);
  }
  if (combined_) trial_[to_grid].subtract(trial_[from_grid]);
  std::vector<double> works;
  for (std::size_t force = 0; force < n_forces_; ++force) {
    const std::vector<Vec3>& impulses = force_impulses_[force];
    works.clear();
    for (std::size_t a = 0; a < impulses.size(); ++a) {
      const double* v = nodes[active[a]].c;
      works.push_back(impulses[a].dot(Vec3(v[0], v[1], v[2])));
    }
    trial_[force_term(force)].add(works);
  }
}

void EnergyBudget::accept(const ParticleSet& particles) {
  for (LocalIndex p = 0; !knows_kinetic_ && p < particles.size(); ++p) {
    const double energy = kinetic_energy(particles, p, inertia_);
    sums_[kinetic].add({&energy, 1});
  }
  knows_kinetic_ = true;
  for (std::size_t k = 0; k < sums_.size(); ++k) sums_[k].merge(trial_[k]);
  sums_[to_grid].merge(sums_[kinetic]);
  sums_[kinetic] = {};
}

void EnergyBudget::before_move(const ParticleSet& particles, ParticleBlock block) {
  const LocalIndex end = std::min(block.end, particles.size());
  for (int a = 0; a < 3; ++a) {
    const double* const x = particles.real(Field::position, a);
    start_[static_cast<std::size_t>(a)].assign(x + block.begin, x + end);
  }
}

void EnergyBudget::add_force_work(std::size_t force, Field field, const ParticleSet& particles, ParticleBlock block) {
  std::vector<double>& works = start_[0];
  for (int a = 0; a < 3; ++a) {
    const double* const f = particles.real(field, a) + block.begin;
    const double* const x = particles.real(Field::position, a) + block.begin;
    const std::vector<double>& start = start_[static_cast<std::size_t>(a)];
    for (std::size_t i = 0; i < works.size(); ++i) {
      const double work = f[i] * (x[i] - start[i]);
      works[i] = a == 0 ? work : works[i] + work;
    }
  }
  sums_[force_term(force)].add(works);
}

double* EnergyBudget::room_for_moved(LocalIndex size) {
  moved_.resize(static_cast<std::size_t>(size) + n_lanes);
  return moved_.data();
}

void EnergyBudget::add_moved(LocalIndex size) { sums_[kinetic].add({moved_.data(), static_cast<std::size_t>(size)}); }

void EnergyBudget::end_step(const ParticleSet& particles, std::span<const LocalIndex> removed) {
  sums_[from_grid].subtract(sums_[kinetic]);
  if (removed.empty()) return;
  std::vector<double> moving, elastic, dissipated;
  for (const LocalIndex p : removed) {
    const double volume = particles.real(Field::reference_volume)[p];
    moving.push_back(kinetic_energy(particles, p, inertia_));
    elastic.push_back(elastic_energy(physics_, particles, p));
    dissipated.push_back(volume * particles.real(Field::plastic_dissipation)[p]);
  }
  sums_[removed_kinetic].add(moving);
  sums_[removed_elastic].add(elastic);
  sums_[removed_dissipation].add(dissipated);
  for (double& energy : moving) energy = -energy;
  sums_[kinetic].add(moving);
}

ParticleEnergies EnergyBudget::energies_of(const ParticleSet& particles, LocalIndex p) const {
  return {kinetic_energy(particles, p, inertia_), elastic_energy(physics_, particles, p)};
}

void EnergyBudget::add_carried(std::size_t feed, const ParticleEnergies& changes) {
  sums_[fed_term(feed)].add({&changes.kinetic, 1});
  sums_[fed_term(feed) + 1].add({&changes.elastic, 1});
  for (const Term term : {from_grid, kinetic}) sums_[term].add({&changes.kinetic, 1});
}

void EnergyBudget::add_fed(std::size_t feed, const ParticleEnergies& energies) {
  sums_[fed_term(feed)].add({&energies.kinetic, 1});
  sums_[fed_term(feed) + 1].add({&energies.elastic, 1});
  sums_[kinetic].add({&energies.kinetic, 1});
}

std::vector<BinnedSum> EnergyBudget::sums(const Comm& comm) const {
  std::vector<BinnedSum> sums = sums_;
  merge_global(comm, sums);
  return sums;
}

EnergyTotals EnergyBudget::totals(const Comm& comm) const {
  const std::vector<BinnedSum> all = sums(comm);
  EnergyTotals totals;
  totals.to_grid = all[to_grid].value();
  totals.kicks = all[kicks].value();
  totals.from_grid = all[from_grid].value();
  totals.gravity = all[gravity].value();
  totals.removed_kinetic = all[removed_kinetic].value();
  totals.removed_elastic = all[removed_elastic].value();
  totals.removed_dissipation = all[removed_dissipation].value();
  for (std::size_t force = 0; force < n_forces_; ++force) totals.forces.push_back(all[force_term(force)].value());
  for (std::size_t k = 0; k < contact_.places().size(); ++k) {
    totals.contact_energy.push_back(all[energy_term(k)].value());
    totals.contact_work.push_back(all[energy_term(k) + 1].value());
  }
  for (std::size_t f = 0; f < physics_.feeds.size(); ++f) {
    totals.fed_kinetic.push_back(all[fed_term(f)].value());
    totals.fed_elastic.push_back(all[fed_term(f) + 1].value());
  }
  totals.combined = combined_;
  return totals;
}

std::vector<std::int64_t> EnergyBudget::words(const Comm& comm) const {
  std::vector<std::int64_t> result{combined_ ? 1 : 0};
  for (const BinnedSum& sum : sums(comm)) {
    const auto words = sum.words();
    result.insert(result.end(), words.begin(), words.end());
  }
  return result;
}

bool EnergyBudget::set_words(const Comm& comm, std::span<const std::int64_t> words) {
  constexpr std::size_t n = BinnedSum::n_words;
  if (words.size() != 1 + n * sums_.size() || words[0] != (combined_ ? 1 : 0)) return false;
  std::fill(sums_.begin(), sums_.end(), BinnedSum{});
  knows_kinetic_ = true;
  if (comm.is_root())
    for (std::size_t k = 0; k < sums_.size(); ++k) sums_[k] = BinnedSum::of_words(words.subspan(1 + n * k).first<n>());
  return true;
}

std::size_t EnergyBudget::memory() const {
  std::size_t total = (sums_.capacity() + trial_.capacity()) * sizeof(BinnedSum) + contact_.memory() +
                      impulse_before_.capacity() * sizeof(Vec3) + moved_.capacity() * sizeof(double);
  for (const auto& impulses : force_impulses_) total += impulses.capacity() * sizeof(Vec3);
  return total;
}

}  // namespace bulkley
