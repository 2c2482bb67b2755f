#pragma once
// Surfaces of shapes as triangles, to look at; the solver knows shapes by their signed distance alone.

#include "bulkley/particle/shape.hpp"
#include "bulkley/particle/triangle_mesh.hpp"

namespace bulkley {

/// Triangles of the surface of `shape`, facing outwards.
///
/// Vertices lie on the surface: boxes and triangle meshes are exact, round shapes have 48 segments to a turn. A union is the
/// surfaces of its parts, which may pass through each other. Planes, complements and differences are traced on a lattice
/// (64 cells along the longest side), planes and complements as far as they lie within `window`, whose faces close them; edges
/// of these are blunted by up to a cell of the lattice. Not collective.
TriangleMesh surface_of(const Shape& shape, const Bounds& window);

}  // namespace bulkley
