#include "kernel/pressure_cells.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <random>
#include <string>
#include <tuple>

#include "support/particle_builders.hpp"

namespace bulkley::pressure_cells_test {
namespace {

using Form = VolumetricLaw::Form;

constexpr double dx = 0.1;

/// Material 1 has no volumetric law, 3 holds no tension.
VolumetricLaws laws() {
  return {VolumetricLaw{Form::neo_hookean, 2e5}, std::nullopt, VolumetricLaw{Form::hencky, 3e4},
          VolumetricLaw{Form::tait, 1e6, 7.0, false}};
}

GridGeometry box(SplineOrder order) {
  return {.lower = Vec3(-0.3, 0.2, 0.7), .cell_size = dx, .n_cells = {8, 12, 4}, .order = order};
}

/// Random particles of the materials given, whose base node along every axis is the one at `lower + 2 dx`; their ids are not in
/// the order of their indices.
ParticleSet particles_of_a_cell(const GridGeometry& grid, int count, const std::vector<std::uint8_t>& materials) {
  std::mt19937_64 random(71);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  ParticleSet set(OptionalFields{Field::cell_mean_stress}, Densities(std::array{1000.0, 700.0, 1300.0, 900.0}));
  set.resize(count);
  std::vector<GlobalIndex> ids(static_cast<std::size_t>(count));
  std::iota(ids.begin(), ids.end(), GlobalIndex{1000});
  std::shuffle(ids.begin(), ids.end(), random);
  for (LocalIndex p = 0; p < count; ++p) {
    Vec3 x;
    for (int a = 0; a < 3; ++a) x[a] = grid.lower[a] + dx * (2.0 + grid.base_shift() + 0.01 + 0.98 * uniform(random));
    place_particle(set, p, x, 1e-4 * (0.5 + uniform(random)));
    set.id()[p] = ids[static_cast<std::size_t>(p)];
    set.material()[p] = materials[static_cast<std::size_t>(p) % materials.size()];
    set.real(Field::volume_ratio)[p] = 0.8 + 0.4 * uniform(random);
    set.real(Field::cell_mean_stress)[p] = 1e3 * (uniform(random) - 0.5);
  }
  return set;
}

std::vector<LocalIndex> all_of(const ParticleSet& set) {
  std::vector<LocalIndex> members(static_cast<std::size_t>(set.size()));
  std::iota(members.begin(), members.end(), 0);
  std::sort(members.begin(), members.end(), [&](LocalIndex a, LocalIndex b) { return set.id()[a] < set.id()[b]; });
  return members;
}

// --- cells ------------------------------------------------------------------------------------------------------------------

TEST(GroupByCell, EachCellHasItsParticlesByAscendingId) {
  std::mt19937_64 random(72);
  const VolumetricLaws law = laws();
  for (int round = 0; round < 50; ++round) {
    const LocalIndex n = round < 3 ? round : static_cast<LocalIndex>(random() % 400), n_places = 12;
    ParticleSet set;
    set.resize(n);
    std::vector<GlobalIndex> ids(static_cast<std::size_t>(n));
    std::iota(ids.begin(), ids.end(), GlobalIndex{1} << 33);
    std::shuffle(ids.begin(), ids.end(), random);
    // Places 0 and 7 have no number; the last number has no place, so that its cell is empty.
    std::vector<LocalIndex> number_of(n_places), cell_of(static_cast<std::size_t>(n));
    LocalIndex n_cells = 0;
    for (LocalIndex place = 0; place < n_places; ++place)
      number_of[static_cast<std::size_t>(place)] = place == 0 || place == 7 ? -1 : n_cells++;
    std::shuffle(number_of.begin(), number_of.end(), random);
    ++n_cells;
    std::map<LocalIndex, std::map<GlobalIndex, LocalIndex>> expected;  // by cell and id
    for (LocalIndex p = 0; p < n; ++p) {
      const auto k = static_cast<std::size_t>(p);
      set.id()[p] = ids[k];
      set.material()[p] = static_cast<std::uint8_t>(random() % law.size());
      cell_of[k] = static_cast<LocalIndex>(random() % n_places);
      const LocalIndex number = number_of[static_cast<std::size_t>(cell_of[k])];
      if (number >= 0 && set.material()[p] != 1) expected[number][ids[k]] = p;
    }
    CellParticles cells;
    cells.first = {7, 8, 9};  // left of another step
    cells.particle.assign(1000, -5);
    group_by_cell(law, set, cell_of, number_of, n_cells, cells);
    ASSERT_EQ(cells.size(), n_cells);
    std::size_t total = 0;
    for (LocalIndex c = 0; c < n_cells; ++c) {
      std::vector<LocalIndex> members;
      for (const auto& [id, p] : expected[c]) members.push_back(p);
      const auto of = cells.of(c);
      EXPECT_EQ(std::vector<LocalIndex>(of.begin(), of.end()), members) << "round " << round << " cell " << c;
      total += members.size();
    }
    EXPECT_EQ(cells.particle.size(), total);
  }
}

// --- rows of B --------------------------------------------------------------------------------------------------------------

class RowsOfB : public testing::TestWithParam<std::tuple<SplineOrder, GradientForm>> {
 protected:
  SplineOrder order() const { return std::get<0>(GetParam()); }
  GradientForm form() const { return std::get<1>(GetParam()); }
  GridGeometry grid() const { return box(order()); }
  int n_stencil() const { return stencil_width(order()) * stencil_width(order()) * stencil_width(order()); }
  Vec3 node(int k) const {
    const int s = stencil_width(order());
    return grid().lower + dx * Vec3(2 + k / (s * s), 2 + k / s % s, 2 + k % s);
  }
  /// Rows of a few cells that share nodes, random.
  PressureRows random_rows(std::mt19937_64& random, int n_cells, int n_nodes) const {
    std::normal_distribution<double> normal(0.0, 1.0);
    std::uniform_int_distribution<LocalIndex> first(0, n_nodes - stencil_width(order()));
    PressureRows rows;
    rows.width = stencil_width(order());
    rows.resize(n_cells);
    for (LocalIndex& row : rows.first) row = first(random);
    for (Node& entry : rows.gradient) entry = {{normal(random), normal(random), normal(random), 0.0}};
    for (LocalIndex c = 0; c < n_cells; ++c) rows.round(c);
    return rows;
  }
};

INSTANTIATE_TEST_SUITE_P(Transfer, RowsOfB,
                         testing::Combine(testing::Values(SplineOrder::quadratic, SplineOrder::cubic),
                                          testing::Values(GradientForm::mls, GradientForm::bspline)),
                         [](const auto& test) {
                           return std::string(std::get<0>(test.param) == SplineOrder::cubic ? "cubic" : "quadratic") +
                                  (std::get<1>(test.param) == GradientForm::mls ? "_mls" : "_bspline");
                         });

TEST_P(RowsOfB, LinearVelocitiesChangeTheVolumeByTheirDivergence) {
  std::mt19937_64 random(73);
  std::normal_distribution<double> normal(0.0, 1.0);
  const ParticleSet set = particles_of_a_cell(grid(), 9, {0, 2, 3});
  const auto members = all_of(set);
  PressureRows rows;
  rows.width = stencil_width(order());
  rows.resize(1);
  for (int r = 0; r < rows.n_rows(); ++r) rows.first[static_cast<std::size_t>(r)] = r * rows.width;
  PressureCell cell;
  fill_cell(grid(), form(), laws(), set, members, cell, rows.gradient.data());
  double volume = 0.0;
  for (const LocalIndex p : members) volume += set.real(Field::reference_volume)[p] * set.real(Field::volume_ratio)[p];
  for (int round = 0; round < 10; ++round) {
    Mat3 L;
    Vec3 at_origin;
    for (int a = 0; a < 3; ++a) {
      at_origin[a] = normal(random);
      for (int b = 0; b < 3; ++b) L(a, b) = normal(random);
    }
    NodeVector velocity(rows.gradient.size());
    for (int k = 0; k < n_stencil(); ++k) {
      const Vec3 v = at_origin + L * node(k);
      velocity[static_cast<std::size_t>(k)] = {{v[0], v[1], v[2], 17.0}};  // and a mass, which is not for the sum
    }
    const double scale = volume * (L.norm() + at_origin.norm() / dx);
    double rate = 0.0;
    volume_rates(rows, RowEntries::exact, std::vector<LocalIndex>{0}, velocity.data(), &rate);
    EXPECT_NEAR(rate, volume * L.trace(), 1e-13 * scale);
  }
}

TEST_P(RowsOfB, ForcesOfACellSumToZero) {
  const ParticleSet set = particles_of_a_cell(grid(), 9, {0, 2, 3});
  NodeVector row(static_cast<std::size_t>(n_stencil()), Node{{5.0, 6.0, 7.0, 8.0}});  // left of another step
  PressureCell cell;
  fill_cell(grid(), form(), laws(), set, all_of(set), cell, row.data());
  double sum[4] = {}, sizes = 0.0;
  for (const Node& entry : row)
    for (int a = 0; a < 4; ++a) {
      sum[a] += entry.c[a];
      sizes += std::fabs(entry.c[a]);
    }
  EXPECT_GT(sizes, 0.0);
  for (int a = 0; a < 3; ++a) EXPECT_NEAR(sum[a], 0.0, 1e-14 * sizes) << a;
  EXPECT_EQ(sum[3], 0.0);
}

TEST_P(RowsOfB, SumsOfACellAreThoseOfItsParticles) {
  const ParticleSet set = particles_of_a_cell(grid(), 9, {0, 2, 3});
  NodeVector row(static_cast<std::size_t>(n_stencil()));
  PressureCell cell;
  const auto members = all_of(set);
  fill_cell(grid(), form(), laws(), set, members, cell, row.data());
  double volume = 0.0, mass = 0.0, compliance = 0.0, target = 0.0, start = 0.0;
  for (const LocalIndex p : members) {
    const double V = set.real(Field::reference_volume)[p], J = set.real(Field::volume_ratio)[p];
    const VolumetricLaw law = *laws()[set.material()[p]];
    volume += V;
    mass += set.mass(p);
    compliance += V / law.slope(J);
    target += V * law.stress(J) / law.slope(J);
    start += V * set.real(Field::cell_mean_stress)[p];
  }
  EXPECT_NEAR(cell.volume, volume, 1e-14 * volume);
  EXPECT_NEAR(cell.mass, mass, 1e-14 * mass);
  EXPECT_NEAR(cell.compliance, compliance, 1e-14 * compliance);
  EXPECT_NEAR(cell.target, target, 1e-14 * volume);
  EXPECT_NEAR(cell.start, start / volume, 1e-13 * 1e3);
  EXPECT_FALSE(cell.parts);
  const ParticleSet parting = particles_of_a_cell(grid(), 3, {3});
  fill_cell(grid(), form(), laws(), parting, all_of(parting), cell, row.data());
  EXPECT_TRUE(cell.parts);
}

// (B^T p) . v = p . (B v)
TEST_P(RowsOfB, GradientsAreTheTransposeOfVolumeRates) {
  std::mt19937_64 random(74);
  std::normal_distribution<double> normal(0.0, 1.0);
  const int n_cells = 7, n_nodes = 90;
  const PressureRows rows = random_rows(random, n_cells, n_nodes);
  ASSERT_EQ(rows.size(), n_cells);
  std::vector<double> pressure(n_cells);
  for (double& p : pressure) p = normal(random);
  NodeVector velocity(n_nodes), sums(n_nodes), rounded(n_nodes);
  for (std::size_t k = 0; k < n_nodes; ++k) {
    velocity[k] = {{normal(random), normal(random), normal(random), 3.0}};
    sums[k] = rounded[k] = {{0.25, 0.5, -0.125, 2.0}};  // they are added to
  }
  add_gradients(rows, RowEntries::exact, 0, n_cells, pressure.data(), sums.data());
  add_gradients(rows, RowEntries::rounded, 0, 3, pressure.data(), rounded.data());
  add_gradients(rows, RowEntries::rounded, 3, n_cells, pressure.data(), rounded.data());
  const double before[3] = {0.25, 0.5, -0.125};
  double left = 0.0, left_rounded = 0.0, right = 0.0, right_rounded = 0.0;
  for (std::size_t k = 0; k < n_nodes; ++k) {
    for (std::size_t a = 0; a < 3; ++a) {
      left += (sums[k].c[a] - before[a]) * velocity[k].c[a];
      left_rounded += (rounded[k].c[a] - before[a]) * velocity[k].c[a];
      EXPECT_NEAR(rounded[k].c[a], sums[k].c[a], 1e-6) << k << ' ' << a;
    }
  }
  std::vector<LocalIndex> cells(n_cells);
  std::iota(cells.rbegin(), cells.rend(), 0);
  std::vector<double> rates(n_cells), coarse_rates(n_cells);
  volume_rates(rows, RowEntries::exact, cells, velocity.data(), rates.data());
  volume_rates(rows, RowEntries::rounded, cells, velocity.data(), coarse_rates.data());
  for (LocalIndex c = 0; c < n_cells; ++c) {
    const double rate = rates[static_cast<std::size_t>(c)], coarse = coarse_rates[static_cast<std::size_t>(c)];
    right += pressure[static_cast<std::size_t>(c)] * rate;
    right_rounded += pressure[static_cast<std::size_t>(c)] * coarse;
    EXPECT_NEAR(coarse, rate, 1e-6 * 3.0 * n_stencil() / 27.0);
    EXPECT_NE(coarse, rate);
  }
  EXPECT_NEAR(left, right, 1e-12);
  EXPECT_NEAR(left_rounded, right_rounded, 1e-12);
}

// The entries of B s B^T on the diagonal, by its products with unit pressures.
TEST_P(RowsOfB, DiagonalIsThatOfTheProducts) {
  std::mt19937_64 random(75);
  std::normal_distribution<double> normal(0.0, 1.0);
  const int n_cells = 5, n_nodes = 200;
  PressureRows rows = random_rows(random, n_cells, n_nodes);
  for (LocalIndex c = 0; c < n_cells; ++c)  // in a stencil each node is once
    for (int r = 0; r < rows.n_rows(); ++r)
      rows.first[static_cast<std::size_t>(c * rows.n_rows() + r)] = 3 * c + r * rows.width;
  NodeVector scales(n_nodes);
  for (Node& scale : scales)
    scale = {{std::fabs(normal(random)), std::fabs(normal(random)), std::fabs(normal(random)), 5.0}};
  for (LocalIndex c = 0; c < n_cells; ++c) {
    std::vector<double> pressure(n_cells, 0.0);
    pressure[static_cast<std::size_t>(c)] = 1.0;
    NodeVector sums(n_nodes, Node{});
    add_gradients(rows, RowEntries::rounded, 0, n_cells, pressure.data(), sums.data());
    for (std::size_t k = 0; k < n_nodes; ++k)
      for (int a = 0; a < 3; ++a) sums[k].c[a] *= scales[k].c[a];
    std::vector<double> rates(n_cells);
    volume_rates(rows, RowEntries::rounded, std::vector<LocalIndex>{c}, sums.data(), rates.data());
    EXPECT_NEAR(diagonal_of(rows, c, scales.data()), rates[static_cast<std::size_t>(c)], 1e-12 * n_stencil());
  }
}

// --- volumes ----------------------------------------------------------------------------------------------------------------

struct Step {
  ParticleSet set;
  std::vector<double> before, trial;  // J
  std::vector<LocalIndex> members;

  explicit Step(const std::vector<std::uint8_t>& materials)
      : set(particles_of_a_cell(box(SplineOrder::quadratic), 12, materials)), members(all_of(set)) {
    std::mt19937_64 random(75);
    std::uniform_real_distribution<double> change(-0.02, 0.05);
    double* const J = set.real(Field::volume_ratio);
    for (LocalIndex p = 0; p < set.size(); ++p) {
      before.push_back(J[p]);
      J[p] += change(random);
      trial.push_back(J[p]);
    }
  }
  void update(double relaxation, bool parted = false, const char* carried = nullptr) {
    update_volumes(laws(), {relaxation, before.data(), carried}, members, -123.5, parted, set);
  }
  double J(LocalIndex p) const { return set.real(Field::volume_ratio)[p]; }
  double V(LocalIndex p) const { return set.real(Field::reference_volume)[p]; }
  double growth(LocalIndex p) const { return J(p) - before[static_cast<std::size_t>(p)]; }
  double slope(LocalIndex p) const { return laws()[set.material()[p]]->slope(before[static_cast<std::size_t>(p)]); }
  /// sum V J over one material.
  double volume(std::uint8_t material) const {
    double sum = 0.0;
    for (const LocalIndex p : members)
      if (set.material()[p] == material) sum += V(p) * J(p);
    return sum;
  }
};

TEST(UpdateVolumes, CellGrowsByTheGrowthOfItsParticles) {
  for (const auto& materials : std::vector<std::vector<std::uint8_t>>{{0}, {2}, {3}, {0, 2}, {0, 2, 3}})
    for (const double relaxation : {0.0, 0.1, 1.0}) {
      Step step(materials);
      double expected = 0.0, sum = 0.0;
      for (const LocalIndex p : step.members) expected += step.V(p) * step.J(p);
      step.update(relaxation);
      for (const LocalIndex p : step.members) sum += step.V(p) * step.J(p);
      EXPECT_NEAR(sum, expected, 1e-14 * expected);
      for (LocalIndex p = 0; p < step.set.size(); ++p) EXPECT_EQ(step.set.real(Field::cell_mean_stress)[p], -123.5);
    }
}

// Those that an inflow carries: their J stays, and the others take up what the whole cell grows by; nothing relaxes towards them.
TEST(UpdateVolumes, KeepsTheVolumesOfWhatIsCarried) {
  for (const double relaxation : {0.0, 0.1}) {
    Step step({0, 2});
    std::vector<char> carried(step.members.size(), 0);
    for (std::size_t p = 0; p < 5; ++p) carried[p] = 1;
    double dilation = 0.0, kept = 0.0;
    for (const LocalIndex p : step.members) dilation += step.V(p) * step.growth(p);
    step.update(relaxation, false, carried.data());
    for (const LocalIndex p : step.members) {
      const auto i = static_cast<std::size_t>(p);
      if (carried[i])
        EXPECT_EQ(step.J(p), step.before[i]);
      else
        kept += step.V(p) * step.growth(p);
    }
    EXPECT_NEAR(kept, dilation, 1e-14 * std::abs(dilation) + 1e-18);
    if (relaxation > 0.0) continue;
    const LocalIndex first = step.members[5];
    for (const LocalIndex p : step.members) {
      if (carried[static_cast<std::size_t>(p)]) continue;
      EXPECT_NEAR(step.growth(p) * step.slope(p), step.growth(first) * step.slope(first), 1e-9 * step.slope(p));
    }
  }
  for (const bool parted : {false, true}) {  // all are carried
    Step step({0, 2});
    const std::vector<char> carried(step.members.size(), 1);
    step.update(0.1, parted, carried.data());
    for (const LocalIndex p : step.members) EXPECT_EQ(step.J(p), step.before[static_cast<std::size_t>(p)]);
  }
}

// The stress of every particle grows by the same: J by that over its slope.
TEST(UpdateVolumes, GrowthIsSharedByCompliance) {
  for (const auto& materials : std::vector<std::vector<std::uint8_t>>{{0}, {0, 2}, {0, 2, 3}}) {
    Step step(materials);
    step.update(0.0);
    const double stress = step.growth(0) * step.slope(0);
    EXPECT_GT(std::fabs(stress), 1.0);
    for (LocalIndex p = 1; p < step.set.size(); ++p)
      EXPECT_NEAR(step.growth(p) * step.slope(p), stress, 1e-15 * step.slope(p) + 1e-12 * std::fabs(stress)) << p;
  }
}

TEST(UpdateVolumes, RelaxationKeepsTheMeanOfEachMaterial) {
  for (const double relaxation : {0.1, 0.6, 1.0}) {
    Step plain({0, 2, 3, 2}), relaxed({0, 2, 3, 2});
    plain.update(0.0);
    relaxed.update(relaxation);
    for (const std::uint8_t material : {0, 2, 3}) {
      EXPECT_NEAR(relaxed.volume(material), plain.volume(material), 1e-14 * plain.volume(material)) << int{material};
      double volume = 0.0;
      for (const LocalIndex p : plain.members)
        if (plain.set.material()[p] == material) volume += plain.V(p);
      const double mean = plain.volume(material) / volume;
      for (const LocalIndex p : plain.members)
        if (plain.set.material()[p] == material) {
          EXPECT_NEAR(relaxed.J(p), (1.0 - relaxation) * plain.J(p) + relaxation * mean, 1e-15) << p;
        }
    }
  }
}

TEST(UpdateVolumes, PartedCellsKeepTheirOwn) {
  Step step({3});
  step.update(0.0, true);
  for (LocalIndex p = 0; p < step.set.size(); ++p) {
    EXPECT_EQ(step.J(p), step.trial[static_cast<std::size_t>(p)]) << p;
    EXPECT_EQ(step.set.real(Field::cell_mean_stress)[p], -123.5);
  }
}

// --- order ------------------------------------------------------------------------------------------------------------------

TEST(PressureCells, OrderOfParticlesInTheSetIsWithoutEffect) {
  std::mt19937_64 random(76);
  const GridGeometry grid = box(SplineOrder::quadratic);
  const ParticleSet first = particles_of_a_cell(grid, 40, {0, 2, 3, 1});
  std::vector<LocalIndex> order(40);
  std::iota(order.begin(), order.end(), 0);
  PressureCell expected_cell;
  NodeVector expected_row;
  std::map<GlobalIndex, double> expected_J;
  for (int round = 0; round < 5; ++round) {
    ParticleSet set = picked(first, order);
    std::shuffle(order.begin(), order.end(), random);
    const std::vector<LocalIndex> cell_of(40, 0), number_of{0};
    CellParticles cells;
    group_by_cell(laws(), set, cell_of, number_of, 1, cells);
    ASSERT_EQ(cells.of(0).size(), 30u);
    PressureCell cell;
    NodeVector row(27);
    fill_cell(grid, GradientForm::bspline, laws(), set, cells.of(0), cell, row.data());
    std::vector<double> before(set.real(Field::volume_ratio), set.real(Field::volume_ratio) + 40);
    for (LocalIndex p = 0; p < 40; ++p) set.real(Field::volume_ratio)[p] += 1e-3 * std::sin(1.0 * set.id()[p]);
    update_volumes(laws(), {0.1, before.data()}, cells.of(0), 1.0, false, set);
    std::map<GlobalIndex, double> J;
    for (LocalIndex p = 0; p < 40; ++p) J[set.id()[p]] = set.real(Field::volume_ratio)[p];
    if (round > 0) {
      EXPECT_EQ(cell.volume, expected_cell.volume);
      EXPECT_EQ(cell.mass, expected_cell.mass);
      EXPECT_EQ(cell.compliance, expected_cell.compliance);
      EXPECT_EQ(cell.target, expected_cell.target);
      EXPECT_EQ(cell.start, expected_cell.start);
      EXPECT_EQ(std::memcmp(row.data(), expected_row.data(), row.size() * sizeof(Node)), 0);
      EXPECT_EQ(J, expected_J);
    }
    expected_cell = cell;
    expected_row = row;
    expected_J = J;
  }
}

}  // namespace
}  // namespace bulkley::pressure_cells_test
