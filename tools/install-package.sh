#!/bin/sh
# install-package.sh: the Python package with its tools, into .venv; what is there already is kept. It is built where the
# suites are, as both are made of the same library.
set -eu
cd "$(dirname "$0")/.."
[ -x .venv/bin/python ] || "$(tools/python.sh)" -m venv .venv
.venv/bin/python --version
.venv/bin/python -m pip install --no-compile --config-settings=build-dir=build/suites ".[dev]"
touch .venv/installed
echo .venv
