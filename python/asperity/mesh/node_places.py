"""Places in the cells of sets of nodes."""

from __future__ import annotations

import numpy as np

from .shapes import Integers


class NodePlaces:
    """Places in the cells by node, cells by place and groups by cell."""

    def __init__(self, before: Integers, sizes: Integers, block: Integers, sets: list[Integers]) -> None:
        """Sort the places by their nodes, and the cells of the groups.

        before: node of each place.  sizes: number of places of each cell.  block: number of the block of each
        cell.  sets: cells of other groups.
        """
        self.node, self.sizes = before, sizes
        self.order = np.argsort(before, kind="stable")
        self.sorted = before[self.order]
        self.cell = np.repeat(np.arange(len(sizes)), sizes)
        self.first = np.cumsum(sizes) - sizes
        order = np.argsort(block, kind="stable")
        count = int(block.max()) + 1
        blocks = np.split(order, np.searchsorted(block[order], range(1, count)))
        self.groups = [*blocks, *sets]
        self.cells_in = np.array([len(cells) for cells in self.groups])
        members = np.concatenate(self.groups)
        group = np.repeat(np.arange(len(self.groups)), self.cells_in)
        order = np.argsort(members, kind="stable")
        self.group = group[order]  # of all cells, one after the other
        self.start = np.searchsorted(members[order], np.arange(len(sizes) + 1))

    def count(self, nodes: Integers) -> int:
        """How many of these nodes are in a cell."""
        at = np.minimum(np.searchsorted(self.sorted, nodes), len(self.sorted) - 1)
        return int((self.sorted[at] == nodes).sum())

    def __call__(self, nodes: Integers) -> Integers:
        """Places with these nodes; if they are all nodes of a group of cells, those of its cells alone."""
        nodes = np.unique(nodes)
        inside = self.order[
            _ranges(*(np.searchsorted(self.sorted, nodes, side) for side in ("left", "right")))
        ]
        cells, count = np.unique(self.cell[inside], return_counts=True)
        complete = cells[count == self.sizes[cells]]
        groups = self.group[_ranges(self.start[complete], self.start[complete + 1])]
        number, count = np.unique(groups, return_counts=True)
        present = len(np.unique(self.node[inside]))
        for k in number[count == self.cells_in[number]].tolist():
            cells = self.groups[k]
            places = _ranges(self.first[cells], self.first[cells] + self.sizes[cells])
            if len(np.unique(self.node[places])) == present:
                return places
        return inside


def _ranges(first: Integers, last: Integers) -> Integers:
    """Numbers from first up to last, range after range."""
    counts = last - first
    begin = np.repeat(first - (np.cumsum(counts) - counts), counts)
    return begin + np.arange(counts.sum())
