#!/bin/sh
# windows.sh: library, driver, C API and suites for Windows by MinGW-w64 in build/windows, run by wine; then the rows of
# Figure 5(b) beside those of Linux, byte by byte. Ends with status 77 where this machine cannot do it, and says why.
set -eu
cd "$(dirname "$0")/.."
folder=$PWD/build/windows
triplet=x86_64-w64-mingw32

missing=""
for compiler in gcc g++ gfortran; do
  command -v $triplet-$compiler-posix >/dev/null || missing="$missing $compiler-mingw-w64-x86-64-posix"
done
command -v wine >/dev/null || missing="$missing wine64 wine"
command -v dpkg-source >/dev/null || missing="$missing dpkg-dev"
if [ -n "$missing" ]; then
  # a package source that does not answer is no reason to stop
  apt-get update -q || true
  # shellcheck disable=SC2086  # a list of words
  env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $missing || {
    echo "left out; as root: apt-get install$missing"
    exit 77
  }
fi

# the routines of LAPACK that are called, and what they call, from Debian's source package
lapack=$PWD/build/windows-lapack
if [ ! -f "$lapack/liblapack.a" ]; then
  mkdir -p "$lapack"
  told=$(tools/debian_source.sh "$lapack" lapack) || { echo "$told: left out" && exit 77; }
  sources=$(echo "$lapack"/src/lapack-*/)
  wanted="la_constants la_xisnan dgesv dgesvd dsyev dgeev"
  while [ -n "$wanted" ]; do
    for name in $wanted; do
      for source in "$sources"SRC "$sources"INSTALL "$sources"BLAS/SRC; do
        for file in "$source/$name".[fF] "$source/$name".[fF]90; do
          [ ! -f "$file" ] || $triplet-gfortran-posix -O2 -frecursive -J "$lapack" -c "$file" -o "$lapack/$name.o"
        done
      done
      [ -f "$lapack/$name.o" ] || { echo "LAPACK: $name: not in Debian's source package" && exit 1; }
    done
    defined=$(cd "$lapack" && ls ./*.o | sed 's|^\./||; s|\.o$||')
    # what is called, without the run-time library
    wanted=$($triplet-nm --undefined-only "$lapack"/*.o | sed -n 's/.* U \([a-z0-9]*\)_$/\1/p' | sort -u |
      while read -r name; do echo "$defined" | grep -qx "$name" || echo "$name"; done)
  done
  $triplet-ar rcs "$lapack/liblapack.a" "$lapack"/*.o
fi

# outside the tree: builders of the sdist follow the links of its drives, one of which is the root of all files
export WINEPREFIX="${XDG_CACHE_HOME:-$HOME/.cache}/asperity-wine" WINEDEBUG=-all
cmake --preset windows -DLAPACK_LIBRARIES="$lapack/liblapack.a" -DBLAS_LIBRARIES="$lapack/liblapack.a"
cmake --build build/windows --parallel "${JOBS:-2}"
mkdir -p "$WINEPREFIX"
wine wineboot --init >/dev/null 2>&1 || true
log=build/windows/Testing/Temporary/LastTest.log
rm -f "$log"
status=0
ctest --test-dir build/windows --parallel "${JOBS:-2}" --timeout 600 --no-tests=error --output-on-failure || status=$?
[ -f "$log" ] || exit 1
counted=$(.venv/bin/python tests/pfunit_stand_in/count_tests.py "$log") || status=1
echo "$counted"
counts=$(echo "$counted" | tail -n 1)

# the same rows as on Linux, of a path as Windows writes it
cd build/windows
rm -f figure05b.csv linux.csv
export ASPERITY_ISA=v1
wine bin/rie_driver.exe '..\..\harness\cases\figure05b.nml' --quiet
../../.venv/bin/rie_driver ../../harness/cases/figure05b.nml -o linux.csv --quiet
cmp figure05b.csv linux.csv || status=1
[ $status != 0 ] || echo "$(wc -l <figure05b.csv) lines of figure05b.csv as on Linux, byte by byte; $counts"
exit $status
