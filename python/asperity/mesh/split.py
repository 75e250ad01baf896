"""Doubling of the nodes of a mesh along joints."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fnmatch import fnmatchcase
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ..contract import Floats
from .cells import Faces, Integers, Solids, corners, locate, read, solids

if TYPE_CHECKING:
    import meshio

Rule = Callable[[Integers, Integers, Floats, Floats], ArrayLike]
"""From blocks (f,) of both sides, centres and normals (f, d) of faces between blocks: which are a joint."""

Joints = Mapping[str, "Rule | Sequence[str] | Mapping[str, str] | None"]

NEARLY_NORMAL = 0.001
"""Sine of the angle between a direction and a normal below which it gives no direction in the face."""

SAME_PLACE = 1e-6  # distance of two nodes a period apart from that period, over the size of the mesh


@dataclass(frozen=True)
class Joint:
    """Faces of a joint.

    minus, plus (f, k): nodes of both sides, node on node; the right-hand normal of minus is N, and its edge
    from node 0 to node 1 is the one closest to Tx.  cells (f, 2): cells beside them.  axes (f, d, d): N from
    minus to plus, Tx and, in 3D, Ty = N x Tx.  area (f,): lengths in 2D.
    """

    minus: Integers
    plus: Integers
    cells: Integers
    axes: Floats
    area: Floats

    @property
    def tips(self) -> int:
        """Number of nodes that both sides share, where the joint ends inside the mesh."""
        return len(np.unique(self.minus[self.minus == self.plus]))


@dataclass(frozen=True)
class Jointed:
    """A mesh with joints: nodes (n, d), cells (m, k) by type, and the number of the block of each cell.

    names: of the blocks.  joints: by name, in one entry for each kind of face.  groups: faces of the named
    groups on the outside, and nodes of named points, by name.  origin (n,): node of the mesh before.
    """

    points: Floats
    cells: dict[str, Integers]
    block: dict[str, Integers]
    names: list[str]
    joints: dict[str, list[Joint]]
    groups: dict[str, list[Integers]]
    origin: Integers

    @property
    def dimension(self) -> int:
        """2 or 3."""
        return self.points.shape[1]

    def nodes(self, group: str) -> Integers:
        """Nodes of a group."""
        if group not in self.groups:
            raise ValueError(f"{group}: no such group: expected one of {', '.join(self.groups) or 'none'}")
        return np.unique(np.concatenate([one.ravel() for one in self.groups[group]]))

    def summary(self) -> str:
        """Counts of cells, blocks, nodes and faces."""
        count, used = sum(map(len, self.cells.values())), len(np.unique(self.origin))
        lines = [f"{count} cells in {len(self.names)} blocks, {used} nodes, {len(self.origin)} with joints"]
        for name, parts in self.joints.items():
            area = sum(float(one.area.sum()) for one in parts)
            ends = sum(one.tips for one in parts)
            size = "length" if self.dimension == 2 else "area"
            lines.append(
                f"joint {name}: {sum(len(one.area) for one in parts)} faces, {size} {area:.6g}, {ends} tips"
            )
        return "\n".join(lines)


def split(
    mesh: meshio.Mesh | Path | str,
    joints: Joints | None = None,
    blocks: str | None = None,
    direction: ArrayLike | None = None,
) -> Jointed:
    """Double the nodes of a mesh along joints.

    Nodes are doubled where joints part the cells around them: at crossings, T-junctions and along a joint,
    but not where it ends inside the mesh.  Nodes that no cell uses are left out.

    mesh: of meshio, or a file that it reads.  joints: names with rules, of which the first that holds counts:
    None, the faces of the group of this name; a pair of patterns, the faces between different blocks whose
    names they match ("*", "brick*"); a function of the blocks on both sides, centres and normals of the faces
    between blocks; {"right": "left"}, two groups of faces on the outside of a periodic mesh, joined by a
    joint whose N points out of the first one.  Default: all faces between blocks, as "joint".  blocks: cell
    data that have the number of the block of each cell, see `cells.tags`.  direction: of Tx, which is its
    projection onto the face.  Default in 3D: x, or z where N is along x.

    N points to the block that comes later in the order of the tags; within one block along the axis that is
    closest to the normals.  In 2D, N is Tx turned to the left: with a direction the sides follow from it.

    Raises ValueError with the name of a group and the number of its faces.
    """
    mesh = read(mesh)
    old = solids(mesh, blocks)
    rules = joints or {"joint": ("*", "*")}
    if both := sorted(set(rules) & set(old.names)):
        raise ValueError(f"joint {both[0]}: a block has this name: expected another one")
    chosen = _choose(rules, old)
    own, origin = _double(old, chosen)
    points = old.points[origin]
    found: dict[str, list[Joint]] = {name: [] for name in rules}
    for face, which in zip(old.faces, chosen, strict=True):
        for number, (name, rule) in enumerate(rules.items()):
            if isinstance(rule, Mapping):
                sides = _period(old, face, rule, name)
            else:
                sides = _inside(old, face, np.flatnonzero(which == number))
            if len(sides[0]):
                found[name].append(_joint(sides, own, points, direction, name))
    cells, block, place, cell = {}, {}, 0, 0
    for kind, one in old.cells.items():
        cells[kind] = own[place : place + one.size].reshape(one.shape)
        block[kind] = old.block[cell : cell + len(one)]
        place, cell = place + one.size, cell + len(one)
    groups = _groups(mesh.point_sets or {}, old, own, origin)
    return Jointed(points, cells, block, old.names, found, groups, origin)


def _choose(joints: Joints, old: Solids) -> list[Integers]:
    """Number of the joint of each inner face, or -1."""
    d, block = old.dimension, old.block
    chosen = [np.full(len(face.first), -1, np.int64) for face in old.faces]
    sides = [(block[face.cell[face.first]], block[face.cell[face.second]]) for face in old.faces]
    for number, (name, rule) in enumerate(joints.items()):
        if isinstance(rule, Mapping):
            continue
        count = 0
        for face, which, (a, b) in zip(old.faces, chosen, sides, strict=True):
            c = corners(d, face.nodes.shape[1])
            at = a != b
            if rule is None:
                named = _facets(old, name, name)
                rows = [locate(face, one, d) for one in named if corners(d, one.shape[1]) == c]
                row = np.concatenate([np.zeros(0, np.int64), *rows])
                lost, outside = int((row < 0).sum()), int((face.number[row] < 0).sum())
                if lost or outside:
                    what = "are no faces of cells" if lost else "have a cell on one side only"
                    raise ValueError(f"joint {name}: {lost or outside} of its {len(row)} faces {what}")
                at[:] = False
                at[face.number[row]] = True
            elif callable(rule):
                where = np.flatnonzero(at)
                x = old.points[face.nodes[face.first[where], :c]]
                at[where] = rule(np.minimum(a, b)[at], np.maximum(a, b)[at], x.mean(1), _area(x)[0])
            else:
                one, other = (np.array([fnmatchcase(text, word) for text in old.names]) for word in rule)
                at &= (one[a] & other[b]) | (one[b] & other[a])
            which[at & (which < 0)] = number
            count += int(at.sum())
        if not count:
            raise ValueError(
                f"joint {name}: 0 of the {sum(int((a != b).sum()) for a, b in sides)} faces between blocks: "
                "expected at least one. Blocks that touch share their nodes (BooleanFragments in gmsh). "
                f"Blocks: {', '.join(old.names)}"
            )
    return chosen


def _double(old: Solids, chosen: list[Integers]) -> tuple[Integers, Integers]:
    """Node of every place in the cells, and the old node of every node.

    Places at one node belong together if the cells share a face that is no joint.
    """
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    n, flat = len(old.points), np.concatenate([one.ravel() for one in old.cells.values()])
    torn = np.zeros(n, bool)
    for face, which in zip(old.faces, chosen, strict=True):
        torn[face.nodes[face.first[which >= 0]]] = True
    places = np.flatnonzero(torn[flat])
    short = np.full(len(flat), -1, np.int64)
    short[places] = np.arange(len(places))
    ends = []
    for face, which in zip(old.faces, chosen, strict=True):
        at = np.flatnonzero((which < 0) & torn[face.nodes[face.first]].any(1))
        ends.append([short[_in_order(face, side[at]).ravel()] for side in (face.first, face.second)])
    a, b = (one[one >= 0] for one in np.concatenate(ends, axis=1))
    links = coo_array((np.ones(len(a), np.int8), (a, b)), shape=(len(places),) * 2)
    count, part = connected_components(links, directed=False)
    node = np.zeros(count, np.int64)
    node[part] = flat[places]
    order = np.argsort(node, kind="stable")
    first = np.r_[True, np.diff(node[order]) > 0][: len(order)]
    number = np.empty(count, np.int64)
    number[order] = np.where(first, node[order], n + np.cumsum(~first) - 1)
    own = flat.copy()
    own[places] = number[part]
    origin = np.concatenate([np.arange(n), node[order][~first]])
    used = np.zeros(len(origin), bool)
    used[own] = True
    return (np.cumsum(used) - 1)[own], origin[used]


def _in_order(face: Faces, rows: Integers) -> Integers:
    """Places of the nodes of faces, by rising numbers of the nodes."""
    return np.take_along_axis(face.place[rows], np.argsort(face.nodes[rows], axis=1), axis=1)


def _area(x: Floats) -> tuple[Floats, Floats]:
    """Normals (f, d) and areas of faces with the corners x (f, k, d); in 2D the edge turned to the left."""
    if x.shape[2] == 2:
        edge = x[:, 1] - x[:, 0]
        normal = np.stack([-edge[:, 1], edge[:, 0]], 1)
    elif x.shape[1] == 3:
        normal = 0.5 * np.cross(x[:, 1] - x[:, 0], x[:, 2] - x[:, 0])
    else:
        normal = 0.5 * np.cross(x[:, 2] - x[:, 0], x[:, 3] - x[:, 1])
    size = np.linalg.norm(normal, axis=1)
    return normal / size[:, None], size


Sides = tuple[Integers, Integers, Integers, Floats]
"""Places of the nodes of both sides, node on node, cells beside them (f, 2), and normals to the second."""


def _inside(old: Solids, face: Faces, at: Integers) -> Sides:
    """Sides of the pairs `at` of faces inside the mesh."""
    first, second, block = face.first[at], face.second[at], old.block
    a, b = face.cell[first], face.cell[second]
    normal, _ = _area(old.points[face.nodes[first][:, : corners(old.dimension, face.nodes.shape[1])]])
    normal *= np.sign(np.einsum("fd,fd->f", normal, old.centres[b] - old.centres[a]))[:, None]
    along = normal[:, np.abs(normal).sum(0).argmax()]
    turn = np.where(block[a] == block[b], along < 0.0, block[a] > block[b])
    first, second = np.where(turn, second, first), np.where(turn, first, second)
    plus = np.empty((len(at), face.nodes.shape[1]), np.int64)
    np.put_along_axis(plus, np.argsort(face.nodes[first], axis=1), _in_order(face, second), axis=1)
    cells = face.cell[np.stack([first, second], 1)]
    return face.place[first], plus, cells, np.where(turn[:, None], -normal, normal)


def _period(old: Solids, face: Faces, rule: Mapping[str, str], name: str) -> Sides:
    """Sides on the outside that are a period apart, which is that of the middles of both groups."""
    from scipy.spatial import KDTree

    [pair] = rule.items()
    groups = ([_outside(old, face, one) for one in _facets(old, group, name)] for group in pair)
    first, second = map(np.concatenate, groups)
    bad, all_ = abs(len(first) - len(second)), max(len(first), len(second))
    if not all_:
        return _inside(old, face, first)
    x, y = (old.points[face.nodes[one]] for one in (first, second))
    if not bad:
        period = y.mean((0, 1)) - x.mean((0, 1))
        _, partner = KDTree(y.mean(1)).query(x.mean(1) + period)
        apart = np.linalg.norm((x + period)[:, :, None] - y[partner][:, None], axis=3)
        bad = int((apart.min(2).max(1) > SAME_PLACE * np.ptp(old.points)).sum())
    if bad:
        raise ValueError(
            f"joint {name}: {bad} of the {all_} faces of {pair[0]} and {pair[1]} have no partner a period "
            "away: expected a periodic mesh"
        )
    cells = face.cell[np.stack([first, second[partner]], 1)]
    normal, _ = _area(x[:, : corners(old.dimension, x.shape[1])])
    normal *= np.sign(np.einsum("fd,fd->f", normal, x.mean(1) - old.centres[cells[:, 0]]))[:, None]
    plus = np.take_along_axis(face.place[second[partner]], apart.argmin(2), axis=1)
    return face.place[first], plus, cells, normal


def _joint(sides: Sides, own: Integers, points: Floats, direction: ArrayLike | None, name: str) -> Joint:
    """Faces of a joint, oriented; own, points: nodes of the places, and where they are."""
    minus, plus, cells, normal = own[sides[0]], own[sides[1]], *sides[2:]
    d, c = points.shape[1], corners(points.shape[1], minus.shape[1])
    if direction is not None:
        tangent = _projected(normal, direction, name)
    else:
        tangent = default_tangent(normal) if d == 3 else np.stack([normal[:, 1], -normal[:, 0]], 1)
    if d == 2:
        turned = np.stack([-tangent[:, 1], tangent[:, 0]], 1)
        turn = (np.einsum("fd,fd->f", turned, normal) < 0.0)[:, None]
        minus, plus = np.where(turn, plus, minus), np.where(turn, minus, plus)
        cells, normal = np.where(turn, cells[:, ::-1], cells), turned
    across = [] if d == 2 else [np.cross(normal, tangent)]
    axes = np.stack([normal, tangent, *across], 1)
    # nodes of the sides in the order that hosts want
    right, area = _area(points[minus[:, :c]])
    backward = np.einsum("fd,fd->f", right, normal) < 0.0
    back = np.r_[0, np.arange(c - 1, 0, -1), c + np.arange(minus.shape[1] - c)[::-1]]
    if d == 2:
        back[:2] = [1, 0]
    for side in (minus, plus):
        side[backward] = side[backward][:, back]
    if d == 3:
        edges = np.roll(points[minus[:, :c]], -1, axis=1) - points[minus[:, :c]]
        start = (np.einsum("fkd,fd->fk", edges, axes[:, 1]) / np.linalg.norm(edges, axis=2)).argmax(1)
        round_ = (start[:, None] + np.arange(c)) % c
        round_ = np.concatenate([round_, c + round_], 1)[:, : minus.shape[1]]
        minus, plus = (np.take_along_axis(side, round_, axis=1) for side in (minus, plus))
    return Joint(minus, plus, cells, axes, area)


def default_tangent(normal: Floats) -> Floats:
    """Tx without a direction (f, 3), as in Abaqus: the projection of x, or of z within 0.1 degrees of x."""
    x, z = np.eye(3)[[0, 2]]
    tangent = x - normal * normal[:, :1]
    upright = np.linalg.norm(tangent, axis=1) < np.sin(np.radians(0.1))
    tangent[upright] = z - normal[upright] * normal[upright, 2:]
    return np.asarray(tangent / np.linalg.norm(tangent, axis=1)[:, None])


def _projected(normal: Floats, direction: ArrayLike, name: str) -> Floats:
    """Tx (f, d), the projection of a direction onto faces; ValueError where it is normal to them."""
    given = np.asarray(direction, float).ravel()[: normal.shape[1]]
    part = given - normal * (normal @ given)[:, None]
    size = np.linalg.norm(part, axis=1)
    if (bad := int((size < NEARLY_NORMAL * np.linalg.norm(given)).sum())) > 0:
        raise ValueError(
            f"joint {name}: direction {given.tolist()} is normal to {bad} of its {len(size)} faces"
        )
    return np.asarray(part / size[:, None])


def _facets(old: Solids, group: str, joint: str) -> list[Integers]:
    """Nodes of the faces of a group."""
    if group not in old.facets:
        known = ", ".join(old.facets) or "none"
        raise ValueError(f"joint {joint}: {group}: no such group of faces: expected one of {known}")
    return old.facets[group]


def _outside(old: Solids, face: Faces, facets: Integers) -> Integers:
    """Faces with a cell on one side among facets."""
    if corners(old.dimension, facets.shape[1]) != corners(old.dimension, face.nodes.shape[1]):
        return np.zeros(0, np.int64)
    row = locate(face, facets, old.dimension)
    return row[(row >= 0) & (face.number[row] < 0)]


def _groups(
    point_sets: Mapping[str, ArrayLike], old: Solids, own: Integers, origin: Integers
) -> dict[str, list[Integers]]:
    """Faces on the outside by group, with their new nodes, and nodes of the sets of points."""
    groups: dict[str, list[Integers]] = {}
    for name, some in old.facets.items():
        for one, face in product(some, old.faces):
            groups.setdefault(name, []).append(own[face.place[_outside(old, face, one)]])
    groups = {name: rows for name, rows in groups.items() if sum(map(len, rows))}
    for name, nodes in point_sets.items():
        groups.setdefault(name, []).append(np.flatnonzero(np.isin(origin, np.asarray(nodes)))[:, None])
    return groups
