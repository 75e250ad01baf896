"""The calls that Abaqus makes at the nodes of the secondary surface of a contact pair: UINTER and VUINTER."""

from __future__ import annotations

import ctypes

import numpy as np
from asperity import installed
from asperity.contract import Floats

LIBRARY = ctypes.CDLL(str(installed.library()))
SIGN = np.array([-1.0, 1.0, 1.0])
"""Penetration and pressure are positive in compression."""

ITERATIONS = 2
"""Calls of an increment, each from the state and stress at its start, as Newton's method needs them."""

NAME = b"JOINT".ljust(80)


class Points:
    """Nodes of the secondary surface in Standard; ndir: components, 3 in space, 2 in the plane."""

    def __init__(self, props: Floats, n: int, ndir: int = 3) -> None:
        """Begin with n virgin nodes."""
        self.props, self.ndir = np.array(props), ndir
        statev = LIBRARY.asperity_nstatv(_at(self.props), len(props), None, 0)
        self.state, self.stress = np.zeros((n, statev)), np.zeros((n, ndir))
        self.stiffness, self.energies = np.zeros((n, ndir, ndir)), np.zeros((n, 4))
        self.closed, self.cut, self.densities = np.full(n, -1), np.ones(n), np.full(5, np.nan)
        # NODE, sizes, step, increment and iteration; then five flags, of which the second is LOPENCLOSE
        self.integers = np.array([1, ndir, statev, 1, len(props), 3, 1, 1, 1, 0, -1, 0, 0, 0], np.int32)
        self.unused, self.columns = np.full(9, np.nan), np.zeros((ndir, ndir))
        # the arguments are the same arrays in every call; only the place of the node in `cut` differs
        self.end, self.shift = (np.zeros(statev), np.zeros(ndir)), np.zeros((2, ndir))
        self.dtime, self.of_cut = ctypes.c_double(), [_at(self.cut[k:]) for k in range(n)]
        state, stress, rdisp, drdisp, unused = map(_at, (*self.end, *self.shift, self.unused))
        of_energies = [_at(self.densities[i:]) for i in range(5)]
        addresses = [_at(self.integers[i:]) for i in range(len(self.integers))]
        self.before = stress, _at(self.columns), *[unused] * 6, state, *of_energies
        self.behind = (
            rdisp, drdisp, *[unused] * 5, ctypes.byref(self.dtime), unused, NAME, NAME, NAME,
            _at(self.props), *[unused] * 5, *addresses, *[ctypes.c_size_t(80)] * 3,
        )  # fmt: skip

    def step(self, start: Floats, end: Floats, dt: float = 0.0) -> Floats:
        """Tractions (n, 3) at the end of an increment from separation to separation (n, 3).

        energies (n, 4) are stored energy, and the sums of friction, crushing and rupture of the increments.
        """
        traction, sign = np.zeros((len(self.state), 3)), SIGN[: self.ndir]
        for k in range(len(self.state)):
            begin = sign * start[k, : self.ndir]
            whole = sign * end[k, : self.ndir] - begin
            for i in range(1, ITERATIONS + 1):
                self._call(k, begin, i / ITERATIONS * whole, dt)
            self.state[k], self.stress[k] = self.end
            self.energies[k] = [self.densities[0], *(self.energies[k, 1:] + self.densities[[1, 2, 4]])]
            traction[k, : self.ndir] = sign * self.stress[k]
        return traction

    def _call(self, k: int, begin: Floats, step: Floats, dt: float) -> None:
        """Call the routine for a node; stress and state of the node stay those at the start."""
        self.end[0][:], self.end[1][:] = self.state[k], self.stress[k]
        self.densities[:], self.integers[0], self.integers[10] = np.nan, k + 1, -1
        self.shift[:], self.dtime.value = (begin + step, step), dt
        LIBRARY.uinter_(*self.before, self.of_cut[k], *self.behind)
        self.stiffness[k], self.closed[k] = self.columns.T, self.integers[10]


class ExplicitPoints:
    """Nodes of the secondary surface in Explicit, all in one call; ndir: components, 3 in space or 2."""

    def __init__(self, props: Floats, n: int, ndir: int = 3) -> None:
        """Begin with n virgin nodes."""
        self.props, self.ndir = np.array(props), ndir
        statev = LIBRARY.asperity_nstatv(_at(self.props), len(props), None, 0)
        self.state, self.stress = np.zeros((n, statev)), np.zeros((n, ndir))
        # friction, rupture, crushing, viscous part, stored energy
        self.densities = np.full((5, n), np.nan)
        # steps, nodes of a facet, of the secondary and of the main surface, directions, sizes
        self.integers = np.array([1, 1, 4, n, 4, ndir, ndir, statev, len(props), 0, 0, 0], np.int32)
        self.unused, self.numbers = np.full(9 * n, np.nan), np.ones(4 * n, np.int32)
        # the arguments are the same arrays in every call
        self.shift, self.dtime = np.zeros((2, n, ndir)), ctypes.c_double()
        friction, rupture, crushing, viscous, stored = (_at(row) for row in self.densities)
        unused, (rdisp, drdisp) = _at(self.unused), map(_at, self.shift)
        self.arguments = (
            friction, rupture, crushing, viscous, _at(self.stress), unused, unused, stored, _at(self.state),
            *[_at(self.integers[i:]) for i in range(len(self.integers))], *[_at(self.numbers)] * 3,
            unused, unused, ctypes.byref(self.dtime), NAME, NAME, NAME, rdisp, drdisp,
            *[unused] * 7, _at(self.props), *[unused] * 9, *[ctypes.c_size_t(80)] * 3,
        )  # fmt: skip

    def step(self, start: Floats, end: Floats, dt: float = 0.0) -> Floats:
        """Tractions (n, 3) at the end of an increment from separation to separation (n, 3)."""
        sign = SIGN[: self.ndir]
        self.shift[0] = sign * end[:, : self.ndir]
        self.shift[1] = self.shift[0] - sign * start[:, : self.ndir]
        self.dtime.value = dt
        LIBRARY.vuinter_(*self.arguments)
        traction = np.zeros((len(end), 3))
        traction[:, : self.ndir] = sign * self.stress
        return traction


def _at(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
