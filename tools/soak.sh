#!/bin/sh
# soak.sh: every program of harness/soak in turn with its long run, then a million calls from Python.
cd "$(dirname "$0")/.." || exit
status=0
for program in build/release/bin/soak/*; do
  "$program" || status=1
done
ASPERITY_CALLS=1000000 .venv/bin/python -m pytest -k test_memory_does_not_grow || status=1
exit $status
