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

for law in neo_hookean hencky fixed_corotated; do
  picture "$law" "$scene" --material "$law" --mode startup --rates 1 --strain 4
done
picture herschel_bulkley --preset cream --mode shear --rates 0.01:100:20
picture newtonian "$scene" --material water --mode shear --rates 0.1:100:10
picture oldroyd_b "$scene" --material polymer --mode shear --rates 0.1:100:16
picture finite_viscoelastic "$scene" --material finite_viscoelastic --mode oscillation --frequencies 0.5:500:16
picture thixotropic_herschel_bulkley "$scene" --material thixotropic --mode shear --rates 0.01:100:20
picture thixotropic_recovery "$scene" --material thixotropic --mode thixotropy --rates 0.1,10,0.1
picture drucker_prager --preset sand --mode startup --rates 1 --strain 0.3 --pressure 1000
picture snow --preset snow --mode startup --rates 1 --strain 0.3
