#!/usr/bin/env bash
# Installs what is missing, builds, runs the long versions of the verification cases, an hour or two on two cores, and
# writes docs/verification.md and its pictures. The page is written even if a case fails, which it reports; the exit
# code is then ctest's. Further arguments go to ctest: `cluster/verify.sh -R slump` runs one case again and
# keeps the results of the others.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"

"$root/cluster/install_packages.sh"
"$root/cluster/build.sh" --target bulkley_program
outcome=0
ctest --test-dir "$root/build" --output-on-failure --no-tests=error -L slow "$@" </dev/null || outcome=$?

python=/usr/bin/python3  # Debian's, as for the tests
[[ -x "$python" ]] || python=python3
"$python" "$root/tests/verification/report.py"
echo "Written: $root/docs/verification.md"
exit "$outcome"
