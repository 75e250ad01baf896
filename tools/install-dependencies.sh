#!/bin/sh
# Installs the packages of Debian or Ubuntu that are missing here, as root or with sudo; else names them and exits 1.
# The only list of them; Python packages are listed in pyproject.toml. With the argument `site` also
# what the site and its tests in Chromium need.
set -u
extra=${1:-}
here=$(dirname "$0")

recent_cmake() {
  printf 'cmake_minimum_required(VERSION 3.22)' >"$probes/version.cmake" && cmake -P "$probes/version.cmake"
}

links_lapack() {
  printf 'external :: dgesv\ncall dgesv()\nend\n' >"$probes/lapack.f90" &&
    gfortran "$probes/lapack.f90" -llapack -lblas -o "$probes/lapack"
}

# need PACKAGES PROBE...: the packages are missing if the probe fails
need() {
  packages=$1
  shift
  "$@" >/dev/null 2>&1 || missing="$missing $packages"
}

look() {
  missing=""
  probes=$(mktemp -d)
  need gfortran command -v gfortran
  need gcc command -v cc
  need g++ command -v c++
  need binutils command -v nm
  need cmake recent_cmake
  need ninja-build command -v ninja
  need "python3 python3-venv python3-dev" "$here/python.sh"
  need liblapack-dev links_lapack
  if [ "$extra" = site ]; then
    need npm command -v npm
    need "chromium chromium-driver" eval "command -v chromium && command -v chromedriver"
  fi
  rm -r "$probes"
}

stop() {
  echo "missing:$missing"
  echo "$1"
  exit 1
}

look
if [ -z "$missing" ]; then
  echo "nothing missing"
  exit 0
fi

command -v apt-get >/dev/null || stop "install what these Debian packages hold, then try again"
if [ "$(id -u)" = 0 ]; then
  as_root=""
elif command -v sudo >/dev/null && { [ -t 0 ] || sudo -n true 2>/dev/null; }; then
  as_root=sudo
else
  stop "neither root nor sudo here; as root: apt-get install$missing"
fi
wanted=$missing
# a package source that does not answer is no reason to stop
$as_root apt-get update -q
# shellcheck disable=SC2086  # lists of words
$as_root env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends $wanted ||
  stop "apt-get failed"
look
[ -z "$missing" ] || stop "still missing after apt-get install$wanted (CMake >= 3.22 and Python >= 3.10 are needed)"
echo "installed:$wanted"
