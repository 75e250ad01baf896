"""Material of Akantu's cohesive elements with the law; needs `asperity[akantu]`."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import akantu as aka
import numpy as np
from numpy.typing import NDArray

from ..interface import Interface

Floats = NDArray[np.float64]

PARALLEL = 1.0e-6
"""Sine of the angle between a normal and the direction of Tx, below which Tx has no direction."""


@dataclass
class Points:
    """Integration points of one type of elements: committed and last separation (n, 3), state (n, nstatv)."""

    separation: Floats
    state: Floats
    new_separation: Floats
    new_state: Floats
    traction: Floats
    tangent: Floats


class Joint(aka.MaterialCohesive):
    """Cohesive material with the law of an interface.

    Separations are those of side 2 from side 1 in small displacements.  The script calls `commit` at the end
    of a step, as Akantu does not tell a material that a step has converged.  `dt` is the duration of the
    step, which viscous damage needs.
    """

    def __init__(
        self, model: aka.SolidMechanicsModelCohesive, name: str, interface: Interface, tx: Sequence[float]
    ) -> None:
        """Create the material; tx (3,) is a direction whose projection on the joint is Tx."""
        super().__init__(model, name)
        self.interface = interface
        self.dt: float | None = None
        self._tx = np.array(tx, dtype=float)
        self._points: dict[object, Points] = {}

    def points(self, element_type: object) -> Points:
        """Integration points of a type of elements, after the last call."""
        return self._points[element_type]

    def axes(self, element_type: object) -> Floats:
        """Axes N, Tx, Ty of the integration points, in global components: (n, axes, components)."""
        normal = np.array(self.getInternalReal("normal")(element_type))
        n, dimension = normal.shape
        tx = np.broadcast_to(self._tx[:dimension], normal.shape)
        along = tx - np.sum(tx * normal, axis=1)[:, None] * normal
        length = np.linalg.norm(along, axis=1)
        if n > 0 and length.min() < PARALLEL * np.linalg.norm(self._tx):
            bad = normal[int(length.argmin())]
            raise ValueError(
                f"tx = {self._tx.tolist()}: expected a direction across the normal {bad.tolist()}"
            )
        along = along / length[:, None]
        rows = [normal, along]
        if dimension == 3:
            rows.append(np.cross(normal, along))
        return np.stack(rows, axis=1)

    def computeTraction(self, element_type: object, ghost: object = aka._not_ghost) -> None:
        """Tractions of the openings; Akantu calls it."""
        opening = np.array(self.getOpening(element_type))
        n, dimension = opening.shape
        axes = self.axes(element_type)
        separation = np.zeros((n, 3))
        separation[:, :dimension] = np.einsum("nai,ni->na", axes, opening)
        points = self._points.get(element_type)
        if points is None or len(points.state) != n:
            zero, state = np.zeros((n, 3)), np.zeros((n, self.interface.nstatv))
            points = Points(zero, state, zero, state, zero, np.zeros((n, 3, 3)))
            self._points[element_type] = points
        result = self.interface.update(separation, points.state, points.separation, self.dt)
        points.new_separation, points.new_state = separation, np.array(result.state)
        points.traction, points.tangent = np.array(result.traction), np.array(result.tangent)
        self.getTraction(element_type)[:] = np.einsum("nai,na->ni", axes, points.traction[:, :dimension])

    def computeTangentTraction(
        self, element_type: object, tangent: Floats, ghost: object = aka._not_ghost
    ) -> None:
        """Tangents of the last call of computeTraction; Akantu stores their symmetric part."""
        axes = self.axes(element_type)
        dimension = axes.shape[1]
        local = self._points[element_type].tangent[:, :dimension, :dimension]
        tangent[:] = np.einsum("nai,nab,nbj->nij", axes, local, axes).reshape(len(axes), -1)

    def commit(self) -> None:
        """End a step: the state of the last call is the start of the next step."""
        for points in self._points.values():
            points.separation, points.state = points.new_separation, points.new_state


def register(
    interface: Interface, name: str = "asperity", tx: Sequence[float] = (1.0, 0.0, 0.0)
) -> list[Joint]:
    """Make the law known under a name, for `material NAME [ ... ]` of an input file.

    Returns the list to which Akantu adds every material of this name; keep it as long as the models.
    """
    made: list[Joint] = []

    def allocate(dimension: int, option: str, model: object, identifier: str) -> Joint:
        made.append(Joint(model, identifier, interface, tx))
        return made[-1]

    # Akantu drops the function when Python has ended already, and must not be the last to do so
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(allocate))
    aka.MaterialFactory.getInstance().registerAllocator(name, allocate)
    return made
