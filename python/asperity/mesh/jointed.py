"""A mesh with joints: its nodes, cells, faces and groups."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..contract import Floats
from .shapes import FACES, Integers, area, backward, corners, in_cells

MOST_PAIRS = 4  # pairs of blocks that the summary names for each joint


@dataclass(frozen=True)
class Joint:
    """Faces of a joint.

    minus, plus (f, k): nodes of both sides, node on node; the right-hand normal of minus is N, and its edge
    from node 0 to node 1 is the one closest to Tx.  cells (f, 2): cells beside them.  axes (f, d, d): N from
    minus to plus, Tx and, in 3D, Ty = N x Tx.  area (f,): lengths in 2D.  sides (f, 2): numbers of the
    faces in the cells beside them, from 1, those of Abaqus.
    """

    minus: Integers
    plus: Integers
    cells: Integers
    axes: Floats
    area: Floats
    sides: Integers

    @property
    def tips(self) -> int:
        """Number of nodes that both sides share, where the joint ends inside the mesh."""
        return len(np.unique(self.minus[self.minus == self.plus]))


@dataclass(frozen=True)
class Jointed:
    """A mesh with joints: nodes (n, d), cells (m, k) by type, and the number of the block of each cell.

    names: of the blocks.  joints: by name, in one entry for each kind of face.  groups: faces of the named
    groups, on joints those of both sides, and nodes of named points, by name.  sets: cells of the groups that
    are no blocks, counted through all types.  surfaces: rows (cell, its face from 1) of the groups of faces
    and, as NAME_minus and NAME_plus, of both sides of the joints.  origin (n,): node of the mesh before.
    types: of the elements (m,) of a deck of Abaqus, by type of cells.  axisymmetric: the mesh is the section
    (r, z) of a body of revolution.
    """

    points: Floats
    cells: dict[str, Integers]
    block: dict[str, Integers]
    names: list[str]
    joints: dict[str, list[Joint]]
    groups: dict[str, list[Integers]]
    sets: dict[str, Integers]
    surfaces: dict[str, Integers]
    origin: Integers
    types: dict[str, NDArray[np.str_]] = field(default_factory=dict)
    axisymmetric: bool = False

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return int(self.points.shape[1])

    def _sizes(self, nodes: Integers) -> Floats:
        """Lengths or areas of faces (f, k); of a body of revolution areas, 2 pi r times the length."""
        x = self.points[nodes[:, : corners(self.dimension, nodes.shape[1])]]
        turn = 2.0 * np.pi * x[:, :, 0].mean(1) if self.axisymmetric else 1.0
        sizes: Floats = area(x)[1] * turn
        return sizes

    def nodes(self, group: str) -> Integers:
        """Nodes of a group."""
        if group not in self.groups:
            raise ValueError(f"{group}: no such group: expected one of {', '.join(self.groups) or 'none'}")
        return in_cells(*self.groups[group])

    def face_nodes(self, surface: Integers) -> list[Integers]:
        """Nodes of the faces of a surface, as `faces` has them."""
        return [nodes for nodes, _ in self.faces(surface)]

    def faces(self, surface: Integers) -> list[tuple[Integers, Integers]]:
        """Nodes and cells of the faces of a surface, rows (cell, face), for each number of nodes.

        Their right-hand normal points out of their cells; in the plane the cells are on the left of edges.
        """
        by_size: dict[int, list[tuple[Integers, Integers]]] = {}
        first, d = 0, self.dimension
        for kind, data in self.cells.items():
            for side, face in enumerate(FACES[kind], 1):
                at = (surface[:, 0] >= first) & (surface[:, 0] < first + len(data)) & (surface[:, 1] == side)
                if not at.any():
                    continue
                cells = data[surface[at, 0] - first]
                nodes = cells[:, face]
                if d == 3:
                    x = self.points[nodes[:, : corners(d, len(face))]]
                    away = x.mean(1) - self.points[cells].mean(1)
                    inward = np.einsum("fd,fd->f", area(x)[0], away) < 0.0
                    nodes = np.where(inward[:, None], nodes[:, backward(d, len(face))], nodes)
                by_size.setdefault(len(face), []).append((nodes, surface[at, 0]))
            first += len(data)
        columns = [zip(*by_size[size], strict=True) for size in sorted(by_size)]
        return [(np.concatenate(nodes), np.concatenate(cells)) for nodes, cells in columns]

    def nodes_of(self, cells: Integers) -> Integers:
        """Nodes of cells, counted through all types."""
        nodes, first = [np.zeros(0, np.int64)], 0
        for data in self.cells.values():
            nodes.append(data[cells[(cells >= first) & (cells < first + len(data))] - first].ravel())
            first += len(data)
        return in_cells(*nodes)

    def summary(self) -> str:
        """Counts of cells, nodes and faces: of the whole, the blocks, the groups and the joints."""
        count, used = sum(map(len, self.cells.values())), len(in_cells(self.origin))
        lines = [f"{count} cells in {len(self.names)} blocks, {used} nodes, {len(self.origin)} with joints"]
        block = np.concatenate([self.block[kind] for kind in self.cells])
        size, d = ("length" if self.dimension == 2 else "area"), self.dimension
        size = "area of revolution" if self.axisymmetric else size
        cells_of = np.bincount(block, minlength=len(self.names)).tolist()
        lines += [f"block {name}: {number} cells" for name, number in zip(self.names, cells_of, strict=True)]
        lines += [f"group {name}: {len(members)} cells" for name, members in self.sets.items()]
        for name, parts_of_group in self.groups.items():
            faces = [part for part in parts_of_group if part.shape[1] > 1]
            total, extent = 0, 0.0
            for part in faces:
                corner = part[:, : corners(d, part.shape[1])]
                _, first = np.unique(np.sort(self.origin[corner], axis=1), axis=0, return_index=True)
                total, extent = total + len(first), extent + float(self._sizes(corner[first]).sum())
            if total:
                lines.append(f"group {name}: {total} faces, {size} {extent:.6g}")
            elif parts_of_group:
                nodes = self.nodes(name)
                before = len(np.unique(self.origin[nodes]))
                doubled = f", {before} of them in the mesh before" if before < len(nodes) else ""
                lines.append(f"group {name}: {len(nodes)} nodes{doubled}")
        for name, parts in self.joints.items():
            extent = sum(float(self._sizes(part.minus).sum()) for part in parts)
            ends = sum(part.tips for part in parts)
            faces_of = sum(len(part.area) for part in parts)
            text = f"joint {name}: {faces_of} faces, {size} {extent:.6g}, {ends} tips"
            lines.append(f"{text}, {self._normals(parts, block)}")
        return "\n".join(lines)

    def _normals(self, parts: list[Joint], block: Integers) -> str:
        """Where N of a joint points: from which block to which."""
        pairs = np.concatenate([block[part.cells] for part in parts])
        kinds, at, count = np.unique(pairs, axis=0, return_inverse=True, return_counts=True)
        normals = np.concatenate([part.axes[:, 0] for part in parts])
        words = []
        for k in np.argsort(-count, kind="stable"):
            a, b = (self.names[number] for number in kinds[k])
            mean = normals[at.ravel() == k].mean(0)
            text = ", ".join(f"{component:.2g}" for component in (mean.round(6) + 0.0).tolist())
            words.append(f"N from {a} to {b}" if a != b else f"N inside {a} about ({text})")
        more = f", and of {len(words) - MOST_PAIRS} other pairs" if len(words) > MOST_PAIRS else ""
        return "; ".join(words[:MOST_PAIRS]) + more
