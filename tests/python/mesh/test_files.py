"""Files of meshes that others write: what comes in is accounted for, and what is not read is refused by name.

The counts of drawn files are those of tests/oracle/mesh_count.py, which reads them on its own.
"""

from __future__ import annotations

import warnings
from collections import Counter
from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity import ModelWarning
from asperity.mesh import Jointed, split

from harness.hosts import structured
from mesh import drawn_meshes
from mesh.support_meshes import ROUNDING, placed
from tests.oracle import mesh_count

DRAWN = 40
"""Drawn files of each kind in the fast tests; the slow one has a thousand mutated ones of each kind."""


def measured(mesh: Jointed) -> mesh_count.Counts:
    """Cells, nodes and area of a plane mesh, and the cells of its blocks and sets, in lower case."""
    area, block = 0.0, np.concatenate([mesh.block[kind] for kind in mesh.cells])
    for cells in mesh.cells.values():
        x = mesh.points[cells]
        y = np.roll(x, -1, axis=1)
        area += 0.5 * float(np.abs((x[..., 0] * y[..., 1] - x[..., 1] * y[..., 0]).sum(1)).sum())
    groups: Counter[str] = Counter()
    for k, name in enumerate(mesh.names):
        groups[name.lower()] += int((block == k).sum())
    for name, cells in mesh.sets.items():
        groups[name.lower()] += len(cells)
    counts: mesh_count.Counts = {"cells": len(block), "nodes": len(np.unique(mesh.origin)), "area": area}
    return counts | {f"cells of {name}": count for name, count in groups.items()}


def same_counts(mesh: Jointed, expected: mesh_count.Counts) -> None:
    """Counts of a mesh are those of its file; sets of several instances begin with that of the instance."""
    counts: Counter[str] = Counter()
    for name, count in measured(mesh).items():
        plain = [key for key in expected if name == key or name.endswith(key.replace("cells of ", "_"))]
        counts[max(plain, key=len) if plain else name] += count  # type: ignore[assignment]
    assert counts == pytest.approx({name: count for name, count in expected.items() if count}, rel=ROUNDING)


def read(kind: str, files: dict[str, str]) -> mesh_count.Counts:
    """Counts of a file by the independent reader."""
    return mesh_count.deck(files) if kind == "deck" else mesh_count.gmsh(files["mesh.msh"])


@pytest.mark.parametrize("kind", ["deck", "gmsh"])
def test_drawn_files(tmp_path: Path, kind: str) -> None:
    """All of a drawn file comes in: cells, nodes, area, blocks, other groups, joints between the blocks."""
    for seed in range(DRAWN):
        drawn = getattr(drawn_meshes, kind)(seed)
        mesh = split(placed(tmp_path, drawn.files))
        same_counts(mesh, read(kind, drawn.files))
        counts = np.bincount(np.concatenate([mesh.block[kind] for kind in mesh.cells]))
        assert dict(zip(mesh.names, counts.tolist(), strict=True)) == drawn.blocks
        length = sum(float(part.area.sum()) for parts in mesh.joints.values() for part in parts)
        assert length == pytest.approx(drawn.length, rel=ROUNDING)


def attack(folder: Path, kind: str, seeds: range) -> int:
    """Read mutated files: each is refused in one line, or all of it comes in; number of those refused."""
    refused = 0
    for seed in seeds:
        files = dict(getattr(drawn_meshes, kind)(seed).files)
        draw = np.random.default_rng([seed, 7])
        name = str(draw.choice(sorted(files)))
        files[name] = drawn_meshes.mutated(files[name], draw)
        path = placed(folder, files)
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", ModelWarning)
                mesh = split(path)
        except ValueError as error:
            refused += 1
            assert "\n" not in str(error) and ("expected" in str(error) or "no such" in str(error)), seed
        else:
            same_counts(mesh, read(kind, files))
    return refused


@pytest.mark.parametrize("kind", ["deck", "gmsh"])
def test_mutated_files(tmp_path: Path, kind: str) -> None:
    """No traceback, and nothing is lost without a word."""
    assert 0 < attack(tmp_path, kind, range(DRAWN)) < DRAWN


@pytest.mark.long
@pytest.mark.parametrize("kind", ["deck", "gmsh"])
def test_thousand_mutated_files(tmp_path: Path, kind: str) -> None:
    """As above, with a thousand files of each kind."""
    assert attack(tmp_path, kind, range(1000, 2000)) < 1000


def test_cells_that_a_reader_loses(tmp_path: Path) -> None:
    """A cell of a legacy VTK file whose type is unknown is not lost without a word."""
    grid = structured.grid(range(3), range(3), block=[1, 2], sides=())
    points = np.pad(grid.points, ((0, 0), (0, 1)))
    path = tmp_path / "wall.vtk"
    meshio.Mesh(points, grid.cells, cell_data=grid.cell_data).write(path, binary=False)
    assert len(split(path).block["quad"]) == 4
    head, types, rest = path.read_text(encoding="utf-8").partition("CELL_TYPES 4\n9\n")
    path.write_text(head + types.replace("9", "-1") + rest, encoding="utf-8")
    with pytest.raises(ValueError, match="3 cells of 4 are read"):
        split(path)


def test_files_that_are_no_mesh(tmp_path: Path) -> None:
    """They are named."""
    path = tmp_path / "wall.msh"
    with pytest.raises(ValueError, match=r"wall.msh: no such file: expected a mesh"):
        split(path)
    path.write_text("", encoding="utf-8")
    with pytest.raises(ValueError, match=r"wall.msh: .*expected a mesh that meshio reads"):
        split(path)
    path = tmp_path / "wall.inp"
    path.write_text("*NODE\n1, 0, 0\n*ELEMENT, TYPE=CPE4, ELSET=A\n1, 1, 1, 1, 1\n", encoding="utf-8")
    error = r"1 of 1 cells \(quad\) have a node twice, as cell 1 of block A at \(0, 0\): expected none"
    with pytest.raises(ValueError, match=error):
        split(path)
