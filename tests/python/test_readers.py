"""Small decks that libraries do not read, as this reader has them; what the page says of meshio."""

from __future__ import annotations

import re
import runpy
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from asperity.mesh.abaqus import read_deck

PROGRAM = Path(__file__).parents[2] / "harness" / "examples" / "lost_by_readers.py"
DECKS: dict[str, tuple[str, str]] = runpy.run_path(str(PROGRAM))["DECKS"]


@pytest.mark.parametrize("name", [name for name in DECKS if name != "cohesive"])
def test_own_reader(name: str, tmp_path: Path) -> None:
    """Nodes, their places, cells and names are those of Abaqus."""
    text, expected = DECKS[name]
    path = tmp_path / "deck.inp"
    path.write_text(text, encoding="utf-8")
    mesh = read_deck(path)
    cells = np.concatenate([entry.nodes for entry in mesh.cells if entry.kind == "quad"])
    x = mesh.points[np.unique(cells), 0]
    assert expected.startswith(f"{len(x)} nodes, x {x.min():g} to {x.max():g}, {len(cells)} cells")
    _, _, names = expected.partition("names ")
    assert {*names.split()} <= {*mesh.groups, *mesh.spots}


def test_what_meshio_reads(tmp_path: Path) -> None:
    """The program names each deck, and meshio ends none of its lines before the last."""
    pytest.importorskip("meshio")
    run = subprocess.run([sys.executable, PROGRAM], cwd=tmp_path, capture_output=True, text=True, check=True)
    assert re.findall(r"(?m)^(\w+)\.inp: ", run.stdout) == [*DECKS]
    assert run.stdout.count("    meshio: ") == len(DECKS)
    assert {path.stem for path in tmp_path.glob("*.inp")} == {*DECKS}
