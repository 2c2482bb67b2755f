#pragma once
// Values as JSON writes them.

#include <string>
#include <string_view>

namespace bulkley {

/// In quotes, with what must not stand between them escaped. Not collective.
std::string json_text(std::string_view text);

/// So that reading it gives the same number; JSON has no word for NaN or infinity: null. Not collective.
std::string json_text(double value);

}  // namespace bulkley
