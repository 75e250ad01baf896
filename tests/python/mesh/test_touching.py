"""Blocks that touch without common nodes, and nodes that are close."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from asperity import ModelWarning
from asperity.mesh import split, write

from mesh.support_meshes import CUBE, groups, placed


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


def bent(bend: float) -> str:
    """Four cubes on four, between whose upper ones and the lower ones one face is bent and has two wedges."""
    points = [(i, j, k) for k in range(3) for j in range(2) for i in range(3)]
    text = "*Node\n" + "".join(
        f"{n + 1}, {x}, {y}, {z if (x, y, z) != (2, 1, 1) else 1 + bend}\n"
        for n, (x, y, z) in enumerate(points)
    )
    at = {point: n + 1 for n, point in enumerate(points)}
    base = [(0, 0), (1, 0), (1, 1), (0, 1)]

    def cell(i: int, k: int, ends: tuple[int, ...] = (0, 1, 2, 3)) -> str:
        return ", ".join(str(at[i + base[n][0], base[n][1], k + up]) for up in (0, 1) for n in ends)

    text += f"*Element, type=C3D8, elset=LOWER\n1, {cell(0, 0)}\n2, {cell(1, 0)}\n"
    text += f"*Element, type=C3D8, elset=UPPER\n3, {cell(0, 1)}\n"
    return (
        text + f"*Element, type=C3D6, elset=UPPER\n4, {cell(1, 1, (0, 1, 2))}\n5, {cell(1, 1, (0, 2, 3))}\n"
    )


@pytest.mark.parametrize("bend", [0.0, 0.1])
def test_faces_that_are_divided_in_another_way(tmp_path: Path, bend: float) -> None:
    """Blocks with common nodes and no common faces would stay bonded, and are refused."""
    path = placed(tmp_path, {"bent.inp": bent(bend)})
    with pytest.raises(
        ValueError, match=r"expected (blocks that share their faces|faces that are divided in one way)"
    ):
        split(path)
    assert sum(len(part.area) for part in split(path, join=0.0).joints["joint"]) == 1


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
