#!/usr/bin/env bash
# Installs the Debian 12 packages that Bulkley needs and this machine lacks. Asks nothing; needs root or sudo only when
# something is missing.
#
#   cluster/install_packages.sh [--slurm]
#
# --slurm: Slurm and munge as well, for the test that runs the job scripts (tests/packaging/cluster), and shellcheck, which reads them.
# Their services do not have to run.
set -euo pipefail

packages=(
  g++ cmake ninja-build pkg-config
  petsc-dev                                     # brings Open MPI and parallel HDF5
  libeigen3-dev libmetis-dev libfmt-dev libtomlplusplus-dev libcli11-dev libmuparser-dev
  nlohmann-json3-dev zlib1g-dev
  libgtest-dev python3 python3-numpy python3-h5py iproute2  # tests
  python3-matplotlib                            # plots of reports, of the rheometer and of the verification page
  python3-pandas python3-nbconvert python3-ipykernel  # data frames, and the notebook of the Python package
  mkdocs mkdocs-material doxygen                # the pages as a site
  paraview python3-paraview xvfb                # pictures; Debian's ParaView renders only with an X server
)

case "${1:-}" in
  "") ;;
  --slurm) packages+=(slurm-wlm munge shellcheck) ;;
  *) echo "cluster/install_packages.sh: '$1' is not an option; there is --slurm" >&2; exit 2 ;;
esac

is_installed() {
  [[ "$(dpkg-query --show --showformat='${db:Status-Status}' "$1" 2>/dev/null)" == installed ]]
}

if ! command -v apt-get >/dev/null || ! command -v dpkg-query >/dev/null; then
  echo "cluster/install_packages.sh: this machine has no apt-get; install the equivalents of: ${packages[*]}" >&2
  exit 1
fi

missing=()
for package in "${packages[@]}"; do
  is_installed "$package" || missing+=("$package")
done
if ((${#missing[@]} == 0)); then
  echo "All packages that Bulkley needs are installed."
  exit 0
fi

as_root=()
if ((EUID != 0)); then
  if ! command -v sudo >/dev/null || ! sudo --non-interactive true 2>/dev/null; then
    echo "cluster/install_packages.sh: missing packages need root, or sudo without a password; as root, run:" \
      "apt-get install --no-install-recommends ${missing[*]}" >&2
    exit 1
  fi
  as_root=(sudo)
fi

echo "Installing ${#missing[@]} packages and what they depend on: ${missing[*]}"
# --no-remove: refuse rather than take away a package that conflicts, such as python3-vtk9 with ParaView.
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get --quiet=2 --option Dpkg::Use-Pty=0
  --option DPkg::Lock::Timeout=300)
log="$(mktemp)"
trap 'rm -f "$log"' EXIT
if ! { "${apt[@]}" update && "${apt[@]}" install --assume-yes --no-install-recommends --no-remove "${missing[@]}"; } \
  </dev/null >"$log" 2>&1; then
  tail -n 40 "$log" >&2
  echo "cluster/install_packages.sh: apt-get could not install the packages; its last lines are above" >&2
  exit 1
fi
