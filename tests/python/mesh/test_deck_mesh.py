"""Sets, types and loads of decks when nodes are joined and doubled: names stay apart, and so do sides."""

from __future__ import annotations

import warnings
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from asperity import ModelWarning
from asperity.mesh import split, write

from harness.hosts import structured
from mesh.support_meshes import placed

PLATE = """*Node
1, 0., 0.
2, 2., 0.
3, 0., 1.
4, 2., 1.
5, 0., 3.
6, 2., 3.
*Element, type=CPS4R, elset=ROCK
1, 1, 2, 4, 3
*Element, type=CPE4, elset=DAM
2, 3, 4, 6, 5
"""
"""Two blocks, 2 x 1 and 2 x 2, which share the nodes 3 and 4."""


def sets(path: Path) -> dict[str, list[str]]:
    """Lines of data of each block of a deck, by its line of the keyword."""
    blocks: dict[str, list[str]] = {}
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("*"):
            rows = blocks.setdefault(line, [])
        else:
            rows.append(line)
    return blocks


def test_nodes_and_faces_of_one_name(tmp_path: Path) -> None:
    """A set of nodes keeps its nodes where a surface has its name, in any case, and other nodes."""
    surface = "*Surface, name=top\nDAM, S3\n"
    with pytest.warns(ModelWarning, match="top is a set of nodes .* the faces are top_faces"):
        mesh = split(placed(tmp_path, PLATE + surface + "*Nset, nset=TOP\n6\n"))
    [written] = write(tmp_path / "out.inp", mesh)
    blocks = sets(written)
    assert blocks["*Nset, nset=TOP"] == ["6"]
    assert blocks["*Surface, type=element, name=top_faces"] == [
        "1, S3"
    ]  # the cells are in the order of the blocks
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh = split(placed(tmp_path, PLATE + surface + "*Nset, nset=TOP\n6, 5\n"))
    assert list(mesh.groups) == ["TOP"] and mesh.nodes("TOP").tolist() == [4, 5]


@pytest.mark.parametrize(
    ("text", "joint", "words"),
    [
        ("*Elset, elset=joint\n2\n", None, "joint joint: a group of cells has this name: .*--joint NAME="),
        ("*Elset, elset=JOINT\n2\n", None, "sets of elements JOINT and joint: one name for abaqus"),
        ("", "rock", "sets of elements ROCK and rock: one name for abaqus"),
    ],
)
def test_names_that_abaqus_takes_for_one(tmp_path: Path, text: str, joint: str | None, words: str) -> None:
    """They are refused: a section of the joint would be that of solids, too."""
    rules = {joint: ("*", "*")} if joint else None
    with pytest.raises(ValueError, match=words):
        write(tmp_path / "out.inp", split(placed(tmp_path, PLATE + text), rules, "ROCK,DAM"))


def test_sets_of_whole_instances(tmp_path: Path) -> None:
    """A set of all elements of a part is no block beside those that divide it, in one instance or more."""
    part = f"*Part, name=P\n{PLATE}*Elset, elset=EACH\nROCK, DAM\n*End Part\n*Assembly, name=X\n"
    placing = "*Instance, name=A, part=P\n*End Instance\n*Instance, name=B, part=P\n9.\n*End Instance\n"
    mesh = split(placed(tmp_path, f"{part}{placing}*End Assembly\n"))
    assert mesh.names == ["A_DAM", "A_ROCK", "B_DAM", "B_ROCK"]
    assert {name: len(cells) for name, cells in mesh.sets.items()} == {"A_EACH": 2, "B_EACH": 2}
    alone = (
        part.replace("*Elset, elset=EACH\nROCK, DAM\n", "").replace(", elset=ROCK", "").replace("DAM", "EACH")
    )
    alone = alone.replace("*Element, type=CPE4, elset=EACH", "*Element, type=CPE4")
    alone = alone.replace("*End Part", "*Elset, elset=EACH\n1, 2\n*End Part")
    with pytest.raises(ValueError, match=r"joint joint: 0 of the 0 faces between blocks.* A_EACH, B_EACH"):
        split(placed(tmp_path, f"{alone}{placing}*End Assembly\n"))


def test_sets_of_instances_of_one_name(tmp_path: Path) -> None:
    """The names that two sets get from their instances are not one."""
    part = f"*Part, name=P\n{PLATE}*Nset, nset=C\n1\n*Nset, nset=B_C\n2\n*End Part\n*Assembly, name=X\n"
    text = "*Instance, name=A, part=P\n*End Instance\n*Instance, name=A_B, part=P\n9.\n*End Instance\n"
    with pytest.raises(ValueError, match=r"sets A.B_C and A_B.C both become A_B_C"):
        split(placed(tmp_path, f"{part}{text}*End Assembly\n"))


def test_types_of_solids(tmp_path: Path) -> None:
    """Types of solids are kept, for plane stress and reduced integration; shells become plane strain."""
    [written] = write(tmp_path / "out.inp", split(placed(tmp_path, PLATE)))
    assert "*Element, type=CPS4R, elset=ROCK" in sets(written)
    assert "*Element, type=CPE4, elset=DAM" in sets(written)
    mesh = split(placed(tmp_path, PLATE.replace("CPS4R", "S4R")))
    with pytest.warns(ModelWarning, match="1 elements of the types S4R become CPE4"):
        write(tmp_path / "shell.inp", mesh)


def test_other_middles(tmp_path: Path) -> None:
    """Faces that share their corners and no nodes between them are refused: they would part."""
    nodes = "1,0,0\n2,1,0\n3,1,1\n4,0,1\n5,.5,0\n6,1,.5\n7,.5,1\n8,0,.5\n9,1,2\n10,0,2\n11,1,1.5\n12,.5,2\n"
    cells = "*Element, type=CPE8, elset=A\n1,1,2,3,4,5,6,7,8\n*Element, type=CPE8, elset=B\n"
    deck = f"*Node\n{nodes}13,0,1.5\n14,.5,1\n{cells}2,4,3,9,10,{{}},11,12,13\n"
    assert split(placed(tmp_path, deck.format(7))).joints["joint"][0].minus.shape == (1, 3)
    with pytest.raises(ValueError, match=r"1 pairs of faces have common corners .* as at \(0.5, 1\)"):
        split(placed(tmp_path, deck.format(14)))
    mesh = split(placed(tmp_path, deck.format(14)), join=1e-6)
    assert len(mesh.points) == 16  # 13, three of them doubled


def test_folded_cells(tmp_path: Path) -> None:
    """Cells on one side of their common face overlap, although each has an area once it is turned."""
    folded = PLATE.replace("5, 0., 3.", "5, 0.3, -4.").replace("6, 2., 3.", "6, 1.7, -4.")
    with pytest.warns(ModelWarning, match="1 cells of negative area were turned round"):
        with pytest.raises(ValueError, match=r"1 pairs of cells overlap, .* as at \(1, 1\)"):
            split(placed(tmp_path, folded))


def test_numbers_that_generate_finds_none_of(tmp_path: Path) -> None:
    """They are counted in a warning, however many they are."""
    text = PLATE + "*Nset, nset=LEFT, generate\n1, 1000000000001, 2\n"
    with pytest.warns(
        ModelWarning, match="line 12: .Nset: 499999999998 of 500000000001 numbers are no nodes"
    ):
        mesh = split(placed(tmp_path, text))
    assert mesh.origin[mesh.nodes("LEFT")].tolist() == [0, 2, 4, 2]


def test_continued_keywords_and_names_in_quotes(tmp_path: Path) -> None:
    """A comment may stand between the lines of a keyword, a comma in the quoted name of a file."""
    head = PLATE.replace("*Element, type=CPE4, elset=DAM", "*Element, type=CPE4,\n** a comment\n elset=DAM")
    (tmp_path / "sets, new.inc").write_text("*Nset, nset=FOOT\n1, 2\n", encoding="utf-8")
    mesh = split(placed(tmp_path, f'{head}*Include, input="sets, new.inc"\n'))
    assert mesh.names == ["DAM", "ROCK"] and mesh.nodes("FOOT").tolist() == [0, 1]


def test_loads_and_nodes_that_are_doubled(tmp_path: Path) -> None:
    """Loads that are left out are named; the summary has the nodes of a set before and after."""
    step = "*Nset, nset=MID\n3, 4, 5\n*Step\n*Static\n*Boundary\nMID, 1\n*Cload\nMID, 2, -1.\n*End Step\n"
    with pytest.warns(ModelWarning, match=r"\*Boundary, \*Cload: not carried over: .* a joint doubles both"):
        mesh = split(placed(tmp_path, PLATE + step))
    assert "group MID: 5 nodes, 3 of them in the mesh before" in mesh.summary()


def test_sets_of_joined_instances(tmp_path: Path) -> None:
    """Nodes and faces of a set of an instance are those of its side after they are joined and doubled."""
    cube = "*Node\n1,0,0\n2,2,0\n3,2,1\n4,0,1\n*Element, type=CPE4, elset=STONE\n1,1,2,3,4\n"
    part = f"*Part, name=P\n{cube}*Nset, nset=FOOT\n1, 2\n*Surface, name=BED\nSTONE, S1\n*End Part\n"
    text = "*Instance, name=A, part=P\n*End Instance\n*Instance, name=B, part=P\n0., 1.\n*End Instance\n"
    mesh = split(placed(tmp_path, f"{part}*Assembly, name=X\n{text}*End Assembly\n"), join=1e-6)
    [joint] = mesh.joints["joint"]
    assert sorted(mesh.nodes("B_FOOT")) == sorted(joint.plus.ravel())
    assert mesh.surfaces["B_BED"].tolist() == [[1, 1]] == mesh.surfaces["joint_plus"].tolist()
    assert len(mesh.nodes("A_FOOT")) == 2 and len(mesh.points) == 8


@pytest.mark.parametrize(("gap", "touches"), [(9e-4, True), (-9e-4, True), (2e-3, False)])
def test_rounded_places(tmp_path: Path, gap: float, touches: bool) -> None:
    """Nodes that miss each other by the digits of a file are refused, and joined; a gap is one."""
    nodes = f"7, 0., {1.0 + gap!r}\n8, 2., {1.0 + gap!r}\n"
    text = PLATE.replace("5, 0., 3.", nodes + "5, 0., 3.").replace("2, 3, 4, 6, 5", "2, 7, 8, 6, 5")
    path = placed(
        tmp_path, text + "*Element, type=CPE4, elset=ROOF\n3, 5, 6, 10, 9\n*Node\n9,0.,4.\n10,2.,4.\n"
    )
    if touches:
        with pytest.raises(
            ValueError,
            match=r"2 pairs of nodes are within 0.0009 .*--join 0.0009 makes them one; .* --join 0 leaves",
        ):
            split(path)
        assert len(split(path, join=1e-3).joints["joint"][0].area) == 2
    else:
        assert len(split(path).joints["joint"][0].area) == 1


FACES = {
    4: ((1, 2), (2, 3), (3, 4), (4, 1)),
    8: ((1, 2, 3, 4), (5, 8, 7, 6), (1, 5, 6, 2), (2, 6, 7, 3), (3, 7, 8, 4), (4, 8, 5, 1)),
}
"""Nodes of the faces S1, S2, ... of CPE4 and C3D8, as the manual of Abaqus has them."""

Place = tuple[float, ...]


def drawn(seed: int) -> tuple[str, dict[str, set[Place]], dict[str, Counter[frozenset[Place]]]]:
    """Deck of a grid of blocks with random numbers, sets of nodes and surfaces; their places."""
    draw = np.random.default_rng(seed)
    d = int(draw.integers(2, 4))
    whole = structured.grid(*[np.cumsum(draw.uniform(0.5, 1.5, 4)).round(3) for _ in range(d)], sides=())
    points, cells = whole.points[:, :d], whole.cells[0].data
    node, cell = draw.permutation(len(points)) + 5, draw.permutation(len(cells)) + 3
    block = np.concatenate([[0, 1], draw.integers(0, 2, len(cells) - 2)])
    place = [tuple(x) for x in points.tolist()]
    text = "*Node\n" + "".join(f"{n}, {', '.join(map(repr, x))}\n" for n, x in zip(node, place, strict=True))
    for k in (0, 1):
        text += f"*Element, type={'CPE4' if d == 2 else 'C3D8'}, elset=B{k}\n"
        for c in np.flatnonzero(block == k):
            text += ", ".join(map(str, [cell[c], *node[cells[c]]])) + "\n"
    nodes, surfaces = {}, {}
    for k in range(3):
        chosen = draw.choice(len(points), int(draw.integers(1, len(points))), replace=False)
        nodes[f"N{k}"] = {place[n] for n in chosen}
        text += f"*Nset, nset=N{k}\n" + "".join(f"{node[n]}\n" for n in chosen)
        rows = {(int(draw.integers(len(cells))), int(draw.integers(2 * d))) for _ in range(6)}
        faces = [frozenset(place[cells[c][i - 1]] for i in FACES[2**d][side]) for c, side in rows]
        surfaces[f"S{k}"] = Counter(faces)
        text += f"*Surface, name=S{k}\n" + "".join(f"{cell[c]}, S{side + 1}\n" for c, side in rows)
    return text, nodes, surfaces


@pytest.mark.parametrize("seed", range(20))
def test_drawn_sets(tmp_path: Path, seed: int) -> None:
    """In the file that is written sets have all nodes at their places, surfaces the given faces."""
    text, nodes, surfaces = drawn(seed)
    [written] = write(tmp_path / "out.inp", split(placed(tmp_path, text)))
    blocks = sets(written)
    at, corners = {}, {}
    for head, rows in blocks.items():
        for row in rows:
            number, *words = row.split(", ")
            if head == "*Node":
                at[number] = tuple(map(float, words))
            elif head.startswith("*Element") and "COH" not in head:
                corners[number] = words
    copies = Counter(at.values())
    for name, places in nodes.items():
        numbers = [word for row in blocks[f"*Nset, nset={name}"] for word in row.split(", ")]
        assert Counter(at[n] for n in numbers) == {x: copies[x] for x in places}
    for name, faces in surfaces.items():
        rows = [row.split(", S") for row in blocks[f"*Surface, type=element, name={name}"]]
        cells = [(corners[c], FACES[len(corners[c])][int(side) - 1]) for c, side in rows]
        assert Counter(frozenset(at[words[i - 1]] for i in face) for words, face in cells) == faces
    assert len(at) > len(set(at.values()))


def test_all_nodes_of_a_block(tmp_path: Path) -> None:
    """A set of all nodes of a group of cells keeps those of its cells when others are doubled."""
    text = "*Nset, nset=ROCK, elset=ROCK\n*Nset, nset=ALL\n1, 2, 3, 4, 5, 6\n*Nset, nset=FEW\n1, 3, 4\n"
    mesh = split(placed(tmp_path, PLATE + text))
    rock = mesh.cells["quad"][mesh.block["quad"] == mesh.names.index("ROCK")]
    assert mesh.nodes("ROCK").tolist() == sorted(rock.ravel())
    assert [len(mesh.nodes(name)) for name in ("ROCK", "ALL", "FEW")] == [4, 8, 5]
