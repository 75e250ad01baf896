"""Interfaces of `asperity` in a finite element code written with scikit-fem: all points in one call."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from asperity import Interface
from asperity.contract import Floats
from numpy.typing import NDArray
from scipy import sparse
from scipy.sparse.linalg import splu
from skfem import FacetBasis

COMPONENTS = 2
"""Components N (y) and Tx (x) in the plane; the separation along Ty is 0."""


class Joint:
    """Zero-thickness interface between a face that lies on y = 0 and a rigid base.

    Its points are the integration points of the face.  `jump` maps displacements to separations of the
    points; `state` is that of the last accepted step.
    """

    def __init__(self, interface: Interface, n_unknowns: int, face: FacetBasis) -> None:
        """Take the integration points of a face and the matrix from displacements to (N, Tx) there."""
        self.interface = interface
        self.weights = np.asarray(face.dx).ravel()
        n = len(self.weights)
        rows, columns, values = [], [], []
        for i, (shape, *_) in enumerate(face.basis):
            components = np.asarray(shape)  # (2, facets, points of a facet): x, y
            unknowns = np.repeat(face.element_dofs[i], components.shape[2])
            for row, component in enumerate((1, 0)):
                rows.append(COMPONENTS * np.arange(n) + row)
                columns.append(unknowns)
                values.append(components[component].ravel())
        entries = (np.concatenate(values), (np.concatenate(rows), np.concatenate(columns)))
        self.jump = sparse.coo_array(entries, shape=(COMPONENTS * n, n_unknowns)).tocsr()
        self.state = np.zeros((n, interface.nstatv))
        self.trial = self.state
        self.separation = np.zeros((n, 3))

    def assemble(self, u: Floats) -> tuple[Floats, sparse.csr_array]:
        """Internal forces of the interface, and their consistent tangent (unsymmetric)."""
        result = self.interface.update(self._separation(u), self.state, self.separation)
        self.trial = result.state
        traction = result.traction[:, :COMPONENTS] * self.weights[:, None]
        tangent = result.tangent[:, :COMPONENTS, :COMPONENTS] * self.weights[:, None, None]
        n = len(self.weights)
        blocks = sparse.bsr_array(
            (tangent, np.arange(n), np.arange(n + 1)), shape=(COMPONENTS * n, COMPONENTS * n)
        )
        return self.jump.T @ traction.ravel(), (self.jump.T @ blocks @ self.jump).tocsr()

    def accept(self, u: Floats) -> None:
        """Accept the last trial state."""
        self.state = self.trial
        self.separation = self._separation(u)

    def _separation(self, u: Floats) -> Floats:
        s = np.zeros((len(self.weights), 3))
        s[:, :COMPONENTS] = (self.jump @ u).reshape(-1, COMPONENTS)
        return s


class NotConverged(RuntimeError):
    """No equilibrium within the allowed iterations."""


@dataclass
class Newton:
    """Equilibrium of elastic bodies and a joint with prescribed displacements.

    norms: residuals of the last step over the largest force, or over `least`, a force, if that is larger.
    halvings: largest number for a correction.
    """

    stiffness: sparse.csr_array
    joint: Joint
    fixed: NDArray[np.int64]
    tolerance: float = 1e-10
    most: int = 20
    halvings: int = 4
    least: float = float(np.finfo(float).tiny)
    iterations: int = 0
    norms: list[float] = field(default_factory=list)

    def step(self, u: Floats, displacements: Floats, load: Floats) -> tuple[Floats, Floats]:
        """Displacements and reactions for prescribed displacements (of `fixed`) and loads; accepts the state.

        A correction is halved if it increases the residual, for example because points open or are damaged.
        """
        free = np.setdiff1d(np.arange(len(u)), self.fixed)
        correction = np.zeros(len(u))
        correction[self.fixed] = displacements - u[self.fixed]
        out, tangent, norm = self.residual(u, load, free)
        self.norms = []
        for _ in range(self.most):
            total = (self.stiffness + tangent).tocsc()
            right = -out[free] - total[free][:, self.fixed] @ correction[self.fixed]
            correction[free] = splu(total[free][:, free]).solve(right)
            self.iterations += 1
            factor = 1.0
            # the first correction applies the prescribed displacements and is not halved
            for _ in range(self.halvings if self.norms else 0):
                if self.residual(u + factor * correction, load, free)[2] < norm:
                    break
                factor /= 2
            u = u + factor * correction
            correction[self.fixed] = 0.0
            out, tangent, norm = self.residual(u, load, free)
            self.norms.append(norm)
            if norm <= self.tolerance:
                self.joint.accept(u)
                return u, out
        raise NotConverged(f"residuals {', '.join(f'{norm:.1e}' for norm in self.norms)}")

    def residual(
        self, u: Floats, load: Floats, free: NDArray[np.int64]
    ) -> tuple[Floats, sparse.csr_array, float]:
        """Residual forces, tangent of the joint, and the norm of the residual over the largest force."""
        force, tangent = self.joint.assemble(u)
        out = self.stiffness @ u + force - load
        scale = max(np.abs(force).max(), np.abs(out[self.fixed]).max(), np.abs(load).max(), self.least)
        return out, tangent, float(np.abs(out[free]).max() / scale)
