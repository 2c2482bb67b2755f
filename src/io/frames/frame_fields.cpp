#include "io/frames/frame_fields.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bulkley/base/tensor.hpp"
#include "kernel/derived_fields.hpp"

namespace bulkley {

namespace {

void store_reals(const double* values, int n, FloatPrecision precision, std::byte*& out) {
  for (int c = 0; c < n; ++c) {
    if (precision == FloatPrecision::float32) {
      const auto value = static_cast<float>(values[c]);
      std::memcpy(out, &value, sizeof value);
      out += sizeof value;
    } else {
      std::memcpy(out, &values[c], sizeof values[c]);
      out += sizeof values[c];
    }
  }
}

void store_integers(const double* values, int n, std::byte*& out) {
  for (int c = 0; c < n; ++c) {
    const auto value = static_cast<std::int32_t>(values[c]);
    std::memcpy(out, &value, sizeof value);
    out += sizeof value;
  }
}

ArrayType real_type(FloatPrecision precision) {
  return precision == FloatPrecision::float32 ? ArrayType::float32 : ArrayType::float64;
}

Array derived_array(const DerivedField& field, FloatPrecision precision, const ParticleRange& range,
                    const ParticleSet& particles, std::int32_t rank, const StressOfState& stress) {
  const ArrayType type = field.is_integer ? ArrayType::int32 : real_type(precision);
  Array array = particle_array(field.name, type, field.n_components, range);
  array.unit = field.unit;
  array.meaning = field.meaning;
  array.fill = [field, precision, rank, &particles, &stress](GlobalIndex first, GlobalIndex n, std::byte* out) {
    double values[DerivedField::most_components];
    for (GlobalIndex p = first; p < first + n; ++p) {
      field.evaluate({particles, stress, static_cast<LocalIndex>(p), rank}, values);
      if (field.is_integer)
        store_integers(values, field.n_components, out);
      else
        store_reals(values, field.n_components, precision, out);
    }
  };
  return array;
}

/// A field of the table; six components become the nine of a full tensor, which is what viewers agree on.
Array table_array(const FieldInfo& field, FloatPrecision precision, const ParticleRange& range,
                  const ParticleSet& particles) {
  const bool symmetric = field.n_components == 6;
  const int n_components = symmetric ? 9 : field.n_components;
  const bool real = field.type == FieldType::real;
  Array array = particle_array(field.name, real ? real_type(precision) : stored_type(field.type), n_components, range);
  array.unit = field.unit;
  array.meaning = field.meaning;
  array.fill = [field, precision, n_components, symmetric, real, &particles](GlobalIndex first, GlobalIndex n,
                                                                             std::byte* out) {
    if (!real) return field_to_rows(particles, field, first, n, out);
    double values[9];
    for (GlobalIndex p = first; p < first + n; ++p) {
      for (int c = 0; c < n_components; ++c)
        values[c] = particles.real(field.field, symmetric ? symmetric_index(c / 3, c % 3) : c)[p];
      store_reals(values, n_components, precision, out);
    }
  };
  return array;
}

}  // namespace

Array frame_array(const std::string& name, FloatPrecision precision, const ParticleRange& range,
                  const ParticleSet& particles, std::int32_t rank, const StressOfState& stress) {
  for (const FieldInfo& field : field_table) {
    if (!field.written || name != field.name) continue;
    if (particles.has(field.field)) return table_array(field, precision, range, particles);
    throw UsageError(fmt::format("output.fields: '{}' is a variable that no particle here has ({})", name, field.meaning));
  }
  for (const DerivedField& field : derived_fields())
    if (name == field.name) return derived_array(field, precision, range, particles, rank, stress);
  throw UsageError(
      fmt::format("output.fields: there is no field '{}'; the fields are {}", name, fmt::join(frame_field_names(), ", ")));
}

namespace {

/// Visits the owned nodes of z-planes [first, first + n) in the order of the file, which is that of XDMF: x fastest.
template <class Visit>
void for_each_node(const GridNodes& nodes, GlobalIndex first, GlobalIndex n, const Visit& visit) {
  const Int3& count = nodes.count;
  for (GlobalIndex k = first; k < first + n; ++k)
    for (GlobalIndex j = 0; j < count[1]; ++j)
      for (GlobalIndex i = 0; i < count[0]; ++i)
        visit(nodes.nodes[static_cast<std::size_t>((i * count[1] + j) * count[2] + k)]);
}

}  // namespace

std::vector<Array> grid_arrays(const GridNodes& nodes, FloatPrecision precision) {
  const GridGeometry& grid = nodes.geometry;
  Array mass;
  mass.path = "/grid/mass_density";
  mass.type = real_type(precision);
  mass.unit = "kg/m^3";
  mass.meaning = "m_i / dx^3";
  for (int axis = 2; axis >= 0; --axis) {
    mass.shape.push_back(grid.n_nodes(axis));
    mass.start.push_back(nodes.first[axis]);
    mass.count.push_back(nodes.count[axis]);
  }
  const double inverse_volume = std::pow(grid.inverse_cell_size(), 3);
  mass.fill = [nodes, precision, inverse_volume](GlobalIndex first, GlobalIndex n, std::byte* out) {
    for_each_node(nodes, first, n, [&](const Node& node) {
      const double value = node.c[3] * inverse_volume;
      store_reals(&value, 1, precision, out);
    });
  };

  Array velocity = mass;
  velocity.path = "/grid/velocity";
  velocity.unit = "m/s";
  velocity.meaning = "v_i; zero where there is no mass";
  velocity.shape.push_back(3);
  velocity.start.push_back(0);
  velocity.count.push_back(3);
  velocity.fill = [nodes, precision](GlobalIndex first, GlobalIndex n, std::byte* out) {
    for_each_node(nodes, first, n, [&](const Node& node) {
      constexpr double nothing[3] = {0.0, 0.0, 0.0};
      store_reals(node.c[3] > 0.0 ? node.c : nothing, 3, precision, out);
    });
  };
  return {mass, velocity};
}

namespace {

/// z-planes of tiles that this rank writes; a rank may have none.
struct Planes {
  GlobalIndex first, count;
};

/// `value_of`: of a TileIndex.
template <class ValueOf>
Array tile_array(const char* name, ArrayType type, const GridGeometry& grid, Planes planes, const ValueOf& value_of) {
  Array array;
  array.path = std::string("/tiles/") + name;
  array.type = type;
  array.shape = {grid.n_tiles(2), grid.n_tiles(1), grid.n_tiles(0)};
  array.start = {planes.first, 0, 0};
  array.count = {planes.count, grid.n_tiles(1), grid.n_tiles(0)};
  array.unit = "1";
  array.fill = [grid, planes, value_of](GlobalIndex first, GlobalIndex n, std::byte* out) {
    const int lowest = static_cast<int>(planes.first + first);
    for (int k = lowest; k < lowest + static_cast<int>(n); ++k)
      for (int j = 0; j < grid.n_tiles(1); ++j)
        for (int i = 0; i < grid.n_tiles(0); ++i) {
          const auto value = value_of(grid.tile_index({i, j, k}));
          std::memcpy(out, &value, sizeof(value));
          out += sizeof(value);
        }
  };
  return array;
}

}  // namespace

std::vector<Array> tile_arrays(const Comm& comm, const TileValues& tiles) {
  const GridGeometry& grid = tiles.geometry;
  const EvenShare share = even_share(comm, grid.n_tiles(2));
  const Planes planes{share.first, share.count()};
  BULKLEY_ASSERT(tiles.owners.n_tiles() == grid.n_tiles());
  BULKLEY_ASSERT(tiles.particles.size() == tiles.tile.size() && tiles.load.size() == tiles.tile.size());
  const auto owner_of = [&map = tiles.owners](TileIndex tile) { return map.owner(tile); };
  const auto element_of = [&loaded = tiles.tile](auto values) {
    return [loaded, values](TileIndex tile) {
      const auto found = std::ranges::lower_bound(loaded, tile);
      const bool holds = found != loaded.end() && *found == tile;
      return holds ? values[static_cast<std::size_t>(found - loaded.begin())] : std::remove_cvref_t<decltype(values[0])>{};
    };
  };
  std::vector<Array> arrays{tile_array("rank", ArrayType::int32, grid, planes, owner_of),
                            tile_array("particles", ArrayType::int64, grid, planes, element_of(tiles.particles)),
                            tile_array("load", ArrayType::float64, grid, planes, element_of(tiles.load))};
  arrays[0].meaning = "rank that owns the tile";
  arrays[1].meaning = "particles in the tile";
  arrays[2].meaning = "estimated cost of the tile";
  return arrays;
}

}  // namespace bulkley
