#pragma once
// Runs of small scenes with their energy accounts.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "integrator/diagnostics.hpp"
#include "integrator/energy_budget.hpp"
#include "rebalance/share.hpp"
#include "support/solver_run.hpp"

namespace bulkley {

inline Diagnostics diagnosed(const Comm& comm, const Solver& solver) {
  const Physics& p = solver.physics();
  return diagnose(comm, p, solver.particles());
}

inline EnergyStart start_of(const Comm& comm, const Solver& solver) {
  const Diagnostics d = diagnosed(comm, solver);
  return {d.kinetic_energy, d.elastic_energy, d.dissipated_energy};
}

inline EnergyAccount account_of(const Comm& comm, const Solver& solver, const EnergyStart& start) {
  return energy_account(solver.energy_totals(), start, diagnosed(comm, solver));
}

inline double sum(const std::vector<double>& values) {
  double total = 0.0;
  for (const double value : values) total += value;
  return total;
}

// What is left of all terms, as a part of the largest.
inline double imbalance(const EnergyAccount& a) {
  double largest = 0.0;
  const double terms[] = {
      a.kinetic,     a.elastic,           a.dissipated,       a.gravity, a.removed, a.from_grid, a.to_grid_and_integration,
      sum(a.forces), sum(a.contact_loss), sum(a.contact_work)};
  for (const double term : terms) largest = std::max(largest, std::abs(term));
  const double left = a.kinetic + a.elastic + a.dissipated + a.removed + a.from_grid + a.to_grid_and_integration +
                      sum(a.contact_loss) - sum(a.contact_work) - a.gravity - sum(a.forces);
  EXPECT_NEAR(left, a.residual, 1e-12 * largest);
  return std::abs(left) / largest;
}

class EnergyBudgetTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};
  Comm self{MPI_COMM_SELF};

  static std::unique_ptr<Solver> solver_on(const Comm& on, const SolverScene& scene) {
    return solver_of(on, scene, partition_of(on, scene, PartitionMethod::ranges));
  }

  struct Ran {
    std::vector<std::int64_t> words;
    EnergyAccount account;
    std::vector<double> steps;  // s, their lengths
    GlobalIndex n_rejected = 0;
    double lost_mass = 0.0;  // kg, through outflow faces
    double distance = 0.0;   // m, of the centre of mass along x
    Vec3 momentum = Vec3::Zero();  // kg m/s, gained
    ParticleSet particles;
  };
  // Steps of no more than what is `handed` to each, or than 1 s.
  static Ran run(const Comm& on, const SolverScene& scene, int n_steps, const std::vector<double>& handed = {}) {
    const auto solver = solver_on(on, scene);
    const Diagnostics first = diagnosed(on, *solver);
    const EnergyStart start{first.kinetic_energy, first.elastic_energy, first.dissipated_energy};
    TimeStepState state;
    Ran ran;
    double time = 0.0;
    for (int step = 0; step < n_steps; ++step) {
      const double longest = handed.empty() ? 1.0 : handed[static_cast<std::size_t>(step)];
      const StepReport report = solver->step({time, longest}, state);
      time += report.plan.dt;
      ran.steps.push_back(report.plan.dt);
      ran.n_rejected += report.n_rejected;
      const Diagnostics now = diagnosed(on, *solver);
      ran.distance += report.plan.dt * now.momentum[0] / now.mass;
      ran.lost_mass = first.mass - now.mass;
      ran.momentum = now.momentum - first.momentum;
    }
    ran.particles = gathered(on, solver->particles());
    ran.words = solver->energy_words();
    ran.account = account_of(on, *solver, start);
    return ran;
  }

  static std::vector<TransferSettings> transfers() {
    std::vector<TransferSettings> all;
    for (const TransferScheme scheme : {TransferScheme::pic, TransferScheme::flip, TransferScheme::blend,
                                        TransferScheme::apic, TransferScheme::moment_flip})
      for (const SplineOrder order : {SplineOrder::quadratic, SplineOrder::cubic})
        for (const GradientForm gradient : {GradientForm::mls, GradientForm::bspline}) {
          TransferSettings& transfer = all.emplace_back();
          transfer.scheme = scheme;
          transfer.order = order;
          transfer.gradient = gradient;
        }
    return all;
  }

  static bool splits(const TransferSettings& transfer) { return transfer.n_exchanges() > 1; }

  static Ran run_separate(const Comm& on, SolverScene& scene, int n_steps) {
    scene.physics.separate_energies = true;
    return run(on, scene, n_steps);
  }

  // PIC and APIC that tell the transfer to the grid from the time integration: the account closes, on any ranks, and the
  // particles are those of the run that does not, but for rounding.
  void expect_separate(SolverScene scene, int n_steps, bool contact) {
    const Ran together = run(comm, scene, n_steps), apart = run_separate(comm, scene, n_steps);
    EXPECT_LT(imbalance(apart.account), 1e-12);
    EXPECT_TRUE(std::isnan(together.account.to_grid));
    EXPECT_NEAR(apart.account.to_grid + apart.account.time_integration, apart.account.to_grid_and_integration,
                1e-12 * (std::abs(apart.account.to_grid) + std::abs(apart.account.time_integration)));
    EXPECT_EQ(apart.words, run(self, scene, n_steps).words);
    EXPECT_NEAR(apart.account.from_grid, together.account.from_grid, 1e-7 * together.account.from_grid);
    EXPECT_NEAR(apart.account.kinetic, together.account.kinetic, 1e-7 * std::abs(together.account.kinetic));
    EXPECT_GT(apart.account.to_grid, 0.0);
    // Works of contact are taken along another velocity where velocities before impulses are not known.
    if (contact) return;
    EXPECT_NEAR(apart.account.to_grid_and_integration, together.account.to_grid_and_integration,
                1e-7 * (std::abs(apart.account.to_grid) + std::abs(apart.account.dissipated)));
  }
};

}  // namespace bulkley
