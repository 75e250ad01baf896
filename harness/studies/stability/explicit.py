"""One point taken through the VUMATs of the library as in an explicit code."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from asperity.contract import Floats, statev_names
from asperity.interface import Interface
from numpy.typing import NDArray

from tests.python.support_calls import LIBRARY, vumat

Array = NDArray[np.floating]


class Vumat:
    """VUMAT (double) or VUMAT_SINGLE of the library with the state of one point, virgin at first.

    Calls are those of Abaqus/Explicit for a 3D cohesive element of thickness and density 1: order N, Ty, Tx.
    """

    def __init__(self, interface: Interface, single: bool = False) -> None:
        """Begin with a virgin point in the precision."""
        kind = np.float32 if single else np.float64
        self.names = statev_names(interface.n_planes)
        self.props, self.density = interface.props().astype(kind), np.ones(1, kind)
        self.state = np.zeros((1, interface.nstatv), kind)
        self.stress, self.energies = np.zeros((1, 3), kind), np.zeros((1, 2), kind)

    def step(self, ds: Array, time: float = 1.0) -> Array:
        """Return the traction (N, Tx, Ty) after a change ds (3,) of the separation; time: at its end, > 0."""
        strain = np.array([[ds[0], 0.5 * ds[2], 0.5 * ds[1]]])
        old = self.stress, self.state, self.energies
        found = vumat(LIBRARY, self.props, self.density, (time, 1.0), strain, *old)
        self.stress, self.state, self.energies = found.stress, found.state, found.energies
        return found.stress[0, [0, 2, 1]]

    @property
    def work(self) -> float:
        """Work of the traction on the separation, as the VUMAT reports it to the host, stress*length."""
        return float(self.energies[0, 0])

    def value(self, name: str) -> float:
        """Value of a state variable by its name."""
        return float(self.state[0, self.names.index(name)])


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
