#pragma once
// How strongly a magnetic material is magnetised by a field: laws of one phase without memory.

#include <limits>

#include "bulkley/base/types.hpp"

namespace bulkley {

/// The permeability of empty space, V s/(A m): its value before 2019, to which all sources of data refer.
inline constexpr double vacuum_permeability = 1.25663706143591729539e-6;

/// M(H) of the undiluted material: m >= 0, growing, with a falling m/H. Magnetisation and field are parallel. `linear` is
/// chi H; with x = chi H/M_s, `langevin` is M_s (coth 3x - 1/(3x)), `froehlich_kennelly` M_s x/(1 + x) and `exponential`
/// M_s (1 - exp(-x)), chi the initial susceptibility and M_s the saturation magnetisation.
struct Magnetisation {
  enum class Law { linear, langevin, froehlich_kennelly, exponential };

  Law law = Law::linear;
  double susceptibility = std::numeric_limits<double>::quiet_NaN();  ///< chi = dm/dH at H = 0, > 0
  double saturation = std::numeric_limits<double>::infinity();       ///< M_s, A/m, > 0; unused by `linear`

  /// m at the field strength `H` >= 0 (A/m), A/m. Not collective.
  double at(double H) const;
  /// dm/dH at `H` >= 0 (A/m). Not collective.
  double slope(double H) const;
  /// Both at once, A/m and 1. Not collective.
  struct Response {
    double magnetisation, slope;
  };
  Response response(double H) const;
  /// The co-energy e = integral of m from 0 to `H` >= 0 (A/m), (A/m)^2; times mu_0: J/m^3. Not collective.
  double co_energy(double H) const;
  /// dm/dH at H = 0. Not collective.
  double initial_susceptibility() const { return susceptibility; }
};

}  // namespace bulkley
