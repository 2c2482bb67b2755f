// Counts what the program asks of `new`. Preloaded (LD_PRELOAD) into it, each rank adds a line to the file ALLOCATION_LOG when MPI ends: its
// rank, and the most bytes that it held at one time. MPI, PETSc and HDF5 use malloc, and are not counted.
#include <malloc.h>
#include <mpi.h>

#include <atomic>
#include <cstddef>
#include <cstdio>
#include <cstdlib>
#include <new>

namespace {

std::atomic<long> held{0}, most{0};

void* taken(std::size_t size, std::size_t alignment) {
  constexpr std::size_t least = alignof(std::max_align_t);
  const std::size_t unit = alignment < least ? least : alignment;
  void* const piece = std::aligned_alloc(unit, (size + unit - 1) / unit * unit + (size == 0 ? unit : 0));
  if (!piece) throw std::bad_alloc();
  const long now = held += static_cast<long>(malloc_usable_size(piece));
  long before = most;
  while (now > before && !most.compare_exchange_weak(before, now)) {
  }
  return piece;
}

void given_back(void* piece) {
  if (!piece) return;
  held -= static_cast<long>(malloc_usable_size(piece));
  std::free(piece);
}

}  // namespace

void* operator new(std::size_t size) { return taken(size, 0); }
void* operator new[](std::size_t size) { return taken(size, 0); }
void* operator new(std::size_t size, std::align_val_t unit) { return taken(size, static_cast<std::size_t>(unit)); }
void* operator new[](std::size_t size, std::align_val_t unit) { return taken(size, static_cast<std::size_t>(unit)); }
void operator delete(void* piece) noexcept { given_back(piece); }
void operator delete[](void* piece) noexcept { given_back(piece); }
void operator delete(void* piece, std::size_t) noexcept { given_back(piece); }
void operator delete[](void* piece, std::size_t) noexcept { given_back(piece); }
void operator delete(void* piece, std::align_val_t) noexcept { given_back(piece); }
void operator delete[](void* piece, std::align_val_t) noexcept { given_back(piece); }
void operator delete(void* piece, std::size_t, std::align_val_t) noexcept { given_back(piece); }
void operator delete[](void* piece, std::size_t, std::align_val_t) noexcept { given_back(piece); }

extern "C" int MPI_Finalize() {
  int rank = 0;
  PMPI_Comm_rank(MPI_COMM_WORLD, &rank);
  const char* const path = std::getenv("ALLOCATION_LOG");
  if (std::FILE* const log = path ? std::fopen(path, "a") : nullptr) {
    std::fprintf(log, "%d %ld\n", rank, most.load());
    std::fclose(log);
  }
  return PMPI_Finalize();
}
