#!/usr/bin/env bash
# Configures and builds Bulkley (Release, for this machine's processor) into build/. Further arguments go to
# `cmake --build`, for example `cluster/build.sh --target bulkley_program` for the program without its tests.
#
#   cluster/build.sh [--program] [ARGUMENTS OF cmake --build]
#
# --program: the program alone; a new build/ is configured without tests, which need GoogleTest, until cluster/build.sh runs without it.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build="$root/build"

# nproc heeds OMP_NUM_THREADS, which cluster/environment.sh sets to 1.
# A compilation of this code takes up to about 1.5 GiB; more at once than the memory holds would be killed.
cores="$(env -u OMP_NUM_THREADS nproc)"
by_memory="$(awk '/^MemAvailable/ {print int($2 / 1024 / 1536)}' /proc/meminfo)"
jobs=$((by_memory < cores ? by_memory : cores))
jobs=$((jobs < 1 ? 1 : jobs))

settings=(-DCMAKE_BUILD_TYPE=Release)
is_new=no
if [[ ! -f "$build/CMakeCache.txt" ]]; then  # an existing folder keeps its generator
  is_new=yes
  settings+=(-G Ninja)
fi
if [[ "${1:-}" == --program ]]; then
  shift
  set -- --target bulkley_program "$@"
  if [[ "$is_new" == yes ]]; then settings+=(-DBULKLEY_TESTS=OFF); fi
else
  settings+=(-DBULKLEY_TESTS=ON)
fi
cmake -S "$root" -B "$build" "${settings[@]}"
cmake --build "$build" --parallel "$jobs" "$@"
