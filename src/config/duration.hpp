#pragma once
// Human-readable wall times.

#include <string>

namespace bulkley {

/// Seconds of "1h55m", "10m", "2d", "1m30s", "1.5h" or a plain number of seconds. Throws UsageError. Not collective.
double parse_duration(const std::string& text);

/// The inverse, for messages: 6900 -> "1h55m"; seconds are rounded to three decimals. Not collective.
std::string duration_text(double seconds);

}  // namespace bulkley
