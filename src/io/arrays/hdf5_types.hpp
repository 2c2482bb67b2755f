#pragma once
// Common to the HDF5 writer and reader.

#include "io/arrays/hdf5_file.hpp"

namespace bulkley {

/// The HDF5 element type in the file.
hid_t hdf5_type(ArrayType type);

HdfSpace make_space(const Extents& shape);

/// Selects a block of a dataspace. `what` begins the sentence of a failure.
void select_block(hid_t space, const Extents& start, const Extents& count, const std::string& what);

}  // namespace bulkley
