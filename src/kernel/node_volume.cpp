#include "kernel/node_volume.hpp"

#include <algorithm>

#include "kernel/bspline.hpp"

namespace bulkley {

namespace {

constexpr double least_part = 0.25;

// A collider acts where the nodes are that it holds, a tenth of a cell behind the outermost of them (`hold_distance`), and material goes
// as far where that is behind its surface. Cells from there to nodes that it holds, and to those next to them.
constexpr double to_held = 0.1, to_free = 1.1;

// Of a face that material does not pass. Where nodes behind are folded to their images, those in front have the whole volume.
double part_before_face(const GridGeometry& grid, const Face& face, int cells) {
  const FaceBehaviour& behaves = behaviour(face.kind);
  if (!behaves.contact || (behaves.behind != NodesBehind::free && cells > 0)) return 1.0;
  return spline_integral(grid.order, cells);
}

double part_before_collider(const GridGeometry& grid, const Collider& collider, const Vec3& node) {
  const double distance = signed_distance(collider.shape, node);
  const double least = distance > hold_distance(grid, collider.contact) ? to_free : to_held;
  return spline_integral(grid.order, std::max(distance / grid.cell_size, least));
}

}  // namespace

std::vector<NodeVolume> node_volumes(const GridGeometry& grid, const Faces& faces, const std::vector<Collider>& colliders,
                                     const std::vector<Int3>& nodes) {
  std::vector<NodeVolume> result;
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    double part = 1.0;
    for (int f = 0; f < 6; ++f)
      part *= part_before_face(grid, faces[static_cast<std::size_t>(f)], cells_inside(grid, f, nodes[n]));
    const Vec3 x = grid.node_position(nodes[n]);
    double before_colliders = 1.0;
    for (const Collider& collider : colliders)
      if (!collider.motion.moves()) before_colliders = std::min(before_colliders, part_before_collider(grid, collider, x));
    part = std::max(part * before_colliders, least_part);
    if (part < 1.0) result.push_back({static_cast<LocalIndex>(n), part});
  }
  return result;
}

}  // namespace bulkley
