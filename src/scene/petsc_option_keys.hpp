#pragma once
// Keys of a scene that hold options for one of PETSc's solvers.

#include <string>

namespace bulkley {

/// What is wrong with a text of options for PETSc, as a sentence; empty when nothing is: each name has to begin with `prefix`, such as
/// "-bulkley_pressure_", and must not be a tolerance, of which `decides` says what stands in its place. Whether PETSc knows them it
/// says itself. Not collective.
std::string petsc_options_fault(const std::string& options, const std::string& prefix, const std::string& decides);

}  // namespace bulkley
