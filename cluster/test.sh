#!/usr/bin/env bash
# Installs what is missing, builds everything, and runs tests through ctest; ends with ctest's summary and its exit code.
#
#   cluster/test.sh [TIER ...] [ARGUMENTS OF CTEST]
#
# Tiers (docs/testing.md): fast, system, packaging, perf, slow; all: everything but slow. Without a tier: fast and system, or, if
# -L or -R selects tests, all. For example `cluster/test.sh fast`, `cluster/test.sh -L docs`.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
every="fast|system|packaging|perf"

tiers=""
while (($# > 0)); do
  case "$1" in
    fast | system | packaging | perf | slow) tiers+="${tiers:+|}$1" ;;
    all) tiers+="${tiers:+|}$every" ;;
    -*) break ;;
    *) echo "cluster/test.sh: '$1' is not a tier; there are fast, system, packaging, perf, slow and all" >&2; exit 2 ;;
  esac
  shift
done
others=""
if [[ -z "$tiers" ]]; then
  tiers="fast|system"
  if [[ " $* " =~ \ (-L|-R|--label-regex|--tests-regex)[\ =] ]]; then
    tiers="$every"
  else
    others="Not run: 'cluster/test.sh packaging' (installation, pages, job scripts, pictures), 'perf', 'slow'; 'all' is all but slow."
  fi
fi

"$root/cluster/install_packages.sh"
"$root/cluster/build.sh"
code=0
ctest --test-dir "$root/build" --output-on-failure --no-tests=error --label-regex "^($tiers)\$" \
  --parallel "$(env -u OMP_NUM_THREADS nproc)" "$@" </dev/null || code=$?
[[ -z "$others" ]] || echo "$others"
exit "$code"
