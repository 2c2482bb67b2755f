#include "parallel/petsc_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <vector>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

std::vector<std::string> unused_options_of(PetscOptions options) {
  PetscInt n = 0;
  char **names = nullptr, **values = nullptr;
  BULKLEY_PETSC(PetscOptionsLeftGet(options, &n, &names, &values));
  std::vector<std::string> unused;
  for (PetscInt k = 0; k < n; ++k) unused.push_back(fmt::format("-{}", names[k]));
  BULKLEY_PETSC(PetscOptionsLeftRestore(options, &n, &names, &values));
  return unused;
}

}  // namespace

OptionsHandle petsc_options_of(const std::string& text) {
  OptionsHandle options;
  BULKLEY_PETSC(PetscOptionsCreate(options.put()));
  BULKLEY_PETSC(PetscOptionsInsertString(options.get(), text.c_str()));
  return options;
}

void refuse_stray_options(const std::string& prefix, const std::string& of, const std::string& key) {
  std::vector<std::string> stray = unused_options_of(nullptr);
  std::erase_if(stray, [&](const std::string& name) { return !name.starts_with(prefix); });
  if (!stray.empty())
    throw UsageError(fmt::format("{}: options of {} stand in the scene, as {}", fmt::join(stray, ", "), of, key));
}

void try_petsc_options(const std::string& key, const OptionsHandle& options, const std::function<void()>& trial) {
  try {
    const PetscErrorsThrow errors;
    trial();
  } catch (const RunError& error) {
    throw UsageError(fmt::format("{}: {}", key, error.what()));
  }
  if (const std::vector<std::string> unused = unused_options_of(options.get()); !unused.empty())
    throw UsageError(fmt::format("{}: PETSc's solver knows no option {}", key, fmt::join(unused, ", ")));
}

}  // namespace bulkley
