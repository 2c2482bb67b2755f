#pragma once
// Numbers on the command line.

#include <optional>
#include <string>
#include <vector>

namespace bulkley::rheometer {

/// A finite number that is the whole text; nothing otherwise. Not collective.
std::optional<double> parse_number(const std::string& text);

/// "1,2,5" as given, or "0.01:100:20": 20 numbers from 0.01 to 100, evenly over their logarithm, both ends among them.
/// Every number must be above 0, or at least 0 where `zero_allowed`. Throws UsageError with one sentence that begins with
/// `option`. Not collective.
std::vector<double> parse_number_list(const std::string& text, const std::string& option, bool zero_allowed = false);

struct Range {
  double lower, upper;
};

/// "0.1:100", 0 <= lower < upper. Throws UsageError like parse_number_list. Not collective.
Range parse_range(const std::string& text, const std::string& option);

}  // namespace bulkley::rheometer
