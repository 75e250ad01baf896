"""Files for ParaView: what is in them, and wrong input."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace
from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from asperity.mesh.paraview import Step, write

JOINT = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), Pattern.regular(2, 30.0))
NODES = np.array([[x, y] for y in (0.0, 1.0, 1.0, 2.0) for x in (0.0, 2.0)])
SEPARATION = 0.01 * np.array([[1.0, 2.0, 3.0], [3.0, 4.0, 7.0]])
UPDATE = JOINT.update(SEPARATION)
STEP = Step(
    0.5, NODES, 0.1 * NODES, "quad", np.array([[0, 1, 3, 2], [4, 5, 7, 6]]), np.array([[2, 3, 5, 4]]),
    SEPARATION[None], UPDATE.traction[None], UPDATE.state[None],
)  # fmt: skip
"""Two squares with a joint of two points; the nodes move by their positions."""


def test_fields(tmp_path: Path) -> None:
    """The files have the values of the library, in two parts for each time, as means over a joint."""
    write(tmp_path / "run.pvd", [STEP, replace(STEP, time=1.5)])
    sets = [element.attrib for element in ET.parse(tmp_path / "run.pvd").getroot().iter("DataSet")]
    assert [(entry["timestep"], entry["part"]) for entry in sets] == [
        ("0.5", "0"), ("0.5", "1"), ("1.5", "0"), ("1.5", "1"),
    ]  # fmt: skip
    solids, joints = (meshio.read(tmp_path / entry["file"]) for entry in sets[:2])
    assert solids.cells_dict["quad"].tolist() == STEP.solids.tolist()
    for mesh in (solids, joints):
        assert np.array_equal(mesh.points[:, :2], NODES)
        assert np.array_equal(mesh.point_data["displacement"][:, :2], 0.1 * NODES)
    fields = {name: values[0] for name, values in joints.cell_data.items()}
    assert fields.keys() == {"separation", "traction", "damage", "stored", "rupture", "friction"}
    assert fields.pop("separation")[0] == pytest.approx([0.02, 0.03, 0.05], abs=1e-15)
    for name, values in fields.items():
        assert values[0] == pytest.approx(getattr(UPDATE, name).mean(axis=0), rel=1e-14)


def test_joint_in_space(tmp_path: Path) -> None:
    """The joint between two faces of four nodes is a hexahedron."""
    cube = np.array([[x, y, z] for z in (0.0, 1.0) for x, y in ((0, 0), (1, 0), (1, 1), (0, 1))])
    cells = np.arange(8)[None]
    step = replace(STEP, nodes=cube, displacement=cube, kind="hexahedron", solids=cells, joints=cells)
    write(tmp_path / "a.pvd", [step])
    joints = meshio.read(tmp_path / "a" / "joints_0000.vtu")
    assert joints.cells_dict["hexahedron"].tolist() == cells.tolist()
