#!/usr/bin/env bash
# Downloads the Stanford bunny and dragon to meshes/ (docs/meshes.md).
#
# Credit to the Stanford University Computer Graphics Laboratory is required wherever they are shown. Licence of the
# Stanford 3D Scanning Repository: free for research use with that credit; no commercial redistribution, not even inside
# a product, without permission. http://graphics.stanford.edu/data/3Dscanrep/
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
target="$root/meshes"
# Another place that holds the archives, also file:///a/folder.
source="${BULKLEY_MESH_SOURCE:-http://graphics.stanford.edu/pub/3Dscanrep}"

fail() {
  echo "cluster/get_meshes.sh: $1" >&2
  exit 1
}

for tool in curl tar gzip; do
  command -v "$tool" >/dev/null || fail "needs $tool, which this machine lacks"
done

work="$(mktemp -d)"
trap 'rm -rf "$work"' EXIT

# get NAME ARCHIVE FILE-IN-ARCHIVE NUMBER-OF-FACES
get() {
  local name="$1" archive="$2" file="$3" faces="$4"
  if [[ -s "$target/$name.ply" ]]; then
    echo "meshes/$name.ply is there already."
    return
  fi
  echo "Fetching $source/$archive"
  local reason
  reason="$(curl --fail --silent --show-error --location --connect-timeout 20 --max-time 900 --retry 2 \
    --output "$work/$name.tar.gz" "$source/$archive" 2>&1)" ||
    fail "cannot fetch $source/$archive (${reason##*$'\n'}); file = \"builtin:hare\" and \"builtin:dragon\" need no network"
  tar --extract --gzip --file "$work/$name.tar.gz" --directory "$work" "$file" 2>/dev/null ||
    fail "$archive does not hold $file; the repository may have changed"
  # The header must be that of the mesh we know: an error page or a cut-off file has another.
  head -c 1000 "$work/$file" | tr -d '\r' | grep -a "^element face $faces\$" >/dev/null ||
    fail "$file has not the $faces faces it should have"
  mkdir -p "$target"
  mv "$work/$file" "$target/$name.ply"
  echo "meshes/$name.ply: $faces triangles"
}

get bunny bunny.tar.gz bunny/reconstruction/bun_zipper.ply 69451
get dragon dragon/dragon_recon.tar.gz dragon_recon/dragon_vrip_res3.ply 47794

echo "In place of builtin:hare and builtin:dragon, with BODY the name of the body that has the mesh:"
for name in bunny dragon; do
  echo "  bulkley run SCENE.toml --set bodies.BODY.shape.file=$target/$name.ply"
done
echo "Credit: Stanford University Computer Graphics Laboratory."
