"""Groups of cells that are blocks: sets, cell data, names of programs."""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np
import pytest
from asperity.mesh import split

from mesh.support_meshes import STRIP, grid, placed


def plate(**data: list[float]) -> meshio.Mesh:
    """Six squares in two rows with cell data."""
    points = [[float(i), float(j), 0.0] for j in range(3) for i in range(4)]
    cells = [[4 * j + i, 4 * j + i + 1, 4 * j + i + 5, 4 * j + i + 4] for j in range(2) for i in range(3)]
    return meshio.Mesh(
        np.array(points), [("quad", np.array(cells))],
        cell_data={name: [np.array(values)] for name, values in data.items()},
    )  # fmt: skip


ROWS = [1, 1, 1, 2, 2, 2]


@pytest.mark.parametrize("ending", [".vtk", ".vtu"])
@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("vtkProcessId", [0, 1, 0, 1, 0, 1]), ("rank", ROWS), ("partition", ROWS), ("GlobalCellIds", ROWS),
        ("cell_id", [1, 2, 3, 4, 5, 6]), ("material", [5, 3, 4, 1, 2, 6]), ("is_active", [1, 1, 1, 1, 1, 0]),
        ("damage_flag", ROWS), ("PartitionId", ROWS), ("MPI_rank", ROWS), ("offsets", ROWS), ("stage", ROWS),
        ("processor_of_part", ROWS), ("vtkOriginalCellIds", ROWS), ("elementId", ROWS), ("format", ROWS),
        ("MatFraction", [0.5, 1.0, 1.0, 1.0, 1.0, 1.0]), ("owner", ROWS),
    ],
)  # fmt: skip
def test_cell_data_of_no_blocks(tmp_path: Path, name: str, values: list[float], ending: str) -> None:
    """Ranks, numbers of cells, flags and fractions are no blocks unless --blocks says so."""
    path = tmp_path / f"plate{ending}"
    plate(**{name: values}).write(path)
    with pytest.raises(ValueError, match="the mesh has no groups: expected"):
        split(path)
    if values == ROWS:
        assert split(path, blocks=name).names == ["block_1", "block_2"]
    plate(**{name: values, "material": ROWS}).write(path)
    if name != "material":
        assert split(path).joints["joint"][0].area.sum() == 3.0


@pytest.mark.parametrize(
    "name",
    [
        "MaterialIDs",
        "material",
        "region_id",
        "Layer",
        "CellEntityIds",
        "matid",
        "PartId",
        "BLOCK_ID",
        "ElementBlockIds",
    ],
)
def test_cell_data_of_blocks(tmp_path: Path, name: str) -> None:
    """Numbers of blocks may be written as floats."""
    for values in (ROWS, [float(value) for value in ROWS]):
        plate(**{name: values}).write(tmp_path / "plate.vtu")
        mesh = split(tmp_path / "plate.vtu")
        assert mesh.names == ["block_1", "block_2"] and mesh.joints["joint"][0].area.sum() == 3.0


def test_ghosts_and_two_materials() -> None:
    """Cells of another rank are refused, and so are two arrays that may be those of blocks."""
    with pytest.raises(
        ValueError, match="2 cells are ghosts, of another rank, by vtkGhostType: expected the"
    ):
        split(plate(material=ROWS, vtkGhostType=[0, 1, 0, 0, 1, 0]))
    assert split(plate(material=ROWS, vtkGhostType=[0] * 6)).joints["joint"][0].area.sum() == 3.0
    with pytest.raises(ValueError, match="several arrays with numbers of blocks, material, zone: expected"):
        split(plate(material=ROWS, zone=ROWS[::-1]))


def test_sets_of_programs(tmp_path: Path) -> None:
    """Sets internal to CAE are no blocks; the advice names sets of elements, not those of loads."""
    inner = STRIP + "*Elset, elset=Picked, internal\n1, 2\n"
    mesh = split(placed(tmp_path, {"strip.inp": inner}))
    assert mesh.names == ["DAM", "ROCK"] and list(mesh.sets) == ["Picked"]
    parted = STRIP.replace("CPE4\n1", "CPE4, elset=ROCK\n1").replace(
        "\n2, 3, 4", "\n*Element, type=CPE4, elset=DAM\n2, 3, 4"
    )
    loaded = parted.split("*Elset")[0] + "*Elset, elset=ALOAD\n2, 3\n*Elset, elset=PUSHED\n3\n"
    with pytest.raises(ValueError, match="name the blocks, as --blocks DAM,ROCK"):
        split(placed(tmp_path, {"strip.inp": loaded}))


INP = """*NODE
1, 0., 0.
2, 1., 0.
3, 1., 1.
4, 0., 1.
5, 2., 0.
6, 2., 1.
*ELEMENT, TYPE=CPS4, ELSET=left
1, 1, 2, 3, 4
*ELEMENT, TYPE=CPS4, ELSET=right
2, 2, 5, 6, 3
*ELSET, ELSET=whole
1, 2
"""
"""Two squares; every cell is in a set of all cells, too."""


def test_blocks_of_files(tmp_path: Path) -> None:
    """Blocks are physical groups of gmsh, entities where there are none, and the smallest sets of Abaqus."""
    mesh, entities = grid((2, 1), (1, 1)), {"gmsh:geometrical": [np.array([1, 2])]}
    mesh.cell_data = entities
    assert split(mesh).names == ["block_1", "block_2"]
    mesh.cell_data = {"gmsh:physical": [np.array([7, 5])]} | entities
    mesh.write(tmp_path / "wall.msh", file_format="gmsh22", binary=False)
    (tmp_path / "wall.inp").write_text(INP, encoding="utf-8")
    for name, blocks in ("wall.msh", ["block_5", "block_7"]), ("wall.inp", ["left", "right"]):
        jointed = split(tmp_path / name)
        assert jointed.names == blocks and len(jointed.points) == 8


def test_blocks_that_are_chosen(tmp_path: Path) -> None:
    """--blocks names groups that are blocks; the others stay whole beside them."""
    path = placed(tmp_path, {"strip.inp": STRIP + "*Elset, elset=CREST\n3\n"})
    mesh = split(path, blocks="ROCK,DAM")
    assert mesh.names == ["ROCK", "DAM"] and mesh.sets["CREST"].tolist() == [2]
    assert mesh.joints["joint"][0].area.tolist() == [1.0]
    with pytest.raises(ValueError, match="blocks = SOIL: expected groups of the mesh: CREST, DAM, ROCK"):
        split(path, blocks="SOIL")


@pytest.mark.parametrize(
    "names",
    [("Surface1", "Surface2"), ("Internal_Selection-1_A", "Internal_Selection-2_B"), ("_PickedSet4", "_P")],
)
def test_names_of_programs(tmp_path: Path, names: tuple[str, str]) -> None:
    """Groups that a program names are blocks only where the user has named none, or not all."""
    text = STRIP.replace("*Elset, elset=ROCK\n1\n*Elset, elset=DAM\n2, 3\n", "")
    given = f"*Elset, elset={names[0]}\n1, 2\n*Elset, elset={names[1]}\n3\n"
    own = "*Elset, elset=rock\n1\n*Elset, elset=dam\n2, 3\n"
    mesh = split(placed(tmp_path, {"strip.inp": text + given + own}))
    assert mesh.names == ["dam", "rock"] and len(mesh.sets[names[0]]) == 2
    assert sorted(split(placed(tmp_path, {"strip.inp": text + given})).names) == sorted(names)
    crest = "*Elset, elset=CREST\n3\n"
    with pytest.raises(ValueError, match="one block for each: name the blocks, as --blocks dam,rock"):
        split(placed(tmp_path, {"strip.inp": text + given + own + crest}))


def test_a_part_of_a_set_is_no_block(tmp_path: Path) -> None:
    """A set of the user and one that a program names are no blocks together."""
    text = STRIP.replace("*Elset, elset=ROCK\n1\n*Elset, elset=DAM\n2, 3\n", "")
    sets = "*Elset, elset=_rest\n1\n*Elset, elset=UPPER\n2, 3\n*Elset, elset=ALL\n_rest, UPPER\n"
    with pytest.raises(ValueError, match=r"2 of 3 cells are in two groups, .* in ALL and UPPER"):
        split(placed(tmp_path, {"strip.inp": text + sets}))
