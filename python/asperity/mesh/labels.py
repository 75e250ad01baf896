"""Numbers that a file gives its nodes and cells, for messages."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from .shapes import Integers

if TYPE_CHECKING:
    import meshio

LABELS = "asperity:labels"
"""Entry of the `info` of a mesh of meshio that has the labels of its file."""

LEFT_OUT = "asperity:left out"
"""Entry of `info` that has the surfaces of the file that are not read, by name, and why."""


@dataclass(frozen=True)
class Labels:
    """Numbers of nodes and cells in their file, and of the scopes, as instances, that number them.

    homes: names of the scopes; an empty one for the model.  Without numbers all nodes are "a node".
    """

    nodes: Integers
    home_of_node: Integers
    cells: Integers
    home_of_cell: Integers
    homes: list[str]

    def node(self, k: int) -> str:
        """Name of node k of the mesh in a message."""
        return _name("node", self.nodes, self.home_of_node, self.homes, k)

    def cell(self, k: int) -> str:
        """Name of cell k of the mesh, counted through all its arrays, in a message."""
        return _name("cell", self.cells, self.home_of_cell, self.homes, k)


def _name(kind: str, numbers: Integers, home_of: Integers, homes: list[str], k: int) -> str:
    if not len(numbers):
        return f"a {kind}"
    home = homes[home_of[k]]
    return f"{kind} {home}.{numbers[k]}" if home else f"{kind} {numbers[k]}"


def labels_of(mesh: meshio.Mesh) -> Labels:
    """Labels of the file of a mesh; none if it was not read by this package."""
    none = np.zeros(0, np.int64)
    labels: Labels = (mesh.info or {}).get(LABELS, Labels(none, none, none, none, []))
    return labels


def left_out_of(mesh: meshio.Mesh) -> dict[str, str]:
    """Surfaces of the file of a mesh that are not read, and why."""
    return dict((mesh.info or {}).get(LEFT_OUT, {}))
