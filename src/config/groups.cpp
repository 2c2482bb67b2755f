#include "config/groups.hpp"

#include <fmt/format.h>

namespace bulkley::config {

const Value* first_given(const Value& table, const std::vector<std::string>& names) {
  for (const std::string& name : names)
    if (const Value* value = table.find(name)) return value;
  return nullptr;
}

bool refuse_mixture(const Value& table, const std::vector<std::string>& group, const std::string& meaning,
                    const std::vector<std::string>& other_group, const std::string& other_meaning, Faults& faults) {
  const Value* one = first_given(table, group);
  const Value* other = first_given(table, other_group);
  if (!one || !other) return false;
  faults.add(other->key_place, fmt::format("{} mixes '{}' ({}) with '{}' ({}); give one or the other",
                                           table_name(table.path), one->key, meaning, other->key, other_meaning));
  return true;
}

}  // namespace bulkley::config
