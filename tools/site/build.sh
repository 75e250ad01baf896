#!/bin/sh
# build.sh: the static site in build/site. Its tools live in build/site-tools: MkDocs (group `site` of pyproject.toml) and
# KaTeX from npm.
set -eu
cd "$(dirname "$0")/../.."
here=tools/site
work=build/site-tools
katex=0.19.1
mkdir -p "$work"
export NO_MKDOCS_2_WARNING=1

# the environment is made anew when the list of packages changes
sed -n "/^site = \[/,/\]/p" pyproject.toml >"$work/wanted"
if ! cmp -s "$work/wanted" "$work/installed"; then
  rm -rf "$work/site"
  "$(tools/python.sh)" -m venv "$work/site"
  "$work/site/bin/python" -m pip install --quiet "pip>=25.1"
  "$work/site/bin/python" -m pip install --quiet --group site
  cp "$work/wanted" "$work/installed"
fi
if [ "$(cat "$work/katex/version" 2>/dev/null)" != "$katex" ]; then
  rm -rf "$work/package" "$work/katex"
  (cd "$work" && npm pack --silent "katex@$katex" && tar xzf "katex-$katex.tgz" && rm "katex-$katex.tgz")
  mkdir "$work/katex"
  mv "$work/package/LICENSE" "$work/package/dist/katex.min.js" "$work/package/dist/katex.min.css" "$work/package/dist/fonts" \
    "$work/katex"
  rm -r "$work/package"
  echo "$katex" >"$work/katex/version"
fi

"$work/site/bin/python" $here/stage.py "$work"
out=build/site
"$work/site/bin/mkdocs" build --strict --config-file "$work/mkdocs.yml" --site-dir "$PWD/$out"
# the page for missing pages needs the address of the site
rm "$out/404.html"
echo "$out"
