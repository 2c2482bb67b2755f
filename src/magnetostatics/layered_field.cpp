// What Mixing::layers adds to a magnetic field: permeabilities that couple the axes.
#include <cmath>

#include "magnetostatics/magnetostatics.hpp"

namespace bulkley {

void Magnetostatics::set_gradients() {
  const FieldLevel& level = potential_solver_.finest();
  const NodeBox &owned = level.owned(), &ghosted = level.ghosted();
  for_rows(owned, [&](int i, int j) {
    for (int k = owned.first[2]; k < owned.first[2] + owned.count[2]; ++k)
      for (int axis = 0; axis < 3; ++axis) {
        const auto at = static_cast<std::size_t>(ghosted.index(i, j, k)),
                   next = static_cast<std::size_t>(ghosted.stride(axis));
        gradient_[static_cast<std::size_t>(axis)][static_cast<std::size_t>(owned.index(i, j, k))] =
            0.5 * (total_around_[at + next] - total_around_[at - next]);
      }
  });
}

LayeredNode Magnetostatics::layered(std::size_t i) const {
  const auto [c, slope] = dilution(total_[i]);
  const Vec3 gradient(gradient_[0][i], gradient_[1][i], gradient_[2][i]);
  Mat3 squares;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) squares(a, b) = squares_[static_cast<std::size_t>(a == b ? a : 6 - a - b)][i];
  return layered_node(Mixture(materials_, content_, i, total_[i]), {total_[i], c, slope, gradient}, squares);
}

// `permeability_` is that of the trace, by which sweeps are judged.
void Magnetostatics::set_layers() {
  const FieldLevel& level = potential_solver_.finest();
  std::array<std::vector<double>, 3> along, cross;
  for (std::size_t a = 0; a < 3; ++a) {
    along[a].assign(total_.size(), 1.0);
    cross[a].assign(total_.size(), 0.0);
  }
  for (std::size_t n = 0; n < filled_.size(); ++n) {
    const std::size_t i = filled_[n];
    const Mat3& permeability = layered_states_[n].permeability;
    permeability_[i] = permeability.trace() / 3.0;
    for (int a = 0; a < 3; ++a) {
      along[static_cast<std::size_t>(a)][i] = permeability(a, a);
      cross[static_cast<std::size_t>(a)][i] = permeability((a + 1) % 3, (a + 2) % 3);
    }
  }
  for (std::size_t a = 0; a < 3; ++a) {
    level.spread(along[a], permeability_around_[a]);
    level.spread(cross[a], potential_solver_.cross()[a]);
  }
}

double Magnetostatics::central_field(int axis, std::ptrdiff_t at) const {
  const auto here = static_cast<std::size_t>(at),
             next = static_cast<std::size_t>(potential_solver_.finest().ghosted().stride(axis));
  return 0.5 * (edge_field(axis, here) + edge_field(axis, here - next));
}

double Magnetostatics::central_applied(int axis, std::ptrdiff_t at) const {
  const auto here = static_cast<std::size_t>(at),
             next = static_cast<std::size_t>(potential_solver_.finest().ghosted().stride(axis));
  const std::vector<double>& along = applied_along_[static_cast<std::size_t>(axis)];
  return 0.5 * (along[here] + along[here - next]);
}

double Magnetostatics::central_applied(int axis, const Int3& n, double time) const {
  Int3 before = n;
  --before[static_cast<std::size_t>(axis)];
  return 0.5 * (applied_at(axis, n, time) + applied_at(axis, before, time));
}

void Magnetostatics::set_crossed_squares(std::size_t own, std::ptrdiff_t at) {
  double field[3];
  for (int axis = 0; axis < 3; ++axis) field[axis] = central_field(axis, at);
  for (std::size_t a = 0; a < 3; ++a) squares_[3 + a][own] = field[(a + 1) % 3] * field[(a + 2) % 3];
}

// w depends on the content of a node, and through its gradient on that of the neighbours.
void Magnetostatics::set_layered_slopes() {
  const FieldLevel& level = potential_solver_.finest();
  std::vector<double> by_content(total_.size(), 0.0);
  std::array<std::vector<double>, 3> by_gradient;
  for (auto& values : by_gradient) values.assign(total_.size(), 0.0);
  for (std::size_t n = 0; n < filled_.size(); ++n) {
    const std::size_t i = filled_[n];
    const LayeredNode& node = layered_states_[n];
    const auto [c, slope] = dilution(total_[i]);
    by_content[i] = 0.5 * (c - total_[i] * slope) * node.depolarised;
    for (int a = 0; a < 3; ++a) by_gradient[static_cast<std::size_t>(a)][i] = node.gradient_slope[a];
    for (std::size_t s = 0; s < materials_.size(); ++s) energy_slopes_[s][i] = materials_[s].co_energy(node.inner);
  }
  std::vector<double> around(level.ghosted().size());
  for (int axis = 0; axis < 3; ++axis) {
    level.spread(by_gradient[static_cast<std::size_t>(axis)], around);
    const std::ptrdiff_t next = level.ghosted().stride(axis);
    for_rows(level.owned(), [&](int i, int j) {
      for (int k = level.owned().first[2]; k < level.owned().first[2] + level.owned().count[2]; ++k) {
        const double* const here = around.data() + level.ghosted().index(i, j, k);
        by_content[static_cast<std::size_t>(level.owned().index(i, j, k))] += 0.5 * (here[-next] - here[next]);
      }
    });
  }
  for (const std::size_t i : filled_)
    for (auto& slopes : energy_slopes_) slopes[i] = vacuum_permeability * (slopes[i] + by_content[i]);
}

}  // namespace bulkley
