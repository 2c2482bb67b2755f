// A driver of one's own: steps a scene until its kinetic energy has fallen to a thousandth of the largest it had, and prints how
// long that takes and how far the material has spread.
//
//   mpirun -n 2 until_rest SCENE.toml

#include <bulkley/parallel/petsc.hpp>
#include <bulkley/simulation/stepper.hpp>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <sstream>

#include "carreau.hpp"

namespace {

std::string read(const bulkley::Comm& comm, const char* file) {
  std::string text;
  bulkley::root_guard(comm, [&] {
    std::ifstream stream(file);
    std::stringstream whole;
    if (!(whole << stream.rdbuf())) throw bulkley::UsageError(std::string(file) + ": cannot be read");
    text = whole.str();
  });
  return bulkley::broadcast_text(comm, std::move(text));
}

void run(const bulkley::Comm& comm, const char* file) {
  constexpr double interval = 0.005;  // s, between two measurements of the energy
  bulkley::Stepper stepper(comm, read(comm, file), file);
  double largest = 0.0;
  bulkley::Diagnostics now = stepper.diagnostics();
  bool at_rest = false;
  while (!at_rest && stepper.time() < stepper.end_time()) {
    stepper.advance(std::min(interval, stepper.end_time() - stepper.time()));
    now = stepper.diagnostics();
    largest = std::max(largest, now.kinetic_energy);
    at_rest = now.kinetic_energy < 1e-3 * largest;
  }
  if (comm.is_root())
    std::printf("%s at t = %.3f s, %d steps; spread %.4f m, height %.4f m\n", at_rest ? "at rest" : "still moving",
                stepper.time(), static_cast<int>(stepper.n_steps()), now.upper[0] - now.lower[0],
                now.upper[2] - now.lower[2]);
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
