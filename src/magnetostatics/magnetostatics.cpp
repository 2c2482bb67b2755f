#include "magnetostatics/magnetostatics.hpp"

#include <algorithm>
#include <climits>
#include <cmath>
#include <tuple>
#include <utility>

#include "parallel/reproducible_sum.hpp"

namespace bulkley {

namespace {

constexpr int newton_steps = 6;
constexpr double newton_converged = 1e-8;  // the step after it would be of the order of its square
constexpr int relaxations = 2;             // of permeabilities at a given potential, before the first sweep
constexpr int most_iterations = 100;

// The smallest box that holds both, of which one may be empty.
NodeBox hull(const NodeBox& a, const NodeBox& b) {
  if (a.size() == 0 || b.size() == 0) return a.size() == 0 ? b : a;
  NodeBox both;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    both.first[axis] = std::min(a.first[axis], b.first[axis]);
    both.count[axis] = std::max(a.first[axis] + a.count[axis], b.first[axis] + b.count[axis]) - both.first[axis];
  }
  return both;
}

// (d - 1) (x . n) / |x|^2 over the faces of the box, d being the number of its open axes: the fall of a dipole's potential.
PotentialSolver::Leaks leaks_of(FarField boundary, const Vec3& origin, double unit) {
  return [boundary, origin, unit](FieldLevel& level) {
    const LevelShape& shape = level.shape();
    int n_open = 0;
    for (const bool wraps : shape.wraps) n_open += !wraps;
    const NodeBox& box = level.owned();
    Int3 n;
    for_rows(box, [&](int i, int j) {
      n[0] = i, n[1] = j;
      for (n[2] = box.first[2]; n[2] < box.first[2] + box.count[2]; ++n[2]) {
        Vec3 from = shape.position(n) - origin;
        double square = 0.0;
        for (int axis = 0; axis < 3; ++axis)
          if (!shape.wraps[static_cast<std::size_t>(axis)]) square += from[axis] * from[axis];
        double sum = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
          const auto a = static_cast<std::size_t>(axis);
          const bool last = n[a] == shape.n_nodes[a] - 1;
          if (shape.wraps[a] || (n[a] != 0 && !last)) continue;
          const double area = shape.share_across(axis, n) * shape.spacing[(axis + 1) % 3] * shape.spacing[(axis + 2) % 3];
          if (boundary == FarField::robin)
            sum += area * (n_open - 1) * (last ? from[axis] : -from[axis]) / square;
          else if (boundary == FarField::zero)
            sum += area / unit;
        }
        level.leak[static_cast<std::size_t>(box.index(n))] = sum / unit;
      }
    });
  };
}

bool nothing_leaks(const FieldLayout& layout, FarField boundary) {
  int n_open = 0;
  for (int axis = 0; axis < 3; ++axis) n_open += !layout.wraps_along(axis);
  return boundary == FarField::neumann || n_open == 0 || (n_open == 1 && boundary == FarField::robin);
}

}  // namespace

Magnetostatics::Magnetostatics(const Comm& comm, const FieldLayout& layout, const MagneticsSettings& settings,
                               const Vec3& origin, std::vector<Magnetisation> materials, const AppliedField& applied)
    : all_(comm),
      settings_(settings),
      depolarisation_(settings.mixing == Mixing::spheres  ? 1.0 / 3.0
                      : settings.mixing == Mixing::layers ? 1.0
                                                          : 0.0),
      materials_(std::move(materials)),
      applied_(applied),
      linear_(std::all_of(materials_.begin(), materials_.end(),
                          [](const Magnetisation& m) { return m.law == Magnetisation::Law::linear; })),
      layers_(settings.mixing == Mixing::layers),
      overfill_(0.2),
      spacing_(layout.geometry.cell_size),
      potential_solver_(comm, layout, leaks_of(settings.boundary, origin, layout.geometry.cell_size),
                        nothing_leaks(layout, settings.boundary)) {
  if (const double N = depolarisation_; N > 0.0)
    for (const Magnetisation& material : materials_)
      overfill_ = std::min(overfill_, 1.0 / (2.0 * N * material.initial_susceptibility()));
  if (settings.solver == FieldSolver::petsc) petsc_.emplace(potential_solver_, settings.petsc_options);
  const FieldLevel& level = potential_solver_.finest();
  const std::size_t n_owned = level.owned().size(), n_ghosted = level.ghosted().size();
  energy_slopes_.assign(materials_.size(), std::vector<double>(n_owned, 0.0));
  for (auto* values : {&total_, &permeability_, &strength_, &potential_, &right_}) values->assign(n_owned, 0.0);
  for (auto* values : {&total_around_, &potential_around_}) values->assign(n_ghosted, 0.0);
  for (std::size_t a = 0; a < (layers_ ? 3u : 1u); ++a) permeability_around_[a].assign(n_ghosted, 0.0);
  if (layers_) {
    for (auto& values : gradient_) values.assign(n_owned, 0.0);
    for (auto& values : squares_) values.assign(n_owned, 0.0);
    for (auto& values : potential_solver_.cross()) values.assign(n_ghosted, 0.0);
  }
  for (auto& values : applied_along_) values.assign(n_ghosted, std::numeric_limits<double>::quiet_NaN());
  near_content_ = level.ghosted();
}

// c(theta) and its derivative.
std::pair<double, double> Magnetostatics::dilution(double total) const {
  if (total <= 1.0) return {1.0 - total, -1.0};
  const double beyond = std::exp(-(total - 1.0) / overfill_);
  return {-overfill_ * (1.0 - beyond), -beyond};
}

// (G6): h + N c mean(h) = |H|, by Newton's method from the linear material's h.
void Magnetostatics::find_states() {
  if (layers_) {
    for (std::size_t n = 0; n < filled_.size(); ++n) layered_states_[n] = layered(filled_[n]);
    return;
  }
  for (std::size_t n = 0; n < filled_.size(); ++n) {
    const std::size_t i = filled_[n];
    NodeState& state = states_[n];
    state.inner = state.mean = 0.0;
    if (!(strength_[i] > 0.0)) continue;
    const double Nc = depolarisation_ * state.dilution, strength = strength_[i];
    const Mixture mixture(materials_, content_, i, total_[i]);
    double h = strength / (1.0 + Nc * mixture.initial_susceptibility());
    for (int step = 0; step < newton_steps; ++step) {
      const Magnetisation::Response m = mixture.response(h);
      const double change = (h + Nc * m.magnetisation - strength) / (1.0 + Nc * m.slope);
      h -= change;
      if (std::abs(change) < newton_converged * h) break;
    }
    state.inner = h;
    state.mean = mixture.at(h);
  }
}

// H_0 along an edge at its middle; where that is on a rim, a wire or a dipole, which no material is, a little beside it.
double Magnetostatics::applied_at(int axis, const Int3& n, double time) const {
  Vec3 middle = potential_solver_.finest().shape().position(n);
  middle[axis] += 0.5 * spacing_;
  const double value = applied_.at(middle, time)[axis];
  return std::isfinite(value) ? value : applied_.at(middle + Vec3::Constant(1e-3 * spacing_), time)[axis];
}

// The nodes with content and one more all around, of the ghosted ones.
NodeBox Magnetostatics::box_near_content() const {
  const NodeBox& ghosted = potential_solver_.finest().ghosted();
  Int3 first{INT_MAX, INT_MAX, INT_MAX}, last{INT_MIN, INT_MIN, INT_MIN};
  for_rows(ghosted, [&](int i, int j) {
    const double* const row = total_around_.data() + ghosted.index(i, j, ghosted.first[2]);
    for (int k = 0; k < ghosted.count[2]; ++k) {
      if (!(row[k] > 0.0)) continue;
      const Int3 node{i, j, ghosted.first[2] + k};
      for (std::size_t a = 0; a < 3; ++a) first[a] = std::min(first[a], node[a]), last[a] = std::max(last[a], node[a]);
    }
  });
  if (first[0] > last[0]) return {ghosted.first, {0, 0, 0}};
  NodeBox box;
  for (std::size_t a = 0; a < 3; ++a) box.first[a] = first[a] - 1, box.count[a] = last[a] - first[a] + 3;
  return common(box, ghosted);
}

void Magnetostatics::spread_content(double time) {
  std::fill(total_.begin(), total_.end(), 0.0);
  for (const auto& values : content_)
    for (std::size_t i = 0; i < total_.size(); ++i) total_[i] += values[i];
  std::fill(permeability_.begin(), permeability_.end(), 1.0);
  const FieldLevel& level = potential_solver_.finest();
  filled_.clear();
  filled_at_.clear();
  for_rows(level.owned(), [&](int i, int j) {
    auto own = static_cast<std::size_t>(level.owned().index(i, j, level.owned().first[2])),
         at = static_cast<std::size_t>(level.ghosted().index(i, j, level.owned().first[2]));
    for (int k = 0; k < level.owned().count[2]; ++k, ++own, ++at) {
      if (!(total_[own] > 0.0)) continue;
      filled_.push_back(own);
      filled_at_.push_back(at);
    }
  });
  level.spread(total_, total_around_);
  const NodeBox before = near_content_;
  near_content_ = box_near_content();
  touched_ = hull(before, near_content_);
  if (layers_) {
    layered_states_.resize(filled_.size());
    set_gradients();
  } else {
    states_.resize(filled_.size());
    for (std::size_t n = 0; n < filled_.size(); ++n)
      std::tie(states_[n].dilution, states_[n].dilution_slope) = dilution(total_[filled_[n]]);
  }
  const bool stale = time != time_ && applied_.varies();
  for (int axis = 0; axis < 3; ++axis) {
    auto& along = applied_along_[static_cast<std::size_t>(axis)];
    if (stale) std::fill(along.begin(), along.end(), std::numeric_limits<double>::quiet_NaN());
    const auto next = static_cast<std::size_t>(level.ghosted().stride(axis));
    for_edges(axis, near_content_, [&](const Int3& n, std::size_t at) {
      if (!std::isnan(along[at]) || !(total_around_[at] > 0.0 || total_around_[at + next] > 0.0)) return;
      along[at] = applied_at(axis, n, time);
    });
  }
  time_ = time;
}

// Where there is no field yet, that of a weak one.
void Magnetostatics::set_permeabilities() {
  find_states();
  if (layers_) return set_layers();
  for (std::size_t n = 0; n < filled_.size(); ++n) {
    const std::size_t i = filled_[n];
    double ratio = strength_[i] > 0.0 ? states_[n].mean / strength_[i] : 0.0;
    if (!(strength_[i] > 0.0)) {
      const double susceptibility = Mixture(materials_, content_, i, total_[i]).initial_susceptibility();
      ratio = susceptibility / (1.0 + depolarisation_ * states_[n].dilution * susceptibility);
    }
    permeability_[i] = 1.0 + total_[i] * ratio;
  }
  potential_solver_.finest().spread(permeability_, permeability_around_[0]);
}

// (G4).
void Magnetostatics::set_edges() {
  const FieldLevel& level = potential_solver_.finest();
  const bool harmonic = settings_.edges == EdgeMean::harmonic;
  for (int axis = 0; axis < 3; ++axis) {
    const std::ptrdiff_t next = level.ghosted().stride(axis);
    for_edge_rows(axis, touched_, [&](const Int3&, int count, std::size_t at) {
      const double* const here = around(axis).data() + at;
      double* const edge = potential_solver_.edges(axis).data() + at;
      for (int k = 0; k < count; ++k) {
        const double sum = here[k] + here[k + next];
        edge[k] = harmonic ? 2.0 * here[k] * here[k + next] / sum : 0.5 * sum;
      }
    });
  }
  potential_solver_.prepare(touched_);
  if (petsc_) petsc_->prepare();
}

// (G7): what flows out of a node because of the magnetised part of H_0.
void Magnetostatics::set_right_side() {
  const FieldLevel& level = potential_solver_.finest();
  const NodeBox& owned = level.owned();
  std::fill(right_.begin(), right_.end(), 0.0);
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const std::span<const double> edges = potential_solver_.edges(axis);
    for_edges(axis, near_content_, [&](const Int3& n, std::size_t at) {
      const double applied = applied_along_[a][at];
      if (std::isnan(applied)) return;
      const double flux = (edges[at] - 1.0) * applied * spacing_ * level.shape().share_across(axis, n);
      for (std::size_t d = 0; d < 3; ++d)
        if (d != a && (n[d] < owned.first[d] || n[d] >= owned.first[d] + owned.count[d])) return;
      if (n[a] >= owned.first[a]) right_[static_cast<std::size_t>(owned.index(n))] -= flux;
      Int3 there = n;
      if (++there[a] < owned.first[a] + owned.count[a]) right_[static_cast<std::size_t>(owned.index(there))] += flux;
    });
  }
  if (layers_) level.add_crossed([&](int b, std::ptrdiff_t at) { return spacing_ * central_applied(b, at); }, right_);
}

// On ranks without nodes, the report of the root, which has some.
PotentialReport Magnetostatics::find_potential() {
  PotentialReport report;
  if (potential_solver_.has_nodes())
    report = petsc_ ? petsc_->solve(right_, settings_.tolerance, most_iterations, potential_)
                    : potential_solver_.solve(right_, settings_.tolerance, most_iterations, potential_);
  double numbers[3] = {1.0 * report.n_iterations, report.residual, report.solved ? 1.0 : 0.0};
  BULKLEY_MPI(MPI_Bcast(numbers, 3, MPI_DOUBLE, 0, all_.get()));
  return {static_cast<int>(numbers[0]), numbers[1], numbers[2] == 1.0};
}

double Magnetostatics::edge_field(int axis, std::size_t at) const {
  const auto next = static_cast<std::size_t>(potential_solver_.finest().ghosted().stride(axis));
  return applied_along_[static_cast<std::size_t>(axis)][at] -
         (potential_around_[at + next] - potential_around_[at]) / spacing_;
}

// The fields in the two halves of an edge over that of the whole.
std::array<double, 2> Magnetostatics::half_edge_shares(double here, double there) const {
  if (settings_.edges == EdgeMean::arithmetic) return {1.0, 1.0};
  return {2.0 * there / (here + there), 2.0 * here / (here + there)};
}

// (G5), where there is content.
void Magnetostatics::find_strength() {
  const FieldLevel& level = potential_solver_.finest();
  level.spread(potential_, potential_around_);
  for (std::size_t n = 0; n < filled_.size(); ++n) {
    const std::size_t own = filled_[n], at = filled_at_[n];
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis) {
      const double before = sum;
      const auto next = static_cast<std::size_t>(level.ghosted().stride(axis));
      for (const std::size_t lower : {at - next, at}) {
        if (std::isnan(applied_along_[static_cast<std::size_t>(axis)][lower])) continue;  // beyond the box
        const auto shares = half_edge_shares(around(axis)[lower], around(axis)[lower + next]);
        const double field = shares[lower == at ? 0 : 1] * edge_field(axis, lower);
        sum += field * field;
      }
      if (layers_) squares_[static_cast<std::size_t>(axis)][own] = 0.5 * (sum - before);
    }
    if (layers_) set_crossed_squares(own, static_cast<std::ptrdiff_t>(at));
    strength_[own] = std::sqrt(0.5 * sum);
  }
}

MagneticReport Magnetostatics::solve(double time, std::vector<std::vector<double>> content) {
  content_ = std::move(content);
  const bool here = potential_solver_.has_nodes();
  if (here) {
    spread_content(time);
    std::fill(strength_.begin(), strength_.end(), 0.0);
    for (auto& values : squares_) std::fill(values.begin(), values.end(), 0.0);
    set_permeabilities();
    for (int n = 0; n < relaxations && !linear_; ++n) {
      find_strength();
      set_permeabilities();
    }
  }
  MagneticReport report;
  std::vector<double> before(filled_.size());
  const int n_sweeps = linear_ ? 1 : settings_.picard_limit;
  while (report.n_sweeps < n_sweeps) {
    if (here) {
      set_edges();
      set_right_side();
    }
    const PotentialReport found = find_potential();
    ++report.n_sweeps;
    report.n_iterations += found.n_iterations;
    report.residual = found.residual;
    report.solved = found.solved;
    double change = 0.0, largest = 1.0;
    if (here) {
      find_strength();
      for (std::size_t n = 0; n < filled_.size(); ++n) before[n] = permeability_[filled_[n]];
      linear_ ? find_states() : set_permeabilities();
      for (std::size_t n = 0; n < filled_.size(); ++n) {
        const double now = permeability_[filled_[n]];
        change = std::max(change, std::abs(now - before[n]) / before[n]);
        largest = std::max(largest, now);
      }
    }
    report.change = max_global(all_, change);
    report.largest_permeability = max_global(all_, largest);
    report.settled = linear_ || report.change <= settings_.picard_tolerance;
    if (!report.solved || report.settled) break;
  }
  if (here) set_energy_slopes();
  return report;
}

void Magnetostatics::set_energy_slopes() {
  for (auto& slopes : energy_slopes_) std::fill(slopes.begin(), slopes.end(), 0.0);
  if (layers_) return set_layered_slopes();
  for (std::size_t n = 0; n < filled_.size(); ++n) {
    const std::size_t i = filled_[n];
    const NodeState& state = states_[n];
    const double mixing =
        0.5 * depolarisation_ * (state.dilution - total_[i] * state.dilution_slope) * state.mean * state.mean;
    for (std::size_t s = 0; s < materials_.size(); ++s)
      energy_slopes_[s][i] = vacuum_permeability * (materials_[s].co_energy(state.inner) + mixing);
  }
}

std::size_t Magnetostatics::memory() const {
  const std::size_t n_owned = (5 + 2 * materials_.size() + (layers_ ? 9 : 0)) * potential_.size();
  const std::size_t n_ghosted = (layers_ ? 11 : 6) * potential_around_.size();
  return (n_owned + n_ghosted) * sizeof(double) + potential_solver_.memory() + (petsc_ ? petsc_->memory() : 0);
}

}  // namespace bulkley
