"""Joints that a file has itself, as cohesive elements: the sides of their faces."""

from __future__ import annotations

import numpy as np

from .cells import Solids
from .faces import Faces, Sides, locate
from .shapes import STITCHED, area, corners, place, stitches


def sides_of_file(old: Solids, face: Faces, name: str) -> Sides:
    """Sides of a joint that the file has as cohesive elements: faces on the outside of its solids."""
    d, size = old.dimension, face.nodes.shape[1]
    none = np.zeros(0, np.int64)
    parts = [(none.reshape(0, size), none.reshape(0, size), none.reshape(0, 2))]
    for pairs in old.joints[name]:
        if pairs.lower.shape[1] != corners(d, size):
            continue
        rows = np.stack([locate(face, side, d) for side in (pairs.lower, pairs.upper)], 1)
        here = (rows >= 0).all(1)
        if not here.any():
            continue
        if size != pairs.lower.shape[1]:
            text = f"{pairs.where}: solids with nodes in the middle of their edges beside elements without"
            raise ValueError(f"{text}: expected linear solids")
        rows = rows[here]
        nodes = face.nodes[rows]
        at = (pairs.lower[here][:, None] == nodes[:, 0, :, None]).argmax(2)
        opposite = np.take_along_axis(pairs.upper[here], at, axis=1)
        partner = (nodes[:, 1][:, None] == opposite[:, :, None]).argmax(2)
        plus = np.take_along_axis(face.place[rows[:, 1]], partner, axis=1)
        parts.append((face.place[rows[:, 0]], plus, rows))
    minus, plus, rows = (np.concatenate(column) for column in zip(*parts, strict=True))
    cells = face.cell[rows]
    x = old.points[face.nodes[rows[:, 0]]]
    normal, _ = area(x[:, : corners(d, size)])
    normal *= np.sign(np.einsum("fd,fd->f", normal, x.mean(1) - old.centres[cells[:, 0]]))[:, None]
    return minus, plus, cells, face.side[rows], normal


def check_sides(old: Solids) -> None:
    """Raise ValueError, with line and place, for cohesive elements of the file that have not two solids."""
    d = old.dimension
    for pairs in (pairs for parts in old.joints.values() for pairs in parts):
        between = np.ones(len(pairs.lower), bool)
        for side in (pairs.lower, pairs.upper):
            outside = np.zeros(len(side), bool)
            for face in old.faces:
                if corners(d, face.nodes.shape[1]) == side.shape[1]:
                    row = locate(face, side, d)
                    outside |= (row >= 0) & (face.number[row] < 0)
            between &= outside
        if (bad := np.flatnonzero(~between)).size:
            where = place(old.points[pairs.lower[bad[0]]].mean(0))
            text = f"{pairs.where}: {len(bad)} of {len(between)} elements, as at {where}, do not lie between"
            wanted = "expected common nodes, or tied ones at one place; shells and other meshes are none"
            raise ValueError(f"{text} two solids that share their nodes: {wanted}")
    everywhere = [pairs for parts in old.joints.values() for pairs in parts]
    if len(nodes := stitches((pairs.lower, pairs.upper) for pairs in everywhere)):
        first = next(pairs for pairs in everywhere if np.isin(nodes[0], pairs.lower))
        where = f"{first.where}: {len(nodes)} nodes within the joint, as at {place(old.points[nodes[0]])}"
        raise ValueError(f"{where}, {STITCHED}")
