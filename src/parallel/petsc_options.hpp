#pragma once
// Options for one of PETSc's solvers that a scene holds, apart from PETSc's own options.

#include <petscsys.h>

#include <functional>
#include <string>

#include "bulkley/parallel/petsc.hpp"

namespace bulkley {

using OptionsHandle = PetscHandle<PetscOptions, PetscOptionsDestroy>;

/// The options of a text, "-name value -name value". Not collective.
OptionsHandle petsc_options_of(const std::string& text);

/// While one lives, PETSc reads these options and no others.
class OptionsInForce {
 public:
  explicit OptionsInForce(const OptionsHandle& options) { BULKLEY_PETSC(PetscOptionsPush(options.get())); }
  ~OptionsInForce() { BULKLEY_PETSC(PetscOptionsPop()); }
  OptionsInForce(const OptionsInForce&) = delete;
  OptionsInForce& operator=(const OptionsInForce&) = delete;
};

/// Throws UsageError where PETSc's own options have one that begins with `prefix`: it would not be in force. `of`: whose options,
/// such as "the pressure's solver"; `key`: that of the scene that holds them. The same on every rank.
void refuse_stray_options(const std::string& prefix, const std::string& of, const std::string& key);

/// Runs `trial`, which solves something with `options` in force, and throws UsageError where PETSc fails in it or leaves an option
/// unread. As collective as `trial`.
void try_petsc_options(const std::string& key, const OptionsHandle& options, const std::function<void()>& trial);

}  // namespace bulkley
