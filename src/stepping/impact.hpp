#pragma once
// How many steps a flow needs once it has been thrown against something: for predictions, before anything is run.

#include <optional>
#include <vector>

#include "bulkley/base/types.hpp"
#include "stepping/time_step.hpp"

namespace bulkley {

/// A body that flows meets a wall, a collider or another body, and spreads over it.
struct Impact {
  double time = 0.0;     ///< s, of first contact
  double speed = 0.0;    ///< U, m/s, of the body at the start; > 0
  double size = 0.0;     ///< L, m, of the body; > 0
  int n_directions = 2;  ///< in which it spreads: 1 in a plane scene
};

/// The largest ||L_p||, 1/s, of cells of `cell_size`, m, at `time`, s: 0 before contact, then 1.5 U / dx, which falls like the
/// thickness of a sheet that runs off at U, (1 + t U / L)^-n_directions (docs/theory.md, "Time step"). Not collective.
double largest_gradient(const Impact& impact, double cell_size, double time);

/// Steps from 0 to `end`, s, of `dt`, s, shorter where (T26) says so for the gradients of `impacts`. Not collective.
double count_steps(const TimeStepSettings& settings, double cell_size, double end, double dt,
                   const std::vector<Impact>& impacts);

/// When the box from `lower` to `upper`, m, which moves at `velocity`, m/s, first touches another that rests, s >= 0; none if it
/// never does. Boxes may be endless. Not collective.
std::optional<double> first_contact(const Vec3& lower, const Vec3& upper, const Vec3& velocity, const Vec3& other_lower,
                                    const Vec3& other_upper);

}  // namespace bulkley
