#pragma once
// Evaluation of the last rows of history.csv: how fast it goes, what limits its time step, whether energy is kept.

#include <string>
#include <utility>
#include <vector>

#include "program/run_folder.hpp"

namespace bulkley {

/// J.
struct EnergyFigures {
  double kinetic = 0.0, elastic = 0.0, gravitational = 0.0, dissipated = 0.0;
  double sum() const { return kinetic + elastic + gravitational + dissipated; }
};

/// The energy budget as the last row has it, J since the budget began. NaN if no row contains it.
struct AccountFigures {
  double gravity, acceleration_field, magnetic_field, to_grid, time_integration, to_grid_and_integration, from_grid, removed,
      residual;
  std::vector<std::pair<std::string, double>> contact_losses, contact_works;  ///< of walls and colliders, by name
  bool known() const { return residual == residual; }
};

/// NaN or empty if no row contains it.
struct RunFigures {
  double step, time, dt;                                       ///< of the newest of status.json and history.csv; s
  double last_row_time;                                        ///< s, of the last row
  std::string limiter;                                         ///< of the last row
  std::vector<std::pair<std::string, double>> limiter_shares;  ///< of the rows read, largest first; parts of one
  GlobalIndex n_rows = 0;                                      ///< rows read: the last 4 MB
  bool all_rows = true;                                        ///< the table has no more
  double trials, accepted, rejected;                           ///< since the first step of the run
  double particles, removed, imbalance, mass, max_speed;
  double thickness_decile;                                               ///< cells
  double volume_error;                                                   ///< rms of J - 1
  double pressure_iterations, most_pressure_iterations, contact_rounds;  ///< a step, of the last row
  double viscosity_iterations, most_viscosity_iterations;                ///< likewise
  EnergyFigures first, last;
  AccountFigures account;
  double energy_scale;                                     ///< J, that the change of the sum is measured by
  double seconds_per_step;                                 ///< s of wall time in steps, over the last 100 rows
  double recent_steps_per_second, recent_time_per_second;  ///< the same, with the fraction of output of the present part
  double part_steps_per_second, part_time_per_second;      ///< of the whole present part, output included

  /// Part of the end time that is done; NaN if that is not known.
  double done(const RunFolder& run) const;
  /// s of wall time to the end time at the recent rate; NaN if that is not known.
  double left(const RunFolder& run) const;
};

/// Reads the first row and the last 4 MB of the table. Not collective.
RunFigures figures_of(const RunFolder& run);

}  // namespace bulkley
