#!/bin/sh
# wheel.sh [--dry]: sdist and wheel in build/wheel. The wheel is built from the sdist and needs no compiler. With --dry it
# makes the sdist only, by what .venv has.
set -eu
cd "$(dirname "$0")/.."
export PATH="$PWD/.venv/bin:$PATH"
out=build/wheel
if [ "${1:-}" = --dry ]; then
  rm -rf "$out"
  python -m build --sdist --no-isolation --outdir "$out"
  exit
fi
version=$(python -c "import asperity; print(asperity.__version__)")
# with the version pinned pip takes no package of this name from an index
python -m pip install --quiet "asperity[wheel]==$version"
rm -rf "$out"
python -m build --outdir "$out/made"
tools/repair_wheel.sh "$out"/made/*.whl "$out"
mv "$out"/made/*.tar.gz "$out"
rm -r "$out/made"
cd "$out"
echo "$out:" ./*
