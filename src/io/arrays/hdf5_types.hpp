#pragma once
// What the HDF5 writer and reader share.

#include "io/arrays/hdf5_file.hpp"

namespace bulkley {

/// The element type as HDF5 knows it in the file.
hid_t hdf5_type(ArrayType type);

HdfSpace make_space(const Extents& shape);

/// Selects a block of a dataspace. `what` begins the sentence of a failure.
void select_block(hid_t space, const Extents& start, const Extents& count, const std::string& what);

}  // namespace bulkley
