#!/usr/bin/env bash
# Prints what the adaptive time step gains on the figures' scenes; docs/adaptive-step.md holds the tables. Options: --help.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
. "$root/cluster/environment.sh"
python=/usr/bin/python3  # Debian's, which its h5py belongs to
[[ -x "$python" ]] || python=python3
exec "$python" "$root/drivers/adaptive_gain.py" "$@"
