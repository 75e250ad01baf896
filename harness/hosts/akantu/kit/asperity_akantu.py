"""Material of Akantu's cohesive elements with the law of asperity, from `asperity export akantu`."""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from dataclasses import dataclass

import akantu as aka
import numpy as np
from asperity import Interface, Material, Pattern, contract
from asperity.contract import Floats
from scipy.spatial import KDTree

FACETS = {
    aka._cohesive_2d_4: aka._segment_2, aka._cohesive_2d_6: aka._segment_3,
    aka._cohesive_3d_6: aka._triangle_3, aka._cohesive_3d_12: aka._triangle_6,
    aka._cohesive_3d_8: aka._quadrangle_4, aka._cohesive_3d_16: aka._quadrangle_8,
}  # fmt: skip
"""Type of the facets at which elements of a type are inserted."""

CONSTANTS = contract.owned("law", "pattern")
"""Constants that an input file may give."""

SAME_PLACE = 1.0e-9
"""Largest distance of a new element from its facet, relative to the size of the model."""

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

    Separations are those of side 2 from side 1, in axes that turn with the joint.  The script calls `commit`
    at the end of a step, as Akantu does not tell a material that a step has converged.  `dt` is the duration
    of the step, which viscous damage needs.

    In an extrinsic model Akantu inserts elements during the run, where the traction of a facet (its shear and
    its tension, root of the sum of squares) exceeds `insertion` times sigma0.  A new element carries this
    traction at separation zero, as after `Interface.initial`.

    Without an interface the constants are those of the input file (`asperity card akantu`).
    """

    interface: Interface

    def __init__(
        self,
        model: aka.SolidMechanicsModelCohesive,
        name: str,
        interface: Interface | None,
        tx: Sequence[float],
        insertion: float,
    ) -> None:
        """Create the material; tx (3,) is a direction whose projection on the joint is Tx."""
        super().__init__(model, name)
        if interface is not None:
            self.interface = interface
        else:
            for row in CONSTANTS:
                default = np.nan if row.default is None else row.default
                self.registerParamReal(default, row.name, aka._pat_parsmod, row.meaning)
        self.insertion = insertion
        self._model = model
        self._places: list[Floats] = []
        self._stresses: list[Floats] = []
        self.dt: float | None = None
        self._tx = np.array(tx, dtype=float)
        self._points: dict[object, Points] = {}
        self._start: dict[object, Floats] = {}

    def initMaterial(self) -> None:
        """Start the material; Akantu calls it when it has read the input file."""
        super().initMaterial()
        if not hasattr(self, "interface"):
            values = {row.name: self.getReal(row.name) for row in CONSTANTS}
            missing = [name for name, value in values.items() if np.isnan(value)]
            if missing:
                raise ValueError(f"{', '.join(missing)}: expected in the material section of the input file")
            pattern = {row.name: values.pop(row.name) for row in contract.owned("pattern")}
            self.interface = Interface(Material(**values), Pattern(pattern.pop("m"), **pattern))

    def points(self, element_type: object) -> Points:
        """Integration points of a type of elements, after the last call."""
        return self._points[element_type]

    def types(self) -> list[object]:
        """Types of elements that have points."""
        return list(self._points)

    def axes(self, element_type: object) -> Floats:
        """Axes N, Tx, Ty of the integration points, in global components: (n, axes, components).

        They turn with the normals, about axes in the joint: Tx starts along tx.
        """
        normal = np.array(self.getInternalReal("normal")(element_type))
        start = self._start.get(element_type, np.zeros((0, 2, normal.shape[1])))
        if len(start) < len(normal):
            start = np.concatenate([start, self._first_axes(normal[len(start) :])])
            self._start[element_type] = start
        old, tx = start[:, 0], start[:, 1]
        share = np.sum(tx * normal, axis=1) / (1.0 + np.sum(old * normal, axis=1))
        along = tx - share[:, None] * (old + normal)
        across = [np.cross(normal, along)] if normal.shape[1] == 3 else []
        return np.stack([normal, along, *across], axis=1)

    def _first_axes(self, normal: Floats) -> Floats:
        """N and Tx of points that are new: (n, 2, components)."""
        n, dimension = normal.shape
        if dimension == 2:  # there is one direction across the normal, whose sense is that of tx
            along = np.stack([-normal[:, 1], normal[:, 0]], axis=1)
            against = along @ self._tx[:2] < -PARALLEL * np.linalg.norm(self._tx)
            return np.stack([normal, np.where(against, -1.0, 1.0)[:, None] * along], axis=1)
        tx = np.broadcast_to(self._tx[:dimension], normal.shape)
        along = tx - np.sum(tx * normal, axis=1)[:, None] * normal
        length = np.linalg.norm(along, axis=1)
        if n > 0 and length.min() < PARALLEL * np.linalg.norm(self._tx):
            bad = normal[int(length.argmin())]
            raise ValueError(
                f"tx = {self._tx.tolist()}: expected a direction across the normal {bad.tolist()}"
            )
        along = along / length[:, None]
        return np.stack([normal, along], axis=1)

    def computeTraction(self, element_type: object, ghost: object = aka._not_ghost) -> None:
        """Tractions of the openings; Akantu calls it."""
        opening = np.array(self.getOpening(element_type))
        n, dimension = opening.shape
        axes = self.axes(element_type)
        separation = np.zeros((n, 3))
        separation[:, :dimension] = np.einsum("nai,ni->na", axes, opening)
        points = self._points.get(element_type)
        if points is None or len(points.state) != n:
            old = 0 if points is None else len(points.state)
            zero, state = np.zeros((n, 3)), np.zeros((n, self.interface.nstatv))
            if points is not None:
                zero[:old], state[:old] = points.separation, points.state
            if self._places:
                state[old:] = self._first_states(element_type, axes, old)
            points = Points(zero, state, zero, state, zero, np.zeros((n, 3, 3)))
            self._points[element_type] = points
        result = self.interface.update(separation, points.state, points.separation, self.dt)
        points.new_separation, points.new_state = separation, np.array(result.state)
        points.traction, points.tangent = np.array(result.traction), np.array(result.tangent)
        self.getTraction(element_type)[:] = np.einsum("nai,na->ni", axes, points.traction[:, :dimension])

    def computeTangentTraction(
        self, element_type: object, tangent: Floats, ghost: object = aka._not_ghost
    ) -> None:
        """Tangents of the last call of computeTraction; Akantu keeps one triangle of the stiffness."""
        axes = self.axes(element_type)
        dimension = axes.shape[1]
        local = self._points[element_type].tangent[:, :dimension, :dimension]
        tangent[:] = np.einsum("nai,nab,nbj->nij", axes, local, axes).reshape(len(axes), -1)

    def checkInsertion(self, check_only: bool = False) -> None:
        """Mark the facets where elements are to be inserted; Akantu calls it in an extrinsic model."""
        inserter, facets = self._model.getElementInserter(), self._model.getMesh().getMeshFacets()
        nodes = np.array(self._model.getMesh().getNodes())
        dimension = nodes.shape[1]
        engine = self._model.getFEEngine("FacetsFEEngine")
        for facet in FACETS.values():
            if aka.Mesh.getSpatialDimension(facet) != dimension - 1 or facets.getNbElement(type=facet) == 0:
                continue
            if facet in (aka._quadrangle_4, aka._quadrangle_8):
                raise ValueError(
                    "facets are quadrilaterals: expected triangles, as Akantu's stresses on others are wrong"
                )
            candidates = np.array(self.getFacetFilter(facet)).ravel()
            allowed = np.array(inserter.getCheckFacets(facet)).ravel().astype(bool)
            candidates = candidates[allowed[candidates]]
            if check_only or len(candidates) == 0:
                continue
            connectivity = np.array(facets.getConnectivity(facet))
            count = engine.getNbIntegrationPoints(facet)
            # stresses of both sides at the integration points
            stress = np.array(self._model.getStressOnFacets(facet))
            stress = stress.reshape(-1, count, 2, dimension, dimension)[candidates].mean(axis=(1, 2))
            normal = np.array(engine.getNormalsOnIntegrationPoints(facet))[count * candidates]
            traction = np.einsum("nij,nj->ni", stress, normal)
            tension = np.sum(traction * normal, axis=1)
            shear = np.linalg.norm(traction - tension[:, None] * normal, axis=1)
            size = np.hypot(np.maximum(tension, 0.0), shear)
            chosen = size >= self.insertion * self.interface.material.sigma0
            inserter.getInsertionFacets(facet)[candidates[chosen]] = True
            self._places.extend(nodes[connectivity[candidates[chosen]]].mean(axis=1))
            self._stresses.extend(stress[chosen])

    def _first_states(self, element_type: object, axes: Floats, old: int) -> Floats:
        """States of the points from number `old` on, which carry the stress of their facets."""
        mesh = self._model.getMesh()
        nodes, numbers = np.array(mesh.getNodes()), np.array(self.getElementFilter()(element_type)).ravel()
        places = nodes[np.array(mesh.getConnectivity(element_type))[numbers]].mean(axis=1)
        per_element = len(axes) // len(numbers)
        distance, at = KDTree(np.array(self._places)).query(places[old // per_element :])
        if distance.max() > SAME_PLACE * np.ptp(nodes):
            raise RuntimeError(f"a new element is {distance.max():g} away from all facets that were marked")
        stress = np.repeat(np.array(self._stresses)[at], per_element, axis=0)
        new, traction = axes[old:], np.zeros((len(axes) - old, 3))
        traction[:, : axes.shape[1]] = np.einsum("nai,nij,nj->na", new, stress, new[:, 0])
        return self.interface.initial(traction)

    def commit(self) -> None:
        """End a step: the state of the last call is the start of the next step."""
        for points in self._points.values():
            points.separation, points.state = points.new_separation, points.new_state


def register(
    interface: Interface | None = None,
    name: str = "asperity",
    tx: Sequence[float] = (1.0, 0.0, 0.0),
    insertion: float = 0.5,
) -> list[Joint]:
    """Make the law known under a name, for `material NAME [ ... ]` of an input file.

    interface: None for the constants of that section.  insertion, 0 to 1: see `Joint`.  Returns the list to
    which Akantu adds every material of this name; keep it as long as the models.
    """
    if not 0.0 < insertion < 1.0:
        raise ValueError(f"insertion = {insertion:g}: expected a part of the strength, 0 < insertion < 1")
    joints: list[Joint] = []

    def allocate(dimension: int, option: str, model: object, identifier: str) -> Joint:
        joints.append(Joint(model, identifier, interface, tx, insertion))
        return joints[-1]

    # Akantu drops the function when Python has ended already, and must not be the last to do so
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(allocate))
    aka.MaterialFactory.getInstance().registerAllocator(name, allocate)
    return joints
