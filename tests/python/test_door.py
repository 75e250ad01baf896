"""Solver and runs know the law through one door, and nothing of planes and constants."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
FOLDERS = (ROOT / "src" / folder for folder in ("solver", "run"))
#: A case file has constants and planes, which the modules of its reader know.
SOLVER = sorted(
    file for folder in FOLDERS for file in folder.glob("*.f90") if not file.stem.startswith("asperity_case")
)
#: What they may use of src/law: the door, types, texts and checks.
DOOR = {
    "asperity_call_checks",
    "asperity_checks",
    "asperity_contract",
    "asperity_elimination",
    "asperity_interface",
    "asperity_kinds",
    "asperity_pattern",
    "asperity_point_law",
    "asperity_rie_law",
    "asperity_text",
}
#: Names of constants in messages, and numbers of planes in the array of a state.
CONSTANTS = {
    "asperity_initial.f90": {"pattern%n", "material%guard"},
}


@pytest.mark.parametrize("file", SOLVER, ids=lambda file: file.stem)
def test_solver_knows_no_plane(file: Path) -> None:
    """A module uses solver, runs and the door, and no other constant than the listed ones."""
    text = re.sub(r"!.*", "", file.read_text(encoding="utf-8"))
    used = set(re.findall(r"^\s*use (?:, intrinsic ::)?\s*(asperity_\w+)", text, re.MULTILINE))
    assert used
    assert used <= DOOR | {other.stem for other in SOLVER}
    assert set(re.findall(r"\b(?:pattern|material)%\w+", text)) <= CONSTANTS.get(file.name, set())
    if "asperity_pattern" in used:
        names = re.findall(r"use asperity_pattern, only: (.*)", text)
        assert names == ["direction_vector"]
