#pragma once
// The implicit pressure of a step: one unknown a base cell, one linear system a step, solved by conjugate gradients whose
// arithmetic is the same on any number of ranks (docs/theory.md, "Implicit pressure").

#include <memory>

#include "distribution/cell_grid.hpp"
#include "integrator/integrator.hpp"
#include "integrator/pressure_bodies.hpp"
#include "integrator/pressure_contact.hpp"
#include "integrator/pressure_matrix.hpp"
#include "kernel/pressure_cells.hpp"

namespace bulkley {

class PetscSolver;
struct PetscGoal;

class ImplicitPressure {
 public:
  /// `parts` must outlive this. Collective.
  explicit ImplicitPressure(StepParts& parts);
  ~ImplicitPressure();

  /// Makes everything fit the present pools. Collective.
  void fit();

  /// Makes the system of a step from `time` of the particles as they are. `nodes`: {v, m} of the owned ones before contact, images
  /// folded. Collective.
  void begin(double time, const GridUpdate& update, const Node* nodes);
  /// After `begin`, where the velocities of `nodes` have changed. Collective.
  void fetch(const Node* nodes);
  /// The impulses of the last step's pressure in a step of dt, s, of owned nodes in front of walls and behind; after `begin`,
  /// valid until `apply`. Collective.
  std::span<const Node> last_impulses(double dt);
  /// Finds the pressures at the end of a step from `time` and adds their impulses to the owned nodes. `nodes`: {v, m} before
  /// contact, images folded; `change`: likewise their change in the step, or null. `unclipped_dt`: s, that of (I7). Where it was
  /// not solved, nothing is added; the same on every rank. Collective.
  PressureReport apply(double time, const GridUpdate& update, double unclipped_dt, Node* nodes, Node* change);

  /// The particles of `block` are about to learn their own deformation. Not collective.
  void keep_volumes(ParticleBlock block);
  /// All particles know it: volume ratios become those of the cells, and `totals` theirs. Not collective.
  void update_volumes(StepBounds& local);

  /// That this rank sends. Not collective.
  std::size_t bytes_per_iteration() const { return halo_.sent_bytes(); }
  std::size_t memory() const;

 private:
  void find_cells(double time);
  const std::vector<LocalIndex>& cells() const;
  void count_cells();
  void select_nodes(const GridUpdate& update, const Node* nodes);
  void number_cells();
  void sort_own_by_wave();
  void fill_cells();
  void account_for_carried(std::size_t k);
  void copy_nodes(const GridUpdate& update, const Node* nodes);
  double precondition(const std::vector<double>& from);
  void begin_solution(double dt);
  bool solve(double dt, double tolerance, PressureReport& report);
  void assemble(double dt);
  bool solve_with_petsc(const PetscGoal& goal, PressureReport& report);
  template <class F>
  void hold_nodes(F velocity_of_body);
  void set_right_side(double dt);
  void find_residual(double dt);
  void sum_blocks(const std::vector<double>& p);
  double stabilisation(std::size_t k, const std::vector<double>& p) const;
  void set_diagonal(double dt, double unclipped_dt);
  void multiply(double dt, std::vector<double>& p, const PressureBodies::Coupling& coupling);
  PressureBodies::Coupling couple(const std::vector<double>& p) const;
  void merge_bodies(double time, const GridUpdate& update);
  void gradients_of(std::vector<double>& p, RowEntries entries);
  void find_unheld(double dt);
  GlobalIndex revise(double dt, RowEntries entries);
  GlobalIndex revise_parted();
  void copy_impulses(double dt);
  void add_impulses(const GridUpdate& update, Node* nodes, Node* change);
  double speed_scale(double dt) const;

  StepParts& parts_;
  VolumetricLaws laws_;
  bool any_may_part_;  // some material holds no tension
  PressureContact contact_;
  std::unique_ptr<PressureBodies> bodies_;                               // only where there are rigid bodies
  PressureBodies::Coupling coupling_of_scaled_, coupling_of_direction_;  // likewise
  std::unique_ptr<CellGrid> grid_;
  GlobalIndex fitted_ = -1;
  CellHalo halo_;
  // Cells with particles in the order of their places, this rank's and those of others that it needs.
  std::vector<LocalIndex> cell_of_;                   // by particle: id, or n_own_ids of grid_ for none; only with inflows
  std::vector<char> carried_;                         // by particle: an inflow carries it in the step; empty without inflows
  std::vector<LocalIndex> number_of_;                 // by id; -1: empty
  std::vector<std::int32_t> counts_;                  // by id
  std::vector<LocalIndex> own_;                       // numbers of this rank's cells
  std::vector<LocalIndex> others_;                    // and of those of other ranks
  std::vector<LocalIndex> place_of_;                  // in own_, by id of this rank's cells, and of none; -1: empty
  CellParticles members_;                             // by place in own_
  std::vector<double> volume_, compliance_, target_;  // of PressureCell, by place in own_
  std::vector<char> may_part_;                        // likewise: no particle of it holds tension
  // Products go through the grid in waves.
  std::vector<LocalIndex> end_of_plane_;               // numbers at which planes of cells end, 0 before the first
  std::vector<LocalIndex> wave_of_own_, own_by_wave_;  // by place in own_; its numbers sorted by wave
  WaveRanges own_ranges_;
  PressureRows rows_;
  // Blocks of 2 x 2 x 2 cells of a tile.
  std::vector<LocalIndex> block_of_;  // by place in own_
  std::vector<double> block_volume_, inverse_block_volume_, block_mass_, block_sum_;
  std::vector<double> within_block_;  // by place in own_: Z of pressures that differ from the mean of the block, m^3/Pa
  // By number of the cell; where it is another rank's, zero but for what has been exchanged.
  std::vector<double> pressure_, right_, residual_, direction_, product_, scaled_, inverse_diagonal_;
  double square_ = 0.0, square_of_right_ = 0.0;  // of the residual and the right side, over the diagonal, J
  std::vector<char> parted_;                     // by place in own_: cells that hold no tension and have p = 0
  std::vector<char> takes_part_;                 // by node of grid_
  // By node of contact_.nodes().
  NodeVector free_, held_, impulses_;
  std::vector<double> scale_;  // 1/m, 0 where empty
  NodeVector pool_, owned_impulses_;
  std::vector<double> before_;  // J at the start of the step, by particle
  // Only with PETSc as the solver.
  PressureMatrix matrix_;
  std::unique_ptr<PetscSolver> petsc_;
  bool preconditioned_ = false;  // petsc_ has a preconditioner for the cells of this step
};

}  // namespace bulkley
