#!/bin/sh
# build-and-test.sh PRESET [CMAKE_OPTION...]: configures a preset of CMakePresets.json into build/PRESET, builds it, runs every
# suite and counts the tests ('N passed, N failed'). SUITES='name name': only these suites, or those of these folders of
# tests. Ends with status 77 where this machine cannot run the preset, and says why.
set -eu
cd "$(dirname "$0")/.."
preset=$1
shift
folder=build/$preset
python=$PWD/.venv/bin/python
[ -x "$python" ] || python=$(command -v python3)

case $preset in
flang)
  compiler=$(tools/flang.sh)
  if [ -z "$compiler" ]; then
    echo "flang 19 or later is not installed, left out"
    exit 77
  fi
  # shellcheck disable=SC2086  # a list of options
  set -- $compiler "$@"
  ;;
esac

suites=
for name in ${SUITES:-}; do
  if [ -d "tests/$name" ]; then
    for file in "tests/$name"/test_*.pf; do
      [ -f "$file" ] || { echo "tests/$name: no suites" && exit 1; }
      suites="$suites $(basename "$file" .pf)"
    done
  else
    suites="$suites $name"
  fi
done
SUITES=$(echo $suites)

# coverage counts what one thread runs
[ "$preset" != debug ] || export OMP_THREAD_LIMIT=1

cmake --preset "$preset" -DPython3_EXECUTABLE="$python" "$@"
# shellcheck disable=SC2086  # a list of words
cmake --build "$folder" --parallel "${JOBS:-2}" ${SUITES:+--target $SUITES}
# coverage and counts must be of this run
log=$folder/Testing/Temporary/LastTest.log
rm -f "$log"
find "$folder" -name '*.gcda' -delete
status=0
only=$(echo "${SUITES:-.*}" | tr ' ' '|')
ctest --test-dir "$folder" --parallel "${JOBS:-2}" --timeout 900 --no-tests=error --output-on-failure -R "^($only)\$" ||
  status=$?
[ -f "$log" ] || exit 1
if [ $status -ne 0 ]; then
  echo "--- what failed, from $log"
  grep -A 4 -E '\.\.\. FAILED$|^Failure|^ *[0-9]+\) |ERROR: |\.c(pp)?:[0-9]+: ' "$log" | head -n 40 || true
fi
"$python" tests/pfunit_stand_in/count_tests.py "$log" && exit $status
