#!/usr/bin/env bash
# From a fresh clone to pictures: installs what the first run needs, builds the program, runs a splash on 2 ranks, draws it.
# Minutes on two free cores, and what the downloads take (500 MB, more than half of them behind the build). What tests, notebooks and
# the pages as a site need comes later: cluster/test.sh installs it.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
cd "$root"
scene=first_splash
output="out/$scene"
picture_log=out/picture_packages.log
mkdir -p out

times=()
stage() {  # stage NAME SENTENCE...: ends the last stage and says what comes, and how long it takes on two cores
  end_stage
  name="$1"
  begin=$SECONDS
  echo "== $2"
}
end_stage() {
  if [[ -n "${name:-}" ]]; then times+=("$(printf '%s %d s' "$name" $((SECONDS - begin)))"); fi
}

installing=""
let_installing_end() {  # dpkg refuses to go on after an installation that was broken off
  if [[ -n "$installing" ]]; then
    echo "The packages for pictures are still being installed; waiting for that to end." >&2
    wait "$installing" || true
  fi
}
trap let_installing_end EXIT

stage packages "1/5 packages to build and run the program: half a minute and the download"
cluster/install_packages.sh --program
# ParaView and matplotlib are not needed before the last stages.
cluster/install_packages.sh --pictures </dev/null >"$picture_log" 2>&1 &
installing=$!

stage build "2/5 build of the program: four minutes; meanwhile packages for pictures are installed (log: $picture_log)"
cluster/build.sh --program

stage run "3/5 run of drivers/scenes/$scene.toml on 2 ranks: seconds"
. cluster/environment.sh
mpirun -n 2 build/bulkley run "drivers/scenes/$scene.toml" --out "$output" --overwrite </dev/null

if kill -0 "$installing" 2>/dev/null; then stage "rest of the packages" "waiting for the packages for pictures"; fi
process="$installing"
installing=""
if ! wait "$process"; then
  cat "$picture_log" >&2
  echo "cluster/quickstart.sh: the packages for pictures could not be installed (above); the run is in $root/$output" >&2
  exit 1
fi

stage picture "4/5 six pictures in a strip: half a minute"
pvpython drivers/paraview/render.py --run "$output" --strip "$output/splash.png" --frame 0,2,4,7,12,30 \
  --look "drivers/paraview/looks/$scene.toml" </dev/null

stage report "5/5 report: seconds"
build/bulkley report "$output" </dev/null
end_stage
name=""

cat <<END

Done in $((SECONDS / 60)) min $((SECONDS % 60)) s: $(printf '%s, ' "${times[@]}" | sed 's/, $//').
  Pictures of the splash:   $root/$output/splash.png
  Report of the run:        $root/$output/report.html   (any browser)
  Open in ParaView:         $root/$output/frames.xdmf   (choose a reader if asked: Xdmf3 Reader S)
Next, and then docs/tutorial.md:
  . cluster/environment.sh    # Open MPI's settings for a workstation; then a slower ball, and a film of it:
  mpirun -n 2 build/bulkley run drivers/scenes/$scene.toml --set 'bodies.ball.velocity=[0,0,-4]' --out out/crown
  pvpython drivers/paraview/render.py --run out/crown --animation film.gif --look drivers/paraview/looks/$scene.toml
END
