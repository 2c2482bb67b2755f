#include "io/status/history.hpp"

#include <charconv>
#include <filesystem>

#include <fmt/format.h>

#include "io/files/text_file.hpp"

namespace bulkley {

namespace {

/// A cell by RFC 4180: quoted where it holds a comma, quote or line break.
std::string cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string cell(const HistoryValue& value) {
  if (const auto* text = std::get_if<std::string>(&value)) return cell(*text);
  if (const auto* real = std::get_if<double>(&value)) return fmt::format("{}", *real);
  return fmt::format("{}", std::get<GlobalIndex>(value));
}

template <class Value>
std::string line_of(const std::vector<Value>& values) {
  std::string line;
  for (const Value& value : values) line += (line.empty() ? "" : ",") + cell(value);
  return line + "\n";
}

/// `text` without rows of steps beyond `step` and without a last row cut short.
std::string cut_rows(const std::string& path, const std::string& text, GlobalIndex step) {
  std::size_t end = text.find('\n') + 1;
  std::string kept = text.substr(0, end);
  for (std::size_t start = end; (end = text.find('\n', start)) != std::string::npos; start = end + 1) {
    GlobalIndex row_step = 0;
    const auto [stop, error] = std::from_chars(text.data() + start, text.data() + end, row_step);
    if (error != std::errc() || *stop != ',')
      throw RunError(fmt::format("cannot go on with '{}': a row does not begin with a step: '{}'", path,
                                 text.substr(start, end - start)));
    if (row_step <= step) kept += text.substr(start, end + 1 - start);
  }
  return kept;
}

}  // namespace

History::History(const Comm& comm, const std::string& folder, std::vector<std::string> columns, GlobalIndex restart_step)
    : path_(path_in(folder, "history.csv")), n_columns_(columns.size()) {
  root_guard(comm, [&] {
    const std::string header = line_of(columns);
    std::string table = header;
    if (restart_step >= 0 && std::filesystem::exists(path_)) {
      const std::string found = read_text(path_);
      if (!found.starts_with(header))
        throw RunError(
            fmt::format("cannot go on with '{}': its columns are not those of this program; move it away to begin "
                        "a new one",
                        path_));
      table = cut_rows(path_, found, restart_step);
    }
    write_text_atomically(path_, table);
    file_.open(path_);
  });
}

void History::write(const Comm& comm, const std::vector<HistoryValue>& row) {
  root_guard(comm, [&] {
    if (row.size() != n_columns_)
      throw RunError(fmt::format("a row of {} values for the {} columns of '{}'", row.size(), n_columns_, path_));
    file_.append(line_of(row));
  });
}

void History::sync(const Comm& comm) {
  root_guard(comm, [&] { file_.sync(); });
}

}  // namespace bulkley
