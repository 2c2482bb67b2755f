#pragma once
// TOML text to values and back.

#include <string>

#include "bulkley/config/value.hpp"

namespace bulkley::config {

/// Bytes; a scene text has some kilobytes. Whoever reads a file stops there.
inline constexpr std::size_t largest_text = std::size_t{16} << 20;

/// The root table of a TOML text. Throws UsageError "file:line:column: ..." where it is not TOML, repeats a key, or is too large
/// or nested too deeply.
Value parse_toml(const std::string& text, const std::string& file_name);

/// Applies "key.path=value" to the tree; tables on the way are made, entries of lists are found by index or by `name`.
/// What cannot be applied is a fault; whether the keys exist is checked later, like those of the file.
void apply_override(Value& root, const std::string& assignment, Faults& faults);

/// TOML text of a root table, every number with the digits that give back the same bits.
std::string print_toml(const Value& root);

/// One value on one line, as TOML writes it.
std::string print_inline(const Value& value);

}  // namespace bulkley::config
