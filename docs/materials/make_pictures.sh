#!/usr/bin/env bash
# Makes the pictures of docs/materials with the virtual rheometer. Run from anywhere, after a build.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
bulkley="${BULKLEY:-$root/build/bulkley}"
scene="$root/drivers/scenes/all_materials.toml"
pictures="$root/docs/materials/pictures"
csv="$(mktemp -d)"
trap 'rm -rf "$csv"' EXIT
mkdir -p "$pictures"

# picture NAME OPTIONS...: runs the rheometer and plots it.
picture() {
  local name="$1"
  shift
  "$bulkley" rheometer "$@" --out "$csv/$name.csv" --plot "$pictures/$name.png"
}
