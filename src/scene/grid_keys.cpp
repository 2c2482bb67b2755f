#include "scene/grid_keys.hpp"

#include <fmt/format.h>

#include <cmath>
#include <limits>

namespace bulkley {
namespace {

using config::Faults;
using config::Value;

constexpr int fewest_cells = 4;

/// `count` cells rounded to the nearest multiple of `step`, at least the fewest allowed.
double usable_count(double count, int step) {
  return std::max(static_cast<double>(fewest_cells), std::round(count / step) * step);
}

/// "'domain.upper' must leave ... along x: <what is wrong>; 1.05 (21 cells) would fit".
void suggest_size(const Value& domain, const char* wanted, int axis, double lower, double size, double cell_size, int step,
                  Faults& faults) {
  const double count = usable_count(size / cell_size, step);
  faults.add(
      domain.find("upper")->place,
      fmt::format(
          "the domain is {:.10g} cells of {} m long along {}; it must be {}: '{}.upper' = {:.12g} ({} cells) along {} "
          "would fit",
          size / cell_size, cell_size, "xyz"[axis], wanted, domain.path, lower + count * cell_size, count, "xyz"[axis]));
}

}  // namespace

const config::Keys<DomainInput>& keys(config::Of<DomainInput>) {
  static const auto table = config::Keys<DomainInput>(
                                "The simulated box, and the grid that fills it. Every side is a whole "
                                "number of cells, at least 4; "
                                "along periodic axes a multiple of 4, or 1 for a plane flow.")
                                .key("lower", &DomainInput::lower, {.about = "Lower corner.", .unit = "m", .required = true})
                                .key("upper", &DomainInput::upper, {.about = "Upper corner.", .unit = "m", .required = true})
                                .key("cell_size", &DomainInput::cell_size,
                                     {.about = "Grid spacing, the same along all axes.",
                                      .unit = "m",
                                      .range = config::between(1e-12, 1e12),  // its powers must be numbers
                                      .required = true});
  return table;
}

void check_number_of_cells(const Value& domain, const GridGeometry& grid, Faults& faults) {
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    const int n = grid.n_cells[a];
    const auto refuse = [&](const char* wanted, int step) {
      suggest_size(domain, wanted, axis, grid.lower[axis], n * grid.cell_size, grid.cell_size, step, faults);
    };
    if (grid.periodic[a] && n != 1 && n % tile_width != 0)
      refuse("a multiple of 4 cells because the axis is periodic, or one cell for a plane flow", tile_width);
    else if (!grid.periodic[a] && n < fewest_cells)
      refuse(n == 1 ? "at least 4 cells, or have periodic faces for a plane flow" : "at least 4 cells", 1);
  }
}

namespace config {

bool Codec<GridGeometry>::read(const Value& value, const Rule&, GridGeometry& out, Faults& faults) {
  DomainInput input;
  if (!keys(Of<DomainInput>{}).read(value, input, faults)) return false;
  const std::size_t faults_before = faults.size();
  constexpr double tolerance = 1e-9;      // of the number of cells: what decimal input leaves over
  constexpr double most_cells = 1 << 20;  // per axis, far below what the tile index holds
  constexpr double farthest = 1e9;        // cells from the origin: positions must resolve a cell finely
  out.lower = input.lower;
  out.cell_size = input.cell_size;
  double n_tiles = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double size = input.upper[axis] - input.lower[axis];
    const double count = size / input.cell_size, whole = std::round(count);
    if (!(size > 0.0))
      faults.add(value.find("upper")->place, fmt::format("'{}.upper' = {} along {}; it must be greater than 'lower' = {}",
                                                         value.path, input.upper[axis], "xyz"[axis], input.lower[axis]));
    else if (!(std::max(std::abs(input.lower[axis]), std::abs(input.upper[axis])) <= farthest * input.cell_size))
      faults.add(value.find("lower")->place,
                 fmt::format("'{}' reaches from {} to {} along {}; it must lie within {:g} cells of {} m of the origin",
                             value.path, input.lower[axis], input.upper[axis], "xyz"[axis], farthest, input.cell_size));
    else if (!(whole <= most_cells))
      faults.add(value.find("cell_size")->place,
                 fmt::format("'{}.cell_size' = {} gives {:.6g} cells along {}; it must give at most {}", value.path,
                             input.cell_size, whole, "xyz"[axis], most_cells));
    else if (std::abs(count - whole) > tolerance * std::max(whole, 1.0))
      suggest_size(value, "a whole number of cells", axis, input.lower[axis], size, input.cell_size, 1, faults);
    else
      out.n_cells[static_cast<std::size_t>(axis)] = static_cast<int>(whole);
    n_tiles *= whole / tile_width + 2.0;  // the padding adds up to two tiles
  }
  if (faults.size() == faults_before && n_tiles > std::numeric_limits<TileIndex>::max())
    faults.add(
        value.find("cell_size")->place,
        fmt::format("'{}.cell_size' = {} gives {} x {} x {} cells; the grid must have fewer than 2^31 tiles of 4 x 4 x 4",
                    value.path, input.cell_size, out.n_cells[0], out.n_cells[1], out.n_cells[2]));
  return faults.size() == faults_before;
}

Value Codec<GridGeometry>::write(const GridGeometry& grid) {
  // The upper corner only gives the number of cells, so a rounded value is enough.
  DomainInput input{grid.lower, grid.upper(), grid.cell_size};
  for (int axis = 0; axis < 3; ++axis) input.upper[axis] = std::stod(fmt::format("{:.14g}", input.upper[axis]));
  return keys(Of<DomainInput>{}).write(input);
}

void Codec<GridGeometry>::describe(const std::string& path, std::vector<TableText>& out) {
  keys(Of<DomainInput>{}).describe("[" + path + "]", path, out);
}

}  // namespace config
}  // namespace bulkley
