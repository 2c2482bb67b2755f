#include "scene/time_step_keys.hpp"

#include <array>
#include <sstream>

namespace bulkley {

namespace {

// The scene's own keys say when the pressure is solved.
constexpr std::array<const char*, 5> without_effect{"ksp_rtol", "ksp_atol", "ksp_divtol", "ksp_max_it",
                                                    "ksp_convergence_test"};

}  // namespace

std::string petsc_options_fault(const std::string& options) {
  std::istringstream words(options);
  std::string word;
  for (bool first = true; words >> word; first = false) {
    const bool is_name = word.size() > 1 && word[0] == '-' && (word[1] < '0' || word[1] > '9') && word[1] != '.';
    if (is_name ? !word.starts_with(petsc_pressure_prefix) : first)
      return fmt::format("'{}' does not begin with {}", word, petsc_pressure_prefix);
    for (const char* name : without_effect)
      if (word == petsc_pressure_prefix + std::string(name))
        return fmt::format(
            "'{}' has no effect: time.pressure.tolerance and .max_iterations say when a solution is good enough", word);
  }
  return {};
}

}  // namespace bulkley
