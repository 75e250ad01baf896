"""The call of umat41c that LS-DYNA makes at a block of points, as its sources for users describe it."""

from __future__ import annotations

import ctypes
import subprocess
import tempfile
from functools import cache
from pathlib import Path
from shutil import which

import numpy as np
from asperity import contract, installed
from asperity.contract import Floats

NLQ, FIRST = 7, 2
"""Length of the arrays of a block, and the first point (from 0) of those that a call has."""

HISTORY = 3
"""History variables behind STATEV."""


def available() -> bool:
    """Whether there is the compiler of Fortran that builds the routine of the kit."""
    return which("gfortran") is not None


@cache
def library() -> ctypes.CDLL:
    """The routine of the kit, compiled with the length of arrays of an imitated program."""
    door = installed.named_library("asperity_lsdyna")
    source = Path(__file__).parent / "kit" / "umat41c.f"
    # what is loaded stays after its file is gone
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "nlqparm").write_text(f"      parameter (nlq={NLQ})\n", encoding="ascii")
        # LS-DYNA in double precision has integers of eight bytes
        flags = ["-shared", "-fPIC", "-fdefault-integer-8", f"-I{folder}"]
        command = ["gfortran", *flags, str(source), str(door), f"-Wl,-rpath,{door.parent}"]
        subprocess.run([*command, "-o", f"{folder}/libumat41c.so"], check=True)
        return ctypes.CDLL(f"{folder}/libumat41c.so")


class Points:
    """Points FIRST, FIRST + 1, ... of a block."""

    def __init__(self, props: Floats, n: int) -> None:
        """Begin with n virgin points; the others of the block are not to be touched."""
        self.n, self.cm = n, np.zeros(48)
        self.cm[2 : 2 + contract.N_FIXED_PROPS] = props[: contract.N_FIXED_PROPS]
        c_api = ctypes.CDLL(str(installed.library()))
        self.nstatv = c_api.asperity_nstatv(
            ctypes.c_void_p(self.cm[2:].ctypes.data), contract.N_FIXED_PROPS, None, 0
        )
        self.aux = np.full((NLQ, self.nstatv + HISTORY), np.nan, order="F")
        self.here = slice(FIRST, FIRST + n)
        self.aux[self.here] = 0.0
        self.ek = np.zeros(NLQ)
        self.others = np.delete(np.arange(NLQ), np.arange(FIRST, FIRST + n))
        # the arguments are the same arrays in every call
        self.fc, self.dx, self.rate = (np.full((NLQ, 3), np.nan, order="F") for _ in range(3))
        self.duration, self.failed = np.full(NLQ, np.nan), np.zeros(NLQ, np.int64)
        self.numbers = np.arange(1, NLQ + 1)
        single, first, last = (ctypes.byref(ctypes.c_long(k)) for k in (1, FIRST + 1, FIRST + n))
        duration = _at(self.duration)
        self.arguments = (
            single, _at(self.cm), first, last, _at(self.fc), _at(self.dx), _at(self.rate), _at(self.aux),
            _at(self.ek), _at(self.failed), duration, duration, _at(self.numbers), duration,
        )  # fmt: skip

    def step(self, start: Floats, end: Floats, dt: float = 0.0) -> Floats:
        """Tractions (n, 3) at the end of an increment from separation to separation (n, 3)."""
        self.fc[:] = np.nan
        self.dx[self.here] = end[:, [1, 2, 0]]
        self.rate[self.here] = (end - start)[:, [1, 2, 0]]
        self.duration[self.here], self.failed[:] = dt, 0
        library().umat41c_(*self.arguments)
        assert not self.failed.any() and np.isnan(self.fc[self.others]).all()
        assert np.isnan(self.aux[self.others]).all()
        return self.fc[self.here][:, [2, 0, 1]]

    @property
    def state(self) -> Floats:
        """STATEV (n, :)."""
        return self.aux[self.here, : self.nstatv]


def _at(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
