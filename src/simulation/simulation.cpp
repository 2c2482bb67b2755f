#include "simulation/simulation.hpp"

#include <fmt/format.h>

#include <chrono>
#include <thread>

#include "io/files/text_file.hpp"
#include "io/frames/frame.hpp"
#include "simulation/run_folder.hpp"
#include "simulation/run_loop.hpp"
#include "simulation/setup.hpp"
#include "stepping/failure.hpp"

namespace bulkley {

namespace {

constexpr double cells_around_failure = 6.0;
constexpr std::chrono::milliseconds time_of_root{300};  // for its words, if it aborts, too

// Writes the particles near the place of the failure, as they are now, with all they hold; says where. Collective.
std::string save_neighbourhood(Run& run, const StepFailure& failure) {
  const ParticleSet& particles = run.solver->particles();
  const double reach = cells_around_failure * run.scene.grid.cell_size;
  std::vector<LocalIndex> near;
  for (LocalIndex p = 0; p < particles.size(); ++p) {
    const Vec3 x = particles.vector(Field::position, p);
    if (failure.place ? (x - *failure.place).cwiseAbs().maxCoeff() <= reach : !x.allFinite()) near.push_back(p);
  }
  OutputSettings everything;
  everything.precision = FloatPrecision::float64;
  everything.fields = particle_field_names(particles);
  const std::string file = path_in(run.options.folder, fmt::format("failure_{:09}.h5", run.state.step + 1));
  const auto watch = run.watch_write(file);
  try {
    write_frame_file(run.comm, file, {0, run.state.step + 1, run.state.time, 0}, particles.selected(near),
                     run.scene.materials, everything);
  } catch (const RunError& error) {  // the same on every rank
    return fmt::format("what is around could not be saved: {}", error.what());
  }
  return fmt::format("what is around is saved in {}", file);
}

// As on_abort, before there is a run.
std::string on_abort_in_set_up(const Comm& comm, const Scene& scene, const RunOptions& options, const std::string& message,
                               Fault fault) {
  if (!comm.is_root()) std::this_thread::sleep_for(time_of_root);
  write_set_up_failure_alone(comm, scene, options, message, fault == Fault::machine);
  return {};
}

// An abort comes from one rank alone. The root goes first: it usually fails, too, and the first word stays.
std::string on_abort(const Run& run, const std::string& message, Fault fault) {
  if (!run.comm.is_root()) std::this_thread::sleep_for(time_of_root);
  std::string text = fmt::format("; {}", run.checkpoint_hint());
  Status status = run.status(RunState::failed, message + text);
  status.unresponsive = fault == Fault::machine;
  write_first_failure_alone(run.options.folder, status, run.comm.rank());
  return text;
}

// Collective.
[[noreturn]] void fail(const Run& run, const std::string& fault) {
  const std::string text =
      fmt::format("step {}, t = {:g} s: {}; {}", run.state.step + 1, run.state.time, fault, run.checkpoint_hint());
  write_failure(run.comm, run.options.folder, run.status(RunState::failed, text));
  throw RunError(text);
}

}  // namespace

RunOutcome run_simulation(const Comm& comm, const Scene& scene, const RunOptions& options) {
  check_grid_output(scene);
  check_magnetics(scene);
  check_colliders(scene);
  check_rigid_bodies(scene);
  check_gauges(scene);
  check_petsc_options(comm, scene);
  prepare_folder(comm, options);
  std::unique_ptr<Run> run;
  const AbortHook hook([&](const std::string& message, Fault fault) {
    return run ? on_abort(*run, message, fault) : on_abort_in_set_up(comm, scene, options, message, fault);
  });
  try {
    run = std::make_unique<Run>(comm, scene, options);
  } catch (const RunError& error) {  // the same on every rank
    write_set_up_failure(comm, scene, options, error.what());
    throw;
  } catch (const UsageError& error) {  // the same on every rank
    // A run whose continuation is refused is what it was.
    if (!options.restart) write_set_up_failure(comm, scene, options, error.what());
    throw;
  }
  try {
    return run_to_end(*run);
  } catch (const StepFailure& failure) {  // the same on every rank
    fail(*run, fmt::format("{}; {}", failure.what(), save_neighbourhood(*run, failure)));
  } catch (const RunError& error) {  // the same on every rank
    fail(*run, error.what());
  }
}

}  // namespace bulkley
