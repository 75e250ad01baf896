"""Cohesive elements of decks: taken over as joints of a mesh, and checked by `asperity doctor`."""

from __future__ import annotations

import warnings
from itertools import islice
from pathlib import Path

import numpy as np
import pytest
from asperity import ModelWarning
from asperity.cli import main
from asperity.mesh import split, write
from asperity.mesh.deck_joints import judged
from drawn_decks import MISTAKES, bonded, harmless, mistaken

DRAWN = 30
"""Drawn decks of the fast tests."""

EACH = 6
"""Drawn decks with each mistake."""

DIGITS = 1.0e-6
"""Relative error of areas of decks whose places have nine digits."""


def placed(folder: Path, text: str) -> Path:
    """Write a deck."""
    path = folder / "job.inp"
    path.write_text(text, encoding="utf-8")
    return path


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
        text = written.read_text(encoding="utf-8")
        assert text.count("\n*Element, type=COH") == len(parts)


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
