#pragma once
// What `bulkley bench` found, as JSON (docs/performance.md, "Keys of the JSON").

#include "bench/run.hpp"
#include "io/files/json_text.hpp"
#include "scene/transfer_keys.hpp"

namespace bulkley {

/// The name of a value of an enumeration that scenes name. Not collective.
template <class E>
std::string name_of(E value) {
  for (const auto& [name, candidate] : names(config::Of<E>{}))
    if (candidate == value) return name;
  return {};
}

/// A case and what it costs. Not collective.
Json describe(const BenchCase& what, const BenchResult& result);

/// Prints nothing; writes the object to `path`, whose folder is made. Root only; throws RunError.
void write_json(const std::string& path, const Json& object);

}  // namespace bulkley
