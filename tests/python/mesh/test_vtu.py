"""VTU files: blocks, joints, axes of OpenGeoSys, groups beside them."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity.mesh import split, write

from mesh.support_meshes import MSH, grid, placed


def test_vtu(tmp_path: Path) -> None:
    """Blocks and joints have numbers and axes; a layer has its volume, and all of it that of the mesh."""
    jointed = split(grid((2, 2, 2), (2, 1, 2)))
    write(tmp_path / "wall.vtu", jointed, "ogs", layer=0.01)
    read = meshio.read(tmp_path / "wall.vtu")
    numbers = np.concatenate(read.cell_data["MaterialIDs"])
    assert (np.bincount(numbers) == [2, 2, 2, 2, 8]).all()
    x = np.concatenate([read.points[block.data] for block in read.cells])
    size = np.abs(np.linalg.det(np.stack([x[:, 1] - x[:, 0], x[:, 3] - x[:, 0], x[:, 4] - x[:, 0]], 1)))
    assert size[numbers == 4].sum() == pytest.approx(2 * 4 * 0.01, rel=0.01)
    assert (np.concatenate(read.cell_data["N"])[numbers == 4].max(0) == [1.0, 0.0, 1.0]).all()


TWO = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
5
2 1 "low"
2 2 "high"
1 3 "foot, left/right"
0 4 "corner"
2 5 "wet"
$EndPhysicalNames
$Nodes
8
1 0 0 0
2 2 0 0
3 0 1 0
4 2 1 0
5 0 3 0
6 2 3 0
7 5 0 0
8 5 1 0
$EndNodes
$Elements
8
1 15 2 4 1 6
2 1 2 3 1 1 2
3 1 2 3 1 2 7
4 3 2 1 1 1 2 4 3
5 3 2 1 2 2 7 8 4
6 3 2 2 3 3 4 6 5
7 3 2 5 2 2 7 8 4
8 3 2 5 3 3 4 6 5
$EndElements
"""
"""Two squares below, one above; two faces on the lower outline, a corner, and a group of two cells."""


@pytest.mark.parametrize(("host", "layer"), [("ogs", 0.01), ("vtu", 0.0)])
def test_groups_beside_a_vtu_file(host: str, layer: float, tmp_path: Path) -> None:
    """Each is a mesh whose nodes lie at those of the whole mesh, and whose faces are edges of its cells."""
    path = placed(tmp_path, {"two.msh": TWO})
    files = write(
        tmp_path / "wall.vtu", split(path, {"joint": ("low", "high")}, "low,high"), host, layer=layer
    )
    names = ["wall", "wall_foot_left_right", "wall_corner", "wall_wet"]
    assert sorted(file.stem for file in files) == sorted(names)
    whole, foot, corner, wet = (meshio.read(tmp_path / f"{name}.vtu") for name in names)
    for part in (foot, corner, wet):
        assert part.points.tolist() == whole.points[part.point_data["bulk_node_ids"]].tolist()
    assert foot.cells_dict["line"].tolist() == [[0, 1], [1, 2]]
    assert foot.points[:, :2].tolist() == [[0.0, 0.0], [2.0, 0.0], [5.0, 0.0]]
    cells = np.concatenate([block.data for block in whole.cells if block.type == "quad"])
    for part, kind in ((foot, "line"), (wet, "quad")):
        beside = cells[np.concatenate(part.cell_data["bulk_element_ids"])]
        nodes = part.point_data["bulk_node_ids"][part.cells_dict[kind]]
        assert all(set(own) <= set(cell) for own, cell in zip(nodes.tolist(), beside.tolist(), strict=True))
    assert corner.cells_dict["vertex"].tolist() == [[0]] and corner.points[0, :2].tolist() == [2.0, 3.0]
    # of both sides of the joint each cell has its own nodes
    assert len(wet.cells_dict["quad"]) == 2 and len(wet.points) == 8


def test_two_groups_in_one_file(tmp_path: Path) -> None:
    """Groups whose names become one file, or that of the mesh, are refused; own files alone are replaced."""
    text = TWO.replace('"corner"', '"foot, left:right"')
    with pytest.raises(
        ValueError, match=r"groups 'foot, left/right' and 'foot, left:right': one file .*wall_f"
    ):
        write(tmp_path / "wall.vtu", split(placed(tmp_path, {"two.msh": text}), None, "low,high"))


def test_axes_of_opengeosys(tmp_path: Path) -> None:
    """In the plane they have two components and are right-handed."""
    write(tmp_path / "wall.vtu", split(placed(tmp_path, {"wall.msh": MSH})), "ogs", layer=0.01)
    read = meshio.read(tmp_path / "wall.vtu")
    axes = np.stack([np.concatenate(read.cell_data[name]) for name in ("N", "Tx")], 1)
    assert axes.shape == (3, 2, 2) and (np.linalg.det(axes) == 1.0).all()
    assert axes[2].tolist() == [[0.0, 1.0], [-1.0, 0.0]]
