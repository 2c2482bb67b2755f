#pragma once
// Bounds on what a text may ask of the TOML parser and of the tree behind it, which both use memory and stack in proportion.

#include <cstddef>
#include <optional>
#include <string>

namespace bulkley::config {

/// Far above any scene: its tree takes a few hundred bytes for each value.
inline constexpr std::size_t most_values = 500'000;

/// What is wrong with the size or the depth of a text; line 0: with the text as a whole.
struct TextFault {
  int line = 0, column = 0;
  std::string sentence;
};
/// Reads the text as far as brackets, quotes and comments go. Not collective.
std::optional<TextFault> size_fault(const std::string& text);

}  // namespace bulkley::config
