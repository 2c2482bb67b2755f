#pragma once
// The part of a law that depends on volume alone, where it can be taken apart from the rest: what an implicit pressure replaces
// (docs/theory.md, "Implicit pressure").

#include <algorithm>
#include <cmath>

namespace bulkley {

/// The mean stress p = dU/dJ that a change of volume causes, tension positive, Pa; the Kirchhoff stress is J p 1.
struct VolumetricLaw {
  enum class Form {
    neo_hookean,  ///< p = (kappa/2) (J - 1/J)
    hencky,       ///< p = kappa ln J / J
    tait,         ///< p = -(kappa/n) (J^-n - 1)
  };
  Form form;
  double bulk_modulus;    ///< kappa, Pa, > 0
  double exponent = 1.0;  ///< n, tait only
  bool tension = true;    ///< false: the material parts where p would be positive

  /// p of a material that holds tension, for J > 0. Not collective.
  double stress(double J) const {
    switch (form) {
      case Form::hencky:
        return bulk_modulus * std::log(J) / J;
      case Form::tait:
        return -(bulk_modulus / exponent) * (power_of(J) - 1.0);
      case Form::neo_hookean:
        break;
    }
    return 0.5 * bulk_modulus * (J - 1.0 / J);
  }

  /// dp/dJ, Pa, > 0. Hencky's falls to zero at J = e, where the material softens for good; there it stays at a tenth. Not
  /// collective.
  double slope(double J) const {
    switch (form) {
      case Form::hencky:
        return bulk_modulus * std::max(1.0 - std::log(J), 0.1) / (J * J);
      case Form::tait:
        return bulk_modulus * power_of(J) / J;
      case Form::neo_hookean:
        break;
    }
    return 0.5 * bulk_modulus * (1.0 + 1.0 / (J * J));
  }

 private:
  /// J^-n; whole exponents, which are the rule, by products.
  double power_of(double J) const {
    const int whole = static_cast<int>(exponent);
    if (exponent != whole || whole > 16) return std::pow(J, -exponent);
    double product = 1.0;
    for (int k = 0; k < whole; ++k) product *= J;
    return 1.0 / product;
  }
};

}  // namespace bulkley
