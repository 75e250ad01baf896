"""Numbers that a file gives its nodes and cells, for messages."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .shapes import Integers


@dataclass(frozen=True)
class Labels:
    """Numbers of nodes and cells in their file, and of the scopes, as instances, that number them.

    homes: names of the scopes; an empty one for the model.  Without numbers all nodes are "a node".
    """

    nodes: Integers
    home_of_node: Integers
    cells: Integers
    home_of_cell: Integers
    homes: tuple[str, ...]

    @classmethod
    def none(cls) -> Labels:
        """Labels of a file without numbers."""
        none = np.zeros(0, np.int64)
        return cls(none, none, none, none, ())

    def node(self, k: int) -> str:
        """Name of node k of the mesh in a message."""
        return _name("node", self.nodes, self.home_of_node, self.homes, k)

    def cell(self, k: int) -> str:
        """Name of cell k of the mesh, counted through all its arrays, in a message."""
        return _name("cell", self.cells, self.home_of_cell, self.homes, k)


def _name(kind: str, numbers: Integers, home_of: Integers, homes: tuple[str, ...], k: int) -> str:
    if not len(numbers):
        return f"a {kind}"
    home = homes[home_of[k]]
    return f"{kind} {home}.{numbers[k]}" if home else f"{kind} {numbers[k]}"
