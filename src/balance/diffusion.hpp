#pragma once
// From unequal loads of parts to equal ones by moving few tiles.

#include "balance/tile_graph.hpp"

namespace bulkley {

/// `part` with tiles of overloaded parts given straight to underloaded ones, wherever those are: what a part receives
/// grows around a first tile. Moves no more load than the excess, where diffusion hands load on from neighbour to neighbour,
/// but parts come to lie in several pieces. The largest load never grows, and no part loses its last tile. Deterministic.
std::vector<std::int32_t> relieved(const TileGraph& graph, const TileLoad& load, std::vector<std::int32_t> part, int n_parts,
                                   double tolerance);

/// `part` (of each tile of the load) with tiles moved across the borders of parts until the largest load is at most
/// `tolerance` times the mean, or no further move helps. First single tiles leave the most loaded parts, which moves the fewest
/// and hardly lengthens borders; or whole pieces of a part, where no part that touches has room. If that is not enough, the
/// flow of least squares that makes the loads equal says how much goes from part to part (Hu, Blake & Emerson 1998). Which
/// tiles go is chosen for short borders. The largest load never grows, and no part loses its last tile. Deterministic.
std::vector<std::int32_t> diffused(const TileGraph& graph, const TileLoad& load, std::vector<std::int32_t> part, int n_parts,
                                   double tolerance);

}  // namespace bulkley
