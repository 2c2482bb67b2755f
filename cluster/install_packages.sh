#!/usr/bin/env bash
# Installs the packages of Debian 12 or 13 that Bulkley needs and this machine lacks. Asks nothing; needs root or sudo only when
# something is missing.
#
#   cluster/install_packages.sh [--program | --pictures | --slurm | --deb]
#
# Without an option: all that the program, its tests, pictures, notebooks and pages need.
# --program: what building and running the program needs, two fifths of the megabytes of all. --pictures: what reports and pictures need.
# cluster/quickstart.sh begins with these two; cluster/test.sh installs the rest.
# --slurm: all, and Slurm and munge for the test that runs the job scripts (tests/packaging/cluster), and shellcheck, which reads them.
# Their services do not have to run.
# --deb: what cluster/packaging/build_deb.sh builds Debian packages with: --program and Debian's tools.
set -euo pipefail

program=(
  g++ cmake ninja-build pkg-config
  petsc-dev                                     # brings Open MPI and parallel HDF5
  libeigen3-dev libmetis-dev libfmt-dev libtomlplusplus-dev libcli11-dev libmuparser-dev
  nlohmann-json3-dev zlib1g-dev
)
pictures=(
  python3 python3-numpy python3-h5py
  python3-matplotlib                            # reports, and plots of the rheometer and of the verification page
  paraview python3-paraview xvfb python3-pil    # Debian's ParaView renders only with an X server; Pillow joins pictures to strips
)
others=(
  libgtest-dev iproute2                         # tests
  python3-pandas python3-nbconvert python3-ipykernel  # data frames, and the notebook of the Python package
  mkdocs mkdocs-material doxygen                # the pages as a site
)
debian=(build-essential debhelper dh-python pybuild-plugin-pyproject python3 python3-setuptools lintian)

case "${1:-}" in
  "") packages=("${program[@]}" "${pictures[@]}" "${others[@]}") ;;
  --program) packages=("${program[@]}") ;;
  --pictures) packages=("${pictures[@]}") ;;
  --slurm) packages=("${program[@]}" "${pictures[@]}" "${others[@]}" slurm-wlm munge shellcheck) ;;
  --deb) packages=("${program[@]}" "${debian[@]}") ;;
  *) echo "cluster/install_packages.sh: '$1' is not an option; there are --program, --pictures, --slurm and --deb" >&2; exit 2 ;;
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
  echo "All packages that are needed are installed."
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

# --no-remove: refuse rather than take away a package that conflicts, such as python3-vtk9 with ParaView.
apt=("${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get --quiet=2 --option Dpkg::Use-Pty=0
  --option DPkg::Lock::Timeout=300)
install=(install --assume-yes --no-install-recommends --no-remove "${missing[@]}")
log="$(mktemp)"
trap 'rm -f "$log"' EXIT
give_up() {
  tail -n 40 "$log" >&2
  echo "cluster/install_packages.sh: apt-get could not install the packages; its last lines are above" >&2
  exit 1
}
"${apt[@]}" update </dev/null >"$log" 2>&1 || give_up
"${apt[@]}" --print-uris "${install[@]}" </dev/null >"$log" 2>&1 || give_up
size="$(awk '/^\047/ {n += 1; bytes += $3} END {printf "%d in all, %.0f MB to download", n, bytes / 1e6}' "$log")"
echo "Installing ${#missing[@]} packages and what they depend on, $size: ${missing[*]}"
"${apt[@]}" "${install[@]}" </dev/null >"$log" 2>&1 || give_up
