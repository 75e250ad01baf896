#!/bin/sh
# demo.sh: the paper's Figure 5(b) by the driver of build/release, drawn into build/demo.
set -eu
cd "$(dirname "$0")/.."
mkdir -p build/demo
ASPERITY_DRIVER=build/release/bin/rie_driver .venv/bin/asperity run harness/cases/figure05b.nml \
  -o build/demo/figure05b.csv --plot build/demo/figure05b.png
