#pragma once
// Keys of [domain] of a scene.

#include "bulkley/config/keys.hpp"
#include "grid/grid_geometry.hpp"

namespace bulkley {

/// The background grid as scenes write it.
struct DomainInput {
  Vec3 lower = Vec3::Zero();  ///< m
  Vec3 upper = Vec3::Zero();  ///< m
  double cell_size = 0.0;     ///< m
};
const config::Keys<DomainInput>& keys(config::Of<DomainInput>);

/// Reports axes with too few cells, and periodic ones that are neither a whole number of tiles long nor one cell. `domain`: the table [domain].
void check_number_of_cells(const config::Value& domain, const GridGeometry& grid, config::Faults& faults);

namespace config {

/// Fills lower, cell_size and n_cells; which axes are periodic and the spline's order are other tables' matter.
template <>
struct Codec<GridGeometry> : PlainCodec {
  static std::string type(const Rule&) { return "table"; }
  static bool read(const Value& value, const Rule& rule, GridGeometry& out, Faults& faults);
  static Value write(const GridGeometry& grid);
  static void describe(const std::string& path, std::vector<TableText>& out);
};

}  // namespace config
}  // namespace bulkley
