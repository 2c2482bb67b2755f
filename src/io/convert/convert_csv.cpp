// A table as text: every number in the fewest digits that give it back.

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <iterator>

#include "io/convert/selected_rows.hpp"
#include "io/files/placed_file.hpp"

namespace bulkley {

namespace {

/// The columns in the order of the file: the id if it is wanted, the position, the other fields.
std::vector<const Column*> columns_of(const Snapshot& snapshot) {
  std::vector<const Column*> columns{&snapshot.position};
  for (const Column& column : snapshot.fields)
    columns.insert(column.name == "id" ? columns.begin() : columns.end(), &column);
  return columns;
}

std::string component_name(int component, int n_components) {
  static const char* const vector[] = {"x", "y", "z"};
  static const char* const symmetric[] = {"xx", "yy", "zz", "xy", "yz", "xz"};
  if (n_components == 1) return "";
  if (n_components == 3) return fmt::format("_{}", vector[component]);
  if (n_components == 6) return fmt::format("_{}", symmetric[component]);
  if (n_components == 9) return fmt::format("_{}{}", vector[component / 3], vector[component % 3]);
  return fmt::format("_{}", component);
}

std::string header_of(const std::vector<const Column*>& columns) {
  std::string text;
  for (const Column* column : columns)
    for (int c = 0; c < column->n_components; ++c)
      text += fmt::format("{}{}{}{}", text.empty() ? "" : ",", column->name, component_name(c, column->n_components),
                          column->unit.empty() ? "" : fmt::format(" [{}]", column->unit));
  return text + "\n";
}

template <class Number>
void append(std::string& text, const std::byte* value) {
  Number number;
  std::memcpy(&number, value, sizeof number);
  fmt::format_to(std::back_inserter(text), "{}", number);
}

void append_value(std::string& text, ArrayType type, const std::byte* value) {
  switch (type) {
    case ArrayType::float32:
      return append<float>(text, value);
    case ArrayType::float64:
      return append<double>(text, value);
    case ArrayType::int32:
      return append<std::int32_t>(text, value);
    case ArrayType::int64:
      return append<GlobalIndex>(text, value);
    case ArrayType::uint8:
      return append<std::uint8_t>(text, value);
  }
}

void append_row(std::string& text, const std::vector<const Column*>& columns,
                const std::vector<std::vector<std::byte>>& values, std::size_t row) {
  const std::size_t begin = text.size();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const ArrayType type = columns[i]->array.type;
    const std::byte* at = values[i].data() + row * static_cast<std::size_t>(columns[i]->row_bytes());
    for (int c = 0; c < columns[i]->n_components; ++c, at += element_size(type)) {
      if (text.size() > begin) text += ',';
      append_value(text, type, at);
    }
  }
  text += '\n';
}

/// Calls `sink(lines)` with the lines of this rank, some at a time.
void for_each_text(const Share& share, const std::vector<const Column*>& columns,
                   const std::function<void(const std::string&)>& sink) {
  constexpr GlobalIndex letters_per_byte = 4;  // of a value in memory, nearly: text takes more than the value
  GlobalIndex row_bytes = 0;
  for (const Column* column : columns) row_bytes += column->row_bytes();
  const GlobalIndex step = rows_at_a_time(letters_per_byte * row_bytes);
  std::vector<std::vector<std::byte>> values(columns.size());
  std::string text;
  for (GlobalIndex first = 0; first < share.rows.count(); first += step) {
    const GlobalIndex n = std::min(step, share.rows.count() - first);
    for (std::size_t i = 0; i < columns.size(); ++i) {
      values[i].resize(static_cast<std::size_t>(n * columns[i]->row_bytes()));
      share.rows.read(*columns[i], first, n, values[i].data());
    }
    text.clear();
    for (std::size_t row = 0; row < static_cast<std::size_t>(n); ++row) append_row(text, columns, values, row);
    sink(text);
  }
}

}  // namespace

void write_csv(const Comm& comm, const std::string& path, const Share& share) {
  const std::vector<const Column*> columns = columns_of(share.snapshot);
  const std::string header = header_of(columns);
  // Where a rank's lines begin is known only when those before have been made: they are made twice, and never kept.
  GlobalIndex bytes = comm.is_root() ? static_cast<GlobalIndex>(header.size()) : 0;
  collective_guard(comm, [&] {
    for_each_text(share, columns, [&](const std::string& text) { bytes += static_cast<GlobalIndex>(text.size()); });
  });
  GlobalIndex place = exclusive_sum(comm, bytes);
  write_in_places(comm, path, sum_global(comm, bytes), [&](const PlacedFile& file) {
    const auto put = [&](const std::string& text) {
      file.write(text.data(), static_cast<GlobalIndex>(text.size()), place);
      place += static_cast<GlobalIndex>(text.size());
    };
    if (comm.is_root()) put(header);
    for_each_text(share, columns, put);
  });
}

}  // namespace bulkley
