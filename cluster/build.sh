#!/usr/bin/env bash
# Configures and builds Bulkley (Release, for this machine's processor) into build/. Further arguments go to
# `cmake --build`, for example `cluster/build.sh --target bulkley_program` for the program without its tests.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
build="$root/build"

# A compilation of this code takes up to about 1.5 GiB; more at once than the memory holds would be killed.
cores="$(nproc)"
by_memory="$(awk '/^MemAvailable/ {print int($2 / 1024 / 1536)}' /proc/meminfo)"
jobs=$((by_memory < cores ? by_memory : cores))
jobs=$((jobs < 1 ? 1 : jobs))

generator=()
if [[ ! -f "$build/CMakeCache.txt" ]]; then generator=(-G Ninja); fi  # an existing folder keeps its generator
cmake -S "$root" -B "$build" "${generator[@]}" -DCMAKE_BUILD_TYPE=Release
cmake --build "$build" --parallel "$jobs" "$@"
