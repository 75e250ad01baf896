"""UMAT and VUMAT of a shared library, called as Abaqus calls them: arrays by address, in Fortran's order."""

from __future__ import annotations

import ctypes
from pathlib import Path

import numpy as np

GARBAGE = -7.7e77
"""Value of outputs before a call, and of arguments that Abaqus does not define."""


def _address(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)


class Umat:
    """UMAT: traction, state and tangent of one point at the end of an increment."""

    def __init__(self, library: Path, props: np.ndarray, ntens: int, nstatv: int) -> None:
        """Take the routine of a library for one material and one number of components."""
        self.routine = ctypes.CDLL(str(library)).umat_
        self.props = np.array(props)
        self.stress, self.tangent = np.zeros(ntens), np.zeros((ntens, ntens), order="F")
        self.statev, self.energies = np.zeros(nstatv), np.zeros(3)
        self.stran, self.dstran, self.unused = np.zeros(ntens), np.zeros(ntens), np.full(64, GARBAGE)
        self.time, self.dtime, self.pnewdt = np.zeros(2), np.zeros(1), np.zeros(1)
        self.calls = 0
        numbers = {name: ctypes.c_int(value) for name, value in (("one", 1), ("zero", 0))}
        one, none = ctypes.byref(numbers["one"]), _address(self.unused)
        self.keep = (numbers, ctypes.c_int(ntens), ctypes.c_int(ntens - 1), ctypes.c_int(nstatv))
        tens, shear, states = (ctypes.byref(value) for value in self.keep[1:])
        self.nprops = ctypes.c_int(len(props))
        self.arguments = [
            *map(_address, (self.stress, self.statev, self.tangent)),
            *(ctypes.c_void_p(self.energies.ctypes.data + 8 * i) for i in range(3)),
            *[none] * 4,
            *map(_address, (self.stran, self.dstran, self.time, self.dtime)),
            *[none] * 4,
            ctypes.create_string_buffer(b"JOINT".ljust(80), 80),
            *(one, shear, tens, states),
            *(_address(self.props), ctypes.byref(self.nprops)),
            *(none, none, _address(self.pnewdt), none, none, none),
            *[one] * 6,
            ctypes.c_size_t(80),
        ]

    def call(
        self, stress: np.ndarray, statev: np.ndarray, stran: np.ndarray, dstran: np.ndarray, dtime: float
    ) -> bool:
        """Update a point; results are in stress, statev, tangent; False: a smaller increment is asked for."""
        self.stress[:], self.statev[:], self.stran[:], self.dstran[:] = stress, statev, stran, dstran
        self.tangent[:], self.energies[:] = GARBAGE, GARBAGE
        self.dtime[0], self.pnewdt[0] = dtime, 1.0
        self.routine(*self.arguments)
        self.calls += 1
        return bool(self.pnewdt[0] >= 1.0 and np.isfinite(self.stress).all())


class Vumat:
    """VUMAT: a block of points, in double or in single precision."""

    def __init__(self, library: Path, props: np.ndarray, density: float, single: bool = False) -> None:
        """Take the routine of a library for one material; `density` is that of the section."""
        self.kind = np.float32 if single else np.float64
        self.routine = getattr(ctypes.CDLL(str(library)), "vumat_single_" if single else "vumat_")
        self.props, self.density = np.array(props, dtype=self.kind), density

    def call(
        self, total_time: float, dt: float, increment: np.ndarray, stress: np.ndarray, statev: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Stress and state variables of all points at the end; the arrays have a point in each row."""
        n, components = stress.shape
        kind = self.kind
        numbers = [ctypes.c_int(i) for i in (n, 1, components - 1, statev.shape[1], 0, len(self.props), 0)]
        times = [np.array([value], dtype=kind) for value in (total_time, total_time, dt)]
        new_stress = np.full(stress.shape, -7.7e30, dtype=kind, order="F")
        new_state = np.full(statev.shape, -7.7e30, dtype=kind, order="F")
        strain, old_stress, old_state = (
            np.asfortranarray(a, dtype=kind) for a in (increment, stress, statev)
        )
        unused, density = np.full(9 * n, -7.7e30, dtype=kind), np.full(n, self.density, dtype=kind)
        energies = [np.zeros(n, dtype=kind) for _ in range(4)]
        none = _address(unused)
        self.routine(
            *(ctypes.byref(number) for number in numbers),
            *map(_address, times),
            ctypes.create_string_buffer(b"JOINT".ljust(80), 80),
            *(none, none, _address(self.props), _address(density), _address(strain)),
            *[none] * 5,
            *map(_address, (old_stress, old_state, *energies[:2])),
            *[none] * 4,
            *map(_address, (new_stress, new_state, *energies[2:])),
            ctypes.c_size_t(80),
        )
        return np.ascontiguousarray(new_stress, dtype=float), np.ascontiguousarray(new_state, dtype=float)
