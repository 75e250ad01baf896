#!/bin/sh
# install-package.sh: the Python package with its tools, into .venv; what is there already is kept.
set -eu
cd "$(dirname "$0")/.."
[ -x .venv/bin/python ] || "$(tools/python.sh)" -m venv .venv
.venv/bin/python --version
.venv/bin/python -m pip install --no-compile --config-settings=build-dir=build/python ".[dev]"
touch .venv/installed
echo .venv
