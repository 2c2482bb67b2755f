#!/usr/bin/env bash
# Runs on disks that fail (storage_faults.py).
#   tests/failure/storage_faults.sh [--all] [CASE ...]
. "$(dirname "${BASH_SOURCE[0]}")/environment.sh"
shim="${WORK:-$root/out/storage_faults}.shim.so"
mkdir -p "$(dirname "$shim")"
cc -shared -fPIC -O1 -o "$shim" "$root/tests/failure/storage_shim.c" -ldl
failure_test storage_faults --shim "$shim" "$@"
