"""Meshes for Abaqus and CalculiX: elements, directions, layers."""

from __future__ import annotations

import re
from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity.mesh import split, write
from asperity.mesh.abaqus import read_model
from asperity.mesh.deck_joints import judged

from mesh.support_meshes import LAW, grid, only
from mesh.test_split import random_mesh


@pytest.mark.parametrize("d", [2, 3])
@pytest.mark.parametrize("kind", ["grid", "random"])
def test_abaqus(tmp_path: Path, kind: str, d: int) -> None:
    """Nodes, solids, cohesive elements and their material are those of the mesh, and right for `doctor`."""
    mesh = grid((4, 3, 2)[:d], (2, 3, 1)[:d]) if kind == "grid" else random_mesh(d, 5)
    jointed = split(_turned(mesh))
    (path,) = write(tmp_path / "wall.inp", jointed, laws={"joint": LAW})
    text = path.read_text(encoding="utf-8")
    head, card = text.split("*Material, ", 1)
    sections = "".join(f"*Solid Section, elset={name}, material=SOLID\n" for name in jointed.names)
    solid = f"*Material, name=SOLID\n*Elastic\n1., 0.\n{sections}*Material, {card}"
    step = "*Step, name=PUSH, unsymm=YES\n*Static\n1., 1.\n*End Step\n"
    path.write_text(head + solid + step, encoding="utf-8")
    assert judged(path).wrong == []
    joint = only(jointed)
    rows = np.concatenate([entry.nodes for entry in read_model(path).cohesive])
    plus = joint.plus[:, ::-1] if d == 2 else joint.plus
    assert (rows == np.concatenate([joint.minus, plus], 1)).all()


def test_abaqus_has_its_own_directions(tmp_path: Path) -> None:
    """A Tx that Abaqus would not have is refused."""
    jointed = split(grid((2, 2, 2), (1, 1, 2)), direction=(0.0, 1.0, 0.0))
    with pytest.raises(ValueError, match="joint joint: expected no direction for abaqus"):
        write(tmp_path / "wall.inp", jointed)


def _turned(mesh: meshio.Mesh) -> meshio.Mesh:
    """Mesh whose triangles and tetrahedra have a positive size."""
    kind, cells = mesh.cells[0].type, mesh.cells[0].data
    if kind in ("triangle", "tetra"):
        x = mesh.points[cells]
        wrong = np.linalg.det(x[:, 1:] - x[:, :1]) < 0.0
        cells[wrong, :2] = cells[wrong, 1::-1]
    return mesh


def test_calculix_layers(tmp_path: Path) -> None:
    """A layer for each orientation, whose local z is N, between the moved faces."""
    jointed = split(grid((2, 2, 2), (2, 1, 2)))
    (path,) = write(tmp_path / "wall.inp", jointed, "calculix", {"joint": LAW}, layer=0.01)
    text = path.read_text(encoding="utf-8")
    assert re.findall(r"\*Element, type=C3D8, elset=(joint\w*)", text) == ["joint_1", "joint_2"]
    lines = re.findall(r"\*Orientation, name=(\w+), system=rectangular\n(.*)\n", text)
    normals = [np.cross(*np.fromstring(line, sep=",").reshape(2, 3)).tolist() for _, line in lines]
    assert sorted(normals) == [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]]
    assert "*SOLID SECTION, ELSET=joint_2, MATERIAL=ABAQUSJOINT, ORIENTATION=joint_2" in text
    with pytest.raises(ValueError, match="layer = 0: expected the thickness of its layers"):
        write(tmp_path / "wall.inp", jointed, "calculix")
    with pytest.raises(ValueError, match="layer = 1: expected less than 1, for the cells at joint joint"):
        write(tmp_path / "wall.inp", jointed, "calculix", layer=1.0)
    jointed.points[:] *= 1e-5 / 3.0  # CalculiX reads 20 characters of a number
    jointed.points[0] = -1e-16 / 3.0, 0.0, -1e20 / 3.0
    (path,) = write(tmp_path / "wall.inp", jointed)
    nodes = path.read_text(encoding="utf-8").split("*Node\n")[1].split("*")[0].splitlines()
    words = [line.split(", ")[1:] for line in nodes]
    assert max(len(word) for line in words for word in line) <= 20
    assert np.array(words, float) == pytest.approx(jointed.points, rel=1e-12, abs=0.0)
    jointed.names[0] = "2words"
    with pytest.raises(ValueError, match="name '2words': expected a letter, then letters"):
        write(tmp_path / "wall.inp", jointed)
