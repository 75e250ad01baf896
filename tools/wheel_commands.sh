#!/bin/sh
# wheel_commands.sh: what a user does first, run by wheel_test.sh in a root without compiler and NumPy.
set -eux
export HOME=/root LC_ALL=C.UTF-8
for program in gfortran gcc cc pip; do
  ! command -v "$program"
done
pip=$(echo /needed/pip-*.whl)
install="python3 $pip/pip install --quiet --root-user-action ignore --no-index --find-links /needed --break-system-packages"
$install asperity
mkdir /first && cd /first

asperity doctor
rie_driver --version
asperity run figure05b --quiet
asperity new mu=0.6 -o joint.nml
rie_driver joint.nml --quiet
asperity card abaqus joint.nml --sigma-N -1
asperity export abaqus kit

# the toolbox
if python3 -c 'import scipy'; then exit 1; fi
if asperity surface --help 2>refused.txt; then exit 1; fi
grep 'asperity\[tools\]' refused.txt
$install 'asperity[tools]'
asperity run figure05b --quiet --force --plot
asperity surface --help >help.txt

# constants of synthetic tests, with a picture and a case that the driver runs
python3 - >record.csv <<END
import numpy as np
from asperity import Interface, Material, Pattern

joint = Interface(Material(1.5, 0.15, 0.9, 0.5, kc=20.0), Pattern.regular(2, 20.0))
noise, slips = np.random.default_rng(0), np.linspace(0.0, 0.8, 4001)
print("test,slip,tau,dilation,sigma_N")
for sigma_N in (-1.0, -2.0, -4.0):
    test = joint.confined_slip(0.0, slips, sigma_N)
    for i in range(60, 4001, 60):
        tau, s_N = test.traction[i, 1], test.dilation[i] - test.dilation[0]
        tau, s_N = (value + noise.normal(0.0, share) for value, share in ((tau, -0.02 * sigma_N), (s_N, 0.005)))
        print(f"{sigma_N},{slips[i]:.5g},{tau:.5g},{s_N:.5g},{sigma_N}")
END
asperity fit record.csv --plot -o found.nml
asperity run found.nml --quiet
ls -l figure05b.csv figure05b.png joint.csv fit.png found*.csv

# what hosts need: library, header, sources for Abaqus
python3 - <<END
import ctypes
from asperity.installed import abaqus, generic_library, library, named_library

ctypes.CDLL(str(library())).umat_
ctypes.CDLL(str(named_library("asperity_kratos"))).umat_
ctypes.CDLL(str(generic_library()))
for name in ("asperity_abaqus", "asperity_abaqus_standard", "asperity_abaqus_explicit", "asperity_abaqus_single"):
    assert (abaqus() / f"{name}.f90").is_file(), name
assert library().with_name("asperity.h").is_file()
END
