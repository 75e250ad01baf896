#!/bin/sh
# Prints the Python to build with: $PYTHON, else the system's, else any on PATH; 3.10 or later, with venv and headers.
usable='
import ensurepip, os, sys, sysconfig, venv
header = os.path.join(sysconfig.get_path("include"), "Python.h")
sys.exit(0 if sys.version_info >= (3, 10) and os.path.isfile(header) else 1)'
for python in ${PYTHON:-/usr/bin/python3 python3 python3.14 python3.13 python3.12 python3.11 python3.10}; do
  if "$python" -c "$usable" 2>/dev/null; then
    exec "$python" -c 'import sys; print(sys.executable)'
  fi
done
echo "no Python >= 3.10 with venv, ensurepip and headers: ${PYTHON:-none on PATH}" >&2
exit 1
