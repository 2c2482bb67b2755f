#pragma once
// The magnetic field in and around magnetic materials on a box of nodes, from the content of its nodes (docs/theory.md, "Magnetic
// fields").

#include <algorithm>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "grid/box_fields.hpp"
#include "magnetics/applied_field.hpp"
#include "magnetics/magnetics_settings.hpp"
#include "magnetics/magnetisation.hpp"
#include "magnetostatics/layered_node.hpp"
#include "magnetostatics/petsc_potential.hpp"

namespace bulkley {

/// What one solution took and found. The same on every rank.
struct MagneticReport {
  int n_sweeps = 0;
  int n_iterations = 0;  ///< of all sweeps
  double residual = 0.0;
  double change = 0.0;  ///< largest relative one of a permeability in the last sweep
  double largest_permeability = 1.0;
  bool solved = true;   ///< potentials reached their tolerance
  bool settled = true;  ///< permeabilities did
};

/// H = H_0 - grad phi with div(mu H) = 0. Nodes are those of a FieldGrid; all arrays by owned node are empty on ranks without.
class Magnetostatics {
 public:
  /// `origin`: m, of the dipole whose fall FarField::robin has. `materials`: magnetic ones. `applied` must outlive this. Collective.
  Magnetostatics(const Comm& comm, const FieldLayout& layout, const MagneticsSettings& settings, const Vec3& origin,
                 std::vector<Magnetisation> materials, const AppliedField& applied);

  std::size_t n_materials() const { return materials_.size(); }
  const Magnetisation& material(std::size_t n) const { return materials_[n]; }
  const FieldGrid& grid() const { return potential_solver_.finest().grid(); }
  const PotentialSolver& potential_solver() const { return potential_solver_; }

  /// `content`: by material, by owned node: the reference volume that particles give the node, over a cell's. Starts from the potential
  /// of the last solution, or the one that was set, and from nothing else: a restart needs no more. Collective.
  MagneticReport solve(double time, std::vector<std::vector<double>> content);

  /// Of the last solution, by owned node: phi, A; |H|, A/m, and mu_0 dw/dtheta (G9), J/m^3, of each material, right where there is
  /// material and zero elsewhere.
  const std::vector<double>& potential() const { return potential_; }
  std::span<const double> strength() const { return strength_; }
  /// Likewise: H along an axis; h, the field inside the content, both A/m; and 1 where there is material.
  std::vector<double> field_along(int axis) const;
  std::vector<double> inner_field() const;
  std::vector<double> indicator() const;
  std::span<const double> energy_slope(std::size_t material) const { return energy_slopes_[material]; }
  /// Where the next solution starts; fields and energies are those of the last one all the same. Not collective.
  void set_potential(std::vector<double> potential) { potential_ = std::move(potential); }
  std::size_t memory() const;

  /// This rank's part of the nodes, without fields. Not collective.
  BoxFields box() const;
  /// For frames, group magnetic_field: `potential` phi, `field` H, `flux_density` B (means of the edges on both sides of a node) and
  /// `content` theta. Inside a magnet, where H_0 is its B/mu_0, H is B/mu_0 too. Not collective.
  BoxFields shown() const;
  /// W of (G8) times mu_0 dx^3: the magnetic energy is minus that, J. Collective.
  double co_energy();
  /// Sum of M over the volume, A m^2. Collective.
  Vec3 moment();
  /// What the sources would give, J, if the material kept the M of the last solution while they change from what they are at the time
  /// of the solution to what they are at `time`, s: - mu_0 dx^3 sum_f M_f (H_0f(time) - H_0f). Collective.
  double source_work(double time);

 private:
  /// What a node's content makes of the field there.
  struct NodeState {
    double dilution = 0.0, dilution_slope = 0.0;  ///< c
    double inner = 0.0;                           ///< h, A/m
    double mean = 0.0;                            ///< magnetisation of the content at h, A/m
  };
  void find_states();
  NodeBox box_near_content() const;
  NodeBox owned_edges(int axis, const NodeBox& box) const;
  void spread_content(double time);
  void set_permeabilities();
  void set_energy_slopes();
  void set_edges();
  void set_right_side();
  PotentialReport find_potential();
  void find_strength();
  /// `visit(lower node, place among ghosted nodes)` of all edges along `axis` whose ends are in `box` and in the field's box.
  template <class Visit>
  void for_edges(int axis, const NodeBox& box, Visit visit) const;
  /// The same by rows along z: `visit(first lower node, number, place)`.
  template <class Visit>
  void for_edge_rows(int axis, const NodeBox& box, Visit visit) const;
  std::pair<double, double> shown_along(int axis, const Int3& node, double applied) const;
  double applied_at(int axis, const Int3& n, double time) const;
  std::pair<double, double> dilution(double total) const;
  /// By ghosted node: of the edges along an axis.
  const std::vector<double>& around(int axis) const {
    return permeability_around_[layers_ ? static_cast<std::size_t>(axis) : 0];
  }
  // With layers (layered_field.cpp); `at`: a ghosted node that is not in the last layer.
  void set_gradients();
  void set_layers();
  void set_crossed_squares(std::size_t own, std::ptrdiff_t at);
  void set_layered_slopes();
  LayeredNode layered(std::size_t i) const;
  double central_field(int axis, std::ptrdiff_t at) const;
  double central_applied(int axis, std::ptrdiff_t at) const;
  double central_applied(int axis, const Int3& n, double time) const;
  /// `visit(coupling, other axis, place, node)` of what couples `axis` to others at owned nodes.
  template <class Visit>
  void for_crossed(int axis, Visit visit) const;
  double edge_field(int axis, std::size_t at) const;
  double edge_energy(int axis, std::size_t at) const;
  std::array<double, 2> half_edge_shares(double here, double there) const;

  const Comm& all_;
  MagneticsSettings settings_;
  double depolarisation_;  // N of the mixing rule
  std::vector<Magnetisation> materials_;
  const AppliedField& applied_;
  bool linear_, layers_;
  double overfill_;  // q of the mixing rule
  double spacing_;
  PotentialSolver potential_solver_;
  std::optional<PetscPotential> petsc_;  // in its place, where the settings say so
  double time_ = std::numeric_limits<double>::quiet_NaN();
  // Nodes among the ghosted ones: those with content and their neighbours, now, and at the last solution too.
  NodeBox near_content_, touched_;
  // Of owned nodes with content: which they are, and their states, with layers or without.
  std::vector<std::size_t> filled_, filled_at_;  // the latter among ghosted nodes
  std::vector<NodeState> states_;
  std::vector<LayeredNode> layered_states_;
  // By owned node.
  std::vector<std::vector<double>> content_;
  std::vector<double> total_, permeability_, strength_, potential_, right_;
  // With layers: gradients of the total, a cell, and H H, (A/m)^2: xx, yy, zz, yz, zx, xy.
  std::array<std::vector<double>, 3> gradient_;
  std::array<std::vector<double>, 6> squares_;
  std::vector<std::vector<double>> energy_slopes_;
  // By ghosted node: of the node, or of the edge to the next one.
  std::vector<double> total_around_, potential_around_;
  std::array<std::vector<double>, 3> permeability_around_;  // of edges along each axis; the first one only without layers
  std::array<std::vector<double>, 3> applied_along_;        // A/m; NaN where not needed so far
};

template <class Visit>
void Magnetostatics::for_edge_rows(int axis, const NodeBox& box, Visit visit) const {
  const FieldLevel& level = potential_solver_.finest();
  const LevelShape& shape = level.shape();
  const NodeBox& ghosted = level.ghosted();
  Int3 first = box.first, end;
  for (int b = 0; b < 3; ++b) {
    const auto a = static_cast<std::size_t>(b);
    end[a] = box.first[a] + box.count[a] - (b == axis);
    if (shape.wraps[a]) continue;
    first[a] = std::max(first[a], 0);
    end[a] = std::min(end[a], shape.n_nodes[a] - (b == axis));
  }
  for (int i = first[0]; i < end[0]; ++i)
    for (int j = first[1]; j < end[1]; ++j)
      if (end[2] > first[2])
        visit(Int3{i, j, first[2]}, end[2] - first[2], static_cast<std::size_t>(ghosted.index(i, j, first[2])));
}

template <class Visit>
void Magnetostatics::for_edges(int axis, const NodeBox& box, Visit visit) const {
  for_edge_rows(axis, box, [&](Int3 n, int count, std::size_t at) {
    for (int k = 0; k < count; ++k, ++n[2], ++at) visit(n, at);
  });
}

template <class Visit>
void Magnetostatics::for_crossed(int axis, Visit visit) const {
  const FieldLevel& level = potential_solver_.finest();
  const NodeBox& owned = level.owned();
  Int3 n;
  for_rows(owned, [&](int i, int j) {
    n[0] = i, n[1] = j;
    for (n[2] = owned.first[2]; n[2] < owned.first[2] + owned.count[2]; ++n[2])
      for (const int b : {(axis + 1) % 3, (axis + 2) % 3}) {
        const std::ptrdiff_t at = level.ghosted().index(n);
        const double coupling = level.cross[static_cast<std::size_t>(3 - axis - b)][static_cast<std::size_t>(at)];
        if (coupling != 0.0) visit(coupling, b, at, n);
      }
  });
}

}  // namespace bulkley
