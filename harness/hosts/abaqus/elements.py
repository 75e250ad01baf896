"""Element matrices of the stand-in: elastic solids and the kinematics of joints."""

from __future__ import annotations

from itertools import product

import numpy as np

GAUSS = 1.0 / np.sqrt(3.0)
CORNERS = {
    2: np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=float),
    3: np.array([[x, y, z] for z in (-1, 1) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))], dtype=float),
}
"""Natural coordinates of the nodes in Abaqus' order."""


def elasticity(kind: str, modulus: float, nu: float) -> np.ndarray:
    """Stress by strain, for the components 11, 22, (33,) 12, (13, 23) without 33 in two dimensions."""
    shear = modulus / (2.0 * (1.0 + nu))
    lame = modulus * nu / ((1.0 + nu) * (1.0 - 2.0 * nu))
    if kind.startswith("CPS"):
        matrix = (
            modulus / (1.0 - nu**2) * np.array([[1.0, nu, 0.0], [nu, 1.0, 0.0], [0.0, 0.0, 0.5 * (1.0 - nu)]])
        )
        return matrix
    n = 2 if kind.startswith("CPE") else 3
    shears = n * (n - 1) // 2
    matrix = np.zeros((n + shears, n + shears))
    matrix[:n, :n] = lame + 2.0 * shear * np.eye(n)
    matrix[n:, n:] = shear * np.eye(shears)
    return matrix


def strains(gradients: np.ndarray) -> np.ndarray:
    """Strain by displacements (node by node), from gradients of the shape functions (nodes, dimension)."""
    nodes, dimension = gradients.shape
    pairs = [(0, 1)] if dimension == 2 else [(0, 1), (0, 2), (1, 2)]
    b = np.zeros((dimension + len(pairs), nodes, dimension))
    for i in range(dimension):
        b[i, :, i] = gradients[:, i]
    for k, (i, j) in enumerate(pairs, dimension):
        b[k, :, i], b[k, :, j] = gradients[:, j], gradients[:, i]
    return b.reshape(len(b), -1)


def solid(
    kind: str, points: np.ndarray, modulus: float, nu: float, stress: np.ndarray | None, thickness: float
):
    """Stiffness, nodal forces of an initial stress, and volume of an elastic solid with full integration.

    The kind CPE4I has incompatible modes, as Abaqus' element.
    """
    dimension = points.shape[1]
    corners = CORNERS[dimension]
    d = elasticity(kind, modulus, nu)
    size = points.size
    n_modes = dimension**2 if kind.endswith("I") else 0
    k = np.zeros((size + n_modes, size + n_modes))
    force, volume = np.zeros(size), 0.0
    center = np.linalg.inv(_derivatives(np.zeros(dimension), corners).T @ points)
    for place in product((-GAUSS, GAUSS), repeat=dimension):
        at = np.array(place)
        derivatives = _derivatives(at, corners)
        jacobian = derivatives.T @ points
        weight = float(np.linalg.det(jacobian)) * (thickness if dimension == 2 else 1.0)
        b = strains(derivatives @ np.linalg.inv(jacobian).T)
        if n_modes:
            b = np.hstack([b, strains(np.diag(-2.0 * at) @ center.T)])
        k += weight * b.T @ d @ b
        volume += weight
        if stress is not None:
            force += weight * b[:, :size].T @ stress
    if n_modes:
        a, c, e = k[:size, :size], k[:size, size:], k[size:, size:]
        k = a - c @ np.linalg.solve(e, c.T)
    return k, force, volume


def _derivatives(at: np.ndarray, corners: np.ndarray) -> np.ndarray:
    """Derivatives of the shape functions by the natural coordinates, (nodes, dimension)."""
    factors = 1.0 + corners * at
    dimension = len(at)
    found = np.empty(corners.shape)
    for i in range(dimension):
        others = [j for j in range(dimension) if j != i]
        found[:, i] = corners[:, i] * factors[:, others].prod(axis=1) / 2**dimension
    return found


def joint(points: np.ndarray, thickness: float) -> tuple[list[np.ndarray], list[float]]:
    """Separation (N, Tx, Ty) by the displacements, and area, of each integration point of a joint.

    In two dimensions `thickness` is that across the plane. The first shear direction is Abaqus' default,
    the x axis projected onto the face.
    """
    dimension = points.shape[1]
    half = len(points) // 2
    lower = points[:half]
    corners = CORNERS[dimension][:half, : dimension - 1]
    order = list(range(half, 2 * half)) if dimension == 3 else [3, 2]
    matrices, areas = [], []
    for place in product((-GAUSS, GAUSS), repeat=dimension - 1):
        at = np.array(place)
        shapes = (1.0 + corners * at).prod(axis=1) / 2 ** (dimension - 1)
        tangents = _derivatives(at, corners).T @ lower if dimension == 3 else (lower[1:] - lower[:1]) / 2.0
        if dimension == 3:
            normal = np.cross(tangents[0], tangents[1])
            area = float(np.linalg.norm(normal))
            normal = normal / area
            first = np.array([1.0, 0.0, 0.0]) - normal[0] * normal
            first /= np.linalg.norm(first)
            axes = np.array([normal, first, np.cross(normal, first)])
        else:
            length = float(np.linalg.norm(tangents[0]))
            area = length * thickness
            first = tangents[0] / length
            axes = np.array([[-first[1], first[0]], first])
        b = np.zeros((dimension, 2 * half, dimension))
        for i in range(half):
            b[:, i, :] -= shapes[i] * axes
            b[:, order[i], :] += shapes[i] * axes
        matrices.append(b.reshape(dimension, -1))
        areas.append(area)
    return matrices, areas


def face(kind: str, number: int) -> list[int]:
    """Nodes of a face of a solid, from 0; only those that the decks load."""
    known = {("2", 3): [2, 3], ("3", 2): [4, 5, 6, 7]}
    return known["3" if kind.startswith("C3D") else "2", number]
