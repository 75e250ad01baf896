#!/bin/sh
# build-and-test.sh FOLDER CMAKE_OPTION...: configures, builds, runs every suite and counts the tests ('N passed, N failed').
# SUITES='name name': only these.
set -eu
folder=$1
shift
log=$folder/Testing/Temporary/LastTest.log
cmake -S . -B "$folder" -G Ninja "$@"
# shellcheck disable=SC2086  # a list of words
cmake --build "$folder" --parallel "${JOBS:-2}" ${SUITES:+--target $SUITES}
rm -f "$log"
status=0
only=$(echo "${SUITES:-.*}" | tr ' ' '|')
ctest --test-dir "$folder" --parallel "${JOBS:-2}" --timeout 300 --no-tests=error --output-on-failure -R "^($only)\$" ||
  status=$?
[ -f "$log" ] || exit 1
if [ $status -ne 0 ]; then
  echo "--- what failed, from $log"
  grep -A 4 -E '\.\.\. FAILED$|^Failure|^ *[0-9]+\) |ERROR: |\.c(pp)?:[0-9]+: ' "$log" | head -n 40 || true
fi
"${PYTHON:-python3}" tests/support/count_tests.py "$log" && exit $status
