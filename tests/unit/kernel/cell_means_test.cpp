// Means over cells against plain sums, their independence of the order of particles, and that forces and motions of cells do the same
// work.

#include "kernel/cell_means.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "support/reference_particles.hpp"
#include "support/serial_step.hpp"

namespace bulkley::cell_means_test {
namespace {

constexpr double dt = 1e-3;

std::vector<LocalIndex> as_they_are(const ParticleSet& set) {
  std::vector<LocalIndex> order(static_cast<std::size_t>(set.size()));
  std::iota(order.begin(), order.end(), 0);
  return order;
}

// Stressed particles of two materials on moving nodes, eight a cell and more; those of the first material form groups.
class Cells {
 public:
  explicit Cells(const TransferSettings& transfer, unsigned order_seed = 0)
      : run(open_scene(transfer), particles_in_order(transfer, order_seed)) {
    for (LocalIndex p = 0; p < run.particles.size(); ++p) run.bounds.totals.largest_volume_ratio.include(ratio(p));
    groups.assign(run.map.cell.size(), -1);
    for (LocalIndex p = 0; p < run.particles.size(); ++p)
      if (run.particles.material()[p] == 0) groups[at(p)] = run.map.cell[at(p)];
    sums.resize(run.map.count.size());
    sum_stress(run.particles, groups, bounds(), sums);
    take_means_of_stress(sums);
  }

  static ParticleSet particles_in_order(const TransferSettings& transfer, unsigned seed) {
    const SerialScene scene = open_scene(transfer);
    ParticleSet set = random_particles(scene, 1501, 21, true, 0.15);
    std::mt19937_64 random(22);
    std::uniform_real_distribution<double> uniform(0.9, 1.1);
    for (LocalIndex p = 0; p < set.size(); ++p) {
      set.real(Field::volume_ratio)[p] = uniform(random);
      set.real(Field::reference_volume)[p] *= uniform(random);
    }
    if (seed == 0) return set;
    std::vector<LocalIndex> order = as_they_are(set);
    std::shuffle(order.begin(), order.end(), std::mt19937(seed));
    return picked(set, order);
  }

  CellSumBounds bounds() const {
    double volume = 0.0;
    for (LocalIndex p = 0; p < run.particles.size(); ++p) volume = std::max(volume, this->volume(p));
    return {volume, run.bounds.sums.stress_volume, run.bounds.totals.largest_volume_ratio, run.bounds.sums.cell_count};
  }
  CellMeans means() const { return {groups.data(), sums.data(), 0.25}; }

  void move_nodes() {
    run.particles_to_nodes(dt);
    run.update_nodes(dt);
  }
  void move_and_find_dilation() {
    move_nodes();
    find_dilation();
  }
  void find_dilation() {
    const auto find = [&](const auto* nodes) {
      find_mean_dilation(run.scene.grid, run.scene.transfer, run.layout, run.map, nodes, run.particles, groups, bounds(), dt,
                         sums);
    };
    if (!run.split()) return find(run.nodes.data());
    std::vector<NodePair> pairs;
    for (std::size_t n = 0; n < run.nodes.size(); ++n) pairs.push_back({run.nodes[n], run.impulse[n]});
    find(pairs.data());
  }

  // Impulses of the stresses alone, on every node, with the means or without.
  std::vector<Node> impulses(bool with_means) const {
    const SumBounds node_sums = sum_bounds(run.scene.grid, run.scene.transfer, run.bounds, dt, true, {}, with_means);
    std::vector<NodePair> pairs(run.nodes.size());
    p2g(run.scene.grid, run.scene.transfer, run.layout, run.particles, run.map, node_sums, dt, pairs.data(), {},
        Impulses::apart, with_means ? means() : CellMeans{});
    std::vector<Node> result;
    for (const NodePair& pair : pairs) result.push_back(pair.change);
    return result;
  }

  static std::size_t at(LocalIndex p) { return static_cast<std::size_t>(p); }
  double volume(LocalIndex p) const { return run.particles.real(Field::reference_volume)[p]; }
  double ratio(LocalIndex p) const { return run.particles.real(Field::volume_ratio)[p]; }
  double stress(LocalIndex p) const {
    double trace = 0.0;
    for (int a = 0; a < 3; ++a) trace += run.particles.real(Field::kirchhoff_stress, a)[p];
    return trace / 3.0;
  }
  const CellSums& mean(LocalIndex p) const { return sums[static_cast<std::size_t>(groups[at(p)])]; }

  SerialStep run;
  std::vector<LocalIndex> groups;
  std::vector<CellSums> sums;
};

// By particle, from the gradients that g2p gives; places and stresses stay.
std::vector<double> traces(SerialStep& run) {
  run.gather(0.0);
  const Field gradient = run.scene.transfer.needs_velocity_gradient() ? Field::velocity_gradient : Field::affine_velocity;
  std::vector<double> result;
  for (LocalIndex p = 0; p < run.particles.size(); ++p)
    result.push_back(run.particles.real(gradient, 0)[p] + run.particles.real(gradient, 4)[p] +
                     run.particles.real(gradient, 8)[p]);
  return result;
}

TEST(CellMeans, AreThoseOfTheParticlesOfAGroup) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    Cells cells(transfer);
    cells.move_and_find_dilation();
    const std::vector<double> trace = traces(cells.run);
    std::vector<CellSums> truth(cells.sums.size());
    double largest = 0.0;
    for (LocalIndex p = 0; p < cells.run.particles.size(); ++p) {
      if (cells.groups[Cells::at(p)] < 0) continue;
      CellSums& cell = truth[static_cast<std::size_t>(cells.groups[Cells::at(p)])];
      const double V = cells.volume(p);
      cell.volume += V;
      cell.stress += V * cells.stress(p);
      cell.ratio += V * cells.ratio(p);
      cell.dilation += V * trace[Cells::at(p)];
      largest = std::max(largest, std::abs(trace[Cells::at(p)]));
    }
    ASSERT_GT(largest, 1.0);
    ASSERT_LT(largest, 1.0 / dt);
    int n_full = 0;
    for (std::size_t g = 0; g < truth.size(); ++g) {
      EXPECT_NEAR(cells.sums[g].volume, truth[g].volume, 1e-13 * truth[g].volume + 1e-300);
      if (truth[g].volume == 0.0) continue;
      ++n_full;
      EXPECT_NEAR(cells.sums[g].stress, truth[g].stress / truth[g].volume, 1e-9);
      EXPECT_NEAR(cells.sums[g].ratio, truth[g].ratio / truth[g].volume, 1e-12);
      EXPECT_NEAR(cells.sums[g].dilation, truth[g].dilation / truth[g].volume, 1e-11 / dt);
    }
    EXPECT_GT(n_full, 20);
  }
}

TEST(CellMeans, HaveTheSameBitsInAnyOrderOfParticles) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    Cells one(transfer), other(transfer, 5);
    for (Cells* cells : {&one, &other}) {
      cells->move_and_find_dilation();
    }
    EXPECT_EQ(std::memcmp(one.sums.data(), other.sums.data(), one.sums.size() * sizeof(CellSums)), 0);
    const std::vector<Node> a = one.impulses(true), b = other.impulses(true);
    EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(Node)), 0);
  }
}

// The impulses of mean stresses on any motion of the nodes, and the mean dilations of that motion: minus dt sum V_c p_c D_c.
TEST(CellMeans, StressesDoTheWorkThatDilationsTake) {
  for (const TransferSettings& transfer : all_transfers()) {
    SCOPED_TRACE(describe(transfer));
    Cells cells(transfer);
    cells.move_and_find_dilation();
    const std::vector<double> trace = traces(cells.run);
    const std::vector<Node> with = cells.impulses(true), without = cells.impulses(false);
    double on_nodes = 0.0, size = 0.0;
    for (std::size_t n = 0; n < with.size(); ++n)
      for (int a = 0; a < 3; ++a) {
        on_nodes += (with[n].c[a] - without[n].c[a]) * cells.run.nodes[n].c[a];
        size += std::abs(without[n].c[a] * cells.run.nodes[n].c[a]);
      }
    double in_cells = 0.0;
    for (LocalIndex p = 0; p < cells.run.particles.size(); ++p) {
      if (cells.groups[Cells::at(p)] < 0) continue;
      const double V = cells.volume(p);
      in_cells -= dt * V * (cells.mean(p).stress * cells.mean(p).dilation - cells.stress(p) * trace[Cells::at(p)]);
    }
    EXPECT_NEAR(on_nodes, in_cells, 1e-11 * size);
    EXPECT_GT(std::abs(in_cells), 1e-4 * size);
  }
}

// The stress update of a particle of a group is that of its law with the group's dilation, from the relaxed volume ratio; of others it
// is as without means.
TEST(CellMeans, TakeThePlaceOfTheParticlesOwn) {
  TransferSettings transfer;
  transfer.gradient = GradientForm::bspline;
  Cells cells(transfer);
  cells.move_and_find_dilation();
  cells.run.gather(0.0);
  const auto update = [&](ParticleSet& set, const CellMeans& means) {
    StepBounds bounds;
    for (std::size_t m = 0; m < 2; ++m)
      stress_update(cells.run.scene.materials[m].material, static_cast<std::uint8_t>(m), Field::velocity_gradient, dt, set,
                    bounds, {}, means);
    EXPECT_FALSE(bounds.failed());
  };
  const ParticleSet& all = cells.run.particles;
  ParticleSet expected = picked(all, as_they_are(all)), with = picked(all, as_they_are(all));
  for (LocalIndex p = 0; p < expected.size(); ++p) {
    if (cells.groups[Cells::at(p)] < 0) continue;
    double trace = 0.0;
    for (int a = 0; a < 3; ++a) trace += expected.real(Field::velocity_gradient, 4 * a)[p];
    for (int a = 0; a < 3; ++a) expected.real(Field::velocity_gradient, 4 * a)[p] += (cells.mean(p).dilation - trace) / 3.0;
    double& J = expected.real(Field::volume_ratio)[p];
    J += 0.25 * (cells.mean(p).ratio - J);
  }
  update(expected, {});
  update(with, cells.means());
  for (LocalIndex p = 0; p < with.size(); ++p) {
    EXPECT_NEAR(with.real(Field::volume_ratio)[p], expected.real(Field::volume_ratio)[p], 1e-14);
    for (int c = 0; c < 6; ++c)
      EXPECT_NEAR(with.real(Field::kirchhoff_stress, c)[p], expected.real(Field::kirchhoff_stress, c)[p], 1e-8);
  }
}

// A node that runs away is for others to tell; the sums stay exact, and other cells hear nothing of it.
TEST(CellMeans, AreNumbersWhateverTheNodesDo) {
  TransferSettings transfer;
  Cells calm(transfer), wild(transfer);
  for (Cells* cells : {&calm, &wild}) {
    cells->move_nodes();
  }
  const LocalIndex group = wild.groups[0];
  ASSERT_GE(group, 0);
  for (std::size_t n = 0; n < wild.run.nodes.size(); ++n)
    if ((wild.run.node_position(n) - wild.run.particles.vector(Field::position, 0)).norm() <
        0.6 * wild.run.scene.grid.cell_size)
      wild.run.nodes[n].c[1] = n % 2 == 0 ? std::numeric_limits<double>::quiet_NaN() : 1e30;
  calm.find_dilation();
  wild.find_dilation();
  int n_changed = 0;
  for (std::size_t g = 0; g < wild.sums.size(); ++g) {
    EXPECT_LE(std::abs(wild.sums[g].dilation), (1.0 + 1e-12) / dt);
    n_changed += wild.sums[g].dilation != calm.sums[g].dilation;
  }
  EXPECT_NE(wild.sums[static_cast<std::size_t>(group)].dilation, calm.sums[static_cast<std::size_t>(group)].dilation);
  EXPECT_LE(n_changed, 64);
}

}  // namespace
}  // namespace bulkley::cell_means_test
