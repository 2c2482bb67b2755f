#include "program/history_reader.hpp"

#include <algorithm>
#include <charconv>
#include <limits>

#include "io/files/text_file.hpp"

namespace bulkley {

namespace {

constexpr std::size_t buffer_bytes = 1 << 18;

}  // namespace

HistoryReader::HistoryReader(const std::string& folder) : buffer_(buffer_bytes) {
  file_.rdbuf()->pubsetbuf(buffer_.data(), static_cast<std::streamsize>(buffer_.size()));
  file_.open(path_in(folder, "history.csv"), std::ios::binary);
  if (!next_line()) return;
  split();
  columns_.assign(cells_.begin(), cells_.end());
}

int HistoryReader::find(std::string_view name) const {
  const auto found = std::find(columns_.begin(), columns_.end(), name);
  return found == columns_.end() ? -1 : static_cast<int>(found - columns_.begin());
}

bool HistoryReader::skip_to_last(std::size_t bytes) {
  const std::streamoff here = file_.tellg();
  if (here < 0) return false;
  file_.seekg(0, std::ios::end);
  const std::streamoff target = static_cast<std::streamoff>(file_.tellg()) - static_cast<std::streamoff>(bytes);
  file_.seekg(std::max(here, target));
  if (target <= here) return false;
  next_line();  // from the middle of a row
  return true;
}

bool HistoryReader::next_line() {
  return static_cast<bool>(std::getline(file_, line_)) && !file_.eof();  // at the end of the file: no line break
}

bool HistoryReader::split() {
  cells_.clear();
  std::string_view rest = line_;
  while (true) {
    const std::size_t comma = rest.find(',');
    cells_.push_back(rest.substr(0, comma));
    if (comma == std::string_view::npos) break;
    rest.remove_prefix(comma + 1);
  }
  return cells_.size() == columns_.size();
}

bool HistoryReader::next() {
  while (next_line())
    if (split()) return true;
  return false;
}

std::string_view HistoryReader::text(int column) const {
  return column < 0 ? std::string_view() : cells_[static_cast<std::size_t>(column)];
}

double HistoryReader::number(int column) const {
  const std::string_view cell = text(column);
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc{} ? value : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace bulkley
