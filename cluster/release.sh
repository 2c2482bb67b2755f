#!/usr/bin/env bash
# Makes the source archive of a release, bulkley-VERSION.tar.gz and its SHA-256. The same commit gives the same bytes.
#
#   cluster/release.sh [--snapshot] [--check[=TIER,TIER]] [FOLDER]      FOLDER: where to, default: out
#
# --snapshot: of any commit, named by it: needs no heading in CHANGELOG.md, and ignores changes that are not committed.
# --check: unpacks the archive elsewhere, builds it and runs all of its tests there, as its user would; or those of some tiers.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
snapshot=false check=false tiers=all folder="$root/out"
for argument in "$@"; do
  case "$argument" in
    --snapshot) snapshot=true ;;
    --check) check=true ;;
    --check=?*) check=true tiers="${argument#--check=}" ;;
    -*) echo "release.sh: '$argument' is none of --snapshot, --check" >&2; exit 2 ;;
    *) folder="$argument" ;;
  esac
done

fail() {
  echo "release.sh: $1" >&2
  exit 2
}

git -C "$root" rev-parse --git-dir >/dev/null 2>&1 || fail "this is no git clone; a release is made from one"
# The one place of the version; everything else must agree with it.
version="$(sed -n 's/^project(bulkley VERSION \([0-9.]*\).*/\1/p' "$root/CMakeLists.txt")"
[[ -n "$version" ]] || fail "CMakeLists.txt names no version"
grep -qx "version: $version" "$root/CITATION.cff" || fail "CITATION.cff has another version than CMakeLists.txt ($version)"
name="bulkley-$version"
if $snapshot; then
  name="$name-g$(git -C "$root" rev-parse --short=12 HEAD)"
else
  grep -q "^## \[$version\]" "$root/CHANGELOG.md" || fail "CHANGELOG.md has no heading '## [$version]'"
  [[ -z "$(git -C "$root" status --porcelain)" ]] || fail "there are changes that are not committed"
fi

mkdir -p "$folder"
archive="$(cd "$folder" && pwd)/$name.tar.gz"
git -C "$root" archive --format=tar --prefix="$name/" HEAD | gzip -n -9 >"$archive.part"
mv "$archive.part" "$archive"
(cd "$folder" && sha256sum "$name.tar.gz" >"$name.tar.gz.sha256")
echo "$archive"
$check || exit 0

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT
tar --extract --gzip --file "$archive" --directory "$work"
read -ra tiers <<<"${tiers//,/ }"
"$work/$name/cluster/test.sh" "${tiers[@]}"
echo "$archive: builds, and its tests pass (${tiers[*]})"
