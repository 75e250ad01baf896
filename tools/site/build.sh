#!/bin/sh
# build.sh: the static site in build/site. Its tools live in build/site-tools: MkDocs (group
# `site` of pyproject.toml), FORD, which needs another version of the Markdown parser (`site-fortran`), KaTeX from npm.
set -eu
cd "$(dirname "$0")/../.."
here=tools/site
work=build/site-tools
katex=0.19.1
mkdir -p "$work"
export NO_MKDOCS_2_WARNING=1

# environment GROUP: made anew when the list of packages changes
environment() {
  sed -n "/^$1 = \[/,/\]/p" pyproject.toml >"$work/$1.wanted"
  cmp -s "$work/$1.wanted" "$work/$1.installed" && return
  rm -rf "${work:?}/$1"
  "$(tools/python.sh)" -m venv "$work/$1"
  "$work/$1/bin/python" -m pip install --quiet "pip>=25.1"
  "$work/$1/bin/python" -m pip install --quiet --group "$1"
  cp "$work/$1.wanted" "$work/$1.installed"
}
environment site
environment site-fortran
if [ "$(cat "$work/katex/version" 2>/dev/null)" != "$katex" ]; then
  rm -rf "$work/package" "$work/katex"
  (cd "$work" && npm pack --silent "katex@$katex" && tar xzf "katex-$katex.tgz" && rm "katex-$katex.tgz")
  mkdir "$work/katex"
  mv "$work/package/LICENSE" "$work/package/dist/katex.min.js" "$work/package/dist/katex.min.css" "$work/package/dist/fonts" \
    "$work/katex"
  rm -r "$work/package"
  echo "$katex" >"$work/katex/version"
fi

rm -rf "$work/fortran"
"$work/site-fortran/bin/python" $here/fortran_pages.py "$work/fortran"
"$work/site/bin/python" $here/stage.py "$work"
out=build/site
"$work/site/bin/mkdocs" build --strict --config-file "$work/mkdocs.yml" --site-dir "$PWD/$out"
# the page for missing pages needs the address of the site
rm "$out/404.html"
echo "$out"
