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

    def step(self, start: Floats, end: Floats, dt: float = 0.0) -> Floats:
        """Tractions (n, 3) at the end of an increment from separation to separation (n, 3)."""
        traction = np.zeros((len(self.state), 3))
        for k in range(len(self.state)):
            u0 = np.ascontiguousarray(start[k, : self.nt])
            for share in np.arange(1, ITERATIONS + 1) / ITERATIONS:
                du = share * (end[k, : self.nt] - u0)
                state, tra, stiff = self.state[k].copy(), self.tra[k].copy(), np.zeros((self.nt, self.nt))
                self._call(u0, du, dt, k, state, tra, stiff)
            # of Fortran, by columns
            self.state[k], self.tra[k], self.stiff[k] = state, tra, stiff.T
            traction[k, : self.nt] = tra
        return traction

    def _call(
        self, u0: Floats, du: Floats, dt: float, point: int, state: Floats, tra: Floats, stiff: Floats
    ) -> None:
        integers = [
            ctypes.byref(ctypes.c_int(k)) for k in (self.nt, 7, point + 1, 1, len(self.props), len(state), 1)
        ]
        nt, elemen, intpt, iteration, nuv, nus, nui = integers
        zero, time = ctypes.byref(ctypes.c_double(0.0)), ctypes.byref(ctypes.c_double(dt))
        coord, usrind = np.zeros(3), np.zeros(1, np.int32)
        LIBRARY.usrifc_(
            _at(u0), _at(du), nt, zero, time, zero, zero, elemen, intpt, _at(coord), _at(stiff), iteration,
            b"ASPERI", _at(self.props), nuv, _at(state), nus, _at(usrind), nui, _at(tra), _at(stiff),
            ctypes.c_size_t(6),
        )  # fmt: skip


def _at(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
