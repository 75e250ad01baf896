"""Cohesive elements of decks: taken over as joints of a mesh, and checked by `asperity doctor`."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from asperity import ModelWarning
from asperity.cli import main
from asperity.mesh import split, write
from asperity.mesh.deck_joints import judged

from mesh.drawn_decks import LAW, MISTAKES, bonded, harmless, mistaken
from mesh.support_meshes import placed

DRAWN = 30
"""Drawn decks of the fast tests."""

EACH = 6
"""Drawn decks with each mistake."""

DIGITS = 1.0e-6
"""Relative error of areas of decks whose places have nine digits."""


def test_joints_of_decks(tmp_path: Path) -> None:
    """Elements of a deck are the joint: their faces, area and N; the crack beside them stays open."""
    for seed in range(DRAWN):
        drawn = bonded(np.random.default_rng([seed, 1]))
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", ModelWarning)
            mesh = split(placed(tmp_path, drawn.text))
            (written,) = write(tmp_path / "new.inp", mesh)
        parts = mesh.joints["JOINT"]
        assert list(mesh.joints) == ["JOINT"] and sum(len(part.area) for part in parts) == drawn.faces
        assert sum(part.area.sum() for part in parts) == pytest.approx(drawn.area, rel=DIGITS)
        assert len(mesh.points) == drawn.nodes and sum(map(len, mesh.cells.values())) == drawn.solids
        for part in parts:
            assert part.axes[:, 0] == pytest.approx(np.tile(drawn.normal, (len(part.area), 1)), abs=DIGITS)
            again = split(written)
            (twice,) = write(tmp_path / "twice.inp", again)
        text = written.read_text(encoding="utf-8")
        assert text.count("\n*Element, type=COH") == len(parts)
        assert again.summary() == mesh.summary()
        assert sorted(again.surfaces) == sorted(mesh.surfaces)
        assert twice.read_text(encoding="utf-8").count("\n") == text.count("\n")


def test_joints_without_solids(tmp_path: Path) -> None:
    """Elements that nothing connects with solids are refused with their line; so is what closes them."""
    loose = MISTAKES["no tie"](bonded(np.random.default_rng(3), tied=True).text)
    with pytest.raises(ValueError, match=r"line \d+: \*Element: .* do not lie between two solids that share"):
        split(placed(tmp_path, loose))
    path = placed(tmp_path, bonded(np.random.default_rng(4), tied=False).text)
    with pytest.raises(ValueError, match="the file has the joints JOINT, which it would close"):
        split(path, join=0.1)
    with pytest.raises(ValueError, match="joint JOINT: the file has this joint: expected another name"):
        split(path, {"JOINT": ("*", "*")})
    lower = bonded(np.random.default_rng(4), tied=False).text.replace("S_LOW", "JOINT_minus")
    with pytest.raises(ValueError, match="joint JOINT: a group is named JOINT_minus: expected another name"):
        split(placed(tmp_path, lower))


@pytest.mark.parametrize("kind", ["stitched", "stitched edge"])
def test_joints_that_are_stitched(tmp_path: Path, kind: str) -> None:
    """Nodes within a joint that both sides have are refused, with their place."""
    found = 0
    for seed in range(DRAWN):
        text = bonded(np.random.default_rng([seed, 2]), tied=False, ways=False).text
        stitched = MISTAKES[kind](text)
        if stitched != text:
            found += 1
            with pytest.raises(
                ValueError, match=r"line \d+: \*Element: [12] nodes within the joint, as at .* cannot open"
            ):
                split(placed(tmp_path, stitched))
    assert found > EACH


def beside_shells(*shells: str) -> str:
    """A cohesive element between two faces, each of a shell or of a solid."""
    text = "*Node\n" + "".join(
        f"{4 * k + i}, {x}, {y}, {z}\n"
        for k, z in enumerate((0.0, 0.0, -1.0, 1.0))
        for i, (x, y) in enumerate(((0, 0), (1, 0), (1, 1), (0, 1)), 1)
    )
    nodes = {"LOW": "9, 10, 11, 12, 1, 2, 3, 4", "UP": "5, 6, 7, 8, 13, 14, 15, 16"}
    faces = {"LOW": "1, 2, 3, 4", "UP": "5, 6, 7, 8"}
    for k, side in enumerate(nodes, 1):
        kind, row = ("S4R", faces[side]) if side in shells else ("C3D8", nodes[side])
        section = "Shell Section" if side in shells else "Solid Section"
        text += f"*Element, type={kind}, elset={side}\n{k}, {row}\n"
        text += f"*{section}, elset={side}, material=STONE\n{'0.1' if side in shells else ','}\n"
    text += "*Element, type=COH3D8, elset=JOINT\n3, 1, 2, 3, 4, 5, 6, 7, 8\n"
    text += LAW.card("abaqus", name="JOINT") + "*Material, name=STONE\n*Elastic\n30000., 0.2\n"
    return text + "*Step, unsymm=YES\n*Static\n*End Step\n"


def other_mesh() -> str:
    """Two cohesive elements with the nodes of the upper solids, tied to one solid twice as long."""
    text = "*Node\n" + "".join(
        f"{n}, {x}, {y}\n"
        for n, x, y in (
            *((1, 0, 0), (2, 2, 0), (3, 0, 1), (4, 2, 1)),
            *((10 * j + i, i - 1, y) for j, y in ((1, 1), (2, 2), (3, 1)) for i in (1, 2, 3)),
        )
    )
    text += "*Element, type=CPE4, elset=LOW\n1, 1, 2, 4, 3\n*Element, type=CPE4, elset=UP\n"
    text += "2, 11, 12, 22, 21\n3, 12, 13, 23, 22\n*Element, type=COH2D4, elset=JOINT\n"
    text += (
        "4, 31, 32, 12, 11\n5, 32, 33, 13, 12\n*Surface, name=ON\nLOW, S3\n*Surface, name=BELOW\nJOINT, S1\n"
    )
    text += "*Tie, name=T\nBELOW, ON\n*Solid Section, elset=LOW, material=STONE\n,\n"
    text += "*Solid Section, elset=UP, material=STONE\n,\n*Material, name=STONE\n*Elastic\n30000., 0.2\n"
    text += LAW.card("abaqus", name="JOINT", dimension=2)
    return text + "*Step, unsymm=YES\n*Static\n*End Step\n"


@pytest.mark.parametrize(
    ("text", "join"),
    [(beside_shells("UP"), None), (beside_shells("LOW", "UP"), None), (other_mesh(), 0.0)],
)
def test_other_meshes_and_shells(
    text: str, join: float | None, tmp_path: Path, said: Callable[..., tuple[str, str]]
) -> None:
    """Abaqus solves them, and doctor finds nothing; joints of other hosts need two solids: refused."""
    path = placed(tmp_path, text)
    said(f"doctor {path}")
    words = r"line \d+: .Element: \d of \d elements, .* two solids .* shells and other meshes are none"
    with pytest.raises(ValueError, match=words):
        split(path, join=join)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ("|", ""),
        ("1, 2, 3, 4, 5, 6, 7, 8|1, 3, 2, 4, 5, 7, 6, 8", "make edges that cross: expected the nodes around"),
        ("1, 2, 3, 4, 5, 6, 7, 8|1, 2, 3, 4, 17, 18, 19, 20", "are shifted along the joint"),
    ],
)
def test_places_of_nodes(
    change: str, words: str, tmp_path: Path, said: Callable[..., tuple[str, str]]
) -> None:
    """Nodes that go round both sides crosswise, and sides an edge apart along the joint, are mistakes."""
    old, _, row = change.partition("|")
    text = beside_shells("LOW", "UP").replace(f"3, {old}\n", f"3, {row}\n")
    text = text.replace("*Element", "17, 1, 0, 0\n18, 2, 0, 0\n19, 2, 1, 0\n20, 1, 1, 0\n*Element", 1)
    out, err = said(f"doctor {placed(tmp_path, text)}", code=int(bool(words)))
    assert words in out + err


def test_no_false_alarm(tmp_path: Path) -> None:
    """Drawn decks without a mistake pass."""
    for seed in range(DRAWN):
        draw = np.random.default_rng([seed, 2])
        judgement = judged(placed(tmp_path, harmless(draw, bonded(draw).text)))
        assert judgement.wrong + judgement.doubtful == [], seed


@pytest.mark.parametrize("kind", MISTAKES)
def test_mistakes(tmp_path: Path, kind: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Each mistake is told with the line and what was expected."""
    possible = (text for seed in range(9 * EACH) if (text := mistaken(seed, kind)) is not None)
    texts = list(islice(possible, EACH))
    assert len(texts) == EACH
    for text in texts:
        assert main(["doctor", str(placed(tmp_path, text))]) == 1
        said = "".join(capsys.readouterr())
        assert "job.inp, line " in said and "expected" in said
