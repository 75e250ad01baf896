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
from asperity.mesh import Jointed, split, write
from asperity.mesh.abaqus import read_deck

from harness.hosts import structured
from mesh import drawn_meshes
from tests.oracle import mesh_count

ROUNDING = 1.0e-9
"""Relative error of areas of files whose places have six decimals, and of instances turned about an axis."""

DRAWN = 40
"""Drawn files of each kind in the fast tests; the slow one has a thousand mutated ones of each kind."""


def placed(folder: Path, files: dict[str, str]) -> Path:
    """Write files and return the main one, the last."""
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    return folder / list(files)[-1]


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


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["deck", "gmsh"])
def test_thousand_mutated_files(tmp_path: Path, kind: str) -> None:
    """As above, with a thousand files of each kind."""
    assert attack(tmp_path, kind, range(1000, 2000)) < 1000


CUBE = """*Part, name=Cube
*Node
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 2.
6, 1., 0., 2.
7, 1., 1., 2.
8, 0., 1., 2.
*Element, type=c3d8r, elset=Stone
7, 1, 2, 3, 4,
5, 6, 7, 8
*Surface, type=ELEMENT, name=Foot
Stone, S1
*Surface, type=ELEMENT, name=Side
7, S3
*End Part
*Assembly, name=A
*Instance, name=One, part=Cube
*End Instance
*Instance, name=Two, part=Cube
3., 0., 2.
3., 0., 2., 4., 0., 2., 90.
*End Instance
*Nset, nset=Corner, instance=Two
1
*Elset, elset=Both
One.Stone, Two.7
*End Assembly
"""
"""A block 1 x 1 x 2, and the same moved by (3, 0, 2), then turned from y to z: its height is along -y."""


def groups(mesh: Jointed) -> dict[str, tuple[int, float]]:
    """Number and area of the faces of each surface, by the corners of its faces."""
    areas = {}
    for name, rows in mesh.surfaces.items():
        total = 0.0
        for nodes in mesh.face_nodes(rows):
            x = mesh.points[nodes]
            if x.shape[2] == 2:
                total += float(np.linalg.norm(x[:, 1] - x[:, 0], axis=1).sum())
            else:  # triangles from the first corner
                fan = np.cross(x[:, 1:-1] - x[:, :1], x[:, 2:] - x[:, :1])
                total += 0.5 * float(np.linalg.norm(fan, axis=2).sum())
        areas[name] = len(rows), total
    return areas


def test_parts_moved_and_turned(tmp_path: Path) -> None:
    """An instance is moved and then turned, and each has nodes of its own."""
    mesh = read_deck(placed(tmp_path, {"two.inp": CUBE}))
    low, high = mesh.points[:8], mesh.points[8:]
    assert low.min(0).tolist() == [0.0, 0.0, 0.0] and low.max(0).tolist() == [1.0, 1.0, 2.0]
    assert high.min(0) == pytest.approx([3.0, -2.0, 2.0], abs=ROUNDING)
    assert high.max(0) == pytest.approx([4.0, 0.0, 3.0], abs=ROUNDING)
    assert high[0] == pytest.approx([3.0, 0.0, 2.0], abs=ROUNDING)
    assert mesh.spots["Corner"].tolist() == [8]


def test_instances_that_touch(tmp_path: Path) -> None:
    """They are refused with number, place and blocks, joined on request, or left apart."""
    above = CUBE.replace("3., 0., 2.\n3., 0., 2., 4., 0., 2., 90.", "0., 0., 2.")
    path = placed(tmp_path, {"two.inp": above})
    words = (
        r"4 pairs of nodes are within 0 of each other, .*, as node One.\d+ and node Two.\d+ at .*, of "
        r"One_Stone and Two_Stone.*--join"
    )
    with pytest.raises(ValueError, match=words):
        split(path)
    with pytest.raises(ValueError, match=r"0 of the 0 faces between blocks"):
        split(path, join=0.0)
    mesh = split(path, join=1e-6)
    assert mesh.summary().splitlines() == [
        "2 cells in 2 blocks, 12 nodes, 16 with joints",
        "block One_Stone: 1 cells", "block Two_Stone: 1 cells",
        "group Both: 2 cells", "group One_Foot: 1 faces, area 1", "group One_Side: 1 faces, area 2",
        "group Two_Foot: 1 faces, area 1", "group Two_Side: 1 faces, area 2", "group Corner: 1 nodes",
        "joint joint: 1 faces, area 1, 0 tips, N from One_Stone to Two_Stone",
    ]  # fmt: skip
    sides = {"One_Foot": 1.0, "Two_Foot": 1.0, "One_Side": 2.0, "Two_Side": 2.0}
    sides |= {"joint_minus": 1.0, "joint_plus": 1.0}
    assert groups(mesh) == {name: (1, pytest.approx(area)) for name, area in sides.items()}
    (written,) = write(tmp_path / "joined.inp", mesh)
    text = written.read_text(encoding="utf-8")
    for line in (
        "*Surface, type=element, name=One_Foot\n1, S1\n",
        "*Surface, type=element, name=joint_minus\n1, S2",
    ):
        assert line in text
    assert "*Surface, type=element, name=joint_plus\n2, S1\n" in text and "*Elset, elset=Both\n1, 2\n" in text


STRIP = """*Node
1, 0., 0.
2, 1., 0.
3, 0., 1.
4, 1., 1.
5, 0., 3.
6, 1., 3.
7, 0., 4.
8, 1., 4.
*Element, type=CPE4
1, 1, 2, 4, 3
2, 3, 4, 6, 5
3, 5, 6, 8, 7
*Elset, elset=ROCK
1
*Elset, elset=DAM
2, 3
"""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (STRIP + "*Elset, elset=CREST\n3\n",
         "1 of 3 cells are in two groups, as a cell at .0.5, 3.5. in CREST and DAM: .*--blocks DAM,ROCK"),
        (STRIP.replace("\n2, 3\n", "\n2\n"), r"1 of 3 cells are in no block, as a cell at \(0.5, 3.5\)"),
        (STRIP + "*Nfill\n1, 8, 1\n", r"strip.inp, line 18: \*Nfill: not read"),
        (STRIP.replace("CPE4", "COH2D4"), "nodes without elements: expected"),
        (STRIP.replace("*Elset, elset=DAM", "*Elsett, elset=DAM"), r"\*Elsett: unknown: expected \*Elset"),
        (STRIP.replace("elset=DAM", "elest=DAM"), r"\*Elset: parameter elest: expected elset"),
        (STRIP.replace("3, 5, 6, 8, 7", "2, 5, 6, 8, 7"), "element 2 is there before"),
        (STRIP.replace("3, 5, 6, 8, 7", "3, 5, 6, 8, 9"), r"\*Element: node 9: no such node"),
        (STRIP.replace("3, 5, 6, 8, 7", "3, 5, 6, 8"), "3 nodes of the last element .*: expected 4"),
        (STRIP.replace("\n2, 3\n", "\n2, 4\n"), r"\*Elset: element 4: no such element"),
        (STRIP.replace("\n2, 3\n", "\nMASS, 3\n"), r"line 17: MASS: expected a number or a set"),
        (STRIP.replace("1., 4.", "1., x"), r"line 9: 8, 1., x.*: expected numbers"),
        (STRIP + "*Include, input=loads.txt\n", r"input=loads.txt: no such file"),
        (STRIP + "*Surface, name=TOP\nDAM, S9\n", r"line 19: face S9 .* expected S1 to S4"),
        (STRIP.replace("0., 3.", "0., 1.").replace("1., 3.", "1., 1."), "1 of 3 cells .* no area, as cell 2"),
        (STRIP.replace("2, 3, 4, 6, 5", "2, 3, 4, 4, 5"), "have a node twice, as cell 2 of block DAM"),
        ("*Part, name=P\n" + STRIP + "*End Part\n*Assembly, name=A\n*End Assembly\n", "no elements"),
        ("*Part, name=P\n" + STRIP, r"\*Part: expected \*End Part after it"),
        ("*Assembly, name=A\n*Instance, name=I, part=P\n*End Instance\n", r"part=P: no such part .*: none"),
        (STRIP.replace(", 1.\n", ", 1., 0.5\n"), r"z from 0 to 0.5: expected a plane mesh"),
        (STRIP.replace("0., ", "0., 0., ").replace("1., ", "1., 0., "), "y constant: expected a plane mesh"),
    ],
)  # fmt: skip
def test_decks_that_are_refused(tmp_path: Path, text: str, words: str) -> None:
    """They name the line, the place or the block, and what was expected."""
    with pytest.raises(ValueError, match=words):
        split(placed(tmp_path, {"strip.inp": text}))


def test_blocks_that_are_chosen(tmp_path: Path) -> None:
    """--blocks names groups that are blocks; the others stay whole beside them."""
    path = placed(tmp_path, {"strip.inp": STRIP + "*Elset, elset=CREST\n3\n"})
    mesh = split(path, blocks="ROCK,DAM")
    assert mesh.names == ["ROCK", "DAM"] and mesh.sets["CREST"].tolist() == [2]
    assert mesh.joints["joint"][0].area.tolist() == [1.0]
    with pytest.raises(ValueError, match="blocks = SOIL: expected groups of the mesh: CREST, DAM, ROCK"):
        split(path, blocks="SOIL")


def test_left_out(tmp_path: Path) -> None:
    """A warning names parts without an instance, ties, elements that are no solids, cells turned round."""
    beam = "*Element, type=T2D2, elset=BAR\n9, 1, 2\n*Tie, name=T\na, b\n"
    with pytest.warns(ModelWarning) as caught:
        mesh = split(placed(tmp_path, {"strip.inp": STRIP.replace("1, 1, 2, 4, 3", "1, 3, 4, 2, 1") + beam}))
    texts = " | ".join(str(warning.message) for warning in caught)
    assert "1 elements of type T2D2 name faces or nodes only" in texts and "*Tie: not carried over" in texts
    assert "1 cells of negative area were turned round" in texts
    assert groups(mesh)["BAR"] == (1, 1.0)


MSH = """$MeshFormat
4.1 0 8
$EndMeshFormat
$PhysicalNames
4
1 4 "foot"
1 5 "rim"
2 1 "rock"
2 2 "dam"
$EndPhysicalNames
$Entities
0 3 2 0
1 0 0 0 3 0 0 2 4 5 0
2 0 2 0 3 2 0 1 5 0
3 0 1 0 3 1 0 0 0
1 0 0 0 3 1 0 1 1 0
2 0 1 0 3 2 0 1 2 0
$EndEntities
$Nodes
1 6 11 16
2 1 0 6
11
12
13
14
15
16
0 0 0
3 0 0
0 1 0
3 1 0
0 2 0
3 2 0
$EndNodes
$Elements
5 5 1 5
1 1 1 1
1 11 12
1 2 1 1
2 15 16
1 3 1 1
3 13 14
2 1 3 1
4 11 12 14 13
2 2 3 1
5 13 14 16 15
$EndElements
"""
"""Two squares 3 x 1; the lowest edge is in two groups, the one between them in none."""


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


def test_axes_of_opengeosys(tmp_path: Path) -> None:
    """In the plane they have two components and are right-handed."""
    write(tmp_path / "wall.vtu", split(placed(tmp_path, {"wall.msh": MSH})), "ogs", layer=0.01)
    read = meshio.read(tmp_path / "wall.vtu")
    axes = np.stack([np.concatenate(read.cell_data[name]) for name in ("N", "Tx")], 1)
    assert axes.shape == (3, 2, 2) and (np.linalg.det(axes) == 1.0).all()
    assert axes[2].tolist() == [[0.0, 1.0], [-1.0, 0.0]]


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
