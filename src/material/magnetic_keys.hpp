#pragma once
// [materials.NAME.magnetic] of a scene: how a magnetic field magnetises the material, and its yield stress in the field.

#include <optional>

#include "bulkley/config/keys.hpp"
#include "magnetics/field_yield.hpp"
#include "magnetics/magnetisation.hpp"

namespace bulkley {

struct MagneticProperties {
  Magnetisation magnetisation;
  FieldYield yield;  ///< of fluids that yield only
};

config::Names<Magnetisation::Law> names(config::Of<Magnetisation::Law>);
config::Names<FieldYield::Form> names(config::Of<FieldYield::Form>);
const config::Keys<MagneticProperties>& keys(config::Of<MagneticProperties>);

}  // namespace bulkley
