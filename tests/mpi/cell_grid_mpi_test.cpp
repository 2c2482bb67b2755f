// ranks: 1 2 3 7
// Cells as unknowns on several ranks: which cells and nodes a rank knows, what it learns of those of others, and the waves of
// products, against a dense grid that every rank can fill for itself.
#include "distribution/cell_grid.hpp"

#include <gtest/gtest.h>

#include <map>

#include "distribution/cell_waves.hpp"
#include "support/solver_run.hpp"

namespace bulkley::cell_grid_mpi_test {
namespace {

struct MappedShape : GridShape {
  LocalIndex n_particles = 400;
  bool scattered = true;  // each tile is on any rank
};

const MappedShape shapes[] = {
    {{"the last tiles end with the nodes", {8, 8, 8}, {false, false, false}}},
    {{"the last tiles reach beyond the nodes", {9, 7, 10}, {false, false, false}}},
    {{"periodic", {8, 12, 8}, {true, true, true}}},
    {{"one tile around z", {14, 8, 4}, {false, true, true}}},
    {{"plane across y", {24, 1, 10}, {false, true, false}}},
    {{"plane across z", {14, 12, 1}, {false, true, true}}},
    {{"a column", {1, 1, 40}, {true, true, false}}},
    // Ranks want cells of ranks that they exchange no nodes with.
    {{"mostly empty", {24, 24, 24}, {false, false, true}}, 100, false},
};

// A whole number that belongs to a place in the grid, so that sums of it are exact.
double number_at(const Int3& at) { return (at[0] * 31 + at[1] * 17 + at[2] * 7) % 101 - 50; }

// One scene on all ranks and the grid of its cells.
struct Setting {
  SolverScene scene;
  PhaseTimes times;
  std::unique_ptr<ParticleGrid> particles;
  std::unique_ptr<CellGrid> cells;
  std::map<Int3, int> count;  // particles of each base node, over all ranks

  Setting(const Comm& comm, const MappedShape& shape, SplineOrder order, bool sticky)
      : scene(empty_scene({.order = order}, shape.n_cells, shape.periodic)) {
    const GridGeometry& grid = scene.physics.grid;
    if (sticky)
      for (std::size_t f = 0; f < 6; ++f)
        if (!shape.periodic[f / 2]) scene.physics.faces[f].kind = FaceKind::sticky;
    const Vec3 lower = grid.lower, size = grid.upper() - lower;
    for (LocalIndex p = 0; p < shape.n_particles; ++p) {  // scattered, with particles on all walls
      Vec3 x;
      for (int a = 0; a < 3; ++a) {
        const double share = std::fmod(0.5 + (p + 1) * (a == 0 ? 0.754877666 : a == 1 ? 0.569840291 : 0.438447187), 1.0);
        const bool on_wall = p % 37 == a, can_be = !shape.periodic[static_cast<std::size_t>(a)];
        x[a] = lower[a] + (on_wall && can_be ? p % 2 : share * 0.999) * size[a];
      }
      add_particle(scene, x);
    }
    for (LocalIndex p = 0; p < scene.particles.size(); ++p) ++count[base_of(scene.particles.vector(Field::position, p))];
    Partition partition = partition_of(comm, scene, PartitionMethod::hilbert, shape.scattered);
    particles = std::make_unique<ParticleGrid>(comm, grid, scene.physics.faces, 2, std::move(partition),
                                               share_of(comm, scene.particles, {}), times);
    cells = std::make_unique<CellGrid>(comm, *particles, scene.physics.faces);
  }

  // By particle of this rank.
  std::span<const LocalIndex> cell() const {
    return {particles->map().cell.data(), static_cast<std::size_t>(particles->particles().size())};
  }
  Int3 base_of(const Vec3& x) const {
    const GridGeometry& grid = scene.physics.grid;
    return {grid.base_node(0, x[0]), grid.base_node(1, x[1]), grid.base_node(2, x[2])};
  }
  Int3 wrapped(Int3 node) const {
    for (int a = 0; a < 3; ++a)
      if (scene.physics.grid.periodic[static_cast<std::size_t>(a)])
        node[static_cast<std::size_t>(a)] %= scene.physics.grid.n_nodes(a);
    return node;
  }
  std::map<LocalIndex, Int3> complete() const {
    std::map<LocalIndex, Int3> position_of;
    const std::vector<Int3> positions = cells->complete_positions();
    for (std::size_t k = 0; k < positions.size(); ++k) position_of[cells->complete_nodes()[k]] = positions[k];
    return position_of;
  }
  // Of each node, the sum of what the occupied cells that reach it have, over all ranks.
  std::map<Int3, double> sums() const {
    std::map<Int3, double> result;
    const int s = cells->width();
    for (const auto& [base, n] : count)
      for (int k = 0; k < s * s * s; ++k)
        result[wrapped({base[0] + k / (s * s), base[1] + k / s % s, base[2] + k % s})] += number_at(base);
    return result;
  }
  std::vector<std::int32_t> counts(const Comm& comm) const {
    std::vector<std::int32_t> by_id(static_cast<std::size_t>(cells->n_ids()), 0);
    for (const LocalIndex id : cell()) ++by_id[static_cast<std::size_t>(id)];
    exchange_counts(comm, *cells, by_id);
    return by_id;
  }
};

class CellGridTest : public testing::Test {
 protected:
  Comm comm{PETSC_COMM_WORLD};

  template <class Check>
  void for_all(Check check) {
    for (const MappedShape& shape : shapes)
      for (const SplineOrder order : {SplineOrder::quadratic, SplineOrder::cubic})
        for (const bool sticky : {false, true}) {
          SCOPED_TRACE(testing::Message() << shape.name << ", width " << stencil_width(order) << (sticky ? ", sticky" : ""));
          check(Setting(comm, shape, order, sticky));
        }
  }
};

TEST_F(CellGridTest, CellsHaveTheParticlesOfAllRanks) {
  for_all([&](const Setting& setting) {
    const std::vector<std::int32_t> counts = setting.counts(comm);
    GlobalIndex n_own = 0;
    int before = -1;
    for (const LocalIndex id : setting.cells->order()) {
      const Int3 at = setting.cells->position(id);
      const auto found = setting.count.find(at);
      EXPECT_EQ(counts[static_cast<std::size_t>(id)], found == setting.count.end() ? 0 : found->second);
      if (id < setting.cells->n_own_ids()) n_own += counts[static_cast<std::size_t>(id)];
      const int number = static_cast<int>(setting.scene.physics.grid.node_number(at));
      EXPECT_LT(before, number) << "in the order of their places";
      before = number;
    }
    EXPECT_EQ(sum_global(comm, n_own), setting.scene.particles.size());
  });
}

TEST_F(CellGridTest, RowsAreTheNodesOfTheStencil) {
  for_all([&](const Setting& setting) {
    const CellGrid& cells = *setting.cells;
    std::map<LocalIndex, Int3> position_of = setting.complete();
    for (const CellGrid::Copy& copy : cells.repeated())
      if (position_of.count(copy.other)) position_of[copy.node] = position_of[copy.other];
    const int s = cells.width();
    for (const LocalIndex id : setting.cell()) {
      const Int3 base = cells.position(id);
      const auto rows = cells.rows(id);
      ASSERT_EQ(rows.size(), static_cast<std::size_t>(s * s));
      for (int k = 0; k < s * s * s; ++k) {
        const auto found = position_of.find(rows[static_cast<std::size_t>(k / s)] + k % s);
        ASSERT_NE(found, position_of.end()) << "all nodes of own particles are complete";
        EXPECT_EQ(found->second, setting.wrapped({base[0] + k / (s * s), base[1] + k / s % s, base[2] + k % s}));
      }
    }
    const auto n_active = setting.particles->exchange().active_positions();
    ASSERT_EQ(cells.owned().size(), n_active.size());
    for (std::size_t k = 0; k < n_active.size(); ++k) EXPECT_EQ(position_of.at(cells.owned()[k].node), n_active[k]);
  });
}

// What each cell has comes through CellHalo; sums over cells are right at complete nodes, in one go and wave by wave.
TEST_F(CellGridTest, SumsAreWholeAtCompleteNodes) {
  for_all([&](const Setting& setting) {
    const CellGrid& cells = *setting.cells;
    const std::vector<std::int32_t> counts = setting.counts(comm);
    std::vector<LocalIndex> number_of(counts.size(), -1), ids;
    for (const LocalIndex id : cells.order())
      if (counts[static_cast<std::size_t>(id)] > 0) {
        number_of[static_cast<std::size_t>(id)] = static_cast<LocalIndex>(ids.size());
        ids.push_back(id);
      }
    CellHalo halo;
    halo.connect(cells, number_of);
    std::vector<double> values(2 * ids.size(), -1e9);
    for (std::size_t n = 0; n < ids.size(); ++n)
      if (ids[n] < cells.n_own_ids()) {
        values[2 * n] = number_at(cells.position(ids[n]));
        values[2 * n + 1] = comm.rank();
      }
    halo.exchange(comm, values.data(), 2);
    const std::map<Int3, double> expected = setting.sums();
    const auto expected_at = [&](const Int3& node) {
      const auto found = expected.find(node);
      return found == expected.end() ? 0.0 : found->second;
    };

    std::vector<CellGrid::Copy> joined;
    if (!cells.complete_nodes().empty()) joined.push_back({cells.complete_nodes().front(), cells.complete_nodes().back()});
    const CellWaves waves(cells, joined);
    std::vector<Node> sums(static_cast<std::size_t>(cells.n_nodes()), Node{});
    const std::map<LocalIndex, Int3> position_of = setting.complete();
    std::size_t k = 0;
    LocalIndex begin = 0;
    for (LocalIndex w = 0; w < waves.size(); ++w) {
      EXPECT_LE(begin, waves.end_of_nodes(w));
      for (; k < cells.order().size() && waves.planes()[k] == w; ++k) {
        const LocalIndex id = cells.order()[k], n = number_of[static_cast<std::size_t>(id)];
        LocalIndex of_nodes = 0;
        for (const LocalIndex first : cells.rows(id))
          for (int z = 0; z < cells.width(); ++z) {
            ASSERT_LT(first + z, waves.end_of_nodes(w));
            if (n >= 0) sums[static_cast<std::size_t>(first + z)].c[0] += values[2 * static_cast<std::size_t>(n)];
            of_nodes = std::max(of_nodes, waves.of_node(first + z));
          }
        EXPECT_EQ(waves.of_cell(id), of_nodes) << "a cell waits for the last of its nodes";
      }
      std::vector<Node> now = sums;
      fold_repeated(cells.repeated(), now.data());
      for (const auto& [node, at] : position_of)
        if (waves.of_node(node) <= w) {
          EXPECT_EQ(now[static_cast<std::size_t>(node)].c[0], expected_at(at));
        }
      begin = waves.end_of_nodes(w);
    }
    EXPECT_EQ(k, cells.order().size());
    for (const CellGrid::Copy& pair : joined) EXPECT_EQ(waves.of_node(pair.node), waves.of_node(pair.other));
    for (const CellGrid::Copy& pair : cells.repeated()) EXPECT_EQ(waves.of_node(pair.node), waves.of_node(pair.other));
    repeat(cells.repeated(), sums.data());
    for (const CellGrid::Copy& pair : cells.repeated())
      EXPECT_EQ(sums[static_cast<std::size_t>(pair.node)].c[0], sums[static_cast<std::size_t>(pair.other)].c[0]);
  });
}

// A node behind a wall and its mirror image are complete together.
TEST_F(CellGridTest, ImagesAreCompleteWithTheNodesBehindWalls) {
  for_all([&](const Setting& setting) {
    std::map<Int3, bool> complete;
    for (const Int3& node : setting.cells->complete_positions()) complete[node] = true;
    const GridGeometry& grid = setting.scene.physics.grid;
    for (std::size_t f = 0; f < 6; ++f) {
      if (behaviour(setting.scene.physics.faces[f].kind).behind == NodesBehind::free) continue;
      const std::size_t axis = f / 2;
      const int wall = grid.node_offset(static_cast<int>(axis)) + (f % 2 == 0 ? 0 : grid.n_cells[axis]);
      const int inwards = f % 2 == 0 ? 1 : -1;
      for (const Int3& node : setting.cells->complete_positions())
        if (node[axis] == wall + inwards) {
          Int3 image = node;
          image[axis] = wall - inwards;
          EXPECT_TRUE(complete.count(image)) << "axis " << axis;
        }
    }
  });
}

}  // namespace
}  // namespace bulkley::cell_grid_mpi_test
