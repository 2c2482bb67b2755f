#!/usr/bin/env bash
# Installs what is missing, builds, runs the long versions of the verification cases, an hour or two on two cores, and
# writes docs/verification.md and its pictures. With --validation: the validation cases, hours, and docs/validation.md.
# The page is written even if a case fails, which it reports; the exit code is then ctest's. Further arguments go to ctest:
# `cluster/verify.sh -R slump`, or `cluster/verify.sh --validation -R hertz`, runs one case again and keeps the other results.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
suite=verification
labels=(-L slow -LE experiments)
if [[ "${1:-}" == --validation ]]; then
  suite=validation
  labels=(-L experiments)
  shift
fi

"$root/cluster/install_packages.sh"
"$root/cluster/build.sh" --target bulkley_program
outcome=0
ctest --test-dir "$root/build" --output-on-failure --no-tests=error "${labels[@]}" "$@" </dev/null || outcome=$?

python=/usr/bin/python3  # Debian's, as for the tests
[[ -x "$python" ]] || python=python3
"$python" "$root/tests/$suite/report.py"
echo "Written: $root/docs/$suite.md"
exit "$outcome"
