#!/bin/sh
# repair_wheel.sh WHEEL FOLDER: writes a wheel to FOLDER that contains the run-time libraries of Fortran and OpenMP, so
# that it needs no package of the system (Linux).
set -eu
wheel=$1
out=$2
work=$(mktemp -d)
trap 'rm -r "$work"' EXIT
python -m auditwheel repair --wheel-dir "$work/repaired" "$wheel"

# auditwheel changes the libraries; the programs get the same libraries here
python -m wheel unpack --dest "$work/open" "$work"/repaired/*.whl
package=$(echo "$work"/open/*/asperity)
for program in "$package/rie_driver"; do
  chmod +x "$program"
  # shellcheck disable=SC2016  # $ORIGIN is for the loader
  patchelf --set-rpath '$ORIGIN/../asperity.libs' "$program"
  for library in "$package".libs/*; do
    name=$(basename "$library")
    needed=$(patchelf --print-needed "$program" | grep "^${name%%-*}[.]so" || true)
    [ -z "$needed" ] || patchelf --replace-needed "$needed" "$name" "$program"
  done
done
python -m wheel pack --dest-dir "$out" "$work"/open/*
