// Any bytes as a checkpoint or frame: described, verified and read, or refused with a sentence.
//
// HDF5 reads the file's metadata; where it is not compiled with sanitizers itself, they see what it does with memory of the heap
// only through malloc, free and the functions of string.h.

#include <fcntl.h>
#include <petscsys.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "bulkley/parallel/petsc.hpp"
#include "io/checkpoint/checkpoint.hpp"

namespace {

using namespace bulkley;

int memory_file = -1;

void read(const Comm& comm, const std::string& path) {
  const CheckpointHeader header = verify_checkpoint(comm, path);
  OptionalFields fields;
  ParticleSet particles(fields);
  if (header.n_particles < 100'000) read_checkpoint(comm, path, 0, header.n_particles, particles);
}

}  // namespace

extern "C" int LLVMFuzzerInitialize(int*, char***) {
  BULKLEY_PETSC(PetscInitializeNoArguments());
  install_assert_handler();
  memory_file = ::memfd_create("checkpoint", 0);
  return memory_file < 0 ? 1 : 0;
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (::ftruncate(memory_file, 0) != 0 || ::pwrite(memory_file, data, size, 0) != static_cast<ssize_t>(size)) std::abort();
  const std::string path = "/proc/self/fd/" + std::to_string(memory_file);
  const Comm comm(MPI_COMM_SELF);
  for (const bool whole : {false, true}) {
    try {
      if (whole)
        describe_file(comm, path);
      else
        read(comm, path);
    } catch (const RunError& error) {
      const std::string sentence = error.what();
      if (!sentence.empty() && sentence.size() < 2000) continue;
      std::fprintf(stderr, "no sentence, or one that is far too long\n");
      std::abort();
    }
  }
  return 0;
}
