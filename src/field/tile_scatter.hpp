#pragma once
// Between the nodes that ranks own because of their particles (Exchange) and a field on the whole grid.

#include <petscsf.h>

#include "bulkley/parallel/petsc.hpp"
#include "distribution/exchange.hpp"
#include "field/field_grid.hpp"

namespace bulkley {

/// Copies of nodal values, both ways, for one Exchange and one FieldGrid: n_components() of the field a node. Built once, it
/// holds until the Exchange is built anew; it keeps neither. Nothing is summed, so that no order matters.
class TileScatter {
 public:
  /// Precondition: the field contains all nodes of the exchange's grid. Collective.
  TileScatter(const Comm& comm, const Exchange& exchange, const FieldGrid& field);
  ~TileScatter();
  TileScatter(const TileScatter&) = delete;
  TileScatter& operator=(const TileScatter&) = delete;

  /// field = owned; zero at nodes that no particle reaches. `owned`: by Exchange, n_owned() nodes of which the active ones
  /// are read. `field`: FieldGrid::size() numbers. Collective.
  void to_field(const double* owned, double* field) const;
  /// owned = field, at active nodes; other owned nodes stay as they are. Collective.
  void to_owned(const double* field, double* owned) const;

 private:
  PetscHandle<PetscSF, PetscSFDestroy> sf_;  ///< roots: nodes of the field; leaves: active owned nodes
  MPI_Datatype node_type_ = MPI_DATATYPE_NULL;
  std::size_t field_size_;
};

}  // namespace bulkley
