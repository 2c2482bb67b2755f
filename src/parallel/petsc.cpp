#include "bulkley/parallel/petsc.hpp"

#include <fmt/format.h>

namespace bulkley {

void check_petsc(PetscErrorCode code, const char* call, const char* file, int line) {
  if (code == 0) return;
  const char* general = nullptr;
  char* specific = nullptr;
  PetscErrorMessage(code, &general, &specific);
  std::string text = fmt::format("{} failed", call);
  if (general) text += fmt::format(": {}", general);
  if (specific && *specific) text += fmt::format(": {}", specific);
  abort_all_ranks(text, file, line);
}

}  // namespace bulkley
