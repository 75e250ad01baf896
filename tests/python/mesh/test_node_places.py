"""Sets of nodes of many blocks."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from asperity.mesh import split

from mesh.support_meshes import groups, placed


def test_many_blocks_and_sets(tmp_path: Path) -> None:
    """Node sets of all nodes of many blocks keep those of their cells, as one of a single block does."""
    n = 12
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1) + 1
    text = "*Node\n" + "".join(f"{number[j, i]}, {i}., {j}.\n" for j in range(n + 1) for i in range(n + 1))
    for j in range(n):
        for i in range(n):
            nodes = number[j, i], number[j, i + 1], number[j + 1, i + 1], number[j + 1, i]
            listed = ", ".join(map(str, nodes))
            text += f"*Element, type=CPE4, elset=B{j}_{i}\n{j * n + i + 1}, {listed}\n"
            text += f"*Nset, nset=N{j}_{i}\n{listed}\n*Surface, name=S{j}_{i}\nB{j}_{i}, S2\n"
    mesh = split(placed(tmp_path, {"many.inp": text}))
    assert len(mesh.points) == 4 * n * n and sum(len(part.area) for part in mesh.joints["joint"]) == 2 * n * (
        n - 1
    )
    [cells] = mesh.cells.values()
    areas = groups(mesh)
    for k, name in enumerate(mesh.names):
        assert set(mesh.nodes(f"N{name[1:]}")) == set(cells[mesh.block["quad"] == k].ravel())
        assert areas[f"S{name[1:]}"] == (1, 1.0)
