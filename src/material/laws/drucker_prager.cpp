#include "material/laws/drucker_prager.hpp"

#include <fmt/format.h>

#include <cmath>

#include "material/laws/shared_keys.hpp"

namespace bulkley {

namespace {

constexpr double largest_angle = 60.0;  // degrees

}  // namespace

std::optional<std::string> parameter_fault(const DruckerPrager::Parameters& p) {
  const auto angle_fault = [](const char* name, double value) -> std::optional<std::string> {
    if (value > 0.0 && value <= largest_angle) return std::nullopt;
    return fmt::format("{} = {} must be above 0 and at most {} degrees", name, value, largest_angle);
  };
  if (p.shear_modulus == 0.0) return "shear_modulus = 0 must be greater than 0";
  if (auto fault = angle_fault("friction_angle - hardening_drop", p.friction_angle - p.hardening_drop)) return fault;
  if (p.hardening_rise == 0.0) return std::nullopt;
  if (p.hardening_decay == 0.0) return "hardening_decay = 0 must be greater than 0 where hardening_rise is";
  // The angle is largest where its derivative by q vanishes.
  const double q = 1.0 / p.hardening_decay + p.hardening_drop / p.hardening_rise;
  return angle_fault("the largest friction angle that hardening reaches",
                     p.friction_angle + (p.hardening_rise * q - p.hardening_drop) * std::exp(-p.hardening_decay * q));
}

template <>
struct LawKeys<DruckerPrager> : SolidKeys<DruckerPrager> {
  static const config::Keys<Input>& table() {
    static const auto keys =
        solid_keys("Sand and other dry grains: elastic in compression, sliding by friction, without resistance to tension.")
            .key("friction_angle", [](auto& s) -> auto& { return s.parameters.friction_angle; },
                 {.about = "Angle of internal friction.",
                  .unit = "degrees",
                  .range = config::above_to(0.0, 60.0),
                  .default_text = required_key})
            .key("cohesion", [](auto& s) -> auto& { return s.parameters.cohesion; },
                 {.about = "Shear stress that the grains hold without pressure.",
                  .unit = "Pa",
                  .range = config::at_least(0.0)})
            .key("hardening_rise", [](auto& s) -> auto& { return s.parameters.hardening_rise; },
                 {.about = "Rise of the friction angle at first, per unit of plastic strain.",
                  .unit = "degrees",
                  .range = config::at_least(0.0)})
            .key("hardening_decay", [](auto& s) -> auto& { return s.parameters.hardening_decay; },
                 {.about = "How soon the change of the friction angle fades: exp(-hardening_decay q), q the plastic strain.",
                  .range = config::at_least(0.0)})
            .key("hardening_drop", [](auto& s) -> auto& { return s.parameters.hardening_drop; },
                 {.about = "By how much the friction angle is smaller before any plastic strain.",
                  .unit = "degrees",
                  .range = config::at_least(0.0)});
    return keys;
  }
};

template struct LawText<DruckerPrager>;

}  // namespace bulkley
