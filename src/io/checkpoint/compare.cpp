#include "io/checkpoint/compare.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include <fmt/format.h>

#include "io/arrays/array_file.hpp"
#include "io/checkpoint/checkpoint.hpp"
#include "io/checkpoint/id_matching.hpp"

namespace bulkley {

namespace {

std::string array_path(const char* name) { return std::string("/particles/") + name; }

std::size_t bytes_of_row(const FieldInfo& field) {
  return element_size(field.type) * static_cast<std::size_t>(field.n_components);
}

/// The arrays of one of the files that are compared, and this rank's share of their rows.
class Side {
 public:
  /// Collective.
  Side(const Comm& comm, const std::string& file, const CheckpointHeader& header)
      : share_(even_share(comm, header.n_particles)), reader_(file) {
    for (StoredArray& array : find_arrays(comm, file, [&](const Hdf5Reader&) {
           std::vector<std::string> paths;
           for (const auto& [name, fingerprint] : header.fingerprints) paths.push_back(array_path(name.c_str()));
           return paths;
         }))
      arrays_.emplace(array.info.path, array);
  }
  bool has(const FieldInfo& field) const { return arrays_.contains(array_path(field.name)); }

  /// Not collective.
  std::vector<std::byte> rows(const FieldInfo& field) {
    const std::size_t row_bytes = bytes_of_row(field);
    std::vector<std::byte> data(static_cast<std::size_t>(share_.count()) * row_bytes);
    reader_.read(arrays_.at(array_path(field.name)), share_.first, share_.count(),
                 [&](GlobalIndex row, GlobalIndex n, const std::byte* rows) {
                   std::memcpy(data.data() + static_cast<std::size_t>(row) * row_bytes, rows,
                               static_cast<std::size_t>(n) * row_bytes);
                 });
    return data;
  }
  std::vector<GlobalIndex> ids() {
    const std::vector<std::byte> data = rows(info(Field::id));
    std::vector<GlobalIndex> ids(data.size() / sizeof(GlobalIndex));
    if (!data.empty()) std::memcpy(ids.data(), data.data(), data.size());
    return ids;
  }

 private:
  EvenShare share_;
  RowReader reader_;
  std::map<std::string, StoredArray> arrays_;
};

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

/// Of two equally large differences, that of the smaller id counts.
void keep_larger(double value, GlobalIndex id, double& largest, GlobalIndex& id_of_largest) {
  if (id_of_largest >= 0 && (value < largest || (value == largest && id >= id_of_largest))) return;
  largest = value;
  id_of_largest = id;
}

void include(double a, double b, GlobalIndex id, FieldDifference& difference) {
  ++difference.n_different;
  double absolute = std::abs(a - b);
  double relative = absolute == 0.0 ? 0.0 : absolute / std::max(std::abs(a), std::abs(b));
  if (!std::isfinite(absolute)) absolute = relative = std::numeric_limits<double>::infinity();
  keep_larger(absolute, id, difference.largest_absolute, difference.absolute_id);
  keep_larger(relative, id, difference.largest_relative, difference.relative_id);
}

/// Compares the rows of the particles that have met on this rank in a round.
void include_round(const FieldInfo& field, const std::vector<Match>& matches, const std::vector<std::byte>& a,
                   const std::vector<std::byte>& b, FieldDifference& difference) {
  const std::size_t size = element_size(field.type), n = static_cast<std::size_t>(field.n_components);
  for (const Match& particle : matches)
    for (std::size_t c = 0; c < n; ++c) {
      const std::size_t i = static_cast<std::size_t>(particle.slot_a) * n + c,
                        j = static_cast<std::size_t>(particle.slot_b) * n + c;
      const double value_a = value_at(a, field.type, i), value_b = value_at(b, field.type, j);
      difference.scale = std::max({difference.scale, std::abs(value_a), std::abs(value_b)});
      if (std::memcmp(a.data() + i * size, b.data() + j * size, size) != 0)
        include(value_a, value_b, particle.id, difference);
    }
}

/// Collective.
FieldDifference compare_field(const Comm& comm, Side& side_a, Side& side_b, const FieldInfo& field,
                              const IdMatching& matching) {
  FieldDifference difference;
  difference.name = field.name;
  difference.unit = field.unit;
  std::vector<std::byte> a, b;
  collective_guard(comm, [&] {
    a = side_a.rows(field);
    b = side_b.rows(field);
  });
  for (std::size_t round = 0; round < matching.n_rounds(); ++round) {
    const std::vector<std::byte> met_a = matching.a().exchange(comm, round, a.data(), bytes_of_row(field));
    const std::vector<std::byte> met_b = matching.b().exchange(comm, round, b.data(), bytes_of_row(field));
    include_round(field, matching.matches(round), met_a, met_b, difference);
  }
  return difference;
}

/// The largest of the ranks' values, and the smallest of the ids that have it; -1 where no rank has one.
void reduce_largest(const Comm& comm, std::vector<double>& largest, std::vector<GlobalIndex>& ids) {
  constexpr GlobalIndex none = std::numeric_limits<GlobalIndex>::max();
  for (std::size_t i = 0; i < ids.size(); ++i)
    if (ids[i] < 0) largest[i] = -1.0;
  const std::vector<double> mine = largest;
  const int n = static_cast<int>(ids.size());
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, largest.data(), n, MPI_DOUBLE, MPI_MAX, comm.get()));
  for (std::size_t i = 0; i < ids.size(); ++i)
    if (ids[i] < 0 || mine[i] != largest[i]) ids[i] = none;
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, ids.data(), n, MPI_INT64_T, MPI_MIN, comm.get()));
  for (std::size_t i = 0; i < ids.size(); ++i)
    if (ids[i] == none) largest[i] = 0.0, ids[i] = -1;
}

/// The ranks' differences made one, on every rank. Collective.
void reduce(const Comm& comm, std::vector<FieldDifference>& fields) {
  std::vector<double> largest, scales;
  std::vector<GlobalIndex> counts, ids;
  for (const FieldDifference& field : fields) {
    counts.push_back(field.n_different);
    scales.push_back(field.scale);
    largest.insert(largest.end(), {field.largest_absolute, field.largest_relative});
    ids.insert(ids.end(), {field.absolute_id, field.relative_id});
  }
  const int n = static_cast<int>(fields.size());
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, counts.data(), n, MPI_INT64_T, MPI_SUM, comm.get()));
  BULKLEY_MPI(MPI_Allreduce(MPI_IN_PLACE, scales.data(), n, MPI_DOUBLE, MPI_MAX, comm.get()));
  reduce_largest(comm, largest, ids);
  for (std::size_t f = 0; f < fields.size(); ++f) {
    fields[f].n_different = counts[f];
    fields[f].scale = scales[f];
    fields[f].largest_absolute = largest[2 * f];
    fields[f].largest_relative = largest[2 * f + 1];
    fields[f].absolute_id = ids[2 * f];
    fields[f].relative_id = ids[2 * f + 1];
  }
}

void expect_once(const std::string& file, const IdMatching::Rest& rest) {
  if (rest.twice >= 0) throw RunError(fmt::format("in '{}' the particle id {} occurs twice", file, rest.twice));
}

bool same_bits(double a, double b) { return std::memcmp(&a, &b, sizeof a) == 0; }

}  // namespace

Comparison compare_checkpoints(const Comm& comm, const std::string& file_a, const std::string& file_b,
                               const ComparisonOptions& options) {
  const CheckpointHeader a = verify_checkpoint(comm, file_a), b = verify_checkpoint(comm, file_b);
  Comparison result{false, a.step, b.step, a.time, b.time, a.n_particles, b.n_particles, 0, 0, -1, -1, {}, {}};
  const bool same_moment = a.step == b.step && same_bits(a.time, b.time);
  if (!options.full && same_moment && a.n_particles == b.n_particles && a.fingerprints == b.fingerprints) {
    result.identical = true;
    return result;
  }
  Side side_a(comm, file_a, a), side_b(comm, file_b, b);
  std::vector<GlobalIndex> ids_a, ids_b;
  collective_guard(comm, [&] {
    ids_a = side_a.ids();
    ids_b = side_b.ids();
  });
  const IdMatching matching(comm, ids_a, ids_b, options.particles_per_round);
  expect_once(file_a, matching.rest_a());
  expect_once(file_b, matching.rest_b());
  result.n_only_a = matching.rest_a().n_only;
  result.first_only_a = matching.rest_a().first_only;
  result.n_only_b = matching.rest_b().n_only;
  result.first_only_b = matching.rest_b().first_only;
  for (const FieldInfo& field : field_table) {
    if (side_a.has(field) && side_b.has(field))
      result.fields.push_back(compare_field(comm, side_a, side_b, field, matching));
    else if (side_a.has(field) || side_b.has(field))
      result.only_in_one.emplace_back(field.name);
  }
  reduce(comm, result.fields);
  result.identical = same_moment && result.n_only_a + result.n_only_b == 0 && result.only_in_one.empty() &&
                     std::all_of(result.fields.begin(), result.fields.end(),
                                 [](const FieldDifference& field) { return field.n_different == 0; });
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
