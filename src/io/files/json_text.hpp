#pragma once
// JSON as this program writes it: keys keep their order, and measured numbers have as many digits as are worth reading.

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace bulkley {

using Json = nlohmann::ordered_json;

/// `value` rounded to six significant digits, for measured values; null where it is not finite. Not collective.
Json rounded(double value);

/// The value on several lines, indented by two spaces, without a line break at the end. Numbers read back as they are, NaN and
/// infinity become null, and bytes that are not UTF-8 become U+FFFD. Not collective.
std::string json_text(const Json& value);

}  // namespace bulkley
