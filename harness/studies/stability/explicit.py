"""One point taken through the VUMATs of the library as in an explicit code."""

from __future__ import annotations

import numpy as np
from asperity.contract import Floats, statev_names
from asperity.interface import Interface

from tests.python.support_calls import LIBRARY, vumat


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

    def step(self, ds: Floats, time: float = 1.0) -> Floats:
        """Return the traction (N, Tx, Ty) after a change ds (3,) of the separation; time: at its end, > 0."""
        strain = np.array([[ds[0], 0.5 * ds[2], 0.5 * ds[1]]])
        old = self.stress, self.state, self.energies
        result = vumat(LIBRARY, self.props, self.density, (time, 1.0), strain, *old)
        self.stress, self.state, self.energies = result.stress, result.state, result.energies
        return result.stress[0, [0, 2, 1]]

    @property
    def damage(self) -> float:
        """Mean damage of the planes."""
        return float(self.state[0, self.names.index("damage")])


def fly(
    interface: Interface, dt: float, steps: int, push: float, force: float, start: float
) -> tuple[float, float]:
    """Central differences for a mass of 1, stress*time^2/length, on a point of the interface, along N.

    push: velocity at the start, length/time.  force: constant, stress.  start: separation at the start, which
    is applied in one increment.  Returns the largest |separation| and the damage at the end.
    """
    point = Vumat(interface)
    s, normal = start, np.array([1.0, 0.0, 0.0])
    velocity = push + 0.5 * dt * (force - point.step(s * normal)[0])
    largest = abs(s)
    for _ in range(steps):
        s += dt * velocity
        velocity += dt * (force - point.step(dt * velocity * normal)[0])
        largest = max(largest, abs(s))
    return largest, point.damage
