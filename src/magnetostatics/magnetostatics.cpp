#include "magnetostatics/magnetostatics.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include "parallel/reproducible_sum.hpp"

namespace bulkley {

namespace {

constexpr int newton_steps = 6;
constexpr int max_iterations = 100;

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

// What a node's content makes of the field there.
struct Magnetostatics::Node {
  double permeability = 1.0;  // relative
  double inner = 0.0;         // h, A/m
  double mean = 0.0;          // magnetisation of the content at h, A/m
  double dilution = 0.0;      // c
  double dilution_slope = 0.0;
};

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
}

// c(theta) and its derivative.
std::pair<double, double> Magnetostatics::dilution(double total) const {
  if (total <= 1.0) return {1.0 - total, -1.0};
  const double beyond = std::exp(-(total - 1.0) / overfill_);
  return {-overfill_ * (1.0 - beyond), -beyond};
}

// (G6): h + N c mean(h) = |H|, by Newton's method from the linear material's h.
Magnetostatics::Node Magnetostatics::node_state(std::size_t i, double strength) const {
  Node node;
  const double total = total_[i];
  if (!(total > 0.0)) return node;
  std::tie(node.dilution, node.dilution_slope) = dilution(total);
  const double Nc = depolarisation_ * node.dilution;
  const Mixture mixture(materials_, content_, i, total);
  const double susceptibility = mixture.initial_susceptibility();
  if (!(strength > 0.0)) {
    node.permeability = 1.0 + total * susceptibility / (1.0 + Nc * susceptibility);
    return node;
  }
  double h = strength / (1.0 + Nc * susceptibility);
  for (int n = 0; n < newton_steps; ++n) h -= (h + Nc * mixture.at(h) - strength) / (1.0 + Nc * mixture.slope(h));
  node.inner = h;
  node.mean = mixture.at(h);
  node.permeability = 1.0 + total * node.mean / strength;
  return node;
}

// `visit(lower node, place among ghosted nodes)` of all edges along `axis` whose ends are in `box` and in the field's box.
template <class Visit>
void Magnetostatics::for_edges(int axis, const NodeBox& box, Visit visit) const {
  const FieldLevel& level = potential_solver_.finest();
  const LevelShape& shape = level.shape();
  const NodeBox& ghosted = level.ghosted();
  Int3 end;
  for (int b = 0; b < 3; ++b) {
    const auto a = static_cast<std::size_t>(b);
    end[a] = box.first[a] + box.count[a] - (b == axis);
    if (!shape.wraps[a]) end[a] = std::min(end[a], shape.n_nodes[a] - (b == axis));
  }
  Int3 first = box.first;
  for (std::size_t a = 0; a < 3; ++a)
    if (!shape.wraps[a]) first[a] = std::max(first[a], 0);
  Int3 n;
  for (n[0] = first[0]; n[0] < end[0]; ++n[0])
    for (n[1] = first[1]; n[1] < end[1]; ++n[1])
      for (n[2] = first[2]; n[2] < end[2]; ++n[2]) visit(n, static_cast<std::size_t>(ghosted.index(n)));
}

// H_0 along an edge at its middle; where that is on a rim, a wire or a dipole, which no material is, a little beside it.
double Magnetostatics::applied_at(int axis, const Int3& n, double time) const {
  Vec3 middle = potential_solver_.finest().shape().position(n);
  middle[axis] += 0.5 * spacing_;
  const double value = applied_.at(middle, time)[axis];
  return std::isfinite(value) ? value : applied_.at(middle + Vec3::Constant(1e-3 * spacing_), time)[axis];
}

void Magnetostatics::spread_content(double time, std::span<const std::vector<double>> content) {
  content_.assign(content.begin(), content.end());
  std::fill(total_.begin(), total_.end(), 0.0);
  for (const auto& values : content_)
    for (std::size_t i = 0; i < total_.size(); ++i) total_[i] += values[i];
  const FieldLevel& level = potential_solver_.finest();
  level.spread(total_, total_around_);
  if (layers_) set_gradients();
  const bool stale = time != time_ && applied_.varies();
  for (int axis = 0; axis < 3; ++axis) {
    auto& along = applied_along_[static_cast<std::size_t>(axis)];
    if (stale) std::fill(along.begin(), along.end(), std::numeric_limits<double>::quiet_NaN());
    const auto next = static_cast<std::size_t>(level.ghosted().stride(axis));
    for_edges(axis, level.ghosted(), [&](const Int3& n, std::size_t at) {
      if (!std::isnan(along[at]) || !(total_around_[at] > 0.0 || total_around_[at + next] > 0.0)) return;
      along[at] = applied_at(axis, n, time);
    });
  }
  time_ = time;
}

void Magnetostatics::set_permeabilities() {
  if (layers_) return set_layers();
  for (std::size_t i = 0; i < permeability_.size(); ++i) permeability_[i] = node_state(i, strength_[i]).permeability;
  potential_solver_.finest().spread(permeability_, permeability_around_[0]);
}

void Magnetostatics::set_edges() {
  const FieldLevel& level = potential_solver_.finest();
  for (int axis = 0; axis < 3; ++axis) {
    const auto next = static_cast<std::size_t>(level.ghosted().stride(axis));
    const std::span<double> edges = potential_solver_.edges(axis);
    for_edges(axis, level.ghosted(), [&](const Int3&, std::size_t at) {
      const double here = around(axis)[at], there = around(axis)[at + next];
      edges[at] = settings_.edges == EdgeMean::harmonic ? 2.0 * here * there / (here + there) : 0.5 * (here + there);
    });
  }
  potential_solver_.prepare();
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
    for_edges(axis, level.ghosted(), [&](const Int3& n, std::size_t at) {
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
    report = petsc_ ? petsc_->solve(right_, settings_.tolerance, max_iterations, potential_)
                    : potential_solver_.solve(right_, settings_.tolerance, max_iterations, potential_);
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

// (G5).
void Magnetostatics::find_strength() {
  const FieldLevel& level = potential_solver_.finest();
  const NodeBox &owned = level.owned(), &ghosted = level.ghosted();
  level.spread(potential_, potential_around_);
  for_rows(owned, [&](int i, int j) {
    for (int k = owned.first[2]; k < owned.first[2] + owned.count[2]; ++k) {
      const auto own = static_cast<std::size_t>(owned.index(i, j, k));
      strength_[own] = 0.0;
      if (!(total_[own] > 0.0)) continue;
      const auto at = static_cast<std::size_t>(ghosted.index(i, j, k));
      double sum = 0.0;
      for (int axis = 0; axis < 3; ++axis) {
        const double before = sum;
        const auto next = static_cast<std::size_t>(ghosted.stride(axis));
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
  });
}

MagneticReport Magnetostatics::solve(double time, std::span<const std::vector<double>> content) {
  const bool here = potential_solver_.has_nodes();
  if (here) {
    spread_content(time, content);
    set_permeabilities();
  }
  MagneticReport report;
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
      const std::vector<double> before = permeability_;
      if (!linear_) set_permeabilities();
      for (std::size_t i = 0; i < before.size(); ++i) {
        change = std::max(change, std::abs(permeability_[i] - before[i]) / before[i]);
        largest = std::max(largest, permeability_[i]);
      }
    }
    report.change = max_global(all_, change);
    report.largest_permeability = max_global(all_, largest);
    report.settled = linear_ || report.change <= settings_.picard_tolerance;
    if (!report.solved || report.settled) break;
  }
  if (layers_) {
    if (here) set_layered_slopes();
    return report;
  }
  for (std::size_t i = 0; i < total_.size(); ++i) {
    const Node node = node_state(i, strength_[i]);
    const double mixing = 0.5 * depolarisation_ * (node.dilution - total_[i] * node.dilution_slope) * node.mean * node.mean;
    for (std::size_t s = 0; s < materials_.size(); ++s)
      energy_slopes_[s][i] = total_[i] > 0.0 ? vacuum_permeability * (materials_[s].co_energy(node.inner) + mixing) : 0.0;
  }
  return report;
}

void Magnetostatics::forget() {
  std::fill(potential_.begin(), potential_.end(), 0.0);
  std::fill(strength_.begin(), strength_.end(), 0.0);
  for (auto& values : squares_) std::fill(values.begin(), values.end(), 0.0);
}

std::size_t Magnetostatics::memory() const {
  const std::size_t n_owned = (5 + 2 * materials_.size() + (layers_ ? 9 : 0)) * potential_.size();
  const std::size_t n_ghosted = (layers_ ? 11 : 6) * potential_around_.size();
  return (n_owned + n_ghosted) * sizeof(double) + potential_solver_.memory() + (petsc_ ? petsc_->memory() : 0);
}

double Magnetostatics::co_energy() {
  std::vector<double> addends;
  if (potential_solver_.has_nodes()) {
    addends.reserve(5 * potential_.size());  // edges, leaks, and content where there is any
    const FieldLevel& level = potential_solver_.finest();
    const LevelShape& shape = level.shape();
    const NodeBox& owned = level.owned();
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      const auto next = static_cast<std::size_t>(level.ghosted().stride(axis));
      NodeBox edges = owned;
      ++edges.count[a];
      for_edges(axis, edges, [&](const Int3& n, std::size_t at) {
        const double applied = applied_along_[a][at];
        const double slope = (potential_around_[at + next] - potential_around_[at]) / spacing_;
        double energy = 0.5 * slope * slope;
        if (!std::isnan(applied)) {
          const double field = applied - slope;
          const auto shares = half_edge_shares(around(axis)[at], around(axis)[at + next]);
          energy = 0.25 * field * field * (shares[0] * shares[0] + shares[1] * shares[1]) - applied * field +
                   0.5 * applied * applied;
        }
        addends.push_back(shape.share_across(axis, n) * energy);
      });
    }
    for (std::size_t i = 0; i < total_.size(); ++i) {
      addends.push_back(0.5 * level.leak[i] * potential_[i] * potential_[i] / (spacing_ * spacing_));
      if (!(total_[i] > 0.0)) continue;
      double inner, energy;
      if (layers_) {
        const LayeredNode node = layered(i);
        inner = node.inner;
        energy = 0.5 * dilution(total_[i]).first * total_[i] * node.depolarised;
      } else {
        const Node node = node_state(i, strength_[i]);
        inner = node.inner;
        energy = 0.5 * depolarisation_ * node.dilution * total_[i] * node.mean * node.mean;
      }
      for (std::size_t s = 0; s < materials_.size(); ++s) energy += content_[s][i] * materials_[s].co_energy(inner);
      addends.push_back(energy);
    }
  }
  return vacuum_permeability * spacing_ * spacing_ * spacing_ * reproducible_sum(all_, addends);
}

Vec3 Magnetostatics::moment() {
  Vec3 sum = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> addends;
    if (potential_solver_.has_nodes()) {
      const auto a = static_cast<std::size_t>(axis);
      NodeBox edges = potential_solver_.finest().owned();
      ++edges.count[a];
      for_edges(axis, edges, [&](const Int3&, std::size_t at) {
        if (!std::isnan(applied_along_[a][at]))
          addends.push_back((potential_solver_.edges(axis)[at] - 1.0) * edge_field(axis, at));
      });
      if (layers_)
        for_crossed(axis, [&](double coupling, int b, std::ptrdiff_t at, const Int3&) {
          addends.push_back(coupling * central_field(b, at));
        });
    }
    sum[axis] = spacing_ * spacing_ * spacing_ * reproducible_sum(all_, addends);
  }
  return sum;
}

BoxFields Magnetostatics::shown() const {
  const FieldLevel& level = potential_solver_.finest();
  const LevelShape& shape = level.shape();
  BoxFields box{"magnetic_field", shape.origin, spacing_, shape.n_nodes, {0, 0, 0}, {0, 0, 0}, {}};
  const std::size_t n = potential_solver_.has_nodes() ? potential_.size() : 0;
  std::vector<std::vector<double>> field(3, std::vector<double>(n)), flux = field;
  if (n > 0) {
    const NodeBox &owned = level.owned(), &ghosted = level.ghosted();
    box.first = owned.first;
    box.count = owned.count;
    Int3 node;
    std::size_t own = 0;
    for (node[0] = owned.first[0]; node[0] < owned.first[0] + owned.count[0]; ++node[0])
      for (node[1] = owned.first[1]; node[1] < owned.first[1] + owned.count[1]; ++node[1])
        for (node[2] = owned.first[2]; node[2] < owned.first[2] + owned.count[2]; ++node[2], ++own) {
          const Vec3 applied = applied_.at(shape.position(node), time_);
          for (int axis = 0; axis < 3; ++axis) {
            const auto a = static_cast<std::size_t>(axis);
            const auto at = static_cast<std::size_t>(ghosted.index(node)),
                       next = static_cast<std::size_t>(ghosted.stride(axis));
            double n_edges = 0.0;
            for (const bool below : {true, false}) {
              if (!shape.wraps[a] && node[a] == (below ? 0 : shape.n_nodes[a] - 1)) continue;
              const std::size_t edge = below ? at - next : at;
              const double strength = applied[axis] - (potential_around_[edge + next] - potential_around_[edge]) / spacing_;
              field[a][own] += strength;
              flux[a][own] += vacuum_permeability * potential_solver_.edges(axis)[edge] * strength;
              n_edges += 1.0;
            }
            field[a][own] /= n_edges;
            flux[a][own] /= n_edges;
          }
          for (int axis = 0; layers_ && axis < 3; ++axis)
            for (const int b : {(axis + 1) % 3, (axis + 2) % 3})
              flux[static_cast<std::size_t>(axis)][own] +=
                  vacuum_permeability *
                  level.cross[static_cast<std::size_t>(3 - axis - b)][static_cast<std::size_t>(ghosted.index(node))] *
                  field[static_cast<std::size_t>(b)][own];
        }
  }
  const auto owned_part = [n](std::span<const double> values) {
    return std::vector<double>(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(n));
  };
  box.fields = {{"potential", "A", "phi, of what material adds to the applied field", {owned_part(potential_)}},
                {"field", "A/m", "H", field},
                {"flux_density", "T", "B", flux},
                {"content", "1", "reference volume of magnetic material over a cell's", {owned_part(total_)}}};
  return box;
}

double Magnetostatics::source_work(double time) {
  if (!applied_.varies()) return 0.0;
  std::vector<double> addends;
  if (potential_solver_.has_nodes()) {
    const FieldLevel& level = potential_solver_.finest();
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      NodeBox edges = level.owned();
      ++edges.count[a];
      for_edges(axis, edges, [&](const Int3& n, std::size_t at) {
        const double magnetised = potential_solver_.edges(axis)[at] - 1.0;
        if (std::isnan(applied_along_[a][at]) || magnetised == 0.0) return;
        const double change = applied_at(axis, n, time) - applied_along_[a][at];
        addends.push_back(level.shape().share_across(axis, n) * magnetised * edge_field(axis, at) * change);
      });
      if (layers_)
        for_crossed(axis, [&](double coupling, int b, std::ptrdiff_t at, const Int3& n) {
          addends.push_back(coupling * central_field(b, at) * (central_applied(axis, n, time) - central_applied(axis, at)));
        });
    }
  }
  return -vacuum_permeability * spacing_ * spacing_ * spacing_ * reproducible_sum(all_, addends);
}

}  // namespace bulkley
