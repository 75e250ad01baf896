#!/bin/sh
# demo.sh: the paper's Figure 5(b), computed by the driver of the package and drawn into build/demo.
set -eu
cd "$(dirname "$0")/.."
mkdir -p build/demo
.venv/bin/asperity run harness/cases/figure05b.nml -o build/demo/figure05b.csv --force --plot build/demo/figure05b.png
