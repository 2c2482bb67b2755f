#include "io/checkpoint/compare.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>

#include <fmt/format.h>

#include "io/arrays/array_file.hpp"
#include "io/checkpoint/checkpoint.hpp"

namespace bulkley {

namespace {

std::string array_path(const char* name) { return std::string("/particles/") + name; }

std::vector<std::byte> read_whole(const Hdf5Reader& file, const std::string& path) {
  const ArrayInfo array = file.array(path);
  std::vector<std::byte> data(static_cast<std::size_t>(n_elements(array.shape)) * element_size(array.type));
  file.read(array, Extents(array.shape.size(), 0), array.shape, data.data());
  return data;
}

/// Ids in ascending order and their rows.
struct Ids {
  std::vector<GlobalIndex> id;
  std::vector<GlobalIndex> row;
};

Ids sorted_ids(const Hdf5Reader& file) {
  const std::vector<std::byte> data = read_whole(file, array_path(info(Field::id).name));
  std::vector<GlobalIndex> stored(data.size() / sizeof(GlobalIndex));
  if (!data.empty()) std::memcpy(stored.data(), data.data(), data.size());
  Ids ids;
  ids.row.resize(stored.size());
  std::iota(ids.row.begin(), ids.row.end(), GlobalIndex{0});
  const auto id_of = [&](GlobalIndex row) { return stored[static_cast<std::size_t>(row)]; };
  std::sort(ids.row.begin(), ids.row.end(), [&](GlobalIndex a, GlobalIndex b) { return id_of(a) < id_of(b); });
  for (const GlobalIndex row : ids.row) ids.id.push_back(id_of(row));
  const auto twice = std::adjacent_find(ids.id.begin(), ids.id.end());
  if (twice != ids.id.end()) throw RunError(fmt::format("in '{}' the particle id {} occurs twice", file.path(), *twice));
  return ids;
}

struct Match {
  GlobalIndex id, row_a, row_b;
};

std::vector<Match> match(const Ids& a, const Ids& b, Comparison& result) {
  std::vector<Match> both;
  const auto only = [](GlobalIndex id, GlobalIndex& n, GlobalIndex& first) {
    if (n++ == 0) first = id;
  };
  std::size_t i = 0, j = 0;
  while (i < a.id.size() || j < b.id.size()) {
    if (j == b.id.size() || (i < a.id.size() && a.id[i] < b.id[j]))
      only(a.id[i++], result.n_only_a, result.first_only_a);
    else if (i == a.id.size() || b.id[j] < a.id[i])
      only(b.id[j++], result.n_only_b, result.first_only_b);
    else {
      both.push_back({a.id[i], a.row[i], b.row[j]});
      ++i, ++j;
    }
  }
  return both;
}

double value_at(const std::vector<std::byte>& data, FieldType type, std::size_t element) {
  if (type == FieldType::uint8) return static_cast<double>(data[element]);
  if (type == FieldType::int64) {
    GlobalIndex value = 0;
    std::memcpy(&value, data.data() + element * sizeof value, sizeof value);
    return static_cast<double>(value);
  }
  double value = 0.0;
  std::memcpy(&value, data.data() + element * sizeof value, sizeof value);
  return value;
}

void include(double a, double b, GlobalIndex id, FieldDifference& difference) {
  ++difference.n_different;
  double absolute = std::abs(a - b);
  double relative = absolute == 0.0 ? 0.0 : absolute / std::max(std::abs(a), std::abs(b));
  if (!std::isfinite(absolute)) absolute = relative = std::numeric_limits<double>::infinity();
  if (difference.absolute_id < 0 || absolute > difference.largest_absolute) {
    difference.largest_absolute = absolute;
    difference.absolute_id = id;
  }
  if (difference.relative_id < 0 || relative > difference.largest_relative) {
    difference.largest_relative = relative;
    difference.relative_id = id;
  }
}

FieldDifference compare_field(const Hdf5Reader& file_a, const Hdf5Reader& file_b, const FieldInfo& field,
                              const std::vector<Match>& matches) {
  FieldDifference difference;
  difference.name = field.name;
  difference.unit = field.unit;
  const std::vector<std::byte> a = read_whole(file_a, array_path(field.name)),
                               b = read_whole(file_b, array_path(field.name));
  const std::size_t size = element_size(field.type), n = static_cast<std::size_t>(field.n_components);
  for (const Match& particle : matches) {
    for (std::size_t c = 0; c < n; ++c) {
      const std::size_t i = static_cast<std::size_t>(particle.row_a) * n + c,
                        j = static_cast<std::size_t>(particle.row_b) * n + c;
      const double value_a = value_at(a, field.type, i), value_b = value_at(b, field.type, j);
      difference.scale = std::max({difference.scale, std::abs(value_a), std::abs(value_b)});
      if (std::memcmp(a.data() + i * size, b.data() + j * size, size) != 0)
        include(value_a, value_b, particle.id, difference);
    }
  }
  return difference;
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

Comparison compare_checkpoints(const Comm& comm, const std::string& file_a, const std::string& file_b) {
  const CheckpointHeader a = verify_checkpoint(comm, file_a), b = verify_checkpoint(comm, file_b);
  Comparison result{false, a.step, b.step, a.time, b.time, a.n_particles, b.n_particles, 0, 0, -1, -1, {}, {}};
  root_guard(comm, [&] {
    const Hdf5Reader reader_a(file_a), reader_b(file_b);
    const std::vector<Match> matches = match(sorted_ids(reader_a), sorted_ids(reader_b), result);
    for (const FieldInfo& field : field_table) {
      if (!field.written) continue;
      const bool in_a = reader_a.has(array_path(field.name)), in_b = reader_b.has(array_path(field.name));
      if (in_a && in_b)
        result.fields.push_back(compare_field(reader_a, reader_b, field, matches));
      else if (in_a || in_b)
        result.only_in_one.emplace_back(field.name);
    }
    result.identical = a.step == b.step && same_bits(a.time, b.time) && result.n_only_a + result.n_only_b == 0 &&
                       result.only_in_one.empty() &&
                       std::all_of(result.fields.begin(), result.fields.end(),
                                   [](const FieldDifference& field) { return field.n_different == 0; });
  });
  int identical = result.identical;
  BULKLEY_MPI(MPI_Bcast(&identical, 1, MPI_INT, 0, comm.get()));
  result.identical = identical != 0;
  return result;
}

bool within(const Comparison& comparison, double tolerance) {
  return comparison.step_a == comparison.step_b && comparison.n_only_a + comparison.n_only_b == 0 &&
         comparison.only_in_one.empty() &&
         std::abs(comparison.time_a - comparison.time_b) <= tolerance * std::abs(comparison.time_a) &&
         std::all_of(comparison.fields.begin(), comparison.fields.end(),
                     [&](const FieldDifference& field) { return field.largest_absolute <= tolerance * field.scale; });
}

std::string comparison_text(const Comparison& comparison) {
  if (comparison.identical) return "identical\n";
  std::string text;
  if (comparison.step_a != comparison.step_b) text += fmt::format("step: {} and {}\n", comparison.step_a, comparison.step_b);
  if (!same_bits(comparison.time_a, comparison.time_b))
    text += fmt::format("time: {} and {} s\n", comparison.time_a, comparison.time_b);
  if (comparison.n_only_a > 0)
    text +=
        fmt::format("{} particles only in the first file, smallest id {}\n", comparison.n_only_a, comparison.first_only_a);
  if (comparison.n_only_b > 0)
    text +=
        fmt::format("{} particles only in the second file, smallest id {}\n", comparison.n_only_b, comparison.first_only_b);
  for (const std::string& name : comparison.only_in_one) text += fmt::format("{}: only in one of the files\n", name);
  for (const FieldDifference& field : comparison.fields)
    if (field.n_different > 0)
      text += fmt::format("{}: {} values differ, by at most {:.3g} {} (particle {}), relatively {:.3g} (particle {})\n",
                          field.name, field.n_different, field.largest_absolute, field.unit, field.absolute_id,
                          field.largest_relative, field.relative_id);
  return text;
}

}  // namespace bulkley
