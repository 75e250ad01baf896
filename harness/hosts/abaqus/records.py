"""What the stand-in keeps: values at integration points, and a row for each increment."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse


@dataclass
class Row:
    """State at the end of an increment."""

    step: str
    time: float
    u: np.ndarray
    reaction: np.ndarray
    iterations: int
    statev: np.ndarray
    traction: np.ndarray
    work: float


@dataclass
class Points:
    """Integration points of all joints: matrices, areas, elements, values at the start of an increment."""

    matrix: sparse.csr_matrix
    area: np.ndarray
    element: np.ndarray
    material: str
    stress: np.ndarray
    strain: np.ndarray
    statev: np.ndarray

    def separation(self, u: np.ndarray) -> np.ndarray:
        """Separation of every point, (points, dimension)."""
        return (self.matrix @ u).reshape(self.stress.shape)

    def forces(self, stress: np.ndarray) -> np.ndarray:
        """Nodal forces of tractions."""
        return self.matrix.T @ (stress * self.area[:, None]).ravel()
