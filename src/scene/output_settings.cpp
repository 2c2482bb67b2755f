#include "scene/output_settings.hpp"

#include "kernel/derived_fields.hpp"

namespace bulkley {

std::vector<std::string> frame_field_names() {
  std::vector<std::string> names;
  for (const FieldInfo& field : field_table)
    if (field.written && field.field != Field::position) names.emplace_back(field.name);
  for (const DerivedField& field : derived_fields()) names.emplace_back(field.name);
  return names;
}

std::vector<std::string> particle_field_names(const ParticleSet& particles) {
  std::vector<std::string> names;
  for (const FieldInfo& field : field_table)
    if (field.written && field.field != Field::position && particles.has(field.field)) names.emplace_back(field.name);
  return names;
}

}  // namespace bulkley
