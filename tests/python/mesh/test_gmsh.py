"""Groups of gmsh in all formats of its files."""

from __future__ import annotations

from pathlib import Path

import pytest
from asperity.mesh import split

from mesh.support_meshes import MSH, groups, placed


def test_groups_of_gmsh(tmp_path: Path) -> None:
    """A face in two groups is in both; an entity in no group is no error unless it is a block."""
    mesh = split(placed(tmp_path, {"wall.msh": MSH}))
    assert mesh.names == ["rock", "dam"]
    sides = {"foot": (1, 3.0), "rim": (2, 6.0), "joint_minus": (1, 3.0), "joint_plus": (1, 3.0)}
    assert groups(mesh) == sides
    assert "joint joint: 1 faces, length 3, 0 tips, N from rock to dam" in mesh.summary()
    loose = MSH.replace("2 0 1 0 3 2 0 1 2 0", "2 0 1 0 3 2 0 0 0")
    with pytest.raises(ValueError, match=r"1 of 2 cells are in no block, as a cell at \(1.5, 1.5\)"):
        split(placed(tmp_path, {"loose.msh": loose}))
    inner = MSH.replace("3 0 1 0 3 1 0 0 0", "3 0 1 0 3 1 0 2 5 4 0")
    inside = split(placed(tmp_path, {"both.msh": inner}))
    # on the joint a group has both sides, and its faces count once
    assert groups(inside)["foot"] == (3, 9.0) and "group foot: 2 faces, length 6" in inside.summary()


def test_other_formats_of_gmsh(tmp_path: Path) -> None:
    """Cells of order 3 and files of format 1 are refused with the options of gmsh that help."""
    with pytest.raises(
        ValueError, match=r"elements of type 21: expected cells of order 1 or 2 .Mesh.ElementOrder"
    ):
        split(placed(tmp_path, {"wall.msh": MSH.replace("2 1 3 1\n4", "2 1 21 1\n4")}))
    old = "$NOD\n1\n1 0 0 0\n$ENDNOD\n$ELM\n0\n$ENDELM\n"
    with pytest.raises(ValueError, match=r"format 1 of gmsh: expected .* 2.2 or 4.1 .Mesh.MshFileVersion"):
        split(placed(tmp_path, {"old.msh": old}))
    with pytest.raises(ValueError, match=r"expected a mesh that meshio reads, of gmsh in format 2.2 or 4.1"):
        split(placed(tmp_path, {"text.msh": "no mesh\n"}))
