// A driver of one's own: steps a scene until its kinetic energy has fallen to a thousandth of the largest it had, and prints how
// long that takes and how far the material has spread.
//
//   mpirun -n 2 until_rest SCENE.toml

#include <bulkley/parallel/petsc.hpp>
#include "integrator/diagnostics.hpp"
#include "simulation/setup.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "carreau.hpp"

namespace {

bulkley::Scene load(const bulkley::Comm& comm, const char* file) {
  std::string text;
  bulkley::root_guard(comm, [&] {
    std::ifstream stream(file);
    std::stringstream whole;
    if (!(whole << stream.rdbuf())) throw bulkley::UsageError(std::string(file) + ": cannot be read");
    text = whole.str();
  });
  return bulkley::parse_scene(bulkley::broadcast_text(comm, std::move(text)), file, {});
}

bulkley::Diagnostics measure(const bulkley::Comm& comm, const bulkley::Scene& scene, const bulkley::Solver& solver) {
  return bulkley::diagnose(comm, scene.grid, scene.transfer, scene.gravity, scene.materials, solver.particles());
}

void run(const bulkley::Comm& comm, const char* file) {
  const bulkley::Scene scene = load(comm, file);
  const std::unique_ptr<bulkley::Solver> solver = bulkley::start_solver(comm, scene);
  bulkley::TimeStepState state;
  double time = 0.0, largest = 0.0;
  bulkley::Diagnostics now = measure(comm, scene, *solver);
  while (time < scene.time.end_time) {
    const double look = std::min(0.005, scene.time.end_time - time);  // s, between two looks at the energy
    double done = 0.0;
    while (done < look) {
      const bulkley::StepReport report = solver->step(look - done, 0, state, time + done);
      done = report.plan.lands ? look : done + report.plan.dt;
    }
    time += look;
    now = measure(comm, scene, *solver);
    largest = std::max(largest, now.kinetic_energy);
    if (now.kinetic_energy < 1e-3 * largest) break;
  }
  if (comm.is_root())
    std::printf("%s at t = %.3f s, %d steps; spread %.4f m, height %.4f m\n",
                now.kinetic_energy < 1e-3 * largest ? "at rest" : "still moving", time, static_cast<int>(state.n_steps),
                now.upper[0] - now.lower[0], now.upper[2] - now.lower[2]);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: until_rest SCENE.toml\n");
    return 2;
  }
  bulkley::add_law<Carreau>();
  int no_arguments = 1;
  if (PetscInitialize(&no_arguments, &argv, nullptr, nullptr) != 0) return 3;
  int code = 0;
  try {
    const bulkley::Comm comm(PETSC_COMM_WORLD);
    run(comm, argv[1]);
  } catch (const std::exception& error) {  // the library throws alike on every rank
    int rank = 0;
    MPI_Comm_rank(MPI_COMM_WORLD, &rank);
    if (rank == 0) std::fprintf(stderr, "until_rest: %s\n", error.what());
    code = dynamic_cast<const bulkley::UsageError*>(&error) ? 2 : 3;
  }
  PetscFinalize();
  return code;
}
