#pragma once
// How thick a shape is, for obstacles that must be thicker than the resolution of the grid.

#include "geometry/shape.hpp"

namespace bulkley {

/// Nine tenths of the shape's surface inside `window` have at least this much of the shape behind them, straight inwards;
/// lengths beyond `enough` are not distinguished, and `enough` is returned where no surface is found. From some thousand
/// points of the surface, so that a sharp edge, which is thin anywhere, does not count, but a blade does. m. Not collective.
double thickness(const Shape& shape, const Bounds& window, double enough);

}  // namespace bulkley
