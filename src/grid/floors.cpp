#include "grid/floors.hpp"

namespace bulkley {

std::vector<Floor> floors_of(const GridGeometry& grid, const Faces& faces, const Vec3& gravity) {
  constexpr double least_square_of_cosine = 0.5;
  std::vector<Floor> floors;
  for (int f = 0; f < 6; ++f) {
    const int axis = f / 2;
    const bool lower = f % 2 == 0;
    const FaceKind kind = faces[static_cast<std::size_t>(f)].kind;
    const double towards = lower ? -gravity[axis] : gravity[axis];
    if (behaviour(kind).contact && towards > 0.0 && towards * towards >= least_square_of_cosine * gravity.squaredNorm())
      floors.push_back({axis, lower ? grid.lower[axis] : grid.upper()[axis], lower ? 1.0 : -1.0, towards, kind});
  }
  return floors;
}

double reach_of_floors(const GridGeometry& grid, SplineOrder order) {
  return (order == SplineOrder::quadratic ? 1.5 : 2.0) * grid.cell_size;
}

}  // namespace bulkley
