#!/bin/sh
# install.sh FOLDER: CalculiX from Debian's source package, compiled once into FOLDER (a few minutes), and again when this
# script has changed; nothing is installed.
# What is missing of the machine (deb-src entries, headers, run-time libraries) is taken into FOLDER as well.
# Exit codes: 0 ready, 77 this machine cannot get or build the source, with the reason in the last line.
set -u
[ $# = 1 ] || { echo "usage: install.sh FOLDER"; exit 2; }
mkdir -p "$1" && folder=$(cd "$1" && pwd) || exit 2
inputs=$(cksum <"$0")
tools=$(cd "$(dirname "$0")/../../../tools" && pwd)
if [ -f "$folder/ready" ] && [ "$(cat "$folder/inputs" 2>&1)" = "$inputs" ]; then
  echo "CalculiX: $(cat "$folder/ready"), compiled before"
  exit 0
fi
rm -rf "$folder/ready" "$folder/src" "$folder/deb"

skip() {
  echo "CalculiX: $1"
  exit 77
}

for tool in apt-get dpkg-source dpkg-deb gcc gfortran make; do
  command -v $tool >/dev/null || skip "$tool is not installed"
done
"$tools/install-dependencies.sh" >/dev/null 2>&1
for library in lapack blas; do
  printf 'end\n' >"$folder/probe.f90"
  gfortran "$folder/probe.f90" -l$library -o "$folder/probe" 2>/dev/null || skip "lib$library is not installed"
done

echo "CalculiX: fetching Debian's source package"
told=$("$tools/debian_source.sh" "$folder" calculix-ccx libspooles-dev libarpack2) || skip "$told"
source=$(echo "$folder"/src/calculix-ccx-*/ccx_*/src)
[ -d "$source" ] || skip "$source: not the folder expected in the source package"
# Version 2.20 has room for 21 constants of a material and does not count them; these files copy them, as materialdata_me has
# istiff = 0 there.  Files of heat, contact and springs have such an array for springs only.
for file in resultsmech.f resultsmech_se.f objective_shapeener_dx.f; do
  sed -i 's/elconloc(21)/elconloc(99)/' "$source/$file"
  grep -Eq 'elconloc\((99|ncmat_)\)' "$source/$file" ||
    skip "$source/$file: not the constants expected, elconloc(21) or elconloc(ncmat_)"
done

echo "CalculiX: compiling (log: $folder/make.log)"
name=$(basename "$(dirname "$source")")
make -C "$source" -j"${JOBS:-2}" "$name.a" "$name.o" CC=gcc FC=gfortran \
  CFLAGS="-w -O2 -I$folder/deb/usr/include/spooles -DARCH=Linux -DSPOOLES -DARPACK -DMATRIXSTORAGE -DUSE_MT=1" \
  FFLAGS="-w -O2 -fopenmp -fallow-argument-mismatch" >"$folder/make.log" 2>&1 || skip "make failed ($folder/make.log)"
# without the UMAT that comes with it, an elastic one: a wrong link must not look right
cp "$source/$name.a" "$folder/ccx.a" && ar d "$folder/ccx.a" umat.o && cp "$source/$name.o" "$folder/ccx.o" &&
  echo "$inputs" >"$folder/inputs" && echo "$name" >"$folder/ready"
echo "CalculiX: $name compiled"
