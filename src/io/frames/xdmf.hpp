#pragma once
// XDMF: the small XML files that let ParaView open our HDF5 files. Not collective.
//
// What both of ParaView's readers understand is narrow: an explicit connectivity, or there is nothing to draw; integers no
// wider than int64; tensors with nine components; origin and spacing of a grid in the order z y x; relative file names.

#include <string>
#include <vector>

#include "io/arrays/hdf5_file.hpp"

namespace bulkley {

struct XdmfField {
  std::string name;
  ArrayInfo array;
};

/// The particles of one file at one time.
struct XdmfParticles {
  std::string file;  ///< name without folder
  double time = 0.0;
  ArrayInfo position;
  ArrayInfo connectivity;
  std::vector<XdmfField> fields;
};

enum class XdmfCenter { node, cell };

/// A regular mesh of one file at one time; arrays are (nz, ny, nx) or (nz, ny, nx, 3) of its nodes or its cells.
struct XdmfGrid {
  std::string name;
  std::string file;
  double time = 0.0;
  XdmfCenter center = XdmfCenter::node;  ///< what the fields belong to
  Extents n_nodes;                       ///< nz, ny, nx
  std::vector<double> origin;            ///< x, y, z; m
  double cell_size = 0.0;                ///< m
  std::vector<XdmfField> fields;
};

/// Triangles at one time. `triangles` and `fields`, of the triangles, may lie in another file than `vertices`.
struct XdmfSurface {
  std::string mesh_file;  ///< of `triangles` and `fields`
  std::string vertex_file;
  double time = 0.0;
  ArrayInfo vertices;
  ArrayInfo triangles;
  std::vector<XdmfField> fields;
};

/// A series of moments, by ascending time, is an opening, the moments one after the other, and a closing. Also a single moment:
/// outside a series one of the readers drops its time.
std::string xdmf_opening(const std::string& series);
std::string xdmf_closing();
std::string xdmf_moment(const XdmfParticles& particles);
std::string xdmf_moment(const XdmfGrid& grid);
std::string xdmf_moment(const XdmfSurface& surface);

/// Describes /particles of a file as it is on disk; `time` from its header. Throws RunError.
XdmfParticles xdmf_particles(const Hdf5Reader& file);
/// Describes /grid of a file, or /tiles as the cells of a mesh. Throws RunError.
XdmfGrid xdmf_grid(const Hdf5Reader& file);
XdmfGrid xdmf_tiles(const Hdf5Reader& file);
XdmfGrid xdmf_magnetic_field(const Hdf5Reader& file);
/// Describes /colliders of a frame, whose triangles lie in `mesh`. Throws RunError, also if the two do not fit together.
XdmfSurface xdmf_colliders(const Hdf5Reader& frame, const Hdf5Reader& mesh);

/// The XDMF file next to an HDF5 file: by itself it opens the particles of that file alone.
std::string sidecar_of(const std::string& file);
/// Writes it, after `file`, so that it never names what is not there; removes it where there are no particles, because ParaView
/// refuses an empty set and an older sidecar may name arrays that are gone. Throws RunError.
void write_sidecar(const std::string& file, GlobalIndex n_particles);

}  // namespace bulkley
