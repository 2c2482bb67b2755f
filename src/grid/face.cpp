#include "grid/face.hpp"

#include <cmath>

namespace bulkley {

std::vector<FaceFault> face_faults(const Faces& faces) {
  std::vector<FaceFault> faults;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const std::size_t lower = 2 * axis, upper = 2 * axis + 1;
    const bool lower_wraps = behaviour(faces[lower].kind).crossing == Crossing::wraps;
    const bool upper_wraps = behaviour(faces[upper].kind).crossing == Crossing::wraps;
    if (lower_wraps == upper_wraps) continue;
    const std::size_t wraps = lower_wraps ? lower : upper, other = lower_wraps ? upper : lower;
    const std::string kind = behaviour(faces[wraps].kind).name;
    faults.push_back(
        {wraps, "",
         "is " + kind + " but '" + face_names[other] + "' is not; an axis is " + kind + " at both ends or at none"});
  }
  for (std::size_t f = 0; f < faces.size(); ++f) {
    const Face& face = faces[f];
    if (!(face.friction >= 0.0 && std::isfinite(face.friction)))
      faults.push_back({f, "friction", "is " + std::to_string(face.friction) + "; it must be a finite number >= 0"});
    if (!face.velocity.allFinite())
      faults.push_back({f, "velocity", "is not finite"});
    else if (face.velocity[static_cast<Eigen::Index>(f / 2)] != 0.0)
      faults.push_back(
          {f, "velocity", std::string("has a component along ") + "xyz"[f / 2] + "; a face moves only in its own plane"});
  }
  return faults;
}

}  // namespace bulkley
