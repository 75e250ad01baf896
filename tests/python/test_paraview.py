"""Files for ParaView: what is in them, where the integration points are, and wrong input."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity import Interface, Material, Pattern

from harness.hosts.paraview_files import Step, Structure, write

JOINT = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), Pattern.regular(2, 30.0))
NODES = np.array([[x, y] for y in (0.0, 1.0, 1.0, 2.0) for x in (0.0, 2.0)])
PLANE = Structure(NODES, np.array([[0, 1, 3, 2], [4, 5, 7, 6]]), np.array([[2, 3, 5, 4]]), (2, 1))
CUBE = np.array([[x, y, z] for z in (0.0, 1.0) for y in (0.0, 1.0) for x in (0.0, 1.0)])
HEXAHEDRON = np.array([[0, 1, 3, 2, 4, 5, 7, 6]])


def step(structure: Structure, time: float = 0.0) -> Step:
    """A step whose points have separations that rise with their number; the nodes move by their positions."""
    n = structure.points
    separation = 0.01 * np.arange(1, n + 1)[:, None] * [1.0, 2.0, 3.0]
    update = JOINT.update(separation)
    return Step(time, 0.1 * structure.nodes, separation, update.traction, update.state)


def test_fields(tmp_path: Path) -> None:
    """The files have the values of the library, in two parts for each time."""
    steps = [step(PLANE, 0.5), step(PLANE, 1.5)]
    write(tmp_path / "run.pvd", PLANE, steps)
    sets = [one.attrib for one in ET.parse(tmp_path / "run.pvd").getroot().iter("DataSet")]
    assert [(one["timestep"], one["part"]) for one in sets] == [
        ("0.5", "0"), ("0.5", "1"), ("1.5", "0"), ("1.5", "1"),
    ]  # fmt: skip
    solids, joints = (meshio.read(tmp_path / one["file"]) for one in sets[:2])
    assert np.array_equal(solids.points[:, :2], NODES) and solids.cells_dict["quad"].tolist() == [
        [0, 1, 3, 2],
        [4, 5, 7, 6],
    ]
    assert np.array_equal(solids.point_data["displacement"][:, :2], 0.1 * NODES)
    expected = JOINT.update(steps[0].separation)
    found = {name: values[0] for name, values in joints.cell_data.items()}
    assert np.array_equal(found["dilation"], steps[0].separation[:, 0])
    assert np.array_equal(found["slip"], steps[0].separation[:, 1:])
    for name in ("traction", "damage", "stored", "rupture", "friction"):
        assert np.array_equal(found[name], getattr(expected, name))
    assert found.keys() == {"dilation", "slip", "traction", "damage", "stored", "rupture", "friction"}


def test_cells_of_points(tmp_path: Path) -> None:
    """Every point has a cell: the joint of 2 mm has two halves, which move with the nodes."""
    write(tmp_path / "run.pvd", PLANE, [step(PLANE)])
    joints = meshio.read(tmp_path / "run" / "joints_0000.vtu")
    corners = joints.points[joints.cells_dict["quad"]]
    assert np.array_equal(corners[:, :, 0], [[0.0, 1.0, 1.0, 0.0], [1.0, 2.0, 2.0, 1.0]])
    assert np.allclose(joints.point_data["displacement"], 0.1 * joints.points, rtol=0, atol=1e-15)


def test_order_of_points(tmp_path: Path) -> None:
    """Points of a hexahedron: the last axis changes fastest."""
    layer = Structure(CUBE, np.zeros((0, 8), dtype=int), HEXAHEDRON, (2, 2, 2))
    write(tmp_path / "run.pvd", layer, [step(layer)])
    joints = meshio.read(tmp_path / "run" / "joints_0000.vtu")
    middles = joints.points[joints.cells_dict["hexahedron"]].mean(axis=1)
    numbers = np.rint(joints.cell_data["dilation"][0] / 0.01).astype(int) - 1
    place = {n: middle for n, middle in zip(numbers.tolist(), middles.tolist(), strict=True)}
    assert place[0] == pytest.approx([0.25] * 3) and place[7] == pytest.approx([0.75] * 3)
    assert place[1] == pytest.approx([0.25, 0.25, 0.75])


def test_wrong_steps(tmp_path: Path) -> None:
    """Results of another number of nodes or points, and another name of the file, are refused."""
    good = step(PLANE)
    with pytest.raises(ValueError, match=r"run\.vtu: expected a name that ends with \.pvd"):
        write(tmp_path / "run.vtu", PLANE, [good])
    bad = Step(0.0, NODES[1:], good.separation, good.traction, good.state)
    with pytest.raises(ValueError, match=r"displacement has shape \(7, 2\): expected \(8, 2\)"):
        write(tmp_path / "run.pvd", PLANE, [bad])
    bad = Step(0.0, NODES, good.separation, good.traction[1:], good.state)
    with pytest.raises(ValueError, match="traction of 1 points: expected 2"):
        write(tmp_path / "run.pvd", PLANE, [bad])
