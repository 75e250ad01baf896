"""Meshes of the decks: blocks on top of each other, with joints of thickness zero between them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import product

Point = tuple[float, ...]


@dataclass
class Mesh:
    """Nodes and elements by number, from 1, and sets of both; the last coordinate is normal to the joints."""

    dimension: int
    nodes: list[Point] = field(default_factory=list)
    elements: list[tuple[int, ...]] = field(default_factory=list)
    types: dict[str, tuple[str, list[int]]] = field(default_factory=dict)
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)

    def add(self, name: str, kind: str, connectivity: Sequence[tuple[int, ...]]) -> None:
        """Add elements of an Abaqus type as an element set."""
        first = len(self.elements) + 1
        self.elements.extend(connectivity)
        self.types[name] = (kind, list(range(first, first + len(connectivity))))

    def lines(self) -> list[str]:
        """Nodes, elements and sets as lines of an input file."""
        text = ["*Node"]
        text += [
            ", ".join([str(i), *(_number(value) for value in point)]) for i, point in enumerate(self.nodes, 1)
        ]
        for name, (kind, numbers) in self.types.items():
            if kind.startswith("COH"):
                text.append(
                    "** A joint: its lower face, then the upper face above it. N points from lower to upper."
                )
            text.append(f"*Element, type={kind}, elset={name}")
            text += [", ".join(map(str, (i, *self.elements[i - 1]))) for i in numbers]
        for keyword, sets in (("Nset, nset", self.node_sets), ("Elset, elset", self.element_sets)):
            for name, numbers in sets.items():
                text.append(f"*{keyword}={name}")
                text += [", ".join(map(str, numbers[i : i + 16])) for i in range(0, len(numbers), 16)]
        return text


@dataclass(frozen=True)
class Layer:
    """A block: name, element type, and the coordinates of its nodes along the normal of the joints."""

    name: str
    kind: str
    heights: Sequence[float]


def stack(
    plan: Sequence[Sequence[float]],
    layers: Sequence[Layer],
    joints: Sequence[str],
    joint_kind: str,
    bonded: Callable[[Point], bool] = lambda _: True,
) -> Mesh:
    """Layers on top of each other, each with nodes of its own, and a joint between every two of them.

    plan: coordinates of the nodes along the joint, (x) or (x, y).  joints: names of the joints, from below.
    bonded: whether the joint has an element at a center.  Node sets NAME_BOTTOM and NAME_TOP and
    element sets NAME_ROOF (uppermost elements) of each layer.
    """
    mesh = Mesh(dimension=len(plan) + 1)
    grids = [_block(mesh, plan, layer) for layer in layers]
    cells = list(product(*(range(len(axis) - 1) for axis in reversed(plan))))
    for name, lower, upper in zip(joints, grids[:-1], grids[1:], strict=True):
        faces = []
        for cell in cells:
            corners = _corners(cell[::-1])
            below = [lower[(*c, -1)] for c in corners]
            above = [upper[(*c, 0)] for c in corners]
            center = [
                sum(values) / len(below) for values in zip(*(mesh.nodes[i - 1] for i in below), strict=True)
            ]
            if bonded(tuple(center)):
                faces.append((*below, *(above if len(plan) == 2 else reversed(above))))
        mesh.add(name, joint_kind, faces)
    return mesh


def _block(mesh: Mesh, plan: Sequence[Sequence[float]], layer: Layer) -> dict[tuple[int, ...], int]:
    """Add a layer; returns its nodes by grid position, whose last index may also count from the top (-1)."""
    axes = [*plan, layer.heights]
    top = len(layer.heights) - 1
    nodes: dict[tuple[int, ...], int] = {}
    for place in product(*(range(len(axis)) for axis in reversed(axes))):
        at = place[::-1]
        mesh.nodes.append(tuple(float(axis[i]) for axis, i in zip(axes, at, strict=True)))
        nodes[at] = len(mesh.nodes)
    for at, number in list(nodes.items()):
        if at[-1] == 0:
            mesh.node_sets.setdefault(f"{layer.name}_BOTTOM", []).append(number)
        if at[-1] == top:
            mesh.node_sets.setdefault(f"{layer.name}_TOP", []).append(number)
            nodes[(*at[:-1], -1)] = number
    elements = []
    roof = []
    first = len(mesh.elements) + 1
    for place in product(*(range(len(axis) - 1) for axis in reversed(axes))):
        *cell, k = place[::-1]
        corners = _corners(cell)
        below, above = ([nodes[(*c, level)] for c in corners] for level in (k, k + 1))
        if k == top - 1:
            roof.append(first + len(elements))
        elements.append((*below, *(above if len(plan) == 2 else reversed(above))))
    mesh.add(layer.name, layer.kind, elements)
    mesh.element_sets[f"{layer.name}_ROOF"] = roof
    return nodes


def _corners(cell: Sequence[int]) -> list[tuple[int, ...]]:
    """Corners of a cell of the plan, counter-clockwise seen from above."""
    if len(cell) == 1:
        return [(cell[0],), (cell[0] + 1,)]
    i, j = cell
    return [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)]


def spaced(start: float, end: float, parts: int) -> list[float]:
    """Coordinates from start to end in equal parts."""
    return [start + (end - start) * i / parts for i in range(parts + 1)]


def _number(value: float) -> str:
    return repr(round(value, 9) + 0.0)
