#!/bin/sh
# soak.sh: every program of harness/soak in turn with its long run, then millions of random calls and
# the Python tests that take long.
cd "$(dirname "$0")/.." || exit
status=0
for program in build/release/bin/soak/*; do
  "$program" || status=1
done
ASPERITY_CALLS=1000000 .venv/bin/python -m pytest -m long || status=1
exit $status
