#include "rheometer/measured_curve.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

#include "bulkley/base/error.hpp"
#include "config/nearest.hpp"
#include "rheometer/number_list.hpp"

namespace bulkley::rheometer {

namespace {

std::string trimmed(const std::string& text) {
  const char* blank = " \t\r\"";
  const auto first = text.find_first_not_of(blank);
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(blank) - first + 1);
}

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> result;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, ',');) result.push_back(trimmed(cell));
  if (!line.empty() && line.back() == ',') result.emplace_back();
  return result;
}

class Reader {
 public:
  Reader(const std::string& name, MeasuredCurve& curve) : name_(name), curve_(curve) {}

  void read(const std::string& text) {
    constexpr const char* byte_order_mark = "\xEF\xBB\xBF";
    std::istringstream stream(text.rfind(byte_order_mark, 0) == 0 ? text.substr(3) : text);
    for (std::string line; std::getline(stream, line);) {
      ++line_;
      if (trimmed(line).empty() || trimmed(line).front() == '#') continue;
      if (header_.empty())
        read_header(cells(line));
      else
        read_point(cells(line));
    }
    if (header_.empty()) throw UsageError(fmt::format("{}: is empty; it needs a header with the columns {}", name_, needed));
  }

 private:
  static constexpr const char* needed = "shear_rate and stress";

  void read_header(const std::vector<std::string>& names) {
    header_ = names;
    for (const std::string& each : names)
      if (std::count(names.begin(), names.end(), each) > 1 && !each.empty()) fault(fmt::format("column '{}' twice", each));
    rate_ = required("shear_rate");
    stress_ = required("stress");
    error_ = index_of("error");
  }

  std::optional<std::size_t> index_of(const std::string& column) const {
    const auto found = std::find(header_.begin(), header_.end(), column);
    if (found == header_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - header_.begin());
  }

  std::size_t required(const std::string& column) const {
    const auto index = index_of(column);
    if (!index) fault(fmt::format("the header has no column '{}'; it has {}", column, config::quoted_list(header_, '\'')));
    return *index;
  }

  void read_point(const std::vector<std::string>& values) {
    if (values.size() != header_.size()) fault(fmt::format("{} values under {} columns", values.size(), header_.size()));
    curve_.shear_rate.push_back(positive(values, rate_));
    curve_.stress.push_back(positive(values, stress_));
    if (error_) curve_.error.push_back(positive(values, *error_));
  }

  double positive(const std::vector<std::string>& values, std::size_t column) const {
    const auto number = parse_number(values[column]);
    if (!number) fault(fmt::format("{} '{}' is not a finite number", header_[column], values[column]));
    if (*number <= 0.0) fault(fmt::format("{} {:g} is not above 0", header_[column], *number));
    return *number;
  }

  [[noreturn]] void fault(const std::string& sentence) const {
    throw UsageError(fmt::format("{}:{}: {}", name_, line_, sentence));
  }

  const std::string& name_;
  MeasuredCurve& curve_;
  std::vector<std::string> header_;
  std::size_t rate_ = 0, stress_ = 0;
  std::optional<std::size_t> error_;
  int line_ = 0;
};

}  // namespace

MeasuredCurve parse_measured_curve(const std::string& text, const std::string& name) {
  MeasuredCurve curve;
  Reader(name, curve).read(text);
  return curve;
}

}  // namespace bulkley::rheometer
