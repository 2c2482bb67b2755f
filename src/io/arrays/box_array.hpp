#pragma once
// Fields on a box of nodes as arrays of a file, (nz, ny, nx) or (nz, ny, nx, 3), in the group that the box names.

#include "grid/box_fields.hpp"
#include "io/arrays/array_file.hpp"

namespace bulkley {

/// Adds every field of `box` to `content`, and where its nodes are; `box` must outlive that. `type`: float32 or float64.
void add_box(FileContent& content, const BoxFields& box, ArrayType type);

/// Fills the components of every field of `box` on its own nodes from arrays of float64. False, and nothing, where the file has no such
/// box or one of other nodes. Throws RunError. Not collective.
bool read_box(const Hdf5Reader& file, BoxFields& box);

}  // namespace bulkley
