"""Command `asperity mesh`: files, counts, refusals, files that are there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from asperity.cli import main

from mesh.support_meshes import grid, placed
from mesh.test_vtu import TWO

CASE = Path(__file__).parents[3] / "harness/cases/figure05b.nml"


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Reads a mesh, prints its counts, writes it; what it wrote it replaces."""
    grid((4, 2), (2, 1)).write(tmp_path / "wall.vtu")
    words = ["mesh", str(tmp_path / "wall.vtu"), "-o", str(tmp_path / "out.inp")]
    assert main([*words, "--joint", "bed=block_0:block_1", "--direction", "0", "1"]) == 0
    out = capsys.readouterr().out.splitlines()
    assert out[:-1] == [
        "8 cells in 2 blocks, 15 nodes, 18 with joints", "block block_0: 4 cells", "block block_1: 4 cells",
        "joint bed: 2 faces, length 2, 0 tips, N from block_1 to block_0",
    ]  # fmt: skip
    assert main([*words[:2], "-o", "x.mdpa", "--joint", "head=right~left"]) == 1
    assert "joint head: right: no such group of faces" in capsys.readouterr().err
    assert main([*words, "--joint", "bed"]) == 1
    assert "joint bed: bed: no such group of faces" in capsys.readouterr().err
    assert main([*words, "--law", "bed=case.nml"]) == 1
    for rule, text in (("--joint", "bed=block_0:block_1"), ("--law", f"bed={CASE}")):
        assert main([*words, rule, text, rule, text]) == 1
        assert "bed is given twice: expected one" in capsys.readouterr().err
    assert main(words) == 0
    assert main([*words[:2], "-o", words[1]]) == 1


def test_files_of_groups_that_are_there(said: Callable, folder: Path) -> None:
    """A file of something else is not replaced, one of this command is."""
    placed(folder, {"two.msh": TWO})
    (folder / "wall_corner.vtu").write_text("my own", encoding="utf-8")
    words = "mesh two.msh --blocks low,high -o wall.vtu"
    assert "wall_corner.vtu: this file is there and is not replaced" in said(words, 1)[1]
    assert not (folder / "wall.vtu").exists()
    (folder / "wall_corner.vtu").unlink()
    assert "wall_corner.vtu" in said(words)[0] and "wall_wet.vtu" in said(words)[0]
