#pragma once
// The pressure system of one rank: what particles of a volumetric law give to the unknown of their base cell, and products with
// its matrices (docs/theory.md, "Implicit pressure").
//
// All particles with one base node share one pressure. They are on one rank and reach the same nodes. Sums over the particles
// of a cell run in the order of their ids, sums over the cells of a node in the order of the cells' places in the grid, and
// sums over the nodes of a cell in the order of the stencil: every number is the same bits wherever it is computed.

#include <optional>
#include <span>
#include <vector>

#include "bulkley/particle/particle_set.hpp"
#include "grid/node_pool.hpp"
#include "kernel/transfer.hpp"
#include "material/volumetric_law.hpp"

namespace bulkley {

/// By material; none for those that the pressure leaves explicit.
using VolumetricLaws = std::vector<std::optional<VolumetricLaw>>;

/// Which particles share a cell, each cell's by ascending id.
struct CellParticles {
  std::vector<LocalIndex> first;     ///< by cell, then the end: where its particles begin
  std::vector<LocalIndex> particle;  ///< indices into the particle set

  std::span<const LocalIndex> of(LocalIndex cell) const {
    const auto c = static_cast<std::size_t>(cell);
    return {particle.data() + first[c], static_cast<std::size_t>(first[c + 1] - first[c])};
  }
  LocalIndex size() const { return static_cast<LocalIndex>(first.size()) - 1; }
};

/// Groups the particles that have a volumetric law. `cell_of`: by particle; `number_of`: the cell's number in the result, -1
/// for none. Not collective.
void group_by_cell(const VolumetricLaws& laws, const ParticleSet& particles, std::span<const LocalIndex> cell_of,
                   std::span<const LocalIndex> number_of, LocalIndex n_cells, CellParticles& result);

/// Sums over the particles of a cell.
struct PressureCell {
  double volume = 0.0;         ///< V_c = sum V_p, m^3, reference
  double mass = 0.0;           ///< kg
  double compliance = 0.0;     ///< A_c = sum V_p / p'_p, m^3/Pa
  double target = 0.0;         ///< A_c p0_c = sum V_p p_p / p'_p, m^3
  double start = 0.0;          ///< mean pressure of the last step, Pa
  bool parts = false;          ///< no particle of it holds tension
  double parted_volume = 0.0;  ///< of the particles without pressure in the last step, m^3
};

/// (I2), (I3): the sums of a cell, and its row of B in m^2, one Node {x, y, z, 0} a node of the stencil, z fastest. `gradient`:
/// stencil_width^3 of them. Not collective.
void fill_cell(const GridGeometry& grid, GradientForm form, const VolumetricLaws& laws, const ParticleSet& particles,
               std::span<const LocalIndex> members, PressureCell& cell, Node* gradient);

/// Rows of B of all cells that a rank needs, in the order of the cells' places in the grid. The nodes of a stencil lie in rows
/// along z, whose nodes follow each other in the caller's arrays.
struct PressureRows {
  int width = 0;                  ///< stencil_width
  std::vector<LocalIndex> first;  ///< by cell and row along z: number of its first node
  NodeVector gradient;            ///< by cell and node of its stencil
  /// {x, y, z} likewise in single precision, and one more number: what products of an iteration read less than half the bytes
  /// of. Both B and its transpose are of them there, so that the matrix stays symmetric; forces come from `gradient`.
  std::vector<float, CacheLineAllocator<float>> rounded;

  int n_rows() const { return width * width; }
  int n_stencil() const { return n_rows() * width; }
  LocalIndex size() const { return width > 0 ? static_cast<LocalIndex>(first.size()) / n_rows() : 0; }
  /// Room for `n` cells; their entries are undefined.
  void resize(LocalIndex n);
  Node* gradient_of(LocalIndex cell) {
    return gradient.data() + static_cast<std::size_t>(cell) * static_cast<std::size_t>(n_stencil());
  }
  /// Fills `rounded` of a cell from its `gradient`.
  void round(LocalIndex cell);
};

/// Which entries of the rows a product takes.
enum class RowEntries { exact, rounded };

/// sums += B^T p over the cells `begin` to `end`, in their order. The fourth number of a sum is undefined. Not collective.
void add_gradients(const PressureRows& rows, RowEntries entries, LocalIndex begin, LocalIndex end, const double* pressure,
                   Node* sums);
/// rates[c] = (B v)_c, m^3/s, of the cells c in `cells`. Not collective.
void volume_rates(const PressureRows& rows, RowEntries entries, std::span<const LocalIndex> cells, const Node* velocity,
                  double* rates);
/// sum over its nodes of B_x^2 s_x + B_y^2 s_y + B_z^2 s_z, with rounded entries: a cell's part of the diagonal of B s B^T. Not
/// collective.
double diagonal_of(const PressureRows& rows, LocalIndex cell, const Node* scales);

/// What the particles of a cell learn of a step.
struct VolumeUpdate {
  double relaxation;              ///< beta of (I9)
  const double* before;           ///< J at the start of the step, by particle
  const char* carried = nullptr;  ///< by particle: an inflow carries it, and its J is given; null: none
};

/// (I8), (I9): the volume ratios that the stress update has left, each from its own det f, become those of the cell's mean
/// dilation, shared by compliance, and relax towards their mean within each material; where the cell has parted each keeps its
/// own. What is carried takes part in the dilation and keeps its J. Sets the field `cell_mean_stress` to `pressure`, Pa. Not collective.
void update_volumes(const VolumetricLaws& laws, const VolumeUpdate& update, std::span<const LocalIndex> members,
                    double pressure, bool parted, ParticleSet& particles);

}  // namespace bulkley
