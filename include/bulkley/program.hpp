#pragma once
// The program `bulkley` as a function, for programs that add constitutive laws to it (material/add_law.hpp).

namespace bulkley {

/// Everything that the program `bulkley` does: initialises MPI and PETSc, runs the subcommand that the arguments name, and
/// finalises both. Returns the exit code: 0 finished, 2 wrong input, 3 failed, 4 stopped early with a good checkpoint. To be
/// called once, on every rank, before anything else that starts MPI. Collective over all ranks.
int run_program(int argc, char** argv);

}  // namespace bulkley
