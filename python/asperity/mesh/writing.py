"""What the files of all hosts share: cells by block, joints as cells, layers, lines of numbers."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import chain, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..contract import Floats
from .jointed import Joint, Jointed
from .shapes import Integers, corners

HEAD = "mesh with joints of asperity"  # first words of a file, after the sign of a comment

SINGULAR = 1.0e-3
"""Directions in which the normals at a node differ by less are left out when its layers get a thickness:
those of joints that meet at 3.6 degrees, where the node would move by 16 h.
"""


def layer_points(mesh: Jointed, h: float) -> Floats:
    """Nodes whose joints have the thickness h: both faces of a joint move apart by h/2, into the blocks."""
    d = mesh.dimension
    square, side = np.zeros((len(mesh.points), d, d)), np.zeros((len(mesh.points), d))
    for joint in chain(*mesh.joints.values()):
        normal = np.repeat(joint.axes[:, 0], joint.minus.shape[1], axis=0)
        for nodes, sign in ((joint.minus.ravel(), -1.0), (joint.plus.ravel(), 1.0)):
            np.add.at(square, nodes, normal[:, :, None] * normal[:, None])
            np.add.at(side, nodes, sign * normal)
    inverse = np.linalg.pinv(square, rcond=SINGULAR, hermitian=True)
    points: Floats = mesh.points + 0.5 * h * np.einsum("nij,nj->ni", inverse, side)
    return points


def blocks(mesh: Jointed) -> Iterator[tuple[str, str, Integers, Integers]]:
    """Type, name of the block, cells and their numbers through all types, block by block."""
    before = 0
    for kind, cells in mesh.cells.items():
        order = np.argsort(mesh.block[kind], kind="stable")
        ends = np.searchsorted(mesh.block[kind][order], range(len(mesh.names) + 1))
        for name, (first, last) in zip(mesh.names, pairwise(ends), strict=True):
            if last > first:
                yield kind, name, cells[order[first:last]], before + order[first:last]
        before += len(cells)


def between(joint: Joint, d: int) -> Integers:
    """Nodes of the cells between the corners of both faces, in the order of VTK."""
    c = corners(d, joint.minus.shape[1])
    plus = joint.plus[:, :c]
    return np.concatenate([joint.minus[:, :c], plus[:, ::-1] if d == 2 else plus], 1)


def lines(form: str, *columns: NDArray[Any]) -> str:
    """Lines of numbers; form: of a line."""
    rows = np.column_stack([np.asarray(column) for column in columns])
    return (form * len(rows)) % tuple(rows.ravel().tolist())


def numbered(form: str, first: int, data: NDArray[Any], text: str = "%d", by: str = ", ") -> str:
    """Lines of elements or nodes with their numbers from `first`."""
    return lines(f"{form}{by}{by.join([text] * data.shape[1])}\n", np.arange(first, first + len(data)), data)
