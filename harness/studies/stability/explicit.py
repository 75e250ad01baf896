"""One point taken through the VUMATs of the library as in an explicit code."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass

import numpy as np
from asperity.contract import Floats, statev_names
from asperity.installed import library
from asperity.interface import Interface
from numpy.typing import NDArray

Array = NDArray[np.floating]


class Vumat:
    """VUMAT (double) or VUMAT_SINGLE of the library with the state of one point, virgin at first.

    Calls are those of Abaqus/Explicit for a 3D cohesive element of thickness 1: order N, Ty, Tx.
    """

    def __init__(self, interface: Interface, single: bool = False) -> None:
        """Load the routine for the precision."""
        self.kind = np.float32 if single else np.float64
        handle = ctypes.CDLL(str(library()))
        self._call = handle.vumat_single_ if single else handle.vumat_
        self.names = statev_names(interface.n_planes)
        self.props = interface.props().astype(self.kind)
        self.state = np.zeros(interface.nstatv, self.kind)
        self.density = 1.0
        self._stress = np.zeros(3, self.kind)
        self._energy = np.zeros(2, self.kind)

    def step(self, ds: Array, time: float = 1.0) -> Array:
        """Return the traction (N, Tx, Ty) after a change ds (3,) of the separation; time: at its end, > 0."""
        n_n, n_tx, n_ty = ds
        strain = np.array([n_n, 0.5 * n_ty, 0.5 * n_tx], self.kind)
        nothing = np.zeros(9, self.kind)
        stress, state, energy = (np.zeros_like(old) for old in (self._stress, self.state, self._energy))
        integers = [ctypes.byref(ctypes.c_int(n)) for n in (1, 1, 2, len(state), 0, len(self.props), 0)]
        reals = np.array([time, time, 1.0, self.density], self.kind)

        def at(array: Array, position: int = 0) -> ctypes.c_void_p:
            return ctypes.c_void_p(array.ctypes.data + position * array.itemsize)

        self._call(
            *integers, at(reals), at(reals, 1), at(reals, 2), ctypes.c_char_p(b" " * 80),
            at(nothing), at(nothing), at(self.props), at(reals, 3), at(strain), at(nothing), at(nothing),
            at(nothing), at(nothing), at(nothing), at(self._stress), at(self.state), at(self._energy),
            at(self._energy, 1), at(nothing), at(nothing), at(nothing), at(nothing),
            at(stress), at(state), at(energy), at(energy, 1), ctypes.c_size_t(80),
        )  # fmt: skip
        self._stress, self.state, self._energy = stress, state, energy
        return stress[[0, 2, 1]]

    @property
    def work(self) -> float:
        """Work of the traction on the separation, as the VUMAT reports it to the host, stress*length."""
        return float(self._energy[0]) * self.density

    def value(self, name: str) -> float:
        """Value of a state variable by its name."""
        return float(self.state[self.names.index(name)])


@dataclass(frozen=True, eq=False)
class Flight:
    """Motion of a mass on an interface under a constant force: separation (T, 3), damage at the end, energy.

    energy (T,), stress*length: kinetic energy, with the mean of the velocities before and after, plus work on
    the interface, less work of the force.
    """

    separation: Floats
    damage: float
    energy: Floats


def fly(
    interface: Interface,
    mass: float,
    dt: float,
    steps: int,
    velocity: Floats,
    force: Floats,
    start: Floats | None = None,
) -> Flight:
    """Central differences for a mass per unit area (stress*time^2/length) on a point of the interface.

    velocity (3,): at the start, length/time.  force (3,): constant, stress.  start (3,): separation at the
    start, which is applied in one increment.
    """
    point = Vumat(interface)
    s = np.zeros(3) if start is None else np.asarray(start, float)
    traction = point.step(s)
    first = point.work
    v_half = velocity + 0.5 * dt * (force - traction) / mass
    path, energy = np.empty((steps, 3)), np.empty(steps)
    origin = s.copy()
    for i in range(steps):
        s = s + dt * v_half
        traction = point.step(dt * v_half)
        v_next = v_half + dt * (force - traction) / mass
        v = 0.5 * (v_half + v_next)
        v_half = v_next
        path[i] = s
        energy[i] = 0.5 * mass * (v @ v) + point.work - first - force @ (s - origin)
    return Flight(path, point.value("damage"), energy)
