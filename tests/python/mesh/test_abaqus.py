"""Decks of other programs: what is no solid and no face is left out by name, or refused with a way out."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from asperity import ModelWarning
from asperity.mesh import split, write

from mesh.test_files import MSH, STRIP, groups, placed

COLUMN = """*Node
1, 0., 0., 0.
2, 1., 0., 0.
3, 1., 1., 0.
4, 0., 1., 0.
5, 0., 0., 1.
6, 1., 0., 1.
7, 1., 1., 1.
8, 0., 1., 1.
9, 0., 0., 2.
10, 1., 0., 2.
11, 1., 1., 2.
12, 0., 1., 2.
*Element, type=C3D8, elset=ROCK
777, 1, 2, 3, 4, 5, 6, 7, 8
*Element, type=C3D8, elset=DAM
778, 5, 6, 7, 8, 9, 10, 11, 12
*Surface, name=CREST
DAM, S2
"""
"""Two cubes, one above the other."""

BED = "*Element, type=S4, elset=BED\n90, 5, 6, 7, 8\n"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("*Surface, type=CYLINDER, name=BAD\nSTART, 1., 0.\nLINE, 1., 2.\n",
         r"column.inp, line 20: \*Surface: type=CYLINDER: expected faces of elements"),
        ("*Surface, name=BAD, combine=union\nCREST\n", r"combine: expected lines of sets and faces"),
        ("*Surface, name=BAD\nDAM,\n", r"line 21: all free faces of elements of 8 nodes: expected S1 to S6"),
        (BED + "*Surface, name=BAD\nBED, SPOS\n",
         r"line 23: SPOS of elements of type S4: their element sets are groups of faces"),
        (BED + "*Surface, name=BAD\nBED, S1\n", r"S1 of elements of type S4: their element sets are groups"),
        ("*Surface, name=BAD\nDAM, S1\nROCK, E1\n", r"line 22: E1 of elements of 8 nodes: expected S1 to S6"),
    ],
)  # fmt: skip
def test_surfaces_that_are_left_out(tmp_path: Path, text: str, words: str) -> None:
    """A surface that no joint needs is named in a warning; a joint that needs it is refused."""
    path = placed(tmp_path, {"column.inp": COLUMN + text})
    with pytest.warns(ModelWarning, match=f"surface BAD is left out: .*{words}"):
        mesh = split(path)
    assert groups(mesh)["CREST"] == (1, 1.0) and "BAD" not in groups(mesh)
    assert mesh.joints["joint"][0].area.tolist() == [1.0]
    with (
        pytest.warns(ModelWarning),
        pytest.raises(ValueError, match=f"joint BAD: surface BAD is not read: .*{words}"),
    ):
        split(path, {"BAD": None})


def test_edges_of_plane_shells(tmp_path: Path) -> None:
    """E1, E2, ... of shells in the plane are faces; their S1 is a side, and no edge."""
    shells = STRIP.replace("CPE4", "S4R") + "*Surface, name=TOP\n3, E3\n"
    assert groups(split(placed(tmp_path, {"strip.inp": shells})))["TOP"] == (1, 1.0)
    with pytest.warns(ModelWarning, match="S3 of elements of type S4R: expected E1, E2, ..., their edges"):
        mesh = split(placed(tmp_path, {"strip.inp": shells.replace("E3", "S3")}))
    assert "TOP" not in groups(mesh)


OTHERS = """*Node, nset=ANCHOR
20, 5., 5., 5.
*Element, type=MASS, elset=CRANE
91, 9
*Element, type=SPRINGA, elset=TIES
92, 9, 20
93, 10, 20
*Element, type=CONN3D2, elset=WIRES
94, , 20
95, 9,
*Element, type=GAPUNI, elset=STOPS
96, 9, 20
*Element, type=CIN3D8, elset=FAR
97, 1, 2, 3, 4, 1, 2,
3, 4
*Element, type=CIN3D18R, elset=FAR
98, 1, 2, 3, 4, 1, 2, 3, 4, 1, 2, 3, 4, 1, 2, 3,
4, 1, 2
*Elset, elset=ALL, generate
1, 1000
*Nset, nset=HELD, elset=TIES
"""


def test_elements_that_are_left_out(tmp_path: Path) -> None:
    """Elements that are no solids are counted by type; sets keep their solids, and their nodes."""
    with pytest.warns(ModelWarning) as caught:
        mesh = split(placed(tmp_path, {"column.inp": COLUMN + OTHERS}))
    texts = [str(warning.message) for warning in caught]
    for count, name, what in (
        (1, "MASS", "masses"), (2, "SPRINGA", "springs or dashpots"), (2, "CONN3D2", "connectors"),
        (1, "GAPUNI", "gaps"), (1, "CIN3D8", "infinite elements"), (1, "CIN3D18R", "infinite elements"),
    ):  # fmt: skip
        assert any(
            f"{count} elements of type {name}, {what}, are left out: what they" in text for text in texts
        )
    assert any("group HELD: 1 of its 3 nodes are in no cell" in text for text in texts)
    assert mesh.names == ["DAM", "ROCK"] and "ALL" in mesh.sets and len(mesh.sets["ALL"]) == 2
    assert mesh.points[mesh.nodes("HELD")].tolist() == [[0.0, 0.0, 2.0], [1.0, 0.0, 2.0]]
    assert not {"CRANE", "TIES", "WIRES", "STOPS", "FAR"} & {*mesh.names, *mesh.sets, *mesh.groups}


@pytest.mark.parametrize(
    ("kind", "words"),
    [
        ("C3D15", r"line 20: \*Element: type=C3D15: not read: expected C3D6: convert them"),
        ("COH3D8", "1 of 1 elements, as at .*, do not lie between two solids that share their nodes"),
        ("CGAX4R", "type=CGAX4R: not read: axisymmetric: expected a plane mesh or one in space, or CAX4"),
        ("C3D5", "pyramids: expected tetrahedra, wedges or hexahedra: convert them"),
        ("DC3D8", "type=DC3D8: not read: expected CPE3 .*: convert them, or remove these lines"),
    ],
)
def test_solids_that_are_not_read(tmp_path: Path, kind: str, words: str) -> None:
    """They are refused with a way out, but not in a part without an instance, which nobody needs."""
    solids = f"*Element, type={kind}, elset=X\n1, 1, 2, 3, 4, 5, 6, 7, 8\n"
    with pytest.raises(ValueError, match=words):
        split(placed(tmp_path, {"column.inp": COLUMN + solids}))
    part = f"*Part, name=P\n*Node\n1, 0., 0., 0.\n{solids}*End Part\n"
    with pytest.warns(ModelWarning, match="part P has no instance"):
        mesh = split(placed(tmp_path, {"column.inp": part + COLUMN}))
    assert mesh.names == ["DAM", "ROCK"]


def test_cells_by_their_numbers(tmp_path: Path) -> None:
    """Messages have the numbers of the file, with the instance, and none for a mesh without."""
    double = COLUMN.replace("778, 5, 6, 7, 8, 9, 10, 11, 12", "778, 5, 6, 7, 7, 9, 10, 11, 11")
    words = (
        "1 of 2 cells .hexahedron. have a node twice, as cell 778 of block DAM at .*wedges or tetrahedra as"
    )
    with pytest.raises(ValueError, match=words):
        split(placed(tmp_path, {"column.inp": double}))
    part = f"*Part, name=P\n{double}*End Part\n*Assembly, name=A\n*Instance, name=I, part=P\n*End Instance\n"
    with pytest.raises(ValueError, match=r"as cell I.778 of block DAM"):
        split(placed(tmp_path, {"column.inp": part + "*End Assembly\n"}))
    with pytest.raises(ValueError, match=r"1 of 2 cells .quad. have a node twice, as cell 5 of block dam at"):
        split(placed(tmp_path, {"wall.msh": MSH.replace("5 13 14 16 15", "5 13 14 14 15")}))


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


def apart(gap: float, size: float = 1.0) -> str:
    """Two squares with a gap between them, and a third one at the same place as the second."""
    y = [0.0, size, size + gap, 2 * size + gap, 2 * size + gap, 3 * size + gap]
    nodes = "".join(f"{2 * k + i + 1}, {i * size!r}, {y[k]!r}\n" for k in range(6) for i in (0, 1))
    cells = [
        f"*Element, type=CPE4, elset=B{k}\n{k + 1}, {4 * k + 1}, {4 * k + 2}, {4 * k + 4}, {4 * k + 3}\n"
        for k in range(3)
    ]
    return f"*Node\n{nodes}{''.join(cells)}"


@pytest.mark.parametrize("gap", [0.0014, 0.05, 0.00123456])
def test_advice_for_nodes_that_are_close(tmp_path: Path, gap: float) -> None:
    """The advice joins all that the message counts; the other one leaves a gap, and joins the rest."""
    size = 2.0 * gap / 0.001
    path = placed(tmp_path, {"apart.inp": apart(gap, size)})
    with pytest.raises(ValueError, match=r"4 pairs of nodes .*; if this is a gap, --join 0 leaves") as why:
        split(path)
    (text,) = re.findall(r"--join (\S+) makes", str(why.value))
    assert gap <= float(text) <= 1.1 * gap
    assert sum(len(part.area) for part in split(path, join=float(text)).joints["joint"]) == 2
    with pytest.warns(ModelWarning, match="2 pairs of nodes .*a gap between them"):
        assert sum(len(part.area) for part in split(path, join=gap / 50.0).joints["joint"]) == 1
    with pytest.raises(ValueError, match=r"if this is a gap, --join (\S+) leaves") as why:
        split(path, join=gap / 5.0)
    (text,) = re.findall(r"--join (\S+) leaves", str(why.value))
    with pytest.warns(ModelWarning, match="a gap between them"):
        split(path, join=float(text))


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


def test_many_blocks_and_sets(tmp_path: Path) -> None:
    """Node sets of all nodes of many blocks keep those of their cells, as one of a single block does."""
    n = 12
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1) + 1
    text = "*Node\n" + "".join(f"{number[j, i]}, {i}., {j}.\n" for j in range(n + 1) for i in range(n + 1))
    for j in range(n):
        for i in range(n):
            nodes = number[j, i], number[j, i + 1], number[j + 1, i + 1], number[j + 1, i]
            listed = ", ".join(map(str, nodes))
            text += f"*Element, type=CPE4, elset=B{j}_{i}\n{j * n + i + 1}, {listed}\n"
            text += f"*Nset, nset=N{j}_{i}\n{listed}\n*Surface, name=S{j}_{i}\nB{j}_{i}, S2\n"
    mesh = split(placed(tmp_path, {"many.inp": text}))
    assert len(mesh.points) == 4 * n * n and sum(len(part.area) for part in mesh.joints["joint"]) == 2 * n * (
        n - 1
    )
    [cells] = mesh.cells.values()
    areas = groups(mesh)
    for k, name in enumerate(mesh.names):
        assert set(mesh.nodes(f"N{name[1:]}")) == set(cells[mesh.block["quad"] == k].ravel())
        assert areas[f"S{name[1:]}"] == (1, 1.0)


def test_bars_and_skins_of_an_instance(tmp_path: Path) -> None:
    """An instance with elements that are no solids names no group, as hosts refuse the colon of its name."""
    bars = BED.replace("BED", "SKIN") + "*Element, type=T3D2, elset=BARS\n91, 1, 2\n"
    part = f"*Part, name=P\n{COLUMN}{bars}*End Part\n*Assembly, name=A\n"
    part += "*Instance, name=I, part=P\n*End Instance\n"
    with pytest.warns(ModelWarning):
        mesh = split(placed(tmp_path, {"column.inp": part + "*End Assembly\n"}))
    assert set(mesh.groups) == {"SKIN", "BARS", "CREST"}
    [written] = write(tmp_path / "out.inp", mesh)
    assert "instance" not in written.read_text(encoding="utf-8")


def test_a_part_of_a_set_is_no_block(tmp_path: Path) -> None:
    """A set of the user and one that a program names are no blocks together."""
    text = STRIP.replace("*Elset, elset=ROCK\n1\n*Elset, elset=DAM\n2, 3\n", "")
    sets = "*Elset, elset=_rest\n1\n*Elset, elset=UPPER\n2, 3\n*Elset, elset=ALL\n_rest, UPPER\n"
    with pytest.raises(ValueError, match=r"2 of 3 cells are in two groups, .* in ALL and UPPER"):
        split(placed(tmp_path, {"strip.inp": text + sets}))


@pytest.mark.parametrize("nodes", ["4, 7, 3", "4, 3, 7", "3, 7, 4"])
def test_edges_of_three_nodes(tmp_path: Path, nodes: str) -> None:
    """Trusses name edges with the middle second, as gmsh and Abaqus write them, or last."""
    text = "1,0,0\n2,1,0\n3,1,1\n4,0,1\n5,.5,0\n6,1,.5\n7,.5,1\n8,0,.5\n9,1,2\n10,0,2\n11,1,1.5\n12,.5,2\n"
    text += "13,0,1.5\n*Element, type=CPE8, elset=A\n1,1,2,3,4,5,6,7,8\n"
    cells = "*Element, type=CPE8, elset=B\n2,4,3,9,10,7,11,12,13\n"
    deck = f"*Node\n{text}{cells}*Element, type=T3D3, elset=BED\n9, {nodes}\n"
    with pytest.warns(ModelWarning, match="1 elements of type T3D3 name faces"):
        mesh = split(placed(tmp_path, {"edges.inp": deck}), {"BED": None})
    assert mesh.joints["BED"][0].area.tolist() == [1.0]
