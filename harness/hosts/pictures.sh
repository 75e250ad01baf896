#!/bin/sh
# pictures.sh PYTHON FOLDER: draws the structural results of docs/how-to (kratos, ogs, calculix, python-fe) into FOLDER.
# A host that is not installed is left out.
# Needs ASPERITY_LIBRARY and ASPERITY_CALCULIX, as `make hosts` sets them.
set -eu
python=$1 folder=$2 here=$(dirname "$0")
drawn=""
kratos=$("$python" -c "import KratosMultiphysics.GeoMechanicsApplication" >/dev/null 2>&1 && echo yes || true)
if [ "$kratos" ]; then
  "$python" "$here/kratos/triplet.py" -o "$folder/kratos-triplet.png"
  drawn="$drawn $folder/kratos-triplet.png"
fi
if "$python" -c "import ogs" >/dev/null 2>&1; then
  "$python" "$here/ogs/ogs_triplet.py" -o "$folder/ogs-triplet.png"
  "$python" "$here/ogs/ogs_block.py" -o "$folder/ogs-block.png"
  drawn="$drawn $folder/ogs-triplet.png $folder/ogs-block.png"
fi
if [ -f "$ASPERITY_CALCULIX/ready" ]; then
  "$here/calculix/link.sh" "$ASPERITY_CALCULIX" "$ASPERITY_LIBRARY" "$ASPERITY_CALCULIX/ccx"
  "$python" "$here/calculix/dcb.py" "$ASPERITY_CALCULIX/ccx" -o "$folder/calculix-dcb.png"
  drawn="$drawn $folder/calculix-dcb.png"
fi
if "$python" -c "import skfem" >/dev/null 2>&1; then
  "$python" "$here/python/dcb.py" -o "$folder/python-dcb.png"
  "$python" "$here/python/pull_out.py" -o "$folder/python-pull-out.png"
  "$python" "$here/python/snap_back.py" -o "$folder/python-snap-back.png"
  drawn="$drawn $folder/python-dcb.png $folder/python-pull-out.png $folder/python-snap-back.png"
  if [ "$kratos" ]; then
    "$python" "$here/kratos/pulled_block.py" -o "$folder/kratos-pulled-block.png"
    drawn="$drawn $folder/kratos-pulled-block.png"
  fi
fi
echo "${drawn:-none: no host is there}"
