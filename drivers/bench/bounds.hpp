#pragma once
// The bounds of the step, defined only here (docs/performance.md, "Bounds").

#include <limits>
#include <vector>

#include "kernel/transfer.hpp"

namespace bulkley {

enum class Sense { at_most, at_least };

struct Bound {
  double limit = std::numeric_limits<double>::quiet_NaN();  ///< NaN: the figure is information
  Sense sense = Sense::at_most;
};

namespace bench_bounds {
inline constexpr Bound spread_over_sizes{1.15};               ///< max/min cost per particle, 100 000 to 10 000 000 of them
inline constexpr Bound empty_domain{1.10};                    ///< a step in 16 times the ball's box, over one in the box
inline constexpr Bound bytes_per_particle{280.0};             ///< of a million particles on one rank
inline constexpr Bound forecast_error{1.20};                  ///< measured over predicted memory, or the other way round
inline constexpr Bound two_ranks{1.85, Sense::at_least};      ///< throughput over that of one rank
inline constexpr Bound eight_ranks{0.5, Sense::at_least};     ///< likewise, on fewer cores: less would be a collapse
inline constexpr Bound imex_step{3.1};                        ///< a step of imex, over an explicit one
inline constexpr Bound imex_two_ranks{1.8, Sense::at_least};  ///< throughput of imex over that of one rank
inline constexpr Bound potential_growth{1.16};                ///< cost of a node of a magnetic field, in eight times as many
inline constexpr Bound field_step{1.3};                       ///< a step with a magnetic field, over one without
}  // namespace bench_bounds

/// A transfer and a material, and the step's cost over that of the naive neo-Hookean kernel: at most a tenth more than the least that
/// a suite has measured.
struct BoundedCase {
  const char* name;
  const char* material;
  TransferSettings transfer;
  Bound ratio_to_naive = {};
};

inline const std::vector<BoundedCase>& bounded_cases() {
  using enum TransferScheme;
  using enum SplineOrder;
  using enum GradientForm;
  static const std::vector<BoundedCase> cases = {
      {"neo-Hookean, APIC, mls", "neo_hookean", {apic, quadratic, mls}, {0.45}},
      {"Herschel-Bulkley (cream), APIC, mls", "cream", {apic, quadratic, mls}, {0.75}},
      {"Herschel-Bulkley (oobleck), APIC, mls", "oobleck", {apic, quadratic, mls}, {0.75}},
      {"Herschel-Bulkley (pie), APIC, mls", "pie", {apic, quadratic, mls}, {0.75}},
      {"Herschel-Bulkley (cream), moment FLIP, mls", "cream", {moment_flip, quadratic, mls}, {1.0}},
      {"neo-Hookean, APIC, bspline", "neo_hookean", {apic, quadratic, bspline}, {0.59}},
      {"neo-Hookean, PIC/FLIP blend, mls", "neo_hookean", {blend, quadratic, mls}, {0.58}},
      {"neo-Hookean, moment FLIP, mls", "neo_hookean", {moment_flip, quadratic, mls}, {0.70}},
      {"neo-Hookean, cubic, APIC, mls", "neo_hookean", {apic, cubic, mls}, {0.65}},
  };
  return cases;
}

}  // namespace bulkley
