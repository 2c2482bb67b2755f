#include "rheometer/magnetic.hpp"

#include <fmt/format.h>

#include "bulkley/base/error.hpp"
#include "rheometer/steady.hpp"

namespace bulkley::rheometer {

Measurement measure_magnetic(const NamedMaterial& named, const MagneticSettings& settings) {
  if (!named.magnetisation) throw UsageError(fmt::format("--mode magnetic: material '{}' is not magnetic", named.name));
  SteadySettings steady{.rates = {settings.rate}};
  steady.strain_per_step = settings.strain_per_step;
  Measurement result;
  for (const double field : settings.fields) {
    const Material material = at_field(named.material, field);
    const Table sheared = measure_steady(material, steady).table;
    Row row;
    row.add("magnetic_field_strength", field).add("magnetisation", named.magnetisation->at(field));
    if (const auto stress = characteristic_stress(material, settings.rate)) row.add("yield_stress", stress->yield);
    row.add("shear_rate", settings.rate).add("shear_stress", sheared.column("shear_stress").front());
    if (sheared.has("analytic_stress")) row.add("analytic_stress", sheared.column("analytic_stress").front());
    row.append_to(result.table);
  }
  return result;
}

}  // namespace bulkley::rheometer
