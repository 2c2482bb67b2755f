#include "program/version.hpp"

#include <H5public.h>
#include <fmt/format.h>
#include <mpi.h>
#include <petscsys.h>

#include <array>

#include "bulkley/version.hpp"

namespace bulkley {

std::string version_text() {
  std::array<char, 256> petsc{};
  if (PetscGetVersion(petsc.data(), petsc.size()) != 0) petsc[0] = '\0';
  unsigned major = 0, minor = 0, release = 0;
  const bool hdf5_known = H5get_libversion(&major, &minor, &release) >= 0;
  std::array<char, MPI_MAX_LIBRARY_VERSION_STRING> mpi{};
  int length = 0;
  if (MPI_Get_library_version(mpi.data(), &length) != MPI_SUCCESS) mpi[0] = '\0';
  return fmt::format("Bulkley {} (commit {})\ncompiler  {}, {} build, {}\nPETSc     {}\nHDF5      {}\nMPI       {}", version,
                     git_commit, compiler, build_type, compiler_flags, petsc.data(),
                     hdf5_known ? fmt::format("{}.{}.{}", major, minor, release) : std::string("unknown"), mpi.data());
}

}  // namespace bulkley
