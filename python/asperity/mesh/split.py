"""Doubling of the nodes of a mesh along joints."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from fnmatch import fnmatchcase
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..contract import Floats
from ..material import ModelWarning
from .cells import Solids, read, solids
from .faces import Faces, Sides, in_order, locate, parts_of
from .jointed import Joint, Jointed
from .own_joints import check_sides, sides_of_file
from .raw import RawMesh
from .shapes import Integers, area, backward, corners, place
from .sides import Joints, check_direction, is_named, sides_of_faces

if TYPE_CHECKING:
    import meshio

NEARLY_NORMAL = 0.001
"""Sine of the angle between a direction and a normal below which it gives no direction in the face."""

SAME_PLACE = 1e-6  # distance of two nodes a period apart from that period, over the size of the mesh


def split(
    mesh: RawMesh | meshio.Mesh | Path | str,
    joints: Joints | None = None,
    blocks: str | None = None,
    direction: ArrayLike | None = None,
    join: float | None = None,
    axisymmetric: bool = False,
) -> Jointed:
    """Double the nodes of a mesh along joints.

    Nodes are doubled where joints part the cells around them: at crossings, T-junctions and along a joint,
    but not where it ends inside the mesh.  Nodes that no cell uses are left out.

    mesh: of meshio, or a file.  joints: names with rules, of which the first that holds counts:
    None, the faces of the group of this name; a pair of patterns, the faces between different blocks whose
    names they match ("*", "brick*"); a function of the blocks on both sides, centres and normals of the faces
    between blocks; {"right": "left"}, two groups of faces on the outside of a periodic mesh, joined by a
    joint whose N points out of the first one.  Default: all faces between blocks, as "joint".  blocks: names
    of the groups that are blocks, with commas, or cell data that have their numbers; by default the groups,
    see `groups.blocks_of`.  join: distance of nodes that become one; by default, blocks that touch without
    common faces are refused; with 0 they stay apart.  direction: of Tx, its projection onto the face.
    Default in 3D: x, or z where N is along x.

    N points to the block that comes later in the order of the groups; where that contradicts itself between
    blocks of two patterns, as segments of a ring and rock, from the first pattern to the second, and of "*"
    and "*" to the side of the later blocks along most of a connected part, as a bed of stones.  Named faces
    have N on one side along each connected part of all named groups, inside a block along the axis closest to
    its mean.  In 2D, N is Tx turned to the left: with a direction the sides follow from it.

    Cohesive elements of a deck of Abaqus are joints with the name of their set, whose N points from their
    lower to their upper side; without rules there are no others.

    axisymmetric: the plane mesh, of elements such as CAX4 or of no type, is the section (r, z) of a body of
    revolution about x = 0; its joints are surfaces of revolution, with the weight 2 pi r.

    Raises ValueError with the name of a group and the number of its faces, or of cells and their place.
    """
    old = solids(read(mesh), blocks, join)
    rules: Joints = joints or ({} if old.joints else {"joint": ("*", "*")})
    if taken := [name for name in old.joints if rules.get(name) is not None]:
        raise ValueError(
            f"joint {taken[0]}: the file has this joint: expected another name, or no faces of it"
        )
    rules = {**dict.fromkeys(old.joints), **rules}
    if taken := sorted(set(rules) & {*old.names, *old.sets}):
        text = f"joint {taken[0]}: a {'block' if taken[0] in old.names else 'group of cells'} has this name"
        raise ValueError(f"{text}: expected another one, as --joint NAME=*:* for all faces between blocks")
    check_sides(old)
    chosen = _choose(rules, old)
    node_of_place, origin = _double(old, chosen)
    points = old.points[origin]
    parts: dict[str, list[Joint]] = {name: [] for name in rules}
    turns, connected = sides_of_faces(rules, old, chosen)
    for number, (name, rule) in enumerate(rules.items()):
        rows = [np.flatnonzero(joint_of == number) for joint_of in chosen]
        for face, at, turn, part in zip(old.faces, rows, turns, connected, strict=True):
            sides = (
                _period(old, face, rule, name)
                if isinstance(rule, Mapping)
                else sides_of_file(old, face, name)
                if name in old.joints
                else _inside(old, face, at, turn[at])
            )
            if len(sides[0]):
                parts[name].append(_joint(sides, node_of_place, points, direction, name))
                if is_named(rules, old, name):
                    check_direction(parts[name][-1], sides[4], part[at], name)
        _check_tips(name, parts[name], points)
    cells, block, place, cell = {}, {}, 0, 0
    for kind, data in old.cells.items():
        cells[kind] = node_of_place[place : place + data.size].reshape(data.shape)
        block[kind] = old.block[cell : cell + len(data)]
        place, cell = place + data.size, cell + len(data)
    groups, surfaces = _groups(old, node_of_place, [joint_of >= 0 for joint_of in chosen])
    for name, pieces in parts.items():
        for k, side in enumerate(("minus", "plus")):
            rows = [np.stack([piece.cells[:, k], piece.sides[:, k]], 1) for piece in pieces]
            faces, group = np.concatenate([np.zeros((0, 2), np.int64), *rows]), f"{name}_{side}"
            if group in surfaces:  # as in a deck that `write` wrote
                if name not in old.joints or not _same_rows(surfaces[group], faces):
                    raise ValueError(f"joint {name}: a group is named {group}: expected another name")
                del groups[group]
            surfaces[group] = faces
    _check_axis(old, axisymmetric, points)
    arrays = points, cells, block, old.names, parts, groups, old.sets, surfaces, origin, old.types
    return Jointed(*arrays, axisymmetric=axisymmetric)


def _same_rows(first: Integers, second: Integers) -> bool:
    """Whether two arrays have the same rows in any order."""
    return bool(np.array_equal(np.unique(first, axis=0), np.unique(second, axis=0)))


def _check_axis(old: Solids, axisymmetric: bool, points: Floats) -> None:
    """Raise ValueError where types of elements or radii contradict the axis of revolution."""
    types = np.unique(np.concatenate([*old.types.values()]))
    turned = [name for name in types.tolist() if name.startswith("CAX")]
    if turned and not axisymmetric:
        wanted = "expected a plane mesh or one in space, or --axisymmetric"
        raise ValueError(f"type={turned[0]}: not read: axisymmetric: {wanted}")
    if not axisymmetric:
        return
    if old.dimension != 2:
        raise ValueError("axisymmetric: expected a plane mesh, the section (r, z) of a body of revolution")
    if others := [name for name in types.tolist() if name and name not in turned]:
        raise ValueError(f"axisymmetric: elements of type {', '.join(others)}: expected types such as CAX4")
    size = float(np.ptp(points, axis=0).max())
    if (least := float(points[:, 0].min())) < -SAME_PLACE * size:
        raise ValueError(f"axisymmetric: a node at r = {least:g}: expected r >= 0, the first coordinate")


def _check_tips(name: str, parts: list[Joint], points: Floats) -> None:
    """Name faces of which no node is doubled: all of them are tips."""
    closed = [(part.minus == part.plus).all(1) for part in parts]
    if not (count := sum(int(rows.sum()) for rows in closed)):
        return
    where = next(
        points[part.minus[at]].mean(1)[0] for part, at in zip(parts, closed, strict=True) if at.any()
    )
    total = sum(map(len, closed))
    text = f"joint {name}: {count} of its {total} faces end with all their nodes inside the mesh"
    text = f"{text}, as at {place(where)}"
    if count == total:
        raise ValueError(f"{text}, and cannot open: expected more faces along the joint")
    warnings.warn(f"{text}: they cannot open", ModelWarning, stacklevel=4)


def _choose(joints: Joints, old: Solids) -> list[Integers]:
    """Number of the joint of each inner face, or -1."""
    d, block = old.dimension, old.block
    chosen = [np.full(len(face.first), -1, np.int64) for face in old.faces]
    sides = [(block[face.cell[face.first]], block[face.cell[face.second]]) for face in old.faces]
    for number, (name, rule) in enumerate(joints.items()):
        if isinstance(rule, Mapping) or name in old.joints:
            continue
        count = remaining = 0
        for face, joint_of, (a, b) in zip(old.faces, chosen, sides, strict=True):
            c = corners(d, face.nodes.shape[1])
            at = a != b
            if rule is None:
                named = _facets(old, name, name)
                rows = [locate(face, facets, d) for facets in named if corners(d, facets.shape[1]) == c]
                row = np.concatenate([np.zeros(0, np.int64), *rows])
                lost, outside = int((row < 0).sum()), int((face.number[row] < 0).sum())
                if lost or outside:
                    problem = "are no faces of cells" if lost else "have a cell on one side only"
                    raise ValueError(f"joint {name}: {lost or outside} of its {len(row)} faces {problem}")
                at[:] = False
                at[face.number[row]] = True
            elif callable(rule):
                where = np.flatnonzero(at)
                x = old.points[face.nodes[face.first[where], :c]]
                at[where] = rule(np.minimum(a, b)[at], np.maximum(a, b)[at], x.mean(1), area(x)[0])
            else:
                fits_first, fits_second = (
                    np.array([fnmatchcase(text, word) for text in old.names]) for word in rule
                )
                at &= (fits_first[a] & fits_second[b]) | (fits_first[b] & fits_second[a])
            count += int(at.sum())
            at &= joint_of < 0
            remaining += int(at.sum())
            joint_of[at] = number
        if not count:
            raise ValueError(
                f"joint {name}: 0 of the {sum(int((a != b).sum()) for a, b in sides)} faces between blocks: "
                "expected at least one. Blocks that touch share their nodes; --join TOL makes nodes one. "
                f"Blocks: {', '.join(old.names)}"
            )
        if not remaining:
            text = f"joint {name}: rules before it have taken all of its {count} faces"
            raise ValueError(f"{text}: expected one that is left, or another order")
    return chosen


def _double(old: Solids, chosen: list[Integers]) -> tuple[Integers, Integers]:
    """Node of every place in the cells, and the old node of every node, of which each part of it has one."""
    n, flat = len(old.points), np.concatenate([data.ravel() for data in old.cells.values()])
    cut = [joint_of >= 0 for joint_of in chosen]
    torn = [face.nodes[face.first[at]].ravel() for face, at in zip(old.faces, cut, strict=True)]
    places, part = parts_of(old.cells, old.faces, np.unique(np.concatenate(torn)), cut)
    node = np.zeros(int(part.max(initial=-1)) + 1, np.int64)
    node[part] = flat[places]
    order = np.argsort(node, kind="stable")
    first = np.r_[True, np.diff(node[order]) > 0][: len(order)]
    number = np.empty(len(node), np.int64)
    number[order] = np.where(first, node[order], n + np.cumsum(~first) - 1)
    node_of_place = flat.copy()
    node_of_place[places] = number[part]
    origin = np.concatenate([np.arange(n), node[order][~first]])
    used = np.zeros(len(origin), bool)
    used[node_of_place] = True
    return (np.cumsum(used) - 1)[node_of_place], origin[used]


def _inside(old: Solids, face: Faces, at: Integers, turn: NDArray[np.bool_]) -> Sides:
    """Sides of the pairs `at` of faces inside the mesh; turn: those whose second face comes first."""
    first, second = face.first[at], face.second[at]
    a, b = face.cell[first], face.cell[second]
    normal, _ = area(old.points[face.nodes[first][:, : corners(old.dimension, face.nodes.shape[1])]])
    normal *= np.sign(np.einsum("fd,fd->f", normal, old.centres[b] - old.centres[a]))[:, None]
    first, second = np.where(turn, second, first), np.where(turn, first, second)
    plus = np.empty((len(at), face.nodes.shape[1]), np.int64)
    np.put_along_axis(plus, np.argsort(face.nodes[first], axis=1), in_order(face, second), axis=1)
    pair = np.stack([first, second], 1)
    return face.place[first], plus, face.cell[pair], face.side[pair], np.where(turn[:, None], -normal, normal)


def _period(old: Solids, face: Faces, rule: Mapping[str, str], name: str) -> Sides:
    """Sides on the outside that are a period apart, which is that of the middles of both groups."""
    from scipy.spatial import KDTree

    [pair] = rule.items()
    groups = ([_outside(old, face, facets) for facets in _facets(old, group, name)] for group in pair)
    first, second = map(np.concatenate, groups)
    bad, most = abs(len(first) - len(second)), max(len(first), len(second))
    if not most:
        return _inside(old, face, first, np.zeros(0, bool))
    x, y = (old.points[face.nodes[rows]] for rows in (first, second))
    if not bad:
        period = y.mean((0, 1)) - x.mean((0, 1))
        _, partner = KDTree(y.mean(1)).query(x.mean(1) + period)
        apart = np.linalg.norm((x + period)[:, :, None] - y[partner][:, None], axis=3)
        bad = int((apart.min(2).max(1) > SAME_PLACE * np.ptp(old.points)).sum())
    if bad:
        raise ValueError(
            f"joint {name}: {bad} of the {most} faces of {pair[0]} and {pair[1]} have no partner a period "
            "away: expected a periodic mesh"
        )
    pairs = np.stack([first, second[partner]], 1)
    cells = face.cell[pairs]
    normal, _ = area(x[:, : corners(old.dimension, x.shape[1])])
    normal *= np.sign(np.einsum("fd,fd->f", normal, x.mean(1) - old.centres[cells[:, 0]]))[:, None]
    plus = np.take_along_axis(face.place[second[partner]], apart.argmin(2), axis=1)
    return face.place[first], plus, cells, face.side[pairs], normal


def _joint(
    sides: Sides, node_of_place: Integers, points: Floats, direction: ArrayLike | None, name: str
) -> Joint:
    """Faces of a joint, oriented; own, points: nodes of the places, and where they are."""
    minus, plus, cells, faces, normal = node_of_place[sides[0]], node_of_place[sides[1]], *sides[2:]
    d, c = points.shape[1], corners(points.shape[1], minus.shape[1])
    if direction is not None:
        tangent = _projected(normal, direction, name)
    else:
        tangent = default_tangent(normal) if d == 3 else np.stack([normal[:, 1], -normal[:, 0]], 1)
    if d == 2:
        upward = np.stack([-tangent[:, 1], tangent[:, 0]], 1)
        turn = (np.einsum("fd,fd->f", upward, normal) < 0.0)[:, None]
        minus, plus = np.where(turn, plus, minus), np.where(turn, minus, plus)
        cells, faces = (np.where(turn, column[:, ::-1], column) for column in (cells, faces))
        normal = upward
    across = [] if d == 2 else [np.cross(normal, tangent)]
    axes = np.stack([normal, tangent, *across], 1)
    # nodes of the sides in the order that hosts want
    right, size = area(points[minus[:, :c]])
    wrong = np.einsum("fd,fd->f", right, normal) < 0.0
    for side in (minus, plus):
        side[wrong] = side[wrong][:, backward(d, minus.shape[1])]
    if d == 3:
        edges = np.roll(points[minus[:, :c]], -1, axis=1) - points[minus[:, :c]]
        start = (np.einsum("fkd,fd->fk", edges, axes[:, 1]) / np.linalg.norm(edges, axis=2)).argmax(1)
        round_ = (start[:, None] + np.arange(c)) % c
        round_ = np.concatenate([round_, c + round_], 1)[:, : minus.shape[1]]
        minus, plus = (np.take_along_axis(side, round_, axis=1) for side in (minus, plus))
    return Joint(minus, plus, cells, axes, size, faces)


def default_tangent(normal: Floats) -> Floats:
    """Tx without a direction (f, 3), as in Abaqus: the projection of x, or of z within 0.1 degrees of x."""
    x, z = np.eye(3)[[0, 2]]
    tangent = x - normal * normal[:, :1]
    upright = np.linalg.norm(tangent, axis=1) < np.sin(np.radians(0.1))
    tangent[upright] = z - normal[upright] * normal[upright, 2:]
    return np.asarray(tangent / np.linalg.norm(tangent, axis=1)[:, None])


def _projected(normal: Floats, direction: ArrayLike, name: str) -> Floats:
    """Tx (f, d), the projection of a direction onto faces; ValueError where it is normal to them."""
    vector = np.asarray(direction, float).ravel()[: normal.shape[1]]
    part = vector - normal * (normal @ vector)[:, None]
    size = np.linalg.norm(part, axis=1)
    if (bad := int((size < NEARLY_NORMAL * np.linalg.norm(vector)).sum())) > 0:
        raise ValueError(
            f"joint {name}: direction {vector.tolist()} is normal to {bad} of its {len(size)} faces"
        )
    return np.asarray(part / size[:, None])


def _facets(old: Solids, group: str, joint: str) -> list[Integers]:
    """Nodes of the faces of a group."""
    if group in old.left_out:
        raise ValueError(f"joint {joint}: surface {group} is not read: {old.left_out[group]}")
    if group not in old.facets:
        known = ", ".join(old.facets) or "none"
        raise ValueError(f"joint {joint}: {group}: no such group of faces: expected one of {known}")
    return [nodes for nodes, _ in old.facets[group]]


def _outside(old: Solids, face: Faces, facets: Integers) -> Integers:
    """Faces with a cell on one side among facets."""
    if corners(old.dimension, facets.shape[1]) != corners(old.dimension, face.nodes.shape[1]):
        return np.zeros(0, np.int64)
    row = locate(face, facets, old.dimension)
    return row[(row >= 0) & (face.number[row] < 0)]


def _groups(
    old: Solids, node_of_place: Integers, parted: list[NDArray[np.bool_]]
) -> tuple[dict[str, list[Integers]], dict[str, Integers]]:
    """Faces by group, with their new nodes, and nodes of named points; rows (cell, face) of groups of faces.

    Of faces inside the mesh those on both sides are taken where a joint parts them and no cell is given, else
    one; of nodes those of all sides, but of a set of all nodes of a block its own.
    """
    groups: dict[str, list[Integers]] = {}
    surfaces: dict[str, Integers] = {}
    rows_in = _located(old)
    for name, pieces in old.facets.items():
        lost, rows_of = 0, []
        for k, (facets, owner) in enumerate(pieces):
            known = np.zeros(len(facets), bool)
            for face, cut, rows in zip(old.faces, parted, rows_in, strict=True):
                if (name, k) not in rows:
                    continue
                row = rows[name, k]
                known |= row >= 0
                only, row = owner[row >= 0], row[row >= 0]
                pair = face.number[row]
                doubled = np.zeros(len(row), bool)
                if len(face.first):
                    first, second = face.first[pair], face.second[pair]
                    partner = np.where(row == first, second, first)
                    row = np.where((pair >= 0) & (face.cell[partner] == only), partner, row)
                    doubled = (pair >= 0) & (only < 0) & cut[pair]
                row = np.concatenate([row[~doubled], face.first[pair[doubled]], face.second[pair[doubled]]])
                groups.setdefault(name, []).append(node_of_place[face.place[row]])
                rows_of.append(np.stack([face.cell[row], face.side[row]], 1))
            lost += int((~known).sum())
        if lost:
            count = sum(len(facets) for facets, _ in pieces)
            text = f"group {name}: {lost} of its {count} faces are no faces of cells: they are left out"
            warnings.warn(text, ModelWarning, stacklevel=4)
        if sum(map(len, rows_of)):
            surfaces[name] = np.concatenate(rows_of)
    groups = {name: [row for row in rows if len(row)] for name, rows in groups.items() if sum(map(len, rows))}
    for name, nodes in old.spots.items():
        at = np.unique(node_of_place[old.places_of(nodes)])
        missing = len(nodes) - old.places_of.count(nodes)
        if missing:
            text = f"group {name}: {missing} of its {len(nodes)} nodes are in no cell: they are left out"
            warnings.warn(text, ModelWarning, stacklevel=4)
        if len(at):
            groups.setdefault(name, []).append(at[:, None])
    return groups, surfaces


def _located(old: Solids) -> list[dict[tuple[str, int], Integers]]:
    """Faces of the facets of all groups, by name and number of the piece, for each array of faces."""
    d, rows_in = old.dimension, []
    for face in old.faces:
        c = corners(d, face.nodes.shape[1])
        pieces = {
            (name, k): facets[:, :c]
            for name, parts in old.facets.items()
            for k, (facets, _) in enumerate(parts)
            if corners(d, facets.shape[1]) == c
        }
        rows = locate(face, np.concatenate([np.zeros((0, c), np.int64), *pieces.values()]), d)
        ends = np.cumsum([0, *map(len, pieces.values())]).tolist()
        rows_in.append({key: rows[a:b] for key, a, b in zip(pieces, ends, ends[1:], strict=False)})
    return rows_in
