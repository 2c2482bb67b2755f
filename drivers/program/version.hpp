#pragma once
#include <string>

namespace bulkley {

/// Version, git commit, compiler, and the versions of PETSc, HDF5 and MPI, as `bulkley --version` prints them.
std::string version_text();

}  // namespace bulkley
