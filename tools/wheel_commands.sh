#!/bin/sh
# wheel_commands.sh: what a user does first, run by wheel_test.sh in a root without compiler and NumPy.
set -eux
export HOME=/root LC_ALL=C.UTF-8
for program in gfortran gcc cc pip; do
  ! command -v "$program"
done
pip=$(echo /needed/pip-*.whl)
python3 "$pip/pip" install --quiet --root-user-action ignore --no-index --find-links /needed --break-system-packages asperity
mkdir /first && cd /first

asperity doctor
rie_driver --version
asperity run figure05b --quiet --plot
asperity new mu=0.6 -o joint.nml
rie_driver joint.nml --quiet
asperity card --host abaqus joint.nml --sigma-N -1
asperity export abaqus kit
asperity surface --help >help.txt

# constants of synthetic tests, with a picture and a case that the driver runs
python3 -m asperity.fit.study record.csv
asperity fit record.csv --plot -o found.nml
asperity run found.nml --quiet
ls -l figure05b.csv figure05b.png joint.csv fit.png found*.csv

# what hosts need: library, header, sources for Abaqus
python3 - <<END
import ctypes
from asperity.installed import abaqus, generic_library, kratos_adapter, library

ctypes.CDLL(str(library())).umat_
ctypes.CDLL(str(kratos_adapter())).umat_
ctypes.CDLL(str(generic_library()))
for name in ("asperity_abaqus", "asperity_abaqus_standard", "asperity_abaqus_explicit", "asperity_abaqus_single"):
    assert (abaqus() / f"{name}.f90").is_file(), name
assert library().with_name("asperity.h").is_file()
END
