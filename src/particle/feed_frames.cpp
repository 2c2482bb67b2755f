#include "particle/feed_frames.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <sstream>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

std::string without_spaces(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// The five numbers of a row; false where it holds anything else.
bool read_row(const std::string& row, std::array<double, 5>& numbers) {
  std::istringstream cells(row);
  std::string cell;
  std::size_t n = 0;
  while (std::getline(cells, cell, ',')) {
    const std::string text = without_spaces(cell);
    if (n == numbers.size()) return false;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), numbers[n]);
    if (error != std::errc{} || end != text.data() + text.size() || !std::isfinite(numbers[n])) return false;
    ++n;
  }
  return n == numbers.size();
}

}  // namespace

std::string key_frames_fault(const std::vector<FeedFrame>& frames) {
  if (frames.size() < 2) return fmt::format("holds {} key frames; it must hold at least two", frames.size());
  for (std::size_t k = 1; k < frames.size(); ++k) {
    if (!(frames[k].time > frames[k - 1].time))
      return fmt::format("has t = {:g} in key frame {} after {:g}; times must increase", frames[k].time, k + 1,
                         frames[k - 1].time);
    if (frames[k].volume < frames[k - 1].volume)
      return fmt::format("has e = {:g} in key frame {} after {:g}; the volume that has entered must not decrease",
                         frames[k].volume, k + 1, frames[k - 1].volume);
  }
  if (frames.front().time < 0.0) return fmt::format("begins at t = {:g}; it must begin at 0 or later", frames.front().time);
  if (frames.front().volume != 0.0) return fmt::format("begins with e = {:g}; it must begin with 0", frames.front().volume);
  return {};
}

std::vector<FeedFrame> parse_key_frames(const std::string& text) {
  std::vector<FeedFrame> frames;
  std::istringstream lines(text);
  std::string line;
  bool may_be_names = true;
  for (int number = 1; std::getline(lines, line); ++number) {
    const std::string row = without_spaces(line);
    if (row.empty() || row[0] == '#') continue;
    std::array<double, 5> v{};
    if (read_row(row, v))
      frames.push_back({v[0], {v[1], v[2], v[3]}, v[4]});
    else if (!may_be_names || row.find_first_of("0123456789") == 0)
      throw UsageError(fmt::format("line {} is not five numbers t, x, y, z, e separated by commas", number));
    may_be_names = false;
  }
  return frames;
}

}  // namespace bulkley
