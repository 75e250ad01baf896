"""Meshes of the decks: blocks on top of each other, with joints of thickness zero between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise, product

import numpy as np
from numpy.typing import NDArray

Point = tuple[float, ...]
Numbers = NDArray[np.int_]


@dataclass
class Mesh:
    """Nodes and elements by number, from 1, and sets of both; the last coordinate is normal to the joints."""

    dimension: int
    nodes: list[Point] = field(default_factory=list)
    elements: list[list[int]] = field(default_factory=list)
    types: dict[str, tuple[str, list[int]]] = field(default_factory=dict)
    node_sets: dict[str, list[int]] = field(default_factory=dict)
    element_sets: dict[str, list[int]] = field(default_factory=dict)

    def add(self, name: str, kind: str, connectivity: Numbers) -> None:
        """Add elements (n, nodes) of an Abaqus type as an element set."""
        first = len(self.elements) + 1
        self.elements += connectivity.tolist()
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
) -> Mesh:
    """Layers on top of each other, each with nodes of its own, and a joint between every two of them.

    plan: coordinates of the nodes along the joint, (x) or (x, y).  joints: names of the joints, from below.
    Node sets NAME_BOTTOM and NAME_TOP and element sets NAME_ROOF (uppermost elements) of each layer.
    """
    mesh = Mesh(dimension=len(plan) + 1)
    grids = [_block(mesh, plan, layer) for layer in layers]
    for name, (lower, upper) in zip(joints, pairwise(grids), strict=True):
        mesh.add(name, joint_kind, _cells(lower[-1], upper[0]))
    return mesh


def _block(mesh: Mesh, plan: Sequence[Sequence[float]], layer: Layer) -> Numbers:
    """Add a layer; returns its nodes by their position (height, y, x) or (height, x)."""
    axes = [layer.heights, *reversed(plan)]
    points = list(product(*axes))
    grid = (len(mesh.nodes) + 1 + np.arange(len(points))).reshape([len(axis) for axis in axes])
    mesh.nodes += [tuple(float(value) for value in point[::-1]) for point in points]
    mesh.node_sets[f"{layer.name}_BOTTOM"] = grid[0].ravel().tolist()
    mesh.node_sets[f"{layer.name}_TOP"] = grid[-1].ravel().tolist()
    rows = [_cells(below, above) for below, above in pairwise(grid)]
    mesh.add(layer.name, layer.kind, np.vstack(rows))
    mesh.element_sets[f"{layer.name}_ROOF"] = mesh.types[layer.name][1][-len(rows[-1]) :]
    return grid


def _cells(lower: Numbers, upper: Numbers) -> Numbers:
    """Nodes of the cells between two levels, of which each is (y, x) or (x), in the order of Abaqus."""
    if lower.ndim == 1:
        corners = [lower[:-1], lower[1:], upper[1:], upper[:-1]]
    else:
        corners = [
            level[j : len(level) - 1 + j, i : level.shape[1] - 1 + i]
            for level in (lower, upper)
            for j, i in ((0, 0), (0, 1), (1, 1), (1, 0))
        ]
    return np.stack(corners, axis=-1).reshape(-1, len(corners))


def spaced(start: float, end: float, parts: int) -> list[float]:
    """Coordinates from start to end in equal parts."""
    return [start + (end - start) * i / parts for i in range(parts + 1)]


def _number(value: float) -> str:
    return repr(round(value, 9) + 0.0)
