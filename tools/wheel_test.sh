#!/bin/sh
# wheel_test.sh: the wheel of build/wheel in a bare Debian root, which has python3 and nothing else (root, debootstrap).
set -eu
cd "$(dirname "$0")/.."
needed=build/wheel/needed
rm -rf "$needed"
.venv/bin/python -m pip download --quiet --only-binary :all: --dest "$needed" pip \
  "asperity[tools] @ file://$(echo "$PWD"/build/wheel/*.whl)"
tools/bare_root.sh python3 "$needed" tools/wheel_commands.sh
echo "the wheel works in a bare root"
