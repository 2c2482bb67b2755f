#!/usr/bin/env bash
# Builds the Debian packages, source and binary, and lets lintian read them; an error of lintian is one here. For
# Debian 12. The build has no tests but that of the program's start.
#
#   cluster/packaging/build_deb.sh [--jobs=N] [FOLDER]      FOLDER: where to, default: out/deb
#
# --jobs: compilations at once, each of which takes up to 1.5 GiB; without it, as many as cores and memory allow.
# In a git clone the source is that of the last commit; in an unpacked archive, that of cluster/release.sh, it is the folder.
set -euo pipefail
PATH=/usr/sbin:/usr/bin:/sbin:/bin  # Debian's own tools and Python

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
jobs="" folder="$root/out/deb"
for argument in "$@"; do
  case "$argument" in
    --jobs=[1-9] | --jobs=[1-9][0-9]) jobs="${argument#--jobs=}" ;;
    -*) echo "build_deb.sh: '$argument' is not --jobs=N with N from 1 to 99" >&2; exit 2 ;;
    *) folder="$argument" ;;
  esac
done
for tool in dpkg-buildpackage dh lintian; do
  if ! command -v "$tool" >/dev/null; then
    echo "build_deb.sh: needs $tool; 'cluster/install_packages.sh --deb' installs what it needs" >&2
    exit 1
  fi
done
if [[ -z "$jobs" ]]; then
  cores="$(env -u OMP_NUM_THREADS nproc)"
  by_memory="$(awk '/^MemAvailable/ {print int($2 / 1024 / 1536)}' /proc/meminfo)"
  jobs=$((by_memory < cores ? by_memory : cores))
  jobs=$((jobs < 1 ? 1 : jobs))
fi

version="$(sed -n 's/^project(bulkley VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")"
mkdir -p "$folder"
folder="$(cd "$folder" && pwd)"
work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
if [[ -e "$root/.git" ]]; then
  archive="$("$root/cluster/release.sh" --snapshot "$work")"
else
  archive="$work/bulkley.tar.gz"
  tar --create --gzip --file "$archive" --directory "$(dirname "$root")" --exclude="$(basename "$root")/out" \
    --exclude="$(basename "$root")/build" "$(basename "$root")"
fi
original="$work/bulkley_$version.orig.tar.gz"
mv "$archive" "$original"
tree="$work/bulkley-$version"
mkdir "$tree"
tar --extract --gzip --file "$original" --directory "$tree" --strip-components=1
cp -R "$tree/cluster/packaging/debian" "$tree/debian"

(cd "$tree" && dpkg-buildpackage --unsigned-source --unsigned-changes --jobs="$jobs")
# The packages are not uploaded to Debian, where the first upload answers a report.
lintian --fail-on error --suppress-tags initial-upload-closes-no-bugs "$work"/bulkley_*.changes
rm -rf "$tree" "$work"/*.sha256
cp "$work"/*bulkley* "$folder/"
ls -l "$folder"
