#pragma once
// PETSc calls are wrapped: a dropped error code would compile silently.

#include <petscsys.h>

#include "bulkley/parallel/comm.hpp"

namespace bulkley {

/// Aborts all ranks with a message that names the failed call (others may wait inside it). Not collective.
void check_petsc(PetscErrorCode code, const char* call, const char* file, int line);
#define BULKLEY_PETSC(call) ::bulkley::check_petsc((call), #call, __FILE__, __LINE__)

/// While one lives, a failed call throws RunError with PETSc's sentence instead of ending all ranks: for calls that fail on all
/// ranks alike. One at a time.
class PetscErrorsThrow {
 public:
  PetscErrorsThrow();
  ~PetscErrorsThrow();
  PetscErrorsThrow(const PetscErrorsThrow&) = delete;
  PetscErrorsThrow& operator=(const PetscErrorsThrow&) = delete;
};

/// Move-only owner of a PETSc object. `Destroy`: PetscErrorCode (*)(T*).
template <class T, PetscErrorCode (*Destroy)(T*)>
class PetscHandle {
 public:
  PetscHandle() = default;
  explicit PetscHandle(T object) : object_(object) {}
  PetscHandle(PetscHandle&& other) noexcept : object_(other.object_) { other.object_ = nullptr; }
  PetscHandle& operator=(PetscHandle&& other) noexcept {
    if (this != &other) {
      reset();
      object_ = other.object_;
      other.object_ = nullptr;
    }
    return *this;
  }
  ~PetscHandle() { reset(); }
  T get() const { return object_; }
  T* put() {
    reset();
    return &object_;
  }
  explicit operator bool() const { return object_ != nullptr; }

 private:
  void reset() {
    if (object_) BULKLEY_PETSC(Destroy(&object_));
    object_ = nullptr;
  }
  T object_ = nullptr;
};

}  // namespace bulkley
