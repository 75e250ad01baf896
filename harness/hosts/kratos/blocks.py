"""Two elastic cubes in Kratos with an interface between them, under compression, shear and rotation."""

from __future__ import annotations

import numpy as np
from asperity import Interface, Material, Pattern
from kratos_model import Floats, Structure

ROUGH = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, kc=20.0), Pattern.regular(4, theta=20.0))
YOUNG, POISSON = 3000.0, 0.2
TOLERANCE = 1.0e-10
"""Accepted residual force, N; the reactions are some N."""

CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))


def run(n: int = 3) -> tuple[list[list[float]], Floats, Floats]:
    """Compress the cubes by 0.01 mm, then shear them by 0.15 mm along x and 0.05 mm along y.

    The top rotates during the shear.  The cubes have an edge of 1 mm and n x n x n elements.  The results are
    the norms of the Newton iterations of each step, then separations and tractions (steps, points, 3).
    """
    s = Structure(3)
    solid, rough = s.elastic(YOUNG, POISSON), s.umat(ROUGH)
    axis = np.linspace(0.0, 1.0, n + 1)
    blocks = []
    for z in (0.0, 1.0):
        grid = np.stack(np.meshgrid(axis, axis, axis + z, indexing="ij"), axis=-1)
        blocks.append(s.add_nodes(grid))
    cells = [(i, j) for i in range(n) for j in range(n)]
    for nodes in blocks:
        for i, j in cells:
            for k in range(n):
                s.add_solid([nodes[i + a, j + b, k + c] for c in (0, 1) for a, b in CORNERS], solid)
    for i, j in cells:
        lower = [blocks[0][i + a, j + b, n] for a, b in CORNERS]
        s.add_interface(lower, [blocks[1][i + a, j + b, 0] for a, b in CORNERS], rough)
    top = blocks[1][:, :, -1]
    s.fix(blocks[0][:, :, 0], 0, 1, 2)
    s.fix(top, 0, 1, 2)
    norms, separation, traction = [], [], []
    for slip in (0.0, 0.01, 0.02, 0.04, 0.06, 0.08, 0.1, 0.12, 0.15):
        s.move(top, 0, slip)
        s.move(top, 1, slip / 3.0)
        s.move(top, 2, lambda node, slip=slip: -0.01 + 0.3 * slip * (node.X0 - 0.3))
        norms.append(s.step(TOLERANCE))
        for values, found in zip((separation, traction), s.points(), strict=True):
            values.append(found)
    return norms, np.array(separation), np.array(traction)
