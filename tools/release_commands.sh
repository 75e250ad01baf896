#!/bin/sh
# release_commands.sh: builds and installs the sdist and runs the fast tests of the package; release_test.sh runs it.
set -eux
export HOME=/root LC_ALL=C.UTF-8
pip=$(echo /needed/pip-*.whl)
python3 -m venv --without-pip /venv
python="/venv/bin/python"
$python "$pip/pip" install --quiet --root-user-action ignore --no-index --find-links /needed "asperity[test]"
mkdir /sources
tar -C /sources --strip-components=1 -xf /needed/asperity-*.tar.gz
cd /sources
export PATH="/venv/bin:$PATH"
$python -m pytest -q -p no:cacheprovider -m "not slow and not long"
