"""Faces of cells: those that are the same, those on the outside, and those of given nodes."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..contract import Floats
from .shapes import FACES, Integers, corners, place

Sides = tuple[Integers, Integers, Integers, Integers, Floats]
"""Places of the nodes of both sides, node on node, cells and their faces (f, 2), normals to the second."""


@dataclass
class Faces:
    """Faces with one number of nodes.

    nodes, place (f, k): nodes and their places among those of all cells.  cell, side (f,): cell of a face,
    and its number in the cell, from 1.  first, second: faces that are the same.  number (f,): that of their
    pair, or -1.
    """

    nodes: Integers
    place: Integers
    cell: Integers
    side: Integers
    key: Integers

    def pair(self, points: Floats) -> None:
        """Find the faces that are the same."""
        order = np.lexsort(self.key.T[::-1])
        same = (self.key[order[1:]] == self.key[order[:-1]]).all(1)
        if (same[1:] & same[:-1]).any():
            where = points[self.nodes[order[1:-1][same[1:] & same[:-1]][0]]].mean(0)
            raise ValueError(f"a face at {place(where)} has more than two cells: expected one or two")
        self.first, self.second = order[:-1][same], order[1:][same]
        self.number = np.full(len(order), -1, np.int64)
        self.number[self.first] = self.number[self.second] = np.arange(len(self.first))

    def check_middles(self, points: Floats) -> None:
        """Raise ValueError, with number and place, for faces that are the same in their corners alone."""
        alike = np.sort(self.nodes[self.first], axis=1) == np.sort(self.nodes[self.second], axis=1)
        if (apart := ~alike.all(1)).any():
            where = place(points[self.nodes[self.first[apart][0]]].mean(0))
            text = "have common corners and other nodes in the middle of their edges"
            raise ValueError(f"{apart.sum()} pairs of faces {text}, as at {where}: expected common nodes")


def key_of(nodes: Integers, d: int) -> Integers:
    """Corners that tell a face from others: its smallest two or three numbers."""
    return np.sort(nodes[:, : corners(d, nodes.shape[1])], axis=1)[:, :d]


def faces_of(cells: dict[str, Integers], points: Floats, d: int) -> list[Faces]:
    """Faces of all cells by their number of nodes, with the pairs that are inside."""
    parts: dict[int, list[tuple[Integers, ...]]] = {}
    cell, place = 0, 0
    for kind, data in cells.items():
        for size in sorted({len(face) for face in FACES[kind]}):
            sides = [k for k, face in enumerate(FACES[kind]) if len(face) == size]
            local = np.array([FACES[kind][k] for k in sides])
            where = place + data.shape[1] * np.arange(len(data))[:, None, None] + local
            owner = np.repeat(cell + np.arange(len(data)), len(local))
            side = np.tile(np.array(sides) + 1, len(data))
            nodes = data[:, local].reshape(-1, size)
            parts.setdefault(size, []).append((nodes, where.reshape(-1, size), owner, side))
        cell, place = cell + len(data), place + data.size
    all_faces = []
    for columns in parts.values():
        nodes, where, owner, side = (np.concatenate(column) for column in zip(*columns, strict=True))
        all_faces.append(Faces(nodes, where, owner, side, key_of(nodes, d)))
        all_faces[-1].pair(points)
    return all_faces


def in_order(face: Faces, rows: Integers) -> Integers:
    """Places of the nodes of faces, by rising numbers of the nodes."""
    return np.take_along_axis(face.place[rows], np.argsort(face.nodes[rows], axis=1), axis=1)


def parts_of(
    cells: Mapping[str, Integers], faces: Sequence[Faces], nodes: Integers, cut: Sequence[NDArray[np.bool_]]
) -> tuple[Integers, Integers]:
    """Places of nodes in the cells, and the part of each of them.

    Places at one node are in one part if the cells share a face inside the mesh; cut: pairs of faces that do
    not count.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    flat = np.concatenate([data.ravel() for data in cells.values()])
    wanted = np.zeros(int(flat.max()) + 1, bool)
    wanted[nodes] = True
    places = np.flatnonzero(wanted[flat])
    short = np.full(len(flat), -1, np.int64)
    short[places] = np.arange(len(places))
    ends = []
    for face, left_out in zip(faces, cut, strict=True):
        at = np.flatnonzero(~left_out & wanted[face.nodes[face.first]].any(1))
        ends.append([short[in_order(face, side[at]).ravel()] for side in (face.first, face.second)])
    a, b = (end[end >= 0] for end in np.concatenate(ends, axis=1))
    links = coo_array((np.ones(len(a), np.int8), (a, b)), shape=(len(places),) * 2)
    return places, connected_components(links, directed=False)[1]


def locate(face: Faces, facets: Integers, d: int) -> Integers:
    """Number of a face for each facet, or -1."""
    if not len(facets):
        return np.zeros(0, np.int64)
    key = key_of(facets, d)
    known = np.zeros(max(int(face.key.max()), int(key.max())) + 1, bool)
    known[key] = True
    near = np.flatnonzero(known[face.key].all(1))
    _, number = np.unique(np.concatenate([face.key[near], key]), axis=0, return_inverse=True)
    number = number.ravel()
    row = np.full(int(number.max(initial=0)) + 1, -1, np.int64)
    row[number[: len(near)]] = near
    return row[number[len(near) :]]
