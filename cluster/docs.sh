#!/usr/bin/env bash
# Builds the pages of docs/ as a site with MkDocs and the reference of the public headers with Doxygen; a warning of either
# is an error. Usage: cluster/docs.sh [FOLDER], by default out/site; open its index.html. Nothing in it needs a network.
set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
site="$(realpath --canonicalize-missing "${1:-$root/out/site}")"

for tool in mkdocs doxygen; do
  if ! command -v "$tool" >/dev/null; then
    echo "cluster/docs.sh: needs $tool (Debian: apt-get install --no-install-recommends mkdocs mkdocs-material doxygen)" >&2
    exit 1
  fi
done
if [[ -e "$site" && ! -f "$site/sitemap.xml" && -n "$(ls -A "$site")" ]]; then
  echo "cluster/docs.sh: $site holds something that is no site; name another folder" >&2
  exit 1
fi

cd "$root"
log="$(mktemp)"
trap 'rm -f "$log"' EXIT
if ! mkdocs build --strict --clean --config-file docs/site/mkdocs.yml --site-dir "$site" >"$log" 2>&1; then
  grep -vE '^INFO|^  ' "$log" >&2
  exit 1
fi
mkdir -p "$site/api"
{ cat docs/site/Doxyfile; echo "OUTPUT_DIRECTORY = \"$site/api\""; } | doxygen -
# Doxygen links to a list of nested classes on pages where it has left them out because they are private.
grep --files-without-match --null 'name="nested-classes"' "$site"/api/*.html |
  xargs --null sed --in-place 's|<a href="#nested-classes">Classes</a> &#124;||'
echo "Site: $site/index.html"
