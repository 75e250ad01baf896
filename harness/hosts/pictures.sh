#!/bin/sh
# pictures.sh PYTHON FOLDER: draws the structural results of docs/how-to (kratos, ogs, oofem, akantu, calculix, python-fe) into
# FOLDER. A host that is not installed is left out. HOST-fields.png is drawn from the files for ParaView.
# Needs ASPERITY_LIBRARY and ASPERITY_CALCULIX, as `make hosts` sets them.
set -eu
python=$1 folder=$2 here=$(dirname "$0")
drawn=""

# fields NAME TITLE OPTION...: a picture from the files for ParaView
fields() {
  name=$1 title=$2
  shift 2
  "$python" "$here/joint_picture.py" "$folder/$name.pvd" -o "$folder/$name-fields.png" --title "$title" "$@"
  drawn="$drawn $folder/$name-fields.png"
}

if "$python" -c "import KratosMultiphysics.GeoMechanicsApplication" >/dev/null 2>&1; then
  "$python" "$here/kratos/triplet.py" -o "$folder/kratos-triplet.png" --pvd "$folder/kratos.pvd"
  fields kratos "Kratos: masonry triplet" --scale 100
  drawn="$drawn $folder/kratos-triplet.png"
fi
if "$python" -c "import ogs" >/dev/null 2>&1; then
  "$python" "$here/ogs/ogs_triplet.py" -o "$folder/ogs-triplet.png"
  "$python" "$here/ogs/ogs_block.py" -o "$folder/ogs-block.png" --pvd "$folder/ogs.pvd"
  fields ogs "OpenGeoSys: block between two joints" --up z --scale 100
  drawn="$drawn $folder/ogs-triplet.png $folder/ogs-block.png"
fi
if "$python" -c "import oofem" >/dev/null 2>&1; then
  "$python" "$here/oofem/pulled_block.py" --pvd "$folder/oofem.pvd"
  fields oofem "OOFEM: block pulled along a rough base" --scale 50 --up z
fi
if "$python" -c "import akantu" >/dev/null 2>&1; then
  "$python" "$here/akantu/peel.py" --pvd "$folder/akantu.pvd"
  fields akantu "Akantu: arm peeled off, elements inserted during the run" --scale 20 --step 58
fi
if [ -f "$ASPERITY_CALCULIX/ready" ]; then
  "$here/calculix/link.sh" "$ASPERITY_CALCULIX" "$ASPERITY_LIBRARY" "$ASPERITY_CALCULIX/ccx"
  "$python" "$here/calculix/dcb.py" "$ASPERITY_CALCULIX/ccx" -o "$folder/calculix-dcb.png" --pvd "$folder/calculix.pvd"
  fields calculix "CalculiX: end moments 0.5 to 1" --scale 3 --up z
  drawn="$drawn $folder/calculix-dcb.png"
fi
if "$python" -c "import skfem" >/dev/null 2>&1; then
  "$python" "$here/python/dcb.py" -o "$folder/python-dcb.png"
  "$python" "$here/python/pull_out.py" -o "$folder/python-pull-out.png" --pvd "$folder/python.pvd"
  fields python "scikit-fem: block pulled along a rough base" --scale 50
  "$python" "$here/python/crack.py" -o "$folder/python-crack.png"
  "$python" "$here/python/snap_back.py" -o "$folder/python-snap-back.png"
  drawn="$drawn $folder/python-dcb.png $folder/python-pull-out.png"
  drawn="$drawn $folder/python-crack.png $folder/python-snap-back.png"
fi
echo "${drawn:-none: no host is there}"
