"""Meshes for hosts: conditions of Kratos, names that a host cannot read."""

from __future__ import annotations

import json
import re
from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity import ModelWarning
from asperity.mesh import split, write

from mesh.support_meshes import LAW, MSH, grid, only, placed


@pytest.mark.parametrize("d", [2, 3])
def test_kratos(tmp_path: Path, d: int) -> None:
    """Nodes, elements, parts of the model and materials."""
    jointed = split(grid((4, 3, 2)[:d], (2, 3, 1)[:d]))
    path, materials = write(tmp_path / "wall.mdpa", jointed, laws={"joint": LAW})
    text = path.read_text(encoding="utf-8")
    kind = "Geo_ULineInterfacePlaneStrainElement2Plus2N" if d == 2 else "Geo_USurfaceInterfaceElement4Plus4N"
    block = text.split(f"Begin Elements {kind}\n")[1].split("End Elements")[0]
    rows = np.array([line.split() for line in block.splitlines()], int)
    assert (rows[:, 2:] == np.concatenate([only(jointed).minus, only(jointed).plus], 1) + 1).all()
    (card,) = json.loads(materials.read_text(encoding="utf-8"))["properties"]
    assert card["model_part_name"] == "Main.joint" and (rows[:, 1] == card["properties_id"]).all()
    parts = re.findall(r"Begin SubModelPart (\w+)", text)
    assert parts == [*jointed.names, "joint", "joint_minus", "joint_plus"]


def test_writers(tmp_path: Path) -> None:
    """Faces of groups and both sides of joints are conditions of Kratos with normals out of the cells."""
    path = placed(tmp_path, {"wall.msh": MSH})
    (written,) = write(tmp_path / "wall.mdpa", split(path))
    text = written.read_text(encoding="utf-8")
    block = text.split("Begin Conditions LineLoadCondition2D2N\n")[1].split("End Conditions")[0]
    assert block.splitlines()[0] == "1 0 1 2"  # the foot, from left to right: the cell is on its left
    part = text.split("Begin SubModelPart rim\n")[1].split("End SubModelPart\n")[0]
    assert "Begin SubModelPartConditions\n2\n3\nEnd" in part
    assert {"rock", "dam", "joint", "foot", "rim", "joint_minus", "joint_plus"} == set(
        line.split()[2] for line in text.splitlines() if line.startswith("Begin SubModelPart ")
    )
    write(tmp_path / "wall.vtu", split(path))
    named = meshio.read(tmp_path / "wall.vtu").field_data
    assert {name: list(x) for name, x in named.items()} == {"rock": [0, 2], "dam": [1, 2], "joint": [2, 1]}


def test_names_that_a_host_cannot_read(tmp_path: Path) -> None:
    """They are written with underscores, which a warning says; two that become one are refused."""
    text = MSH.replace('"rock"', '"rock (lower)"').replace('"foot"', '"my foot"')
    mesh = split(placed(tmp_path, {"wall.msh": text}))
    with pytest.warns(ModelWarning, match="'rock .lower.' is rock_lower, 'my foot' is my_foot"):
        (path,) = write(tmp_path / "wall.inp", mesh)
    written = path.read_text(encoding="utf-8")
    assert "elset=rock_lower\n" in written and "nset=my_foot\n" in written
    text = text.replace('"rim"', '"my_foot"')
    with pytest.raises(ValueError, match="'my foot' and 'my_foot' both become my_foot"):
        write(tmp_path / "wall.inp", split(placed(tmp_path, {"wall.msh": text})))
