"""Which side of the faces of a joint N points to: one along each connected part of its faces."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from fnmatch import fnmatchcase
from itertools import combinations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..contract import Floats
from .cells import Solids
from .jointed import Joint
from .shapes import Integers, area, corners, place

Rule = Callable[[Integers, Integers, Floats, Floats], ArrayLike]
"""From blocks (f,) of both sides, centres and normals (f, d) of faces between blocks: which are a joint."""

Joints = Mapping[str, "Rule | Sequence[str] | Mapping[str, str] | None"]

FLAT = np.cos(np.radians(30.0))
"""Cosine of the angle up to which two of three or more faces at an edge go on into each other."""

NO_MEAN = 1e-6
"""Mean normal, over that of a plane, below which faces are a closed surface."""


def sides_of_faces(
    rules: Joints, old: Solids, chosen: list[Integers]
) -> tuple[list[NDArray[np.bool_]], list[Integers]]:
    """Pairs of faces whose second face comes first, and the connected parts of named groups, or -1.

    N points to the later block.  Where that contradicts itself, it points between blocks of two patterns from
    those of the first one to the others; if a block is of both, as of *:*, to the side of the later blocks
    along most of a connected part.  Named groups count at once, as a fault may be in several.
    """
    sides = [(old.block[face.cell[face.first]], old.block[face.cell[face.second]]) for face in old.faces]
    turns = [a > b for a, b in sides]
    for number, rule in enumerate(rules.values()):
        if isinstance(rule, Mapping) or callable(rule) or rule is None:
            continue
        fits = np.array([[fnmatchcase(text, word) for text in old.names] for word in rule])
        rows = [np.flatnonzero(joint_of == number) for joint_of in chosen]
        if fits.all(0).any():
            wanted = [values for values, _ in turned(old, rows)]
        else:
            wanted = [~fits[0][a[at]] for (a, _), at in zip(sides, rows, strict=True)]
        alike = np.concatenate([turn[at] == new for turn, at, new in zip(turns, rows, wanted, strict=True)])
        for turn, at, new in zip(turns, rows, wanted, strict=True):
            turn[at] = new if alike.any() and not alike.all() else turn[at]
    named = [number for number, name in enumerate(rules) if is_named(rules, old, name)]
    rows = [np.flatnonzero(np.isin(joint_of, named)) for joint_of in chosen]
    parts = [np.full(len(joint_of), -1, np.int64) for joint_of in chosen]
    title = ", ".join(name for name in rules if is_named(rules, old, name))
    for turn, part, at, (values, numbers) in zip(turns, parts, rows, turned(old, rows, title), strict=True):
        turn[at], part[at] = values, numbers
    return turns, parts


def check_direction(joint: Joint, normal: Floats, part: Integers, name: str) -> None:
    """Raise ValueError where a direction turns N to the other side within a connected part of named faces."""
    back = np.einsum("fd,fd->f", joint.axes[:, 0], normal) < 0.0
    count = np.bincount(part), np.bincount(part, weights=back)
    if (mixed := np.flatnonzero((count[1] > 0) & (count[1] < count[0]))).size:
        some = int(min(count[1][mixed[0]], count[0][mixed[0]] - count[1][mixed[0]]))
        raise ValueError(
            f"joint {name}: by its direction N of {some} of {count[0][mixed[0]]} connected faces is on the "
            "other side: expected no direction for faces that turn so far"
        )


def is_named(rules: Joints, old: Solids, name: str) -> bool:
    """Whether a joint is the faces of a group of its name, and none that the file has."""
    return rules[name] is None and name not in old.joints


def turned(old: Solids, rows: list[Integers], name: str = "") -> list[tuple[NDArray[np.bool_], Integers]]:
    """Pairs of faces, by kind, whose first face must come second so that connected faces have N on one side.

    With them comes the number of the connected part of each pair.  rows: pairs of faces of joints, by kind of
    face.  N points to the later block where there are two, else along the axis that is closest to the mean of
    N, or out of a closed surface.  Where there are no two sides, as on a Moebius strip, N points to the later
    block, or with a name ValueError is raised.
    """
    d, total = old.dimension, sum(map(len, rows))
    if not total:
        return [(np.zeros(0, bool), np.zeros(0, np.int64)) for _ in rows]
    normals, areas, middles, order, rims = [], [], [], [], []
    count = 0
    for face, at in zip(old.faces, rows, strict=True):
        first, second = face.cell[face.first[at]], face.cell[face.second[at]]
        around = face.nodes[face.first[at]][:, : corners(d, face.nodes.shape[1])]
        x = old.points[around]
        normal, size = area(x)
        back = np.einsum("fd,fd->f", normal, old.centres[second] - old.centres[first]) < 0.0
        around = np.where(back[:, None], around[:, ::-1], around)
        normals.append(np.where(back[:, None], -normal, normal))
        areas.append(size)
        middles.append(x.mean(1))
        order.append(np.sign(old.block[second] - old.block[first]))
        rims.append(_rim(around, d, count))
        count += len(at)
    n, size, middle, wish = (np.concatenate(parts_of) for parts_of in (normals, areas, middles, order))
    sign, part, bad = one_sided(np.concatenate(rims), n, middle, old.points)
    if len(bad) and name:
        text = f"joint {name}: {len(bad)} faces are connected and have no two sides"
        where = place(middle[bad[0]])
        raise ValueError(f"{text}, as at {where}: expected a surface that is no Moebius strip")
    sign[bad] = np.where(wish[bad] < 0.0, -1.0, 1.0)
    _, label = np.unique(part, return_inverse=True)
    label = label.ravel()

    def sums(values: Floats) -> Floats:
        return np.stack([np.bincount(label, column) for column in np.atleast_2d(values.T)], 1)

    vector, area_of_part = sign * size, sums(size)[:, 0]
    later, mean = sums(vector * wish)[:, 0], sums(vector[:, None] * n)
    away = middle - (sums(middle) / sums(np.ones(len(size))))[label]
    largest = np.abs(mean) > (1.0 - NO_MEAN) * np.abs(mean).max(1, keepdims=True)
    axis = d - 1 - largest[:, ::-1].argmax(1)
    upward = np.take_along_axis(mean, axis[:, None], 1)[:, 0]
    outward = sums(vector * np.einsum("fd,fd->f", n, away))[:, 0]
    flat = np.linalg.norm(mean, axis=1) > NO_MEAN * area_of_part
    along = np.where(np.abs(later) > NO_MEAN * area_of_part, later, np.where(flat, upward, outward))
    along[label[bad]] = 1.0
    sign[along[label] < 0.0] *= -1.0
    cuts = np.cumsum([len(at) for at in rows])[:-1]
    return list(zip(np.split(sign < 0.0, cuts), np.split(part, cuts), strict=True))


def _rim(around: Integers, d: int, first: int) -> Integers:
    """Rows (two nodes in order, or one in the plane, sense, face) of the edges of faces."""
    face = first + np.arange(len(around))
    if d == 2:
        sense = np.ones(len(around), np.int64)
        ends = [np.stack([around[:, k], around[:, k], s * sense, face], 1) for k, s in ((0, 1), (1, -1))]
        return np.concatenate(ends)
    a, b = around.ravel(), np.roll(around, -1, axis=1).ravel()
    return np.stack(
        [np.minimum(a, b), np.maximum(a, b), np.where(a < b, 1, -1), np.repeat(face, around.shape[1])], 1
    )


def one_sided(rim: Integers, n: Floats, middle: Floats, points: Floats) -> tuple[Floats, Integers, Integers]:
    """Signs that make neighbours alike, numbers of connected parts, and faces without two sides."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    total = len(n)
    _, edge, count = np.unique(rim[:, :2], axis=0, return_inverse=True, return_counts=True)
    edge = edge.ravel()
    order = np.argsort(edge, kind="stable")
    start = np.cumsum([0, *count])
    two = start[:-1][count == 2]
    before, after = rim[order[two]], rim[order[two + 1]]
    links = [np.stack([before[:, 3], after[:, 3], before[:, 2] != after[:, 2]], 1)]
    for many in np.unique(count[count > 2]).tolist():
        at = order[start[:-1][count == many][:, None] + np.arange(many)]
        middle_of = points[rim[at[:, 0], :2]].mean(1)
        for i, j in combinations(range(many), 2):
            f, g = rim[at[:, i], 3], rim[at[:, j], 3]
            level = np.einsum("ed,ed->e", n[f], n[g])
            across = np.einsum("ed,ed->e", middle[f] - middle_of, middle[g] - middle_of) < 0.0
            on = (np.abs(level) > FLAT) & across
            links.append(np.stack([f[on], g[on], level[on] > 0.0], 1))
    a, b, same = np.concatenate(links).T
    same = same.astype(bool)
    ends = (
        np.concatenate([a, a + total]),
        np.concatenate([np.where(same, b, b + total), np.where(same, b + total, b)]),
    )
    graph = coo_array((np.ones(len(ends[0]), np.int8), ends), shape=(2 * total, 2 * total))
    _, part = connected_components(graph, directed=False)
    least = np.minimum(part[:total], part[total:])
    bad = np.flatnonzero(part[:total] == part[total:])
    return np.where(part[:total] == least, 1.0, -1.0), least, bad
