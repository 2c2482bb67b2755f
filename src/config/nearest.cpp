#include "config/nearest.hpp"

#include <algorithm>

namespace bulkley::config {
namespace {

/// Edit distance with insertion, deletion, replacement and the swap of neighbours (optimal string alignment).
std::size_t edit_distance(const std::string& a, const std::string& b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
  for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i)
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replace = d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replace});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  return d[a.size()][b.size()];
}

}  // namespace

std::optional<std::string> nearest(const std::string& word, const std::vector<std::string>& candidates) {
  constexpr std::size_t longest = 100;  // typing errors in longer words are unlikely; bounds the work
  if (word.size() > longest) return std::nullopt;
  std::optional<std::string> best;
  std::size_t best_distance = std::max<std::size_t>(2, word.size() / 3) + 1;
  for (const std::string& candidate : candidates) {
    if (candidate.size() > longest) continue;
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance && distance < candidate.size()) {
      best = candidate;
      best_distance = distance;
    }
  }
  return best;
}

std::string suggestion(const std::string& word, const std::vector<std::string>& candidates) {
  if (const auto near = nearest(word, candidates)) return "; did you mean '" + *near + "'?";
  constexpr std::size_t most = 20;
  constexpr std::size_t longest = 1000;
  std::size_t length = 0;
  for (const std::string& candidate : candidates) length += candidate.size();
  if (candidates.empty() || candidates.size() > most || length > longest) return "";
  return "; known: " + quoted_list(candidates, '\'');
}

std::string quoted_list(const std::vector<std::string>& words, char quote) {
  std::string result;
  for (const std::string& word : words) {
    if (!result.empty()) result += ", ";
    result += quote + word + quote;
  }
  return result;
}

}  // namespace bulkley::config
