#!/usr/bin/env bash
# Installs what is missing, builds everything, and runs all tests through ctest; ends with ctest's summary and exit code.
# Further arguments go to ctest: `cluster/test.sh -L unit` runs the unit tests only. Tests with the label `slow`, the long
# verification runs, are left to `ctest -L slow`.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"

"$root/cluster/install_packages.sh"
"$root/cluster/build.sh"
exec ctest --test-dir "$root/build" --output-on-failure --no-tests=error --label-exclude slow \
  --parallel "$(nproc)" "$@" </dev/null
