"""The calls of 3DEC and UDEC at a subcontact of a joint model, imitated in C++ as their headers say."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from shutil import which

import numpy as np
from asperity import installed
from asperity.contract import N_FIXED_PROPS, Floats

FOLDER = Path(__file__).parent
AREA = 2.0
N_X = 97
"""Index of the property n-x, after 96 constants."""
DAMAGE = N_X + 6
TURNED = np.array([(0.6, 0.0, 0.8), (0.0, 1.0, 0.0), (-0.8, 0.0, 0.6)])
"""N, Tx, Ty of a joint in the axes of the shear vectors."""


def available() -> bool:
    """Whether there is a compiler of C++."""
    return which("g++") is not None


@cache
def library(old: bool = False) -> ctypes.CDLL:
    """The model of the kit with the imitated program, by the types of version 7 (old) or 9."""
    shared = installed.library()
    sources = [FOLDER / "kit" / "jmodelasperity.cpp", FOLDER / "imitation" / "host.cpp"]
    command = ["g++", "-std=c++14", "-shared", "-fPIC", "-Wall", "-Wextra", "-Werror", *(["-DOLD"] * old)]
    command += [f"-I{FOLDER / 'imitation'}", f"-I{shared.parent}", *map(str, sources), str(shared)]
    # what is loaded stays after its file is gone
    with tempfile.TemporaryDirectory() as folder:
        program = f"{folder}/libjoint.so"
        subprocess.run([*command, f"-Wl,-rpath,{shared.parent}", "-o", program], check=True)
        loaded = ctypes.CDLL(program)
    loaded.contact_make.restype = ctypes.c_void_p
    loaded.contact_get.restype = loaded.contact_energy.restype = ctypes.c_double
    return loaded


class Contact:
    """A subcontact; axes: N, Tx, Ty in the axes of the shear vectors."""

    def __init__(self, props: Floats, axes: Floats, old: bool = False) -> None:
        """Make one with the properties PROPS."""
        self.library, self.axes = library(old), axes
        self.at = ctypes.c_void_p(self.library.contact_make(ctypes.c_double(AREA)))
        for k, value in enumerate(props, 1):
            self.set(k, value)
        for k, value in enumerate(axes[:2].ravel()):
            self.set(N_X + k, value)

    def set(self, index: int, value: float) -> None:
        """Set a property."""
        self.library.contact_set(self.at, index, ctypes.c_double(value))

    def get(self, index: int) -> float:
        """A property."""
        return float(self.library.contact_get(self.at, index))

    def run(self, increment: Floats, dt: float = 0.0) -> Floats:
        """Traction (3,) N, Tx, Ty after an increment of separation; RuntimeError as the model raises it."""
        shear, force = np.ascontiguousarray(increment[1:] @ self.axes[1:]), np.zeros(5)
        message = ctypes.create_string_buffer(4000)
        places = (ctypes.c_void_p(array.ctypes.data) for array in (shear, force))
        numbers = ctypes.c_double(dt), ctypes.c_double(increment[0])
        if self.library.contact_run(self.at, *numbers, *places, message, 4000):
            raise RuntimeError(message.value.decode())
        assert abs(force[4]) <= 1e-12 * np.abs(force).max()
        # compression is positive, and a shear force resists
        traction: Floats = -np.array([force[0], *(self.axes[1:] @ force[1:4])]) / AREA
        return traction


class Points:
    """Subcontacts with a joint, turned against the axes of the shear vectors."""

    def __init__(self, props: Floats, n: int) -> None:
        """Begin with n virgin ones."""
        assert len(props) >= N_FIXED_PROPS
        self.contacts = [Contact(props, TURNED, old=k == 1) for k in range(n)]

    def step(self, start: Floats, end: Floats, dt: float = 0.0) -> Floats:
        """Tractions (n, 3) at the end of an increment from separation to separation (n, 3)."""
        rows = zip(self.contacts, end - start, strict=True)
        return np.array([contact.run(increment, dt) for contact, increment in rows])

    @property
    def state(self) -> Floats:
        """Damage and energies (n, 4), the state variables that are properties."""
        return np.array([[contact.get(DAMAGE + k) for k in range(4)] for contact in self.contacts])
