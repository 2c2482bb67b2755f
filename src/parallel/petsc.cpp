#include "bulkley/parallel/petsc.hpp"

#include <fmt/format.h>

#include "bulkley/base/error.hpp"

namespace bulkley {

namespace {

bool errors_throw = false;
std::string first_sentence;  // of the error that PETSc is returning from

PetscErrorCode keep_sentence(MPI_Comm, int, const char*, const char*, PetscErrorCode code, PetscErrorType type,
                             const char* sentence, void*) {
  if (type == PETSC_ERROR_INITIAL) first_sentence = sentence ? sentence : "";
  return code;
}

}  // namespace

void check_petsc(PetscErrorCode code, const char* call, const char* file, int line) {
  if (code == 0) return;
  if (errors_throw) throw RunError(first_sentence.empty() ? fmt::format("{} failed", call) : first_sentence);
  const char* general = nullptr;
  char* specific = nullptr;
  PetscErrorMessage(code, &general, &specific);
  std::string text = fmt::format("{} failed", call);
  if (general) text += fmt::format(": {}", general);
  if (specific && *specific) text += fmt::format(": {}", specific);
  abort_all_ranks(text, file, line);
}

PetscErrorsThrow::PetscErrorsThrow() {
  BULKLEY_PETSC(PetscPushErrorHandler(keep_sentence, nullptr));
  first_sentence.clear();
  errors_throw = true;
}

PetscErrorsThrow::~PetscErrorsThrow() {
  errors_throw = false;
  BULKLEY_PETSC(PetscPopErrorHandler());
}

}  // namespace bulkley
