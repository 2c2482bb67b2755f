#include "integrator/floors.hpp"

namespace bulkley {

std::vector<Floor> floors_of(const Physics& physics) {
  constexpr double least_square_of_cosine = 0.5;
  std::vector<Floor> floors;
  for (int f = 0; f < 6; ++f) {
    const int axis = f / 2;
    const bool lower = f % 2 == 0;
    const FaceKind kind = physics.faces[static_cast<std::size_t>(f)].kind;
    const double towards = lower ? -physics.gravity[axis] : physics.gravity[axis];
    if (behaviour(kind).contact && towards > 0.0 && towards * towards >= least_square_of_cosine * physics.gravity.squaredNorm())
      floors.push_back({axis, lower ? physics.grid.lower[axis] : physics.grid.upper()[axis], lower ? 1.0 : -1.0, kind});
  }
  return floors;
}

}  // namespace bulkley
