#include "scene/petsc_option_keys.hpp"

#include <fmt/format.h>

#include <array>
#include <sstream>

namespace bulkley {

namespace {

// The scene's own keys say when a solution is good enough.
constexpr std::array<const char*, 5> without_effect{"ksp_rtol", "ksp_atol", "ksp_divtol", "ksp_max_it",
                                                    "ksp_convergence_test"};

}  // namespace

std::string petsc_options_fault(const std::string& options, const std::string& prefix, const std::string& decides) {
  std::istringstream words(options);
  std::string word;
  for (bool first = true; words >> word; first = false) {
    const bool is_name = word.size() > 1 && word[0] == '-' && (word[1] < '0' || word[1] > '9') && word[1] != '.';
    if (is_name ? !word.starts_with(prefix) : first) return fmt::format("'{}' does not begin with {}", word, prefix);
    for (const char* name : without_effect)
      if (word == prefix + name) return fmt::format("'{}' has no effect: {} when a solution is good enough", word, decides);
  }
  return {};
}

}  // namespace bulkley
