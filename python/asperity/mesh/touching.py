"""Blocks that touch without common faces: meshed apart, or with hanging nodes."""

from __future__ import annotations

import warnings
from itertools import chain

import numpy as np

from ..contract import Floats
from ..material import ModelWarning
from .faces import Faces, parts_of
from .labels import Labels
from .shapes import Integers, corners, in_cells, place

SAME_PLACE = 1e-6
"""Distance of a node from another one, or from a face, over the size of the face, at which they touch."""

GAP = 10.0
"""Distance of nodes over that of --join, beyond which they are meant to be apart."""

TINY = 1e-9
"""Smallest distance over the size of the mesh that is advised for nodes of one place."""

ROUNDED = 1e-3
"""Distance of two nodes over the shortest edge on the outside, within which rounded places may be one."""


def joined(points: Floats, used: Integers, distance: float) -> Integers:
    """Node that each node becomes where nodes of cells within a distance are one."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import KDTree

    if not 0.0 < distance < np.inf:
        raise ValueError(f"join = {distance:g}: expected a distance >= 0")
    pairs = KDTree(points[used]).query_pairs(distance, output_type="ndarray")
    links = coo_array((np.ones(len(pairs), np.int8), (pairs[:, 0], pairs[:, 1])), shape=(len(used),) * 2)
    count, part = connected_components(links, directed=False)
    least = np.full(count, len(points), np.int64)
    np.minimum.at(least, part, used)
    node = np.arange(len(points))
    node[used] = least[part]
    return node


def check_touching(
    points: Floats,
    faces: list[Faces],
    block: Integers,
    names: list[str],
    labels: Labels,
    joined_at: float,
    bonded: list[Integers],
) -> None:
    """Raise ValueError, with number, place and blocks, where faces on the outside touch other cells.

    joined_at: distance within which nodes were joined, or 0; nodes that are much farther apart are a gap, of
    which ModelWarning tells.  bonded (f, k, 2): nodes of the sides of joints that the file has; beside these,
    nodes at one place are apart on purpose, as those of a starter crack, and ModelWarning has their number.
    """
    from scipy.spatial import KDTree

    d = points.shape[1]
    outside = [(face, np.flatnonzero(face.number < 0)) for face in faces]
    corner = [face.nodes[rows][:, : corners(d, face.nodes.shape[1])] for face, rows in outside]
    cell = np.concatenate([face.cell[rows] for face, rows in outside])
    nodes = in_cells(*corner)
    owner = np.zeros(len(points), np.int64)
    owner[np.concatenate([rows.ravel() for rows in corner])] = np.concatenate(
        [
            np.repeat(face.cell[rows], ends.shape[1])
            for (face, rows), ends in zip(outside, corner, strict=True)
        ]
    )
    x = points[nodes]
    least = min(
        float(np.linalg.norm(points[rows] - points[np.roll(rows, 1, axis=1)], axis=2).min())
        for rows in corner
        if len(rows)
    )
    tree_of_nodes = KDTree(x)
    pairs = tree_of_nodes.query_pairs(ROUNDED * least, output_type="ndarray")
    if bonded:
        _warn_of_cracks(np.sort(nodes[pairs], axis=1), points, bonded, labels)
    elif len(pairs):
        distance = np.linalg.norm(x[pairs[:, 0]] - x[pairs[:, 1]], axis=1)
        far = int(distance.argmax())
        a, b = nodes[pairs[far]]
        first_block, second_block = names[block[owner[a]]], names[block[owner[b]]]
        size = f"{len(pairs)} pairs of nodes are within {distance[far]:.2g} of each other, "
        size += f"{ROUNDED:g} of an edge or less"
        where = f"as {labels.node(a)} and {labels.node(b)} at {place(points[a])}, "
        where += f"of {first_block} and {second_block}"
        if joined_at and distance.min() > GAP * joined_at:
            warnings.warn(f"{size}, {where}: a gap between them", ModelWarning, stacklevel=4)
        else:
            near = _rounded_up(max(float(distance[far]), 0.01 * ROUNDED * least, TINY * float(np.ptp(x))))
            apart = _apart(joined_at, float(distance.min()))
            raise ValueError(
                f"{size}, {where}: expected common nodes: --join {near} makes them one; if this is a gap, "
                f"{apart} leaves them apart"
            )
    centres = np.concatenate([points[rows].mean(1) for rows in corner])
    spots = np.concatenate([x, centres])
    spot_cell = np.concatenate([owner[nodes], cell])
    tree_of_spots = KDTree(spots)
    first = 0
    for facets in corner:
        if not len(facets):
            continue
        y, middle = points[facets], points[facets].mean(1)
        radius = np.linalg.norm(y - middle[:, None], axis=2).max(1)
        near = tree_of_spots.query_ball_point(middle, radius * (1.0 + SAME_PLACE))
        rows = np.repeat(np.arange(len(facets)), [len(spots_near) for spots_near in near])
        at = np.fromiter(chain.from_iterable(near), np.int64, len(rows))
        mine = at == len(nodes) + first + rows  # the middle of the face itself
        at_corner = (facets[rows] == np.append(nodes, np.full(len(centres), -1))[at][:, None]).any(1)
        if bonded:  # only nodes within faces; those at corners, as of a crack, are known by their number
            to_corners = np.linalg.norm(y[rows] - spots[at][:, None], axis=2).min(1)
            at_corner |= (at >= len(nodes)) | (to_corners <= ROUNDED * radius[rows])
        rows, at = rows[~(mine | at_corner)], at[~(mine | at_corner)]
        inside = _inside(y[rows], spots[at])
        if inside.any():
            k, spot = rows[inside][0], at[inside][0]
            a, b = names[block[cell[first + k]]], names[block[spot_cell[spot]]]
            raise ValueError(
                f"{len(np.unique(rows[inside]))} faces touch others without common nodes, as one of {a} at "
                f"{place(middle[k])} and {b} at {place(spots[spot])}: expected blocks that share their faces "
                "(fragmented or merged before they are meshed); --join 0 leaves them apart"
            )
        first += len(facets)


def check_hinges(
    points: Floats,
    cells: dict[str, Integers],
    faces: list[Faces],
    block: Integers,
    names: list[str],
    labels: Labels,
    bonded: list[Integers],
) -> None:
    """Raise ValueError, with place and blocks, where blocks have common nodes and no common faces.

    This is so where the faces on both sides of a joint are divided in another way: these would stay bonded.
    bonded (f, k, 2): nodes of the sides of joints that the file has, which are left out.
    """
    flat = np.concatenate([data.ravel() for data in cells.values()])
    owner = np.repeat(block, np.concatenate([np.full(len(data), data.shape[1]) for data in cells.values()]))
    first, last = _extremes(flat, owner, len(points))
    outside = in_cells(*(face.nodes[face.number < 0] for face in faces))
    of_joints = np.concatenate([np.zeros(0, np.int64), *(rows.ravel() for rows in bonded)])
    nodes = np.setdiff1d(outside[first[outside] < last[outside]], of_joints)
    places, part = parts_of(cells, faces, nodes, [np.zeros(len(face.first), bool) for face in faces])
    least, most = _extremes(part, owner[places], len(places))
    lowest, highest = (_extremes(flat[places], ends[part], len(points)) for ends in (most, least))
    apart = np.flatnonzero(highest[1] > lowest[0])  # two parts without a common block
    if len(apart):
        k = int(apart[0])
        a, b = names[lowest[0][k]], names[highest[1][k]]
        raise ValueError(
            f"{len(apart)} nodes, as {labels.node(k)} at {place(points[k])}, are those of blocks without "
            f"common faces there, as {a} and {b}: expected faces that are divided in one way on both sides; "
            "--join 0 leaves them"
        )


def _extremes(at: Integers, values: Integers, count: int) -> tuple[Integers, Integers]:
    """Smallest and largest of the values at each of `count` numbers; -1 for the largest of none."""
    least, most = np.full(count, np.iinfo(np.int64).max), np.full(count, -1)
    np.minimum.at(least, at, values)
    np.maximum.at(most, at, values)
    return least, most


def _warn_of_cracks(pairs: Integers, points: Floats, bonded: list[Integers], labels: Labels) -> None:
    """Name nodes at one place that no joint of the file connects."""
    rows = np.sort(np.concatenate([side.reshape(-1, 2) for side in bonded]), axis=1)
    known = {tuple(row) for row in rows.tolist()}
    if apart := [row for row in pairs.tolist() if tuple(row) not in known]:
        a, b = apart[0]
        text = f"{len(apart)} pairs of nodes at one place are in no joint of the file and stay apart"
        where = f"as {labels.node(a)} and {labels.node(b)} at {place(points[a])}"
        warnings.warn(f"{text}, {where}: a crack, or parts that a tie connects", ModelWarning, stacklevel=5)


def _rounded_up(distance: float) -> str:
    """A distance of two digits that is not less."""
    digit = 10.0 ** (np.floor(np.log10(distance)) - 1.0)
    return f"{np.ceil(distance / digit * (1.0 - 1e-12)) * digit:.2g}"


def _apart(joined_at: float, distance: float) -> str:
    """Option that leaves nodes apart, and others joined if some were."""
    smaller = distance / (2.0 * GAP)
    return f"--join {smaller:.1g}" if joined_at and smaller > 0.0 else "--join 0"


def _inside(x: Floats, p: Floats) -> np.ndarray:
    """Whether points p (f, d) lie on faces with the corners x (f, k, d), to a part of their size."""
    size = np.ptp(x, axis=1).max(1)
    if x.shape[2] == 2:
        edge, to = x[:, 1] - x[:, 0], p - x[:, 0]
        length = np.linalg.norm(edge, axis=1)
        away = np.abs(edge[:, 0] * to[:, 1] - edge[:, 1] * to[:, 0]) / length
        along = np.einsum("fd,fd->f", edge, to) / length
        slack = SAME_PLACE * size
        return np.asarray((away <= slack) & (along > slack) & (along < length - slack))
    on_face = np.zeros(len(x), bool)
    for k in range(1, x.shape[1] - 1):  # the triangles of a face
        a, u, v = x[:, 0], x[:, k] - x[:, 0], x[:, k + 1] - x[:, 0]
        normal = np.cross(u, v)
        area = np.linalg.norm(normal, axis=1)
        area = np.where(area > 0.0, area, 1.0)
        away = np.abs(np.einsum("fd,fd->f", normal, p - a)) / area
        w = np.einsum("fd,fd->f", np.cross(u, p - a), normal) / area**2
        s = np.einsum("fd,fd->f", np.cross(p - a, v), normal) / area**2
        on_face |= (
            (away <= SAME_PLACE * size)
            & (w >= -SAME_PLACE)
            & (s >= -SAME_PLACE)
            & (w + s <= 1.0 + SAME_PLACE)
        )
    return on_face
