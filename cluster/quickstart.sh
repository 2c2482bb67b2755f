#!/usr/bin/env bash
# From a fresh clone to a picture: installs what is missing, builds, runs the cream splash on 2 ranks, renders it at 0.07 s.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
cd "$root"
output=out/cream_splash

echo "== 1/4 packages"
cluster/install_packages.sh
echo "== 2/4 build"
cluster/build.sh --target bulkley_program
echo "== 3/4 run: drivers/scenes/cream_splash.toml on 2 ranks"
. cluster/environment.sh
mpirun -n 2 build/bulkley run drivers/scenes/cream_splash.toml --out "$output" --overwrite </dev/null
echo "== 4/4 picture of the splash at 0.07 s"
pvpython drivers/paraview/render.py --run "$output" --frame 14 --zoom 1.5 --output "$output/splash.png" </dev/null

cat <<END

Done.
  Picture of the splash:      $root/$output/splash.png
  Open in ParaView:           $root/$output/frames.xdmf   (choose a reader if asked: Xdmf3 Reader S)
  Time series of the run:     $root/$output/history.csv
Next: continue with docs/tutorial.md; cluster/test.sh runs all tests.
END
