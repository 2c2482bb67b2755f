#pragma once
// Steps that have gone wrong, or that cannot be taken: what happened, to which particle, and what to try.

#include <optional>
#include <string>

#include "bulkley/base/error.hpp"
#include "bulkley/base/types.hpp"

namespace bulkley {

/// No step can be taken, or the one taken must not be followed by another. Thrown on every rank.
struct NoStep : RunError {
  /// `at_fault`: id of the particle, or -1 where it is none in particular.
  NoStep(const std::string& what, GlobalIndex at_fault, std::string what_to_try)
      : RunError(what), particle(at_fault), advice(std::move(what_to_try)) {}

  GlobalIndex particle;
  std::string advice;
};

/// The end of a run by its physics: one sentence with particle, position, material and advice. Thrown on every rank.
struct StepFailure : RunError {
  StepFailure(const std::string& text, std::optional<Vec3> where) : RunError(text), place(std::move(where)) {}

  std::optional<Vec3> place;  ///< of the particle or node at fault, m; none where it has no finite position
};

}  // namespace bulkley
