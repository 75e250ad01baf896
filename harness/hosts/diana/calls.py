"""The call of USRIFC that DIANA 9.3 to 10 makes at an integration point, as a public routine has it."""

from __future__ import annotations

import ctypes

import numpy as np
from asperity import installed
from asperity.contract import Floats

LIBRARY = ctypes.CDLL(str(installed.named_library("asperity_diana")))
ITERATIONS = 2
"""Calls of an increment, each from the state and traction at its start, as Newton's method needs them."""


class Points:
    """Integration points of interface elements; nt: components, 3 in space, 2 in the plane."""

    def __init__(self, props: Floats, n: int, nt: int = 3) -> None:
        """Begin with n virgin points."""
        self.props, self.nt = np.array(props), nt
        library = ctypes.CDLL(str(installed.library()))
        nus = library.asperity_nstatv(_at(self.props), len(props), None, 0)
        self.state, self.tra = np.zeros((n, nus)), np.zeros((n, nt))
        self.stiff = np.zeros((n, nt, nt))
        # the arguments are the same arrays in every call
        self.shift, self.end = np.zeros((2, nt)), (np.zeros(nus), np.zeros(nt), np.zeros((nt, nt)))
        self.intpt, self.dtime = ctypes.c_int(), ctypes.c_double()
        (u0, du), (usrsta, tra, stiff) = map(_at, self.shift), map(_at, self.end)
        size, elemen, iteration, nuv, states, nui = (
            ctypes.byref(ctypes.c_int(k)) for k in (nt, 7, 1, len(props), nus, 1)
        )
        zero, time, intpt = map(ctypes.byref, (ctypes.c_double(0.0), self.dtime, self.intpt))
        self.coord, self.usrind = np.zeros(3), np.zeros(1, np.int32)
        self.arguments = (
            u0, du, size, zero, time, zero, zero, elemen, intpt, _at(self.coord), stiff, iteration,
            b"ASPERI", _at(self.props), nuv, usrsta, states, _at(self.usrind), nui, tra, stiff,
            ctypes.c_size_t(6),
        )  # fmt: skip

    def step(self, start: Floats, end: Floats, dt: float = 0.0) -> Floats:
        """Tractions (n, 3) at the end of an increment from separation to separation (n, 3)."""
        traction = np.zeros((len(self.state), 3))
        for k in range(len(self.state)):
            u0 = start[k, : self.nt]
            for i in range(1, ITERATIONS + 1):
                self._call(u0, i / ITERATIONS * (end[k, : self.nt] - u0), dt, k)
            state, tra, stiff = self.end
            # of Fortran, by columns
            self.state[k], self.tra[k], self.stiff[k] = state, tra, stiff.T
            traction[k, : self.nt] = tra
        return traction

    def _call(self, u0: Floats, du: Floats, dt: float, point: int) -> None:
        """Call the routine for a point; its traction and state stay those at the start."""
        state, tra, stiff = self.end
        state[:], tra[:], stiff[:] = self.state[point], self.tra[point], 0.0
        self.shift[:], self.intpt.value, self.dtime.value = (u0, du), point + 1, dt
        LIBRARY.usrifc_(*self.arguments)


def _at(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
