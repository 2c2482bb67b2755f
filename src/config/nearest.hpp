#pragma once
// "Did you mean ...?"

#include <optional>
#include <string>
#include <vector>

namespace bulkley::config {

/// The candidate closest to `word` in edit distance (insert, delete, replace, swap of neighbours), if it is close enough to
/// be a typing error: at most 2 edits, or a third of the letters of a long word.
std::optional<std::string> nearest(const std::string& word, const std::vector<std::string>& candidates);

/// "; did you mean 'viscosity'?" or, without a near candidate, "; known: 'a', 'b'" (up to 20 of them), or nothing.
std::string suggestion(const std::string& word, const std::vector<std::string>& candidates);

/// `"a", "b", "c"`.
std::string quoted_list(const std::vector<std::string>& words, char quote = '"');

}  // namespace bulkley::config
