#!/bin/sh
# install.sh PYTHON FOLDER: a Python with PETSc and MPI in FOLDER/bin/python, with the asperity of PYTHON.
#
# Debian's petsc4py and mpi4py belong to Debian's Python and its numpy, so an environment of that Python has them, and a link
# to asperity, which must be built for the same version of Python. OpenBLAS: MUMPS takes four times as long with the
# reference BLAS.
set -eu
python=$1 folder=$2
system=/usr/bin/python3
ready() {
  # shellcheck disable=SC2086  # a pattern
  PETSC_DIR=$(echo /usr/lib/petscdir/petsc3*/*-real) $system -c "import mpi4py.MPI, petsc4py.PETSc" 2>/dev/null
}
if ! ready; then
  [ "$(id -u)" = 0 ] || { echo "as root: apt-get install python3-petsc4py python3-mpi4py libopenblas0-pthread" && exit 77; }
  { apt-get update -q && env DEBIAN_FRONTEND=noninteractive apt-get install -q -y --no-install-recommends \
    python3-petsc4py python3-mpi4py libopenblas0-pthread; } || { echo "no packages here, left out" && exit 77; }
fi
version='import sys; print(sys.version_info[:2])'
[ "$($python -c "$version")" = "$($system -c "$version")" ] || { echo "$python: expected the version of $system" && exit 77; }
[ ! -e "$folder" ] || [ -e "$folder/pyvenv.cfg" ] || { echo "$folder: expected a new folder" && exit 1; }
$system -m venv --clear --without-pip --system-site-packages "$folder"
site=$("$folder/bin/python" -c "import sysconfig; print(sysconfig.get_path('purelib'))")
for one in asperity meshio rich; do
  ln -s "$($python -c "import pathlib, $one; print(pathlib.Path($one.__file__).parent)")" "$site/$one"
done
echo "$folder"
