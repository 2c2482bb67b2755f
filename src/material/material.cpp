#include "material/material.hpp"

#include <algorithm>
#include <cmath>

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

FieldYield field_yield(const Material& material) {
  return std::visit(
      [](const auto& law) -> FieldYield {
        if constexpr (requires { law.parameters.field_yield; })
          return law.parameters.field_yield;
        else
          return {};
      },
      material);
}

bool takes_field_yield(const Material& material) {
  return std::visit([](const auto& law) { return requires { law.parameters.field_yield; }; }, material);
}

Material with_field_yield(const Material& material, const FieldYield& yield) {
  Material changed = material;
  std::visit(
      [&](auto& law) {
        if constexpr (requires { law.parameters.field_yield; }) law.parameters.field_yield = yield;
      },
      changed);
  return changed;
}

Material at_field(const Material& material, double field) {
  const FieldYield yield = field_yield(material);
  if (!yield.given()) return material;
  const double added = std::sqrt(3.0) * yield.at(field);
  const auto raise = [&](HerschelBulkley::Parameters& p) {
    p.sigma_Y += added;
    p.field_yield = {};
    p.given = {};
  };
  if (const auto* fluid = std::get_if<HerschelBulkley>(&material)) {
    HerschelBulkley::Parameters p = fluid->parameters;
    raise(p);
    return HerschelBulkley{p};
  }
  ThixotropicHerschelBulkley::Parameters p = std::get<ThixotropicHerschelBulkley>(material).parameters;
  const double without_structure = p.sigma_Y * p.residual_yield + added;  // the structure acts on the rest
  raise(p);
  if (p.sigma_Y > 0.0) p.residual_yield = without_structure / p.sigma_Y;
  return ThixotropicHerschelBulkley{p};
}

double rest_density(const Material& material) {
  return std::visit([](const auto& law) { return law.density(); }, material);
}

double shear_wave_speed_at_rest(const Material& material) {
  constexpr double strain = 1e-4;
  const SymTensor<double> simple_shear{{1.0 + strain * strain, 1.0, 1.0, strain, 0.0, 0.0}};
  return std::visit(
      [&simple_shear](const auto& law) {
        auto state = state_at_rest(law);
        state.left_cauchy_green = simple_shear;
        const double modulus = law.kirchhoff_stress(state)(0, 1) / strain;
        return std::sqrt(std::max(modulus, 0.0) / law.density());
      },
      material);
}

const char* law_name(const Material& material) {
  if (const auto* added = std::get_if<AddedLaw>(&material)) return added->parameters.model->name();
  return std::visit([](const auto& law) { return law.law_name; }, material);
}

namespace {

template <class Law>
concept HasVolumetricLaw = requires(const Law& law) { law.volumetric(); };

}  // namespace

std::optional<NeoHookean> neo_hookean_stress(const Material& material) {
  return std::visit(
      []<class Law>(const Law& law) -> std::optional<NeoHookean> {
        if constexpr (std::is_same_v<Law, NeoHookean>) {
          return law;
        } else if constexpr (std::is_same_v<Law, HerschelBulkley> || std::is_same_v<Law, ThixotropicHerschelBulkley> ||
                             std::is_same_v<Law, OldroydB>) {
          if (law.viscosity() == 0.0) return law.elastic();
        }
        return std::nullopt;
      },
      material);
}

std::optional<VolumetricLaw> volumetric_law(const Material& material) {
  return std::visit(
      []<class Law>(const Law& law) -> std::optional<VolumetricLaw> {
        if constexpr (HasVolumetricLaw<Law>)
          return law.volumetric();
        else
          return std::nullopt;
      },
      material);
}

Material with_bulk_modulus(const Material& material, double bulk_modulus) {
  Material changed = material;
  std::visit(
      [&]<class Law>(Law& law) {
        if constexpr (HasVolumetricLaw<Law>) law.parameters.bulk_modulus = bulk_modulus;
      },
      changed);
  return changed;
}

Material without_volumetric_law(const Material& material) { return with_bulk_modulus(material, 0.0); }

namespace {

// The parameter behind Law::viscosity(), if it has one.
template <class Law>
double* viscosity_parameter(Law& law) {
  if constexpr (requires { law.parameters.viscosity; })
    return &law.parameters.viscosity;
  else if constexpr (requires { law.parameters.background_viscosity; })
    return &law.parameters.background_viscosity;
  else if constexpr (requires { law.parameters.solvent_viscosity; })
    return &law.parameters.solvent_viscosity;
  else
    return nullptr;
}

}  // namespace

double separable_viscosity(const Material& material) {
  if (std::holds_alternative<AddedLaw>(material)) return 0.0;
  return std::visit([](const auto& law) { return law.viscosity(); }, material);
}

Material without_viscosity(const Material& material) {
  Material rest = material;
  std::visit(
      [](auto& law) {
        if (double* const viscosity = viscosity_parameter(law)) *viscosity = 0.0;
      },
      rest);
  return rest;
}

bool has_yield_stress(const Material& material) {
  return std::visit(
      []<class Law>(const Law& law) {
        if constexpr (requires { law.parameters.sigma_Y, law.parameters.field_yield; })
          return law.parameters.sigma_Y > 0.0 || law.parameters.field_yield.given();
        else
          return false;
      },
      material);
}

bool flows(const Material& material) {
  if (const auto* added = std::get_if<AddedLaw>(&material)) return added->parameters.model->flows();
  return std::visit([](const auto& law) { return law.flows; }, material);
}

}  // namespace bulkley
