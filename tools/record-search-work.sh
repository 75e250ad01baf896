#!/bin/sh
# Makes a new record of how much the solver works (tests/driver/search_work.txt): the scenes of search_work in which
# builds that round in different ways work the same. 'git diff' then shows what a change of the solver costs or saves.
set -eu
cd "$(dirname "$0")/.."
python=$PWD/.venv/bin/python
[ -x "$python" ] || python=$(command -v python3)
flang=$(tools/flang.sh)
[ -n "$flang" ] || {
  echo "record-search-work.sh: flang is not installed; a record of gfortran alone may not hold for other compilers" >&2
  exit 1
}
file=tests/driver/search_work.txt
folder=build/search-work
mkdir -p "$folder"

# record NAME CMAKE_OPTION...: the lines of a build
record() {
  name=$1
  shift
  cmake -S . -B "build/search-work/$name" -G Ninja -DPython3_EXECUTABLE="$python" -DCMAKE_BUILD_TYPE=Release "$@" \
    >"$folder/$name.log"
  cmake --build "build/search-work/$name" --target search_work --parallel "${JOBS:-2}" >>"$folder/$name.log"
  "build/search-work/$name/bin/soak/search_work" >"$folder/$name.txt"
}

record fast
record slow -DCMAKE_BUILD_TYPE=None -DCMAKE_Fortran_FLAGS=-O1
record wide -DASPERITY_ARCH=x86-64-v3
# shellcheck disable=SC2086  # a list of options
record flang $flang -DCMAKE_DISABLE_FIND_PACKAGE_PFUNIT=ON
cat "$folder/fast.txt" "$folder/slow.txt" "$folder/wide.txt" "$folder/flang.txt" | sort | uniq -c | awk '$1 == 4 { sub(/^ *4 /, ""); print }' | sort -k 1,1 -k 2,2n >"$file"
echo "$file: $(wc -l <"$file") scenes, of $(wc -l <"$folder/fast.txt")"
