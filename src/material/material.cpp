#include "material/material.hpp"

#include "material/law_text.hpp"

namespace bulkley {

std::optional<std::string> material_fault(const Material& material) {
  return std::visit([]<class Law>(const Law& law) { return LawText<Law>::fault(law); }, material);
}

std::span<const Field> internal_variables(const Material& material) {
  return std::visit([]<class Law>(const Law&) { return std::span<const Field>(Law::internal); }, material);
}

std::optional<CharacteristicStress> characteristic_stress(const Material& material, double rate) {
  return std::visit(
      [rate](const auto& law) -> std::optional<CharacteristicStress> {
        if constexpr (requires { law.characteristic_stress(rate); })
          return law.characteristic_stress(rate);
        else
          return std::nullopt;
      },
      material);
}

const char* law_name(const Material& material) {
  if (const auto* added = std::get_if<AddedLaw>(&material)) return added->parameters.model->name();
  return std::visit([](const auto& law) { return law.law_name; }, material);
}

bool flows(const Material& material) {
  if (const auto* added = std::get_if<AddedLaw>(&material)) return added->parameters.model->flows();
  return std::visit([](const auto& law) { return law.flows; }, material);
}

}  // namespace bulkley
