"""Joint elements whose nodes are all held: by supports, a rigid body, or couplings to one reference node."""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from .deck import Block
from .deck_connections import Tie, nodes_of_name, ties_of
from .deck_model import Model
from .shapes import Integers, place

ALL = (0, 1, 2)
HELD = {
    "ENCASTRE": ALL, "PINNED": ALL, "XSYMM": (0,), "YSYMM": (1,), "ZSYMM": (2,), "XASYMM": (1, 2),
    "YASYMM": (0, 2), "ZASYMM": (0, 1),
}  # fmt: skip
"""Directions that the names of *Boundary hold."""

BODIES = "ELSET", "NSET", "PIN NSET", "TIE NSET"
"""Parameters of *Rigid Body that name its elements or nodes."""

FREE = "USER", "SUBMODEL", "FIXED"
"""Parameters of *Boundary that do not hold nodes at 0."""

Mask = NDArray[np.bool_]


@dataclass
class Group:
    """Nodes that move as one, the keywords that name some of them, and what holds them in words."""

    text: str
    nodes: Mask
    named: list[tuple[Block, Integers]] = field(default_factory=list)


def held_problems(model: Model, sections: Container[int]) -> Iterator[str]:
    """Elements of joints all of whose nodes are in a group that moves as one, with file and line.

    sections: those of joints, by id.
    """
    joint = list(model.of_sections(sections))
    ties = ties_of(model)
    for group in (*_bodies(model), _supports(model)):
        held = _with_tied(model, ties, group.nodes)
        found = [nodes[held[nodes].all(1)] for nodes in joint]
        if count := sum(map(len, found)):
            first = next(nodes for nodes in found if len(nodes))[0]
            by = [block for block, nodes in group.named if np.isin(first, nodes).any()]
            head = (by or [group.named[0][0]])[0].head()
            text = f"{head}: {group.text} all nodes of {count} elements of a joint"
            yield f"{text}, as at {place(model.points[first].mean(0))}: expected one side that can move"


def _with_tied(model: Model, ties: Iterable[Tie], group: Mask) -> Mask:
    """Nodes of a group and those that ties hold to them."""
    from scipy.spatial import KDTree

    held = group.copy()
    for tie in ties:
        for mine, other in (tie.nodes, tie.nodes[::-1]):
            if len(mine) and group[other].any():
                nearest = KDTree(model.points[other]).query(model.points[mine])[1]
                held[mine] |= group[other[nearest]]
    return held


def _bodies(model: Model) -> Iterable[Group]:
    """Rigid bodies and kinematic couplings, those of one reference node together."""
    groups: dict[str, Group] = {}
    for block, following in pairwise([*model.deck, Block("END", {})]):
        words: list[str | None] = []
        if block.keyword == "RIGID BODY":
            words = [block.parameters.get(name) for name in BODIES]
        elif (
            block.keyword == "COUPLING"
            and following.keyword == "KINEMATIC"
            and _translates(model, following, 0)
        ):
            words = [block.parameters.get("SURFACE")] if "INFLUENCE RADIUS" not in block.parameters else []
        elif block.keyword == "KINEMATIC COUPLING" and _translates(model, block, 1):
            words = [row[0] for _, row in block.rows()]
        for word in filter(None, words):
            reference = (block.parameters.get("REF NODE") or str(id(block))).upper()
            none = np.zeros(len(model.points), bool)
            group = groups.setdefault(reference, Group("it makes one rigid body of", none))
            nodes = nodes_of_name(model, block, word)
            group.nodes[nodes] = True
            group.named.append((block, nodes))
    return groups.values()


def _translates(model: Model, block: Block, first: int) -> bool:
    """Whether a coupling holds all displacements: lines name directions from the word `first` on, or none."""
    named = [row if first else ["", *row] for _, row in block.rows() if row[first:] and row[first]]
    held = {k for row in named for k in _directions(row)}
    return not named or {*range(max(model.dimension, 2))} <= held


def _supports(model: Model) -> Group:
    """Nodes that supports hold at 0 in all directions and in all steps; none where a step has new ones."""
    held = np.zeros((len(model.points), 3), bool)
    moved = np.zeros(len(model.points), bool)
    group = Group("the supports hold", moved)
    for block in model.deck:
        if block.keyword != "BOUNDARY":
            continue
        if (block.parameters.get("OP") or "MOD").upper() == "NEW":
            return Group(group.text, np.zeros_like(moved))
        free = (block.parameters.get("TYPE") or "DISPLACEMENT").upper() != "DISPLACEMENT"
        for k, row in block.rows():
            nodes = nodes_of_name(model, block, row[0])
            if free or {*FREE} & {*block.parameters} or any(block.numbers(row[3:4], k)):
                moved[nodes] = True
            else:
                held[nodes[:, None], _directions(row)] = True
                group.named.append((block, nodes))
    group.nodes = held[:, : max(model.dimension, 2)].all(1) & ~moved
    return group


def _directions(row: list[str]) -> list[int]:
    """Directions that a line of *Boundary holds: a name, or the first and the last one."""
    words = [word.upper() for word in row[1:3] if word]
    if words and words[0] in HELD:
        return [*HELD[words[0]]]
    if not words or not all(word.isdigit() for word in words):
        return []
    return [k for k in ALL if int(words[0]) <= k + 1 <= int(words[-1])]
