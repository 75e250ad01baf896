#!/bin/sh
# release.sh: what a release consists of, in build/release-VERSION, made from a clean clone of the last commit: sdist,
# wheel, single-file sources for Abaqus and checksums. Then the sdist is tested in a bare Debian root with compilers.
# ADDRESS is that of the repository, which replaces its placeholder in the README.
# With --dry it makes the sdist only, in build/release-dry-VERSION, from a tree in any state.
set -eu
dry=${1:-}
cd "$(dirname "$0")/.."
top=$PWD
version=$(sed -n 's/.*public :: version = "\(.*\)"/\1/p' src/law/asperity_contract.f90)
out=$top/build/release-${dry:+dry-}$version
clone=$out/clone
stop() {
  echo "$1" >&2
  exit 1
}
[ -n "$dry" ] || [ -z "$(git status --porcelain)" ] || stop "the tree has changes that are not committed: expected a clean tree"
grep -q "^## $version ([0-9]*-[0-9]*-[0-9]*)$" CHANGELOG.md ||
  stop "CHANGELOG.md: expected the heading '## $version (YYYY-MM-DD)', the version with the date of the release"
[ -n "$dry${ADDRESS:-}" ] || stop "ADDRESS is not set: expected the address of the repository, for the README"
tag=$(git describe --exact-match --tags --match 'v*' 2>/dev/null || echo "v$version")
[ "$tag" = "v$version" ] || stop "tag $tag: expected v$version, the version of the library"

rm -rf "$out"
git clone --quiet --no-local ${dry:+--depth=1} . "$clone"
grep -q "^git clone ADDRESS asperity$" "$clone/README.md" || stop "README.md: expected the line 'git clone ADDRESS asperity'"
[ -n "$dry" ] || sed -i -e "s|^git clone ADDRESS asperity$|git clone $ADDRESS asperity|" \
  -e "s|^ADDRESS is that of this repository. ||" "$clone/README.md"
export PATH="$top/.venv/bin:$PATH"
(cd "$clone" && tools/wheel.sh $dry)
if [ -n "$dry" ]; then
  tar -tzf "$clone"/build/wheel/asperity-*.tar.gz >"$out/files"
  rm -rf "$clone"
  echo "$out/files"
  exit
fi
cp "$clone"/build/wheel/*.whl "$clone"/build/wheel/*.tar.gz "$out"

abaqus=asperity-abaqus-$version
mkdir "$out/$abaqus"
python -m zipfile -e "$out"/*.whl "$out/open"
cp "$out"/open/asperity/abaqus/* LICENSE CITATION.cff docs/how-to/abaqus.md "$out/$abaqus"
tar -C "$out" --sort=name --owner=0 --group=0 --numeric-owner --mtime="@$(git log -1 --format=%ct)" -cf - "$abaqus" |
  gzip -n >"$out/$abaqus.tar.gz"
rm -rf "$out/$abaqus" "$out/open" "$clone"
(cd "$out" && sha256sum ./*.whl ./*.tar.gz >SHA256SUMS && cat SHA256SUMS)
echo "$out"
