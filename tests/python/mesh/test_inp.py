"""Meshes for Abaqus and CalculiX: elements, directions, layers."""

from __future__ import annotations

import re
from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity import ModelWarning
from asperity.mesh import split, write
from asperity.mesh.abaqus import read_model
from asperity.mesh.deck_joints import judged

from mesh.support_meshes import LAW, grid, only
from mesh.test_split import random_mesh

DIGITS = 1.0e-9
"""Relative error of lengths of places that are written with all digits."""


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


@pytest.mark.parametrize("angle", [90.0, 20.0, 6.0])
def test_layers_of_joints_that_cross(tmp_path: Path, angle: float) -> None:
    """Layers have their thickness at every node, at sharp angles too; those without room are refused."""
    mesh, h = grid((2, 2, 2), (2, 1, 2)), 0.01
    mesh.points[:, 0] += (mesh.points[:, 2] - 1.0) / np.tan(np.radians(angle))
    jointed = split(mesh)
    (path,) = write(tmp_path / "wall.vtu", jointed, "ogs", layer=h)
    written = meshio.read(path)
    cells, normals = written.cells_dict["hexahedron"], written.cell_data_dict["N"]["hexahedron"]
    layers = written.cell_data_dict["MaterialIDs"]["hexahedron"] == len(jointed.names)
    x = written.points[cells[layers]]
    across = np.einsum("fkd,fd->fk", x[:, 4:] - x[:, :4], normals[layers])
    assert len(across) == 8 and across == pytest.approx(h, rel=DIGITS)


def test_layers_without_room(tmp_path: Path) -> None:
    """Layers that turn cells inside out are refused, other thicknesses are told, with their place."""
    mesh = grid((2, 2, 2), (2, 1, 2))
    mesh.points[:, 0] += (mesh.points[:, 2] - 1.0) / np.tan(np.radians(2.0))
    text = r"8 of 8 faces of joint joint have other thicknesses, as at \(1, ., 1\) 0.0005, as faces meet"
    with pytest.warns(ModelWarning, match=f"layer = 0.001: {text}"):
        write(tmp_path / "wall.inp", split(mesh), "calculix", layer=1e-3)
    points = [[-1.0, 0.0], [0.0, 0.0], [3.0, 0.0], [1.0, 0.3], [2.0, 0.5], [0.0, 1.0], [0.0, -2.0]]
    cells = [[0, 1, 5], [1, 3, 5], [1, 4, 3], [1, 2, 4], [3, 4, 5], [0, 6, 1], [1, 6, 2]]
    block = {"block": [np.array([1, 1, 1, 1, 1, 2, 2])]}
    sliver = split(
        meshio.Mesh(np.array(points), [("triangle", np.array(cells))], cell_data=block), blocks="block"
    )
    write(tmp_path / "sliver.vtu", sliver, "ogs", layer=0.19)
    with pytest.raises(ValueError, match=r"layer = 0.21: 1 cells, as at \(1, 0.2.*\), would be inside out"):
        write(tmp_path / "sliver.vtu", sliver, "ogs", layer=0.21)


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
