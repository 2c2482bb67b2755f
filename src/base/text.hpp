#pragma once
// Small operations on text. Not collective.

#include <string>
#include <string_view>
#include <vector>

namespace bulkley {

/// The parts between separators, at least one; some may be empty.
std::vector<std::string> split(std::string_view text, char separator);

/// As a shell takes it for one word: in single quotes where it must be.
std::string shell_word(const std::string& word);

/// As a string of TOML, in double quotes.
std::string toml_string(std::string_view text);

/// For sentences about input: in single quotes, at most 40 characters, "?" for those that cannot be printed.
std::string excerpt(std::string_view word);

}  // namespace bulkley
