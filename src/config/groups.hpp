#pragma once
// Keys that belong together: two alternative forms, of which a table uses one.

#include <string>
#include <vector>

#include "bulkley/config/value.hpp"

namespace bulkley::config {

/// The first of `names` that the table holds; null if it holds none.
const Value* first_given(const Value& table, const std::vector<std::string>& names);

/// A fault if the table holds keys of both groups: "[materials.a] mixes 'eta' (<one>) with 'consistency' (<other>); ...".
bool refuse_mixture(const Value& table, const std::vector<std::string>& group, const std::string& meaning,
                    const std::vector<std::string>& other_group, const std::string& other_meaning, Faults& faults);

}  // namespace bulkley::config
