#!/bin/sh
# pictures.sh PYTHON FOLDER: draws the structures of docs/how-to/fe-programs.md into FOLDER,
# from their files for ParaView. A host that is not installed is left out.
# Needs ASPERITY_LIBRARY and ASPERITY_CALCULIX, as `make hosts` sets them.
set -eu
python=$1 folder=$2 here=$(dirname "$0")
drawn=""

# picture HOST MODULE TITLE SCRIPT OPTIONS...: runs a structure and draws it; OPTIONS are those of joint_picture.py
picture() {
  host=$1 title=$3 script=$4 curves=""
  "$python" -c "import $2" >/dev/null 2>&1 || return 0
  shift 4
  # shellcheck disable=SC2086  # a script may have an argument
  "$python" "$here/"$script --pvd "$folder/$host.pvd"
  [ ! -f "$folder/$host.csv" ] || curves="--curves $folder/$host.csv"
  # shellcheck disable=SC2086
  "$python" "$here/joint_picture.py" "$folder/$host.pvd" -o "$folder/$host-fields.png" --title "$title" \
    $curves "$@"
  drawn="$drawn $folder/$host-fields.png"
}

ccx=$ASPERITY_CALCULIX/ccx
mkdir -p "$folder"
rm -f "$folder"/*.csv
picture ogs ogs "OpenGeoSys: masonry triplet" "ogs/triplet.py --csv $folder/ogs.csv" --scale 100
picture oofem oofem "OOFEM: block pulled along a rough base" oofem/pulled_block.py --scale 50 --up z
picture akantu akantu "Akantu: arm peeled off, elements inserted during the run" akantu/peel.py --scale 20 --step 58
if [ -f "$ASPERITY_CALCULIX/ready" ]; then
  "$here/calculix/link.sh" "$ASPERITY_CALCULIX" "$ASPERITY_LIBRARY" "$ccx"
  picture calculix asperity "CalculiX: end moments 0.5 to 1" "calculix/dcb.py $ccx --csv $folder/calculix.csv" \
    --scale 3 --up z
fi
if "$python" -c "import skfem" >/dev/null 2>&1; then
  "$python" "$here/python/crack.py" --elements 4 8 16 -o "$folder/python-crack.png"
  "$python" "$here/python/snap_back.py" -o "$folder/python-snap-back.png"
  drawn="$drawn $folder/python-crack.png $folder/python-snap-back.png"
fi
echo "${drawn:-none: no host is there}"
