#pragma once
// Human-readable numbers. Not collective.

#include <string>

namespace bulkley {

/// "512 B", "4.2 MB", "1.31 GB": powers of 1000, three digits.
std::string bytes_text(double bytes);

/// "8 s", "3m20s", "1h05m", "2d4h": the two largest units. "?" if it is not finite.
std::string span_text(double seconds);

/// Three digits; exponents only where they are shorter to read. "?" if it is not finite.
std::string number_text(double value);

/// "12 345 678": groups of three digits.
std::string count_text(double count);

/// "1 frame", "2 frames".
std::string counted(double count, const std::string& noun);

}  // namespace bulkley
