#include "integrator/pressure_bodies.hpp"

#include <algorithm>
#include <ranges>

#include "parallel/reproducible_sum.hpp"

namespace bulkley {

void PressureBodies::fit(const GridGeometry& grid, const CellGrid& cells) {
  nodes_.assign(cells.complete_nodes().begin(), cells.complete_nodes().end());
  positions_.clear();
  for (const Int3& node : cells.complete_positions()) positions_.push_back(grid.node_position(node));
}

std::span<const NodeConstraint> PressureBodies::find(const CellNodes& nodes, const double* scale) {
  held_.clear();
  moved_of_node_.resize(static_cast<std::size_t>(nodes.size()));
  const std::vector<Pose> poses = bodies_.poses();
  const std::vector<RigidVelocity> velocities = bodies_.velocities();
  for (std::size_t n = 0; n < nodes_.size(); ++n) {
    const LocalIndex node = nodes.number(nodes_[n]);
    if (node < 0 || scale[node] == 0.0) continue;
    std::optional<NodeConstraint> constraint = bodies_.held_at(positions_[n], poses);
    if (!constraint) continue;
    constraint->node = node;
    constraint->velocity = velocities[bodies_.body_of(*constraint)].at(constraint->arm);
    held_.push_back(*constraint);
  }
  return held_;
}

void PressureBodies::merge(double time, const GridUpdate& update, const PressureContact& contact, const Node* velocity,
                           const PressureRows& rows, std::span<const LocalIndex> own) {
  ExactSums sums = bodies_.no_sums();
  contact.for_each_body_node([&](const NodeConstraint& constraint, const Mat3&) {
    if (contact.owns(constraint.node)) bodies_.add_node(constraint, velocity[constraint.node], sums);
  });
  systems_ = bodies_.merged(time, update, sum_global(comm_, sums));
  velocities_ = velocities_under(Coupling(systems_.size(), Vec6::Zero()), 0.0);
  find_modes(contact, rows, own);
}

// P N J of the nodes of bodies and of their images.
void PressureBodies::find_moved(const PressureContact& contact) {
  std::ranges::fill(moved_of_node_, -1);
  moved_.clear();
  const auto add = [&](LocalIndex node, const MovedNode& moved) {
    moved_of_node_[static_cast<std::size_t>(node)] = static_cast<LocalIndex>(moved_.size());
    moved_.push_back(moved);
  };
  contact.for_each_body_node([&](const NodeConstraint& constraint, const Mat3& walls) {
    MovedNode moved{bodies_.body_of(constraint), {}};
    const Mat3 part = walls * held_part(constraint);
    const Vec3 arm = constraint.arm / bodies_.scale(moved.body);
    for (int a = 0; a < 3; ++a) {
      moved.velocity[static_cast<std::size_t>(a)] = part.col(a);
      moved.velocity[static_cast<std::size_t>(a) + 3] = part * Vec3::Unit(a).cross(arm);
    }
    add(constraint.node, moved);
  });
  const auto moved_at = [&](LocalIndex node) { return moved_of_node_[static_cast<std::size_t>(node)]; };
  for (const NodeImage& image : std::views::reverse(contact.images())) {
    if (moved_at(image.front) < 0) continue;
    MovedNode moved = moved_[static_cast<std::size_t>(moved_at(image.front))];
    for (Vec3& velocity : moved.velocity) velocity = image.sign.cwiseProduct(velocity);
    add(image.behind, moved);
  }
  for (const CellGrid::Copy& copy : contact.repeated())
    moved_of_node_[static_cast<std::size_t>(copy.node)] = moved_at(copy.other);
}

void PressureBodies::find_modes(const PressureContact& contact, const PressureRows& rows, std::span<const LocalIndex> own) {
  find_moved(contact);
  modes_.assign(bodies_.n_bodies(), Modes{});
  const auto n_rows = static_cast<std::size_t>(rows.n_rows()), width = static_cast<std::size_t>(rows.width);
  std::vector<std::pair<std::size_t, Vec6>> here;  // bodies at a cell: nearly always one
  for (const LocalIndex cell : own) {
    const auto c = static_cast<std::size_t>(cell);
    here.clear();
    for (std::size_t r = c * n_rows; r < (c + 1) * n_rows; ++r)
      for (std::size_t k = 0; k < width; ++k) {
        const LocalIndex m = moved_of_node_[static_cast<std::size_t>(rows.first[r]) + k];
        if (m < 0) continue;
        const MovedNode& moved = moved_[static_cast<std::size_t>(m)];
        auto at = std::ranges::find(here, moved.body, &std::pair<std::size_t, Vec6>::first);
        if (at == here.end()) at = here.insert(at, {moved.body, Vec6::Zero()});
        const float* const B = rows.rounded.data() + 3 * (r * width + k);
        for (int f = 0; f < 6; ++f) {
          const Vec3& v = moved.velocity[static_cast<std::size_t>(f)];
          at->second[f] += (B[0] * v[0] + B[1] * v[1]) + B[2] * v[2];
        }
      }
    for (const auto& [body, entries] : here) {
      modes_[body].cells.push_back(cell);
      for (int f = 0; f < 6; ++f) modes_[body].row[static_cast<std::size_t>(f)].push_back(entries[f]);
    }
  }
}

void PressureBodies::add_sums(std::span<const double> p, std::vector<BinnedSum>& sums) const {
  std::vector<double> near;
  for (const Modes& modes : modes_) {
    near.clear();
    for (const LocalIndex cell : modes.cells) near.push_back(p[static_cast<std::size_t>(cell)]);
    for (const std::vector<double>& row : modes.row) sums.emplace_back().add_products(row, near);
  }
}

PressureBodies::Coupling PressureBodies::merged(std::vector<BinnedSum>& sums, std::size_t first) const {
  merge_global(comm_, sums);
  Coupling coupling(modes_.size());
  for (std::size_t b = 0; b < modes_.size(); ++b)
    for (int f = 0; f < 6; ++f) coupling[b][f] = sums[first + 6 * b + static_cast<std::size_t>(f)].value();
  return coupling;
}

PressureBodies::Coupling PressureBodies::couple(std::span<const double> p) const {
  std::vector<BinnedSum> sums;
  add_sums(p, sums);
  return merged(sums, 0);
}

std::vector<RigidVelocity> PressureBodies::velocities_under(const Coupling& coupling, double dt) const {
  std::vector<RigidVelocity> velocities;
  for (std::size_t b = 0; b < systems_.size(); ++b) {
    const Vec6 u = systems_[b].velocity() + systems_[b].response(-dt * coupling[b]);
    velocities.push_back({u.head<3>(), u.tail<3>() / systems_[b].length, Vec3::Zero()});
  }
  return velocities;
}

double PressureBodies::dot(std::span<const double> a, std::span<const double> p, Coupling& coupling) const {
  std::vector<BinnedSum> sums(1);
  sums[0].add_products(a, p);
  add_sums(p, sums);
  coupling = merged(sums, 1);
  return sums[0].value();
}

void PressureBodies::add_rates(const Coupling& coupling, double* rates) const {
  for (std::size_t b = 0; b < modes_.size(); ++b) {
    const Modes& modes = modes_[b];
    const Vec6 response = systems_[b].response(coupling[b]);
    for (std::size_t k = 0; k < modes.cells.size(); ++k) {
      double rate = 0.0;
      for (int f = 0; f < 6; ++f) rate += modes.row[static_cast<std::size_t>(f)][k] * response[f];
      rates[modes.cells[k]] += rate;
    }
  }
}

void PressureBodies::add_diagonal(double* diagonal) const {
  for (std::size_t b = 0; b < modes_.size(); ++b) {
    const Modes& modes = modes_[b];
    for (std::size_t k = 0; k < modes.cells.size(); ++k) {
      Vec6 column;
      for (int f = 0; f < 6; ++f) column[f] = modes.row[static_cast<std::size_t>(f)][k];
      diagonal[modes.cells[k]] += column.dot(systems_[b].response(column));
    }
  }
}

std::size_t PressureBodies::memory() const {
  std::size_t total = nodes_.capacity() * sizeof(LocalIndex) + positions_.capacity() * sizeof(Vec3) +
                      held_.capacity() * sizeof(NodeConstraint) + moved_of_node_.capacity() * sizeof(LocalIndex) +
                      moved_.capacity() * sizeof(MovedNode);
  for (const Modes& modes : modes_) total += modes.cells.capacity() * (sizeof(LocalIndex) + 6 * sizeof(double));
  return total;
}

}  // namespace bulkley
