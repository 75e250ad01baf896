#!/bin/sh
# install.sh FOLDER: a Python of 3.12 or later in FOLDER/bin/python with dolfinx (PETSc, MUMPS, MPI), gmsh and this project.
#
# dolfinx has wheels for Python 3.12 and later only. The project is built for that Python in FOLDER-library.
set -eu
folder=$1
cd "$(dirname "$0")/../../.."
if [ ! -x "$folder/bin/python" ]; then
  found=""
  for python in python3.14 python3.13 python3.12 "${PYENV_ROOT:-$HOME/.pyenv}"/versions/3.1[2-9]*/bin/python3; do
    PYENV_VERSION=$(basename "$(dirname "$(dirname "$python")")") "$python" -c \
      'import ensurepip, sys, sysconfig, os; h = sysconfig.get_path("include")
sys.exit(sys.version_info < (3, 12) or not os.path.isfile(h + "/Python.h"))' 2>/dev/null && found=$python && break
  done
  [ -n "$found" ] || { echo "no Python 3.12 or later with headers here, left out" && exit 77; }
  "$found" -m venv "$folder"
fi
pip="$folder/bin/python -m pip install --quiet --no-compile"
$pip dolfinx-solver-real gmsh meshio pytest || { echo "no wheels of dolfinx here, left out" && exit 77; }
$pip --config-settings=build-dir="$folder-library" ".[tools]"
# the library of MPI beside those of PETSc, where dolfinx looks: it is then found without an import of mpi4py before
"$folder/bin/python" - <<'END'
import pathlib, sys, sysconfig

for name in "libmpi.so.12", "mpich":  # and the libraries that it needs
    there = pathlib.Path(sys.prefix, "lib", name)
    here = pathlib.Path(sysconfig.get_path("purelib"), "dolfinx_solver", "lib", name)
    here.exists() or here.symlink_to(there)
END
# bytecode of what every run imports, also where Python is told to write none: else each compiles it for two seconds
PYTHONDONTWRITEBYTECODE="" "$folder/bin/python" -c "import asperity.fenicsx, asperity.mesh"
echo "$folder"
