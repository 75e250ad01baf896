"""Decks of other programs: what is no solid and no face is left out by name, or refused with a way out."""

from __future__ import annotations

from pathlib import Path

import pytest
from asperity import ModelWarning
from asperity.mesh import split, write
from asperity.mesh.abaqus import read_deck

from mesh.support_meshes import CUBE, MSH, ROUNDING, STRIP, groups, placed

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


def test_parts_moved_and_turned(tmp_path: Path) -> None:
    """An instance is moved and then turned, and each has nodes of its own."""
    mesh = read_deck(placed(tmp_path, {"two.inp": CUBE}))
    low, high = mesh.points[:8], mesh.points[8:]
    assert low.min(0).tolist() == [0.0, 0.0, 0.0] and low.max(0).tolist() == [1.0, 1.0, 2.0]
    assert high.min(0) == pytest.approx([3.0, -2.0, 2.0], abs=ROUNDING)
    assert high.max(0) == pytest.approx([4.0, 0.0, 3.0], abs=ROUNDING)
    assert high[0] == pytest.approx([3.0, 0.0, 2.0], abs=ROUNDING)
    assert mesh.spots["Corner"].tolist() == [8]


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


def test_left_out(tmp_path: Path) -> None:
    """A warning names parts without an instance, ties, elements that are no solids, cells turned round."""
    beam = "*Element, type=T2D2, elset=BAR\n9, 1, 2\n*Tie, name=T\na, b\n"
    with pytest.warns(ModelWarning) as caught:
        mesh = split(placed(tmp_path, {"strip.inp": STRIP.replace("1, 1, 2, 4, 3", "1, 3, 4, 2, 1") + beam}))
    texts = " | ".join(str(warning.message) for warning in caught)
    assert "1 elements of type T2D2 name faces or nodes only" in texts and "*Tie: not carried over" in texts
    assert "1 cells of negative area were turned round" in texts
    assert groups(mesh)["BAR"] == (1, 1.0)
