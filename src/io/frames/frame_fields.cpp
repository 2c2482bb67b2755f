#include "io/frames/frame_fields.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <iterator>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "bulkley/base/tensor.hpp"

namespace bulkley {

namespace {

/// A real quantity of one particle, up to nine components.
struct RealField {
  const char* name;
  const char* unit;
  const char* meaning;
  int n_components;
  void (*evaluate)(const ParticleSet& particles, LocalIndex p, double* out);
};

SymTensor<double> kirchhoff_stress(const ParticleSet& particles, LocalIndex p) {
  SymTensor<double> tau;
  for (int c = 0; c < 6; ++c) tau.c[c] = particles.real(Field::kirchhoff_stress, c)[p];
  return tau;
}

void expand(const SymTensor<double>& t, double factor, double* out) {
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3; ++b) out[3 * a + b] = factor * t(a, b);
}

double inverse_volume_ratio(const ParticleSet& particles, LocalIndex p) {
  return 1.0 / particles.real(Field::volume_ratio)[p];
}

void pressure(const ParticleSet& particles, LocalIndex p, double* out) {
  out[0] = -trace(kirchhoff_stress(particles, p)) / 3.0 * inverse_volume_ratio(particles, p);
}
void deviatoric_stress(const ParticleSet& particles, LocalIndex p, double* out) {
  out[0] = std::sqrt(norm_squared(deviator(kirchhoff_stress(particles, p)))) * inverse_volume_ratio(particles, p);
}
void cauchy_stress(const ParticleSet& particles, LocalIndex p, double* out) {
  expand(kirchhoff_stress(particles, p), inverse_volume_ratio(particles, p), out);
}
void density(const ParticleSet& particles, LocalIndex p, double* out) {
  out[0] = particles.real(Field::mass)[p] / particles.real(Field::reference_volume)[p] * inverse_volume_ratio(particles, p);
}

// In the order of derived_frame_fields, of which the last is no real number.
constexpr RealField derived_fields[] = {
    {derived_frame_fields[0], "Pa", "-tr(tau) / (3 J)", 1, pressure},
    {derived_frame_fields[1], "Pa", "||dev tau|| / J", 1, deviatoric_stress},
    {derived_frame_fields[2], "Pa", "tau / J, row-major", 9, cauchy_stress},
    {derived_frame_fields[3], "kg/m^3", "m_p / (V_p^0 J)", 1, density},
};
constexpr const char* rank_field = derived_frame_fields.back();
static_assert(std::size(derived_fields) + 1 == derived_frame_fields.size());

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

ArrayType real_type(FloatPrecision precision) {
  return precision == FloatPrecision::float32 ? ArrayType::float32 : ArrayType::float64;
}

Array derived_array(const RealField& field, FloatPrecision precision, const ParticleRange& range,
                    const ParticleSet& particles) {
  Array array = particle_array(field.name, real_type(precision), field.n_components, range);
  array.unit = field.unit;
  array.meaning = field.meaning;
  array.fill = [field, precision, &particles](GlobalIndex first, GlobalIndex n, std::byte* out) {
    double values[9];
    for (GlobalIndex p = first; p < first + n; ++p) {
      field.evaluate(particles, static_cast<LocalIndex>(p), values);
      store_reals(values, field.n_components, precision, out);
    }
  };
  return array;
}

Array rank_array(const ParticleRange& range, std::int32_t rank) {
  Array array = particle_array(rank_field, ArrayType::int32, 1, range);
  array.unit = "1";
  array.meaning = "rank that holds the particle";
  array.fill = [rank](GlobalIndex, GlobalIndex n, std::byte* out) {
    std::fill_n(reinterpret_cast<std::int32_t*>(out), n, rank);
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
                  const ParticleSet& particles, std::int32_t rank) {
  for (const FieldInfo& field : field_table) {
    if (!field.written || name != field.name) continue;
    if (particles.has(field.field)) return table_array(field, precision, range, particles);
    throw UsageError(fmt::format("output.fields: '{}' is a variable that no particle here has ({})", name, field.meaning));
  }
  for (const RealField& field : derived_fields)
    if (name == field.name) return derived_array(field, precision, range, particles);
  if (name == rank_field) return rank_array(range, rank);
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

template <class Value>
Array tile_array(const char* name, ArrayType type, const GridGeometry& grid, Planes planes, std::span<const Value> values) {
  BULKLEY_ASSERT(std::ssize(values) == grid.n_tiles());
  Array array;
  array.path = std::string("/tiles/") + name;
  array.type = type;
  array.shape = {grid.n_tiles(2), grid.n_tiles(1), grid.n_tiles(0)};
  array.start = {planes.first, 0, 0};
  array.count = {planes.count, grid.n_tiles(1), grid.n_tiles(0)};
  array.unit = "1";
  array.fill = [grid, planes, values](GlobalIndex first, GlobalIndex n, std::byte* out) {
    const int lowest = static_cast<int>(planes.first + first);
    for (int k = lowest; k < lowest + static_cast<int>(n); ++k)
      for (int j = 0; j < grid.n_tiles(1); ++j)
        for (int i = 0; i < grid.n_tiles(0); ++i, out += sizeof(Value))
          std::memcpy(out, &values[static_cast<std::size_t>(grid.tile_index({i, j, k}))], sizeof(Value));
  };
  return array;
}

}  // namespace

std::vector<Array> tile_arrays(const Comm& comm, const TileValues& tiles) {
  const GridGeometry& grid = tiles.geometry;
  const EvenShare share = even_share(comm, grid.n_tiles(2));
  const Planes planes{share.first, share.count()};
  std::vector<Array> arrays{tile_array("rank", ArrayType::int32, grid, planes, tiles.rank),
                            tile_array("particles", ArrayType::int64, grid, planes, tiles.particles),
                            tile_array("load", ArrayType::float64, grid, planes, tiles.load)};
  arrays[0].meaning = "rank that works on the tile";
  arrays[1].meaning = "particles in the tile";
  arrays[2].meaning = "estimated cost of the tile";
  return arrays;
}

}  // namespace bulkley
