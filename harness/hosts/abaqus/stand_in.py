"""A stand-in for Abaqus that runs the decks: elastic solids and cohesive elements with UMAT or VUMAT.

It follows Abaqus where the manuals say how: order of components, increments and cut-backs, loads that grow
over a static step, stresses and state variables of the start of the increment at every call. Strains are
small. It is no substitute for a run in Abaqus.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from deck import DeckError, Keyword
from deck_model import COHESIVE, SOLIDS, Model, Step, rows_of_boundary, rows_of_cload, rows_of_dload
from elements import face, joint, solid
from explicit_steps import explicit_step, ordered
from records import Points, Row
from scipy import sparse
from scipy.sparse.linalg import splu
from user_routines import Umat, Vumat

TOLERANCE, MOST_ITERATIONS = 1.0e-9, 16
"""Largest residual of an increment relative to the largest nodal force; more iterations give it up."""


@dataclass
class StandIn:
    """Model, its matrices, and what it is loaded by."""

    model: Model
    rows: list[Row] = field(default_factory=list)

    def __post_init__(self) -> None:
        """Assemble what does not change."""
        model = self.model
        self.place = {node: i for i, node in enumerate(model.nodes)}
        self.size = len(model.nodes) * model.dimension
        self.mass, self.initial = np.zeros(self.size), np.zeros(self.size)
        self.stiffness = self._solids()
        self.points = self._points()
        self.u = np.zeros(self.size)
        self.prescribed: dict[int, float] = {}
        self.force, self.balance = np.zeros(self.size), np.zeros(self.size)
        self.work, self.dt, self.velocity = 0.0, 0.0, np.zeros(0)
        for keyword in model.boundary:
            for freedoms, value in self._boundary(keyword):
                self.prescribed |= dict.fromkeys(freedoms, value)

    def freedoms(self, nodes: list[int]) -> np.ndarray:
        """Degrees of freedom of nodes, node by node."""
        dimension = self.model.dimension
        return np.array([self.place[node] * dimension + i for node in nodes for i in range(dimension)])

    def total(self, row: Row, nset: str, direction: int) -> float:
        """Sum of the reactions of a node set, in direction 1, 2 or 3."""
        return float(
            sum(row.reaction[self.freedoms([node])[direction - 1]] for node in self.model.nsets[nset])
        )

    def displacement(self, row: Row, node: int, direction: int) -> float:
        """Displacement of a node."""
        return float(row.u[self.freedoms([node])[direction - 1]])

    def _points_of(self, nodes: tuple[int, ...]) -> np.ndarray:
        return np.array([self.model.nodes[node] for node in nodes])

    def _solids(self) -> sparse.csc_matrix:
        model = self.model
        entries: list[tuple[np.ndarray, np.ndarray]] = []
        for number, (kind, nodes) in model.elements.items():
            if kind not in SOLIDS:
                continue
            name, thickness = model.sections[number]
            material = model.materials[name]
            stress = None
            if number in model.stress:
                stress = np.array(model.stress[number])
                if kind.startswith("CPE"):
                    stress = stress[[0, 1, 3]]  # 33 does no work in plane strain
            k, force, volume = solid(kind, self._points_of(nodes), *material.elastic, stress, thickness)
            freedoms = self.freedoms(list(nodes))
            entries.append((freedoms, k))
            self.initial[freedoms] += force
            self.mass[freedoms] += (material.density or 0.0) * volume / len(nodes)
        matrix = sparse.lil_matrix((self.size, self.size))
        for freedoms, k in entries:
            matrix[np.ix_(freedoms, freedoms)] += k
        return matrix.tocsc()

    def _points(self) -> Points:
        model = self.model
        dimension = model.dimension
        rows, areas, owners, material = [], [], [], ""
        for number, (kind, nodes) in model.elements.items():
            if kind not in COHESIVE:
                continue
            name, _ = model.sections[number]
            if material not in ("", name):
                raise DeckError(f"material {name}: the stand-in takes one user material")
            material = name
            matrices, of_points = joint(self._points_of(nodes), 1.0)
            freedoms = self.freedoms(list(nodes))
            for matrix, area in zip(matrices, of_points, strict=True):
                full = sparse.lil_matrix((dimension, self.size))
                full[:, freedoms] = matrix
                rows.append(full.tocsr())
                areas.append(area)
                owners.append(number)
                self.mass[freedoms] += (model.materials[name].density or 0.0) * area / len(nodes)
        count = len(areas)
        stress = np.array([model.stress.get(number, [0.0] * dimension) for number in owners])
        none = [0.0] * len(model.materials[material].statev)
        statev = np.array([model.solution.get(number, none) for number in owners])
        if any(step.explicit for step in model.steps):
            stress = ordered(stress)
        return Points(
            sparse.vstack(rows).tocsr(),
            np.array(areas),
            np.array(owners),
            material,
            stress,
            np.zeros((count, dimension)),
            statev,
        )

    def _boundary(self, keyword: Keyword) -> Iterator[tuple[list[int], float]]:
        for nodes, directions, value in rows_of_boundary(self.model, keyword):
            yield [int(self.freedoms([node])[i - 1]) for node in nodes for i in directions], value

    def targets(
        self, step: Step
    ) -> tuple[list[tuple[dict[int, float], str | None]], list[tuple[np.ndarray, str | None]]]:
        """New prescribed displacements and new forces of a step, each with its amplitude."""
        prescribed, forces = [], []
        for keyword in step.keywords:
            amplitude = keyword.options.get("amplitude")
            if keyword.name == "boundary":
                prescribed += [(dict.fromkeys(f, value), amplitude) for f, value in self._boundary(keyword)]
            elif keyword.name == "cload":
                force = np.zeros(self.size)
                for nodes, direction, value in rows_of_cload(self.model, keyword):
                    for node in nodes:
                        force[self.freedoms([node])[direction - 1]] += value
                forces.append((force, amplitude))
            elif keyword.name == "dload":
                forces.append((self._pressure(keyword), amplitude))
        return prescribed, forces

    def _pressure(self, keyword: Keyword) -> np.ndarray:
        """Nodal forces of pressures on upper faces, against the last coordinate."""
        force = np.zeros(self.size)
        for elements, number, pressure in rows_of_dload(self.model, keyword):
            for element in elements:
                kind, nodes = self.model.elements[element]
                loaded = [nodes[i] for i in face(kind, number)]
                points = self._points_of(tuple(loaded))
                if self.model.dimension == 2:
                    area = float(np.linalg.norm(points[1] - points[0])) * self.model.sections[element][1]
                else:
                    area = 0.5 * float(np.linalg.norm(np.cross(points[2] - points[0], points[3] - points[1])))
                force[[self.freedoms([node])[-1] for node in loaded]] -= pressure * area / len(loaded)
        return force

    def factor(self, amplitude: str | None, time: float, duration: float) -> float:
        """Share of a load at a time of the step; without amplitude it grows in a static step."""
        if amplitude is None:
            return time / duration
        pairs, smooth = self.model.amplitudes[amplitude]
        times, values = zip(*pairs, strict=True)
        if not smooth:
            return float(np.interp(time, times, values))
        x = np.clip((time - times[0]) / (times[1] - times[0]), 0.0, 1.0)
        return float(values[0] + (values[1] - values[0]) * x**3 * (10.0 - 15.0 * x + 6.0 * x * x))

    def run(self, library, single: bool = False, keep: int = 1) -> StandIn:
        """All steps; `keep`: every how many explicit increments a row is kept."""
        total = 0.0
        material = self.model.materials[self.points.material]
        for step in self.model.steps:
            if step.explicit:
                vumat = Vumat(library, np.array(material.props), material.density, single)
                total = explicit_step(self, step, vumat, total, keep)
            else:
                umat = Umat(library, np.array(material.props), self.model.dimension, len(material.statev))
                self._static(step, umat)
        return self

    def _static(self, step: Step, umat: Umat) -> None:
        values = step.keywords[1].numbers()
        direct = "direct" in step.keywords[1].options
        size, duration = values[:2]
        smallest, largest = (size, size) if direct else values[2:]
        prescribed, forces = self.targets(step)
        start, force, beginning = dict(self.prescribed), self.force, self.u
        time = 0.0
        while time < duration * (1.0 - 1.0e-9):
            size = min(size, largest, duration - time)
            held = dict(start)
            for target, amplitude in prescribed:
                share = self.factor(amplitude, time + size, duration)
                for freedom, value in target.items():
                    before = beginning[freedom] if amplitude is None else 0.0
                    held[freedom] = before + share * (value - before)
            load = force + sum(
                (self.factor(a, time + size, duration) * f for f, a in forces), np.zeros(self.size)
            )
            iterations = self._increment(umat, held, load, size)
            if iterations:
                time += size
                self.rows[-1].step, self.rows[-1].time = step.name, time
                size = min(largest, size * 1.5)
                continue
            size *= 0.25
            if size < smallest:
                raise RuntimeError(f"step {step.name}, time {time:g}: no convergence")

    def _increment(self, umat: Umat, held: dict[int, float], load: np.ndarray, dtime: float) -> int:
        """Solve one increment; the number of iterations, 0 if there is no convergence."""
        transform, fixed, free = self._constraints(held)
        u = transform @ self.u[free] + fixed
        for iteration in range(1, MOST_ITERATIONS + 1):
            internal, tangent, stress, statev = self._internal(umat, u, dtime)
            if internal is None:
                return 0
            residual = load - internal
            scale = max(np.abs(internal).max(), np.abs(load).max(), 1.0e-12)
            unbalanced = transform.T @ residual
            if iteration > 1 and np.abs(unbalanced).max() <= TOLERANCE * scale:
                self.prescribed = held
                self._accept(u, load, internal, stress, statev, iteration)
                return iteration
            try:
                step = splu((transform.T @ tangent @ transform).tocsc()).solve(unbalanced)
            except RuntimeError as error:
                raise DeckError(f"the model can move without a force: {error}") from None
            u = u + transform @ step
        return 0

    def _constraints(self, held: dict[int, float]) -> tuple[sparse.csc_matrix, np.ndarray, list[int]]:
        """Matrix from the free unknowns to all displacements, prescribed displacements, and what is free."""
        fixed = np.zeros(self.size)
        fixed[list(held)] = list(held.values())
        dependent: dict[int, list[tuple[int, float]]] = {}
        for terms in self.model.equations:
            (name, direction, factor), *others = terms
            keyword = Keyword("equation", 0, {})
            for node in self.model.nodes_of(keyword, name):
                dependent[int(self.freedoms([node])[direction - 1])] = [
                    (int(self.freedoms(self.model.nodes_of(keyword, other))[i - 1]), -f / factor)
                    for other, i, f in others
                ]
        free = [i for i in range(self.size) if i not in held and i not in dependent]
        column = {freedom: j for j, freedom in enumerate(free)}
        matrix = sparse.lil_matrix((self.size, len(free)))
        for freedom, j in column.items():
            matrix[freedom, j] = 1.0
        for freedom, terms in dependent.items():
            if freedom in held:
                raise DeckError(f"degree of freedom {freedom} is prescribed and eliminated by *Equation")
            for other, factor in terms:
                if other in column:
                    matrix[freedom, column[other]] = factor
                else:
                    fixed[freedom] += factor * held[other]
        return matrix.tocsc(), fixed, free

    def _internal(self, umat: Umat, u: np.ndarray, dtime: float):
        """Internal forces, their derivative, and stresses and state variables of the joints."""
        points = self.points
        strain = points.separation(u)
        stress, statev = np.empty_like(points.stress), np.empty_like(points.statev)
        count, n = stress.shape
        tangents = np.empty((count, n, n))
        for p in range(count):
            old = points.strain[p]
            if not umat.call(points.stress[p], points.statev[p], old, strain[p] - old, dtime):
                return None, None, None, None
            stress[p], statev[p], tangents[p] = umat.stress, umat.statev, umat.tangent
        internal = self.stiffness @ u + self.initial + points.forces(stress)
        blocks = sparse.block_diag(list(tangents * points.area[:, None, None]), format="csr")
        tangent = self.stiffness + points.matrix.T @ blocks @ points.matrix
        return internal, tangent, stress, statev

    def _accept(self, u, load, internal, stress, statev, iterations: int) -> None:
        """Keep an increment; in equilibrium the work of all external forces is that of the internal ones."""
        self.work += 0.5 * float((internal + self.balance) @ (u - self.u))
        self.balance = internal
        points = self.points
        points.strain, points.stress, points.statev = points.separation(u), stress, statev
        self.u, self.force = u, load
        self.rows.append(Row("", 0.0, u, internal - load, iterations, statev, stress, self.work))
