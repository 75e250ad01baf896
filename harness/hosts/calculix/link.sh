#!/bin/sh
# link.sh FOLDER LIBRARY PROGRAM: a ccx whose UMAT is that of LIBRARY and whose SDVINI is sdvini.f90, from what install.sh
# left in FOLDER; takes less than a second.
# CalculiX is under the GPL: keep the program to yourself.
set -eu
[ $# = 3 ] || { echo "usage: link.sh FOLDER LIBRARY PROGRAM"; exit 2; }
folder=$1 library=$2 program=$3
[ -f "$folder/ready" ] || { echo "$folder: expected the folder that install.sh has made"; exit 2; }
[ "$(cat "$folder/inputs")" = "$(cksum <"$(dirname "$0")/install.sh")" ] ||
  { echo "$folder: made by another install.sh: expected that of this folder, which compiles it anew"; exit 2; }
[ -f "$library" ] || { echo "$library: expected libasperity.so"; exit 2; }
libraries=$(cd "$folder/deb/usr/lib/"*/ && pwd)
gfortran -o "$program" "$folder/ccx.o" "$(dirname "$0")/sdvini.f90" -Wl,--no-as-needed "$library" -Wl,--as-needed "$folder/ccx.a" \
  "$libraries/libspooles.a" "$libraries/libarpack.so.2" -llapack -lblas -lpthread -lm -fopenmp \
  -Wl,-rpath,"$(cd "$(dirname "$library")" && pwd):$libraries"
