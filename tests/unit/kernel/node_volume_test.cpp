// How much nodes near walls hold: against the splines' integrals, and against the masses of material that fills all room there is.

#include "kernel/node_volume.hpp"

#include <gtest/gtest.h>

#include "kernel/bspline.hpp"
#include "support/serial_step.hpp"

namespace bulkley::node_volume_test {
namespace {

constexpr double far = 1e3;

GridGeometry grid_of(SplineOrder order = SplineOrder::quadratic) {
  GridGeometry grid;
  grid.lower = Vec3(-0.3, 0.2, 0.7);
  grid.cell_size = 0.1;
  grid.n_cells = {6, 8, 5};
  grid.order = order;
  return grid;
}

Faces all_faces(FaceKind kind) {
  Faces faces;
  for (Face& face : faces) face.kind = kind;
  return faces;
}

// Of nodes at `cells` along the axis and in the middle of the box along the others; 1 where none is listed.
double part_of(const GridGeometry& grid, const Faces& faces, const std::vector<Collider>& colliders, int axis, int cells) {
  Int3 node;
  for (int a = 0; a < 3; ++a)
    node[static_cast<std::size_t>(a)] =
        grid.node_offset(a) + (a == axis ? cells : grid.n_cells[static_cast<std::size_t>(a)] / 2);
  const std::vector<NodeVolume> found = node_volumes(grid, faces, colliders, {node});
  return found.empty() ? 1.0 : found.front().part;
}

TEST(NodeVolume, OfFacesIsWhatIsInFrontOfThem) {
  const GridGeometry grid = grid_of();
  for (int axis = 0; axis < 3; ++axis)
    for (const FaceKind kind : {FaceKind::open, FaceKind::outflow, FaceKind::periodic, FaceKind::sticky, FaceKind::slip}) {
      Faces faces = all_faces(FaceKind::open);
      faces[static_cast<std::size_t>(2 * axis)].kind = kind;
      faces[static_cast<std::size_t>(2 * axis + 1)].kind = kind;
      const bool wall = behaviour(kind).contact.has_value();
      // Nodes behind are folded to their images, which have the whole volume then.
      EXPECT_EQ(part_of(grid, faces, {}, axis, 0), wall ? 0.5 : 1.0) << behaviour(kind).name;
      EXPECT_EQ(part_of(grid, faces, {}, axis, 1), 1.0) << behaviour(kind).name;
      EXPECT_EQ(part_of(grid, faces, {}, axis, grid.n_cells[static_cast<std::size_t>(axis)]), wall ? 0.5 : 1.0);
    }
}

TEST(NodeVolume, OfFacesWithoutImagesReachesIntoTheNextNodes) {
  const GridGeometry grid = grid_of();
  ASSERT_EQ(behaviour(FaceKind::separating).behind, NodesBehind::free);
  const Faces faces = all_faces(FaceKind::separating);
  EXPECT_EQ(part_of(grid, faces, {}, 2, 0), 0.5);
  EXPECT_NEAR(part_of(grid, faces, {}, 2, 1), 47.0 / 48.0, 1e-15);
  EXPECT_EQ(part_of(grid, faces, {}, 2, 2), 1.0);
  const Int3 corner = {grid.node_offset(0), grid.node_offset(1), grid.n_cells[2] / 2 + grid.node_offset(2)};
  const std::vector<NodeVolume> found = node_volumes(grid, faces, {}, {corner});
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found.front().part, 0.25);
}

// A floor at each tenth of a cell: nodes by their distances, but as if it acted no farther in front than a tenth of a cell behind the
// outermost node that it holds.
TEST(NodeVolume, OfCollidersAtRestGoesByWhereTheyAct) {
  for (const SplineOrder order : {SplineOrder::quadratic, SplineOrder::cubic})
    for (const Contact contact : {Contact::sticky, Contact::separating})
      for (int tenth = 0; tenth < 10; ++tenth) {
        const GridGeometry grid = grid_of(order);
        const double height = 2.02 + 0.1 * tenth;  // of the floor, in cells
        const double top = grid.lower[2] + height * grid.cell_size;
        const Collider floor{"floor", {Box{{-far, -far, -far}, {far, far, top}}}, contact, 0.0, {}, {}};
        Collider lift = floor;
        lift.motion.velocity = Vec3(0.0, 0.0, 1.0);
        const Faces open = all_faces(FaceKind::open);
        const int outermost = static_cast<int>(std::floor(height + (contact == Contact::sticky ? 0.75 : 0.0)));
        const double acts = std::min(height, outermost - 0.1);
        for (int cells = outermost; cells < outermost + 2; ++cells) {
          const double part = part_of(grid, open, {floor}, 2, cells);
          EXPECT_NEAR(part, spline_integral(order, cells - acts), 1e-12) << height << " " << cells;
          EXPECT_EQ(part_of(grid, open, {floor, floor}, 2, cells), part) << "two colliders with one surface count once";
          EXPECT_EQ(part_of(grid, open, {lift}, 2, cells), 1.0) << "moving ones are left out";
        }
        EXPECT_GE(part_of(grid, open, {floor}, 2, 0), 0.25);
      }
}

// Eight particles a cell in a box that is full, with walls of all kinds and a floor in it: every node in front of walls, and a node on them,
// holds what it has room for, but for 1.1 % by which eight particles a cell miss the part of a spline in front of a wall.
TEST(NodeVolume, IsWhatMaterialThatFillsTheRoomBringsToNodes) {
  for (const SplineOrder order : {SplineOrder::quadratic, SplineOrder::cubic}) {
    SerialScene scene = open_scene({.order = order});
    const GridGeometry& grid = scene.grid;
    scene.faces = all_faces(FaceKind::slip);
    scene.faces[0].kind = FaceKind::separating;
    scene.faces[3].kind = FaceKind::sticky;
    const double dx = grid.cell_size, top = grid.lower[2] + 2.0 * dx, density = 1000.0;
    scene.colliders = {{"floor", {Box{{-far, -far, -far}, {far, far, top}}}, Contact::sticky}};
    std::vector<Vec3> places;
    for (int i = 0; i < 16; ++i)
      for (int j = 0; j < 16; ++j)
        for (int k = 4; k < 16; ++k) places.push_back(grid.lower + 0.5 * dx * Vec3(i + 0.5, j + 0.5, k + 0.5));
    ParticleSet set(stressed_fields(), Densities(std::array{density}));
    set.resize(static_cast<LocalIndex>(places.size()));
    const double volume = dx * dx * dx / 8.0;
    for (std::size_t p = 0; p < places.size(); ++p)
      place_particle(set, static_cast<LocalIndex>(p), places[p], volume);
    SerialStep run(scene, std::move(set));
    run.particles_to_nodes(1e-3);
    run.update_nodes(1e-3);
    std::vector<double> part(run.indices.size(), 1.0);
    for (const NodeVolume& near : node_volumes(grid, scene.faces, scene.colliders, run.indices))
      part[static_cast<std::size_t>(near.node)] = near.part;
    int n_judged = 0, n_near = 0;
    for (std::size_t n = 0; n < run.indices.size(); ++n) {
      bool in_front = run.node_position(n)[2] > top - 1e-9;
      for (int f = 0; f < 6; ++f) in_front = in_front && cells_inside(grid, f, run.indices[n]) >= 0;
      if (!in_front) continue;
      // In corners of three walls no part is as small as it should be: an eighth. The floor counts as a tenth of a cell lower, by which
      // nodes on it hold S(0.1) = 0.575 in place of a half.
      const double full = run.nodes[n].c[3] / (density * dx * dx * dx * part[n]);
      EXPECT_LE(full, 1.015);
      if (part[n] > 0.25) {
        EXPECT_GE(full, run.node_position(n)[2] < top + 1e-9 ? 0.86 : 0.985) << run.node_position(n).transpose();
        ++n_judged;
        n_near += part[n] < 1.0;
      }
    }
    EXPECT_GT(n_judged, 300);
    EXPECT_GT(n_near, 100);
  }
}

}  // namespace
}  // namespace bulkley::node_volume_test
