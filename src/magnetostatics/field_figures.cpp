// What a solved magnetic field is asked for: energies, moments, and fields for frames.
#include <cmath>
#include <tuple>

#include "magnetostatics/magnetostatics.hpp"
#include "parallel/reproducible_sum.hpp"

namespace bulkley {

// The nodes between which are the edges from owned nodes along `axis`, of those of a box.
NodeBox Magnetostatics::owned_edges(int axis, const NodeBox& box) const {
  NodeBox edges = potential_solver_.finest().owned();
  ++edges.count[static_cast<std::size_t>(axis)];
  return common(edges, box);
}

// By the half edges of (G5).
std::vector<double> Magnetostatics::field_along(int axis) const {
  std::vector<double> field(total_.size(), 0.0);
  const auto next = static_cast<std::size_t>(potential_solver_.finest().ghosted().stride(axis));
  for (std::size_t n = 0; n < filled_.size(); ++n)
    for (const std::size_t lower : {filled_at_[n] - next, filled_at_[n]}) {
      if (std::isnan(applied_along_[static_cast<std::size_t>(axis)][lower])) continue;  // beyond the box
      const auto shares = half_edge_shares(around(axis)[lower], around(axis)[lower + next]);
      field[filled_[n]] += 0.5 * shares[lower == filled_at_[n] ? 0 : 1] * edge_field(axis, lower);
    }
  return field;
}

std::vector<double> Magnetostatics::inner_field() const {
  std::vector<double> inner(total_.size(), 0.0);
  for (std::size_t n = 0; n < filled_.size(); ++n) inner[filled_[n]] = layers_ ? layered_states_[n].inner : states_[n].inner;
  return inner;
}

std::vector<double> Magnetostatics::indicator() const {
  std::vector<double> one(total_.size(), 0.0);
  for (const std::size_t i : filled_) one[i] = 1.0;
  return one;
}

// Of an edge at a place among ghosted nodes, over its share of a cell.
double Magnetostatics::edge_energy(int axis, std::size_t at) const {
  const auto next = static_cast<std::size_t>(potential_solver_.finest().ghosted().stride(axis));
  const double applied = applied_along_[static_cast<std::size_t>(axis)][at];
  const double slope = (potential_around_[at + next] - potential_around_[at]) / spacing_;
  if (std::isnan(applied)) return 0.5 * slope * slope;  // of air
  const double field = applied - slope;
  const auto shares = half_edge_shares(around(axis)[at], around(axis)[at + next]);
  return 0.25 * field * field * (shares[0] * shares[0] + shares[1] * shares[1]) - applied * field + 0.5 * applied * applied;
}

// (G8). Far from content the edges are those of air.
double Magnetostatics::co_energy() {
  BinnedSum sum;
  if (potential_solver_.has_nodes()) {
    const FieldLevel& level = potential_solver_.finest();
    const LevelShape& shape = level.shape();
    std::vector<double> addends;
    for (int axis = 0; axis < 3; ++axis) {
      const std::ptrdiff_t next = level.ghosted().stride(axis);
      for_edge_rows(axis, owned_edges(axis, level.ghosted()), [&](Int3 n, int count, std::size_t at) {
        addends.resize(static_cast<std::size_t>(count));
        const double* const here = potential_around_.data() + at;
        const bool far = near_content_.size() == 0 || n[0] < near_content_.first[0] || n[1] < near_content_.first[1] ||
                         n[0] >= near_content_.first[0] + near_content_.count[0] ||
                         n[1] >= near_content_.first[1] + near_content_.count[1];
        for (int k = 0; k < count; ++k) {
          const double slope = (here[k + next] - here[k]) / spacing_;
          addends[static_cast<std::size_t>(k)] = 0.5 * slope * slope;
        }
        for (int k = 0; k < count && !far; ++k)
          addends[static_cast<std::size_t>(k)] = edge_energy(axis, at + static_cast<std::size_t>(k));
        for (double& addend : addends) addend *= shape.share_across(axis, n), ++n[2];
        sum.add(addends);
      });
    }
    addends.clear();
    for (std::size_t i = 0; i < total_.size(); ++i)
      if (level.leak[i] > 0.0)
        addends.push_back(0.5 * level.leak[i] * potential_[i] * potential_[i] / (spacing_ * spacing_));
    for (std::size_t n = 0; n < filled_.size(); ++n) {
      const std::size_t i = filled_[n];
      const double inner = layers_ ? layered_states_[n].inner : states_[n].inner;
      double energy = layers_ ? dilution(total_[i]).first * layered_states_[n].depolarised
                              : depolarisation_ * states_[n].dilution * states_[n].mean * states_[n].mean;
      energy *= 0.5 * total_[i];
      for (std::size_t s = 0; s < materials_.size(); ++s) energy += content_[s][i] * materials_[s].co_energy(inner);
      addends.push_back(energy);
    }
    sum.add(addends);
  }
  merge_global(all_, {&sum, 1});
  return vacuum_permeability * spacing_ * spacing_ * spacing_ * sum.value();
}

Vec3 Magnetostatics::moment() {
  Vec3 sum = Vec3::Zero();
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> addends;
    if (potential_solver_.has_nodes()) {
      const auto a = static_cast<std::size_t>(axis);
      for_edges(axis, owned_edges(axis, near_content_), [&](const Int3&, std::size_t at) {
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

BoxFields Magnetostatics::box() const {
  const FieldLevel& level = potential_solver_.finest();
  BoxFields box{"magnetic_field", level.shape().origin, spacing_, level.shape().n_nodes, {0, 0, 0}, {0, 0, 0}, {}};
  if (!potential_solver_.has_nodes()) return box;
  box.first = level.owned().first;
  box.count = level.owned().count;
  return box;
}

// H and B along an axis at a node: means of its edges.
std::pair<double, double> Magnetostatics::shown_along(int axis, const Int3& node, double applied) const {
  const FieldLevel& level = potential_solver_.finest();
  const auto a = static_cast<std::size_t>(axis);
  const auto at = static_cast<std::size_t>(level.ghosted().index(node)),
             next = static_cast<std::size_t>(level.ghosted().stride(axis));
  double field = 0.0, flux = 0.0, n_edges = 0.0;
  for (const bool below : {true, false}) {
    if (!level.shape().wraps[a] && node[a] == (below ? 0 : level.shape().n_nodes[a] - 1)) continue;
    const std::size_t edge = below ? at - next : at;
    const double strength = applied - (potential_around_[edge + next] - potential_around_[edge]) / spacing_;
    field += strength;
    flux += vacuum_permeability * potential_solver_.edges(axis)[edge] * strength;
    n_edges += 1.0;
  }
  return {field / n_edges, flux / n_edges};
}

BoxFields Magnetostatics::shown() const {
  const FieldLevel& level = potential_solver_.finest();
  BoxFields shown = box();
  const std::size_t n = potential_.size();
  std::vector<std::vector<double>> field(3, std::vector<double>(n)), flux = field;
  for_rows(NodeBox{shown.first, shown.count}, [&](int i, int j) {
    for (int k = shown.first[2]; k < shown.first[2] + shown.count[2]; ++k) {
      const Int3 node{i, j, k};
      const auto own = static_cast<std::size_t>(level.owned().index(node));
      const Vec3 applied = applied_.at(level.shape().position(node), time_);
      for (std::size_t a = 0; a < 3; ++a)
        std::tie(field[a][own], flux[a][own]) = shown_along(static_cast<int>(a), node, applied[static_cast<int>(a)]);
    }
  });
  for (int axis = 0; axis < 3 && layers_ && n > 0; ++axis)
    for_crossed(axis, [&](double coupling, int b, std::ptrdiff_t, const Int3& node) {
      const auto own = static_cast<std::size_t>(level.owned().index(node));
      flux[static_cast<std::size_t>(axis)][own] += vacuum_permeability * coupling * field[static_cast<std::size_t>(b)][own];
    });
  shown.fields = {{"potential", "A", "phi, of what material adds to the applied field", {potential_}},
                  {"field", "A/m", "H", field},
                  {"flux_density", "T", "B", flux},
                  {"content", "1", "reference volume of magnetic material over a cell's", {total_}}};
  return shown;
}

double Magnetostatics::source_work(double time) {
  if (!applied_.varies()) return 0.0;
  std::vector<double> addends;
  if (potential_solver_.has_nodes()) {
    const FieldLevel& level = potential_solver_.finest();
    for (int axis = 0; axis < 3; ++axis) {
      const auto a = static_cast<std::size_t>(axis);
      for_edges(axis, owned_edges(axis, near_content_), [&](const Int3& n, std::size_t at) {
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
