#pragma once
// The one all-reduce of a step.

#include "bulkley/parallel/comm.hpp"
#include "kernel/step_bounds.hpp"

namespace bulkley {

/// Merges StepBounds over ranks by StepBounds::merge, in one all-reduce of exact quantities.
class BoundsReduction {
 public:
  explicit BoundsReduction(const Comm& comm);
  ~BoundsReduction();
  BoundsReduction(const BoundsReduction&) = delete;
  BoundsReduction& operator=(const BoundsReduction&) = delete;

  /// The merged bounds, the same on every rank. Collective.
  StepBounds operator()(const StepBounds& local) const;

 private:
  const Comm& comm_;
  MPI_Datatype type_ = MPI_DATATYPE_NULL;
  MPI_Op op_ = MPI_OP_NULL;
};

}  // namespace bulkley
