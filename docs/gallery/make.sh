#!/usr/bin/env bash
# Runs the figures of docs/gallery, measures them, and renders their pictures. Run from anywhere, after a build.
#
#   docs/gallery/make.sh [--size small|default] [--ranks N] [--no-pictures] [NUMBER]...
#
# Runs and facts go to out/gallery/SIZE, pictures of the default size to docs/gallery, others beside the runs. A run that has
# ended is not repeated: remove its folder to have it again.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
. "$root/cluster/environment.sh"
bulkley="${BULKLEY:-$root/build/bulkley}"
python=/usr/bin/python3  # Debian's, which its h5py belongs to
[[ -x "$python" ]] || python=python3

size=default ranks=2 pictures=yes numbers=()
while [[ $# -gt 0 ]]; do
  case "$1" in
    --size) size="$2"; shift 2 ;;
    --ranks) ranks="$2"; shift 2 ;;
    --no-pictures) pictures=no; shift ;;
    [0-9]) numbers+=("$1"); shift ;;
    *) echo "make.sh: '$1' is neither an option nor the number of a figure" >&2; exit 2 ;;
  esac
done
[[ ${#numbers[@]} -gt 0 ]] || numbers=(1 3 4 5 6 7 8 9)
case "$size" in
  small) cells=(--set domain.cell_size=0.0125) ;;
  default) cells=() ;;
  *) echo "make.sh: --size is small or default" >&2; exit 2 ;;
esac
out="$root/out/gallery/$size"
target="$root/docs/gallery"
[[ "$size" == default ]] || target="$out"
mkdir -p "$out"
# Twins of the figures that show crushed material: a real bulk modulus and the implicit pressure, on somewhat wider cells.
real=(--set time.integrator=imex --set materials.fluid.bulk_modulus=2e9)
[[ "$size" == default ]] && real+=(--set domain.cell_size=0.00625)

# simulate NAME SCENE OPTIONS...: runs the scene unless it has been run.
simulate() {
  local name="$1" scene="$2"
  shift 2
  grep -qs '"state": "finished"' "$out/$name/status.json" && return
  echo "== $name" >&2
  local begin=$SECONDS
  mpirun -n "$ranks" "$bulkley" run "$root/drivers/scenes/$scene.toml" "${cells[@]}" "$@" --out "$out/$name" --overwrite \
    --quiet </dev/null
  echo "$((SECONDS - begin)) s on $ranks ranks" >"$out/$name/wall_time.txt"
}

# facts NAME COMMAND OPTIONS...: adds what `measure` of the Python package tells of the run to the figure's facts.
facts() {
  local name="$1" command="$2"
  shift 2
  { echo "### $name: $command"; echo; "$python" "$root/drivers/python/bulkley" measure "$command" "$out/$name" "$@"; echo; } >>"$page"
}

# picture NAME FRAMES [PICTURE]: a strip of frames in the look of the picture, or else of the figure.
picture() {
  [[ "$pictures" == yes ]] || return 0
  local picture="${3:-figure_$number}" looks="$root/drivers/paraview/looks"
  local look="$looks/$picture.toml"
  [[ -f "$look" ]] || look="$looks/figure_$number.toml"
  pvpython "$root/drivers/paraview/render.py" --run "$out/$1" --strip "$target/$picture.png" --frame "$2" --look "$look"
}

for number in "${numbers[@]}"; do
  page="$out/figure_$number.md"
  rm -f "$page"
  case "$number" in
    1)
      simulate figure_1 figure_1_oobleck_bunny
      simulate figure_1_bouncing figure_1_oobleck_bunny --set materials.fluid.preset=bouncing_oobleck
      simulate figure_1_real figure_1_oobleck_bunny "${real[@]}"
      for name in figure_1 figure_1_bouncing figure_1_real; do
        facts "$name" rebound
        facts "$name" spread
      done
      picture figure_1 0,4,7,15,30,100
      picture figure_1_bouncing 0,5,7,12,28,100 figure_1_bouncing
      picture figure_1_real 0,5,7,10,20,45 figure_1_real
      ;;
    3)
      for scheme in apic flip pic; do
        simulate "figure_3_$scheme" figure_3_spinning_body --set "transfer.scheme=$scheme"
      done
      "$python" "$root/drivers/python/bulkley" measure spin "$out/figure_3_"{apic,flip,pic} --plot "$target/figure_3_curves.png" >"$page"
      picture figure_3_apic 0,3,6,9,12,15
      ;;
    4)
      simulate figure_4 figure_4_elastic_bunny
      facts figure_4 rebound
      picture figure_4 0,5,6,8,12,30
      ;;
    5)
      simulate figure_5 figure_5_pie_bunny
      facts figure_5 rebound
      facts figure_5 spread
      picture figure_5 0,4,5,7,10,60
      ;;
    6)
      simulate figure_6 figure_6_oobleck_dragon
      simulate figure_6_real figure_6_oobleck_dragon "${real[@]}"
      for name in figure_6 figure_6_real; do
        facts "$name" rebound
        facts "$name" spread --times 0,0.05,0.1,0.2,0.3,0.5,0.75,1,1.5,2,2.5,3
      done
      picture figure_6 0,3,10,20,50,150
      picture figure_6_real 0,3,10,20,50,150 figure_6_real
      ;;
    7)
      simulate figure_7 figure_7_cream_splash
      facts figure_7 spread
      picture figure_7 0,6,8,12,20,40
      ;;
    8)
      simulate figure_8 figure_8_colliding_balls
      simulate figure_8_pie figure_8_colliding_balls --set materials.fluid.preset=pie
      for name in figure_8 figure_8_pie; do
        facts "$name" collision --times 0,0.06,0.07,0.08,0.09,0.1,0.12,0.14,0.2,0.3
        facts "$name" pieces --times 0,0.08,0.1,0.12,0.14,0.2,0.3
      done
      picture figure_8 0,6,8,10,14,30
      picture figure_8_pie 0,6,8,10,14,30 figure_8_pie
      ;;
    9)
      simulate figure_9 figure_9_rod
      simulate figure_9_real figure_9_rod "${real[@]}"
      for name in figure_9 figure_9_real; do
        facts "$name" pieces --times 0,0.005,0.01,0.015,0.02,0.03,0.05,0.1,0.2,0.3
      done
      picture figure_9 0,2,3,4,8,16
      picture figure_9_real 0,2,3,4,8,16 figure_9_real
      ;;
  esac
  cat "$page"
done
