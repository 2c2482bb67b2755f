#!/usr/bin/env bash
# Installs what is missing, builds everything, and runs all tests through ctest; ends with ctest's summary and exit code.
# Further arguments go to ctest: `cluster/test.sh -L unit` runs the unit tests only.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"

"$root/cluster/install_packages.sh"
"$root/cluster/build.sh"
exec ctest --test-dir "$root/build" --output-on-failure --no-tests=error --parallel "$(nproc)" "$@" </dev/null
