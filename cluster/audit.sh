#!/usr/bin/env bash
# All checks of the code that are independent of the physics: strict warnings and internal checks, sanitizers, leaks,
# clang-tidy. Hours on two cores; parts by name.
#
#   cluster/audit.sh [audit] [sanitize] [leaks] [tidy]
#
# Debian: apt install clang-16 clang-tidy-16, for tidy alone. Builds go to build-audit, build-sanitize and build-tidy.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
cd "$root"
. cluster/environment.sh
export OMPI_MCA_mpi_yield_when_idle=1

parts=("$@")
[[ ${#parts[@]} -gt 0 ]] || parts=(audit sanitize leaks tidy)
for part in "${parts[@]}"; do
  echo "== $part"
  case "$part" in
    audit | sanitize | tidy) cmake --workflow --preset "$part" ;;
    leaks)
      # One process without MPI: Open MPI and PETSc keep memory until exit by design, which hides leaks of Bulkley.
      cmake --preset sanitize
      for module in base config material particle kernel rheometer; do
        cmake --build build-sanitize --target "unit_$module"
        (cd build-sanitize && ASAN_OPTIONS=detect_leaks=1 UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1 "tests/unit_$module")
      done
      ;;
    *) echo "audit.sh: '$part' is none of audit, sanitize, leaks, tidy" >&2; exit 2 ;;
  esac
done
