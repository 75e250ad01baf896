"""A mesh of a file does not change."""

from __future__ import annotations

import warnings
from dataclasses import FrozenInstanceError
from pathlib import Path

import pytest
from asperity.mesh import split
from asperity.mesh.files import read_raw

from mesh.support_meshes import STRIP, placed


def test_a_mesh_of_a_file_is_constant(tmp_path: Path) -> None:
    """Neither its arrays nor its groups can be changed."""
    raw = read_raw(placed(tmp_path, {"strip.inp": STRIP}))
    with pytest.raises(ValueError, match="read-only"):
        raw.points[0] = 1.0
    with pytest.raises(ValueError, match="read-only"):
        raw.cells[0].nodes[0] = 1
    with pytest.raises(TypeError):
        raw.groups["ROCK"] = ()  # type: ignore[index]
    with pytest.raises(FrozenInstanceError):
        raw.points = raw.points  # type: ignore[misc]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert split(raw).names == ["DAM", "ROCK"]
