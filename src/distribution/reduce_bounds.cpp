#include "distribution/reduce_bounds.hpp"

#include <cstring>
#include <type_traits>

namespace bulkley {

namespace {

static_assert(std::is_trivially_copyable_v<StepBounds>, "StepBounds travels as bytes");

void merge_bounds(void* from, void* into, int* count, MPI_Datatype*) {
  for (int k = 0; k < *count; ++k) {
    StepBounds a, b;
    std::memcpy(&a, static_cast<char*>(from) + k * sizeof(StepBounds), sizeof a);
    std::memcpy(&b, static_cast<char*>(into) + k * sizeof(StepBounds), sizeof b);
    b.merge(a);
    std::memcpy(static_cast<char*>(into) + k * sizeof(StepBounds), &b, sizeof b);
  }
}

}  // namespace

BoundsReduction::BoundsReduction(const Comm& comm) : comm_(comm) {
  BULKLEY_MPI(MPI_Type_contiguous(sizeof(StepBounds), MPI_BYTE, &type_));
  BULKLEY_MPI(MPI_Type_commit(&type_));
  BULKLEY_MPI(MPI_Op_create(merge_bounds, /*commutative=*/1, &op_));
}

BoundsReduction::~BoundsReduction() {
  BULKLEY_MPI(MPI_Op_free(&op_));
  BULKLEY_MPI(MPI_Type_free(&type_));
}

StepBounds BoundsReduction::operator()(const StepBounds& local) const {
  StepBounds global;
  BULKLEY_MPI(MPI_Allreduce(&local, &global, 1, type_, op_, comm_.get()));
  return global;
}

}  // namespace bulkley
