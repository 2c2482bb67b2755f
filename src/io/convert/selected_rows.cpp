#include "io/convert/selected_rows.hpp"

#include <algorithm>
#include <cstring>

#include <fmt/format.h>

#include "base/hash.hpp"
#include "config/nearest.hpp"
#include "io/arrays/array_file.hpp"
#include "io/checkpoint/checkpoint.hpp"
#include "io/frames/frame.hpp"

namespace bulkley {

namespace {

constexpr GlobalIndex block_rows = GlobalIndex{1} << 15;
constexpr GlobalIndex portion_bytes = GlobalIndex{16} << 20;
constexpr const char* group = "/particles/";

/// Refuses what is neither frame nor checkpoint: that is wrong input, not a damaged file.
void check_kind(const Hdf5Reader& file) {
  const std::string kind = file.has_attribute("/", "format") ? file.text("/", "format") : "";
  if (kind == frame_format) return check_format(file, kind, frame_version);
  if (kind == checkpoint_format) return check_format(file, kind, checkpoint_version);
  throw UsageError(fmt::format("{}: is neither a frame nor a checkpoint{}", file.path(),
                               kind.empty() ? "" : fmt::format(", but a '{}'", kind)));
}

Column column_of(const Hdf5Reader& file, const std::string& name, GlobalIndex n_particles) {
  Column column{name, "", file.array(group + name), 1};
  const Extents& shape = column.array.shape;
  if (shape.empty() || shape[0] != n_particles)
    throw RunError(fmt::format("cannot read '{}': {} has not one row a particle", file.path(), column.array.path));
  for (std::size_t axis = 1; axis < shape.size(); ++axis) column.n_components *= static_cast<int>(shape[axis]);
  if (const std::string unit = file.text(column.array.path, "unit"); unit != "1") column.unit = unit;
  return column;
}

bool is_real(ArrayType type) { return type == ArrayType::float32 || type == ArrayType::float64; }

std::vector<std::string> field_names(const Hdf5Reader& file) {
  std::vector<std::string> names = file.members("/particles");
  std::erase_if(names, [](const std::string& name) { return name == "position" || name == "connectivity"; });
  std::stable_partition(names.begin(), names.end(), [](const std::string& name) { return name == "id"; });
  return names;
}

std::vector<std::string> wanted_names(const Hdf5Reader& file, const Selection& selection) {
  std::vector<std::string> known = field_names(file);
  if (selection.fields.empty()) return known;
  std::vector<std::string> names;
  for (const std::string& name : selection.fields) {
    if (name == "position") continue;  // is always written
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw UsageError(
          fmt::format("--fields: '{}' has no field '{}'{}", file.path(), name, config::suggestion(name, known)));
    if (std::find(names.begin(), names.end(), name) != names.end())
      throw UsageError(fmt::format("--fields: '{}' is named twice", name));
    names.push_back(name);
  }
  return names;
}

bool has_region(const Selection& selection) {
  return !(selection.region.lower.array() == -std::numeric_limits<double>::infinity()).all() ||
         !(selection.region.upper.array() == std::numeric_limits<double>::infinity()).all();
}

double coordinate(const std::byte* row, ArrayType type, int axis) {
  if (type == ArrayType::float32) {
    float value;
    std::memcpy(&value, row + axis * sizeof value, sizeof value);
    return value;
  }
  double value;
  std::memcpy(&value, row + axis * sizeof value, sizeof value);
  return value;
}

bool is_in(const Bounds& region, const std::byte* row, ArrayType type) {
  for (int axis = 0; axis < 3; ++axis)
    if (const double x = coordinate(row, type, axis); !(x >= region.lower[axis] && x < region.upper[axis])) return false;
  return true;
}

}  // namespace

bool is_chosen(GlobalIndex id, GlobalIndex every) {
  return splitmix64(static_cast<std::uint64_t>(id)) % static_cast<std::uint64_t>(every) == 0;
}

Snapshot read_moment(const Hdf5Reader& file, const Selection& selection) {
  check_kind(file);
  Snapshot snapshot;
  snapshot.time = file.real("/", "time");
  snapshot.step = file.integer("/", "step");
  snapshot.n_particles = file.integer("/", "n_particles");
  snapshot.position = column_of(file, "position", snapshot.n_particles);
  if (!is_real(snapshot.position.array.type) || snapshot.position.n_components != 3)
    throw RunError(fmt::format("cannot read '{}': its positions are not three numbers a particle", file.path()));
  for (const std::string& name : wanted_names(file, selection))
    snapshot.fields.push_back(column_of(file, name, snapshot.n_particles));
  if (selection.every > 1) {
    if (!file.has("/particles/id"))
      throw UsageError(fmt::format(
          "--every: '{}' does not contain the ids of its particles, by which they are selected: add \"id\" to output.fields",
          file.path()));
    if (file.array("/particles/id").type != ArrayType::int64)
      throw RunError(fmt::format("cannot read '{}': its ids are not 64-bit integers", file.path()));
  }
  return snapshot;
}

std::vector<std::string> arrays_read(const Snapshot& snapshot, const Selection& selection) {
  std::vector<std::string> paths{snapshot.position.array.path};
  for (const Column& column : snapshot.fields) paths.push_back(column.array.path);
  const std::string ids = std::string(group) + "id";
  if (selection.every > 1 && std::find(paths.begin(), paths.end(), ids) == paths.end()) paths.push_back(ids);
  return paths;
}

GlobalIndex rows_at_a_time(GlobalIndex row_bytes) { return std::max<GlobalIndex>(1, portion_bytes / row_bytes); }

SelectedRows::SelectedRows(const Hdf5Reader& file, const Snapshot& snapshot, const Selection& selection, GlobalIndex first,
                           GlobalIndex last)
    : file_(file), first_(first), last_(last), taken_(static_cast<std::size_t>(last - first), true), before_{0} {
  std::vector<std::byte> positions, ids;
  for (GlobalIndex block = 0; block * block_rows < last - first; ++block) {
    if (has_region(selection)) read_block(snapshot.position.array, block, positions);
    if (selection.every > 1) read_block(file.array(std::string(group) + "id"), block, ids);
    take(positions, ids, snapshot, selection, block);
  }
}

GlobalIndex SelectedRows::block_end(GlobalIndex block) const { return std::min((block + 1) * block_rows, last_ - first_); }

void SelectedRows::read_block(const ArrayInfo& array, GlobalIndex block, std::vector<std::byte>& rows) const {
  Extents start(array.shape.size(), 0), count = array.shape;
  start[0] = first_ + block * block_rows;
  count[0] = block_end(block) - block * block_rows;
  rows.resize(static_cast<std::size_t>(n_elements(count)) * element_size(array.type));
  file_.read(array, start, count, rows.data());
}

void SelectedRows::take(const std::vector<std::byte>& positions, const std::vector<std::byte>& ids, const Snapshot& snapshot,
                        const Selection& selection, GlobalIndex block) {
  const bool by_place = has_region(selection);
  const ArrayType type = snapshot.position.array.type;
  const std::size_t position_bytes = 3 * element_size(type);
  const GlobalIndex begin = block * block_rows;
  GlobalIndex n_taken = 0;
  for (GlobalIndex row = begin; row < block_end(block); ++row) {
    const auto at = static_cast<std::size_t>(row - begin);
    bool taken = !by_place || is_in(selection.region, positions.data() + at * position_bytes, type);
    if (taken && selection.every > 1) {
      GlobalIndex id;
      std::memcpy(&id, ids.data() + at * sizeof id, sizeof id);
      taken = is_chosen(id, selection.every);
    }
    taken_[static_cast<std::size_t>(row)] = taken;
    n_taken += taken ? 1 : 0;
  }
  before_.push_back(before_.back() + n_taken);
}

void SelectedRows::read(const Column& column, GlobalIndex first, GlobalIndex n, std::byte* out) const {
  if (n == 0) return;
  const auto row_bytes = static_cast<std::size_t>(column.row_bytes());
  // The block in which taken row `first` lies: the last that begins at or before it.
  GlobalIndex block = std::upper_bound(before_.begin(), before_.end(), first) - before_.begin() - 1;
  GlobalIndex taken = before_[static_cast<std::size_t>(block)];
  std::vector<std::byte> rows;
  for (; taken < first + n; ++block) {
    read_block(column.array, block, rows);
    const GlobalIndex begin = block * block_rows;
    for (GlobalIndex row = begin; row < block_end(block) && taken < first + n; ++row) {
      if (!taken_[static_cast<std::size_t>(row)]) continue;
      if (taken >= first) {
        std::memcpy(out, rows.data() + static_cast<std::size_t>(row - begin) * row_bytes, row_bytes);
        out += row_bytes;
      }
      ++taken;
    }
  }
}

}  // namespace bulkley
