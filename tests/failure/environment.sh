# Sourced by the scripts beside it: failure_test NAME ARGUMENTS... runs NAME.py. The program is build/bulkley, or what BULKLEY
# names; files go to out/NAME, or where WORK says.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
. "$root/cluster/environment.sh"
export OMPI_MCA_mpi_yield_when_idle=1 PYTHONDONTWRITEBYTECODE=1
python=/usr/bin/python3  # Debian's h5py and numpy belong to Debian's own Python
[[ -x "$python" ]] || python=python3

failure_test() {
  local name="$1"
  shift
  exec "$python" "$root/tests/failure/$name.py" --program "${BULKLEY:-$root/build/bulkley}" --work "${WORK:-$root/out/$name}" "$@"
}
