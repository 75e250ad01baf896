"""Steps by passes on FEniCSx: those of the law, also where Newton's method stops, with their errors."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from on_ranks import RANKS, WITH_FENICSX, done_by

pytestmark = WITH_FENICSX

DRY = "--wall SW30 --elements 2 2 --tolerance 1e-5 --step 0.1 --most 0.5"

HALF = 0.45, 0.65
"""Share that the factor of a symmetric matrix has of that of any other; the diagonal counts more there."""

FIXED = "--elements 2 2 --step 0.1 --most 4 --tau 0.05 --to 0.1 0.2 0.3 0.4 0.5"
"""Fixed steps, as long as none is cut; they are too short to be halved for their energies."""


def wall(words: str, out: Path, ranks: int = 1, status: int = 0) -> tuple[np.ndarray, dict, str]:
    """Rows, summary and messages of a run that ends with a status."""
    done = done_by(f"{words} --out {out}", ranks=ranks)
    assert done.returncode == status, done.stderr
    return np.loadtxt(out, delimiter=",", skiprows=1, ndmin=2), json.loads(done.stdout), done.stderr


@pytest.mark.parametrize("ranks", RANKS)
def test_passes_find_the_step_of_the_law(ranks: int, tmp_path: Path) -> None:
    """Passes end at the forces of Newton's method, within the error that they report."""
    newton, whole, _ = wall(FIXED, tmp_path / "newton.csv")
    passes, summary, _ = wall(f"{FIXED} --always --passes 20", tmp_path / "passes.csv", ranks)
    assert summary["by_passes"] == len(passes) == len(newton)
    forces = np.abs(newton[:, 1:3]).sum(axis=1)
    assert (np.abs(passes - newton)[:, 1:3].max(axis=1) <= 2.0 * (passes[:, 7] + 1e-4) * forces).all()
    assert passes[:, 7].max() < 1e-3
    assert HALF[0] < summary["entries"] / whole["entries"] < HALF[1]


def test_a_dry_wall_without_drag(tmp_path: Path) -> None:
    """Blocks that lie in no contact for an iteration stop neither Newton's method nor passes.

    A drag of 1e-6 N/mm3 changes the forces by less than 0.5 %.
    """
    slow, _, _ = wall(f"{DRY} --to 2 --drag 1e-6", tmp_path / "slow.csv")
    newton, alone, _ = wall(f"{DRY} --to 2 --passes 0", tmp_path / "newton.csv")
    passes, summary, _ = wall(f"{DRY} --to 2 --always", tmp_path / "passes.csv")
    assert alone["by_passes"] == 0 and summary["by_passes"] == len(passes)
    for rows in (newton, passes):
        assert rows[-1, 1:3] == pytest.approx(slow[-1, 1:3], rel=5e-3)
    assert (newton[:, 5:] == 0.0).all() and (passes[:, 7] <= 0.01).all()


def test_an_error_of_a_step_that_is_not_shortest(tmp_path: Path) -> None:
    """A step whose last pass leaves an error above the limit is repeated until it is as short as a snap."""
    rows, summary, _ = wall("--elements 2 2 --limit 0.3 --to 2.5", tmp_path / "rows.csv")
    large = rows[:, 7] > 0.01
    assert summary["snaps"] == large.sum() > 0
    assert summary["calm"] == pytest.approx(rows[~large, 7].max(), rel=1e-9)  # digits of the file
    assert (np.diff(rows[:, 0], prepend=0.0)[large] <= 1.001e-4).all()


def test_an_error_above_the_limit_ends_the_run(tmp_path: Path) -> None:
    """A snap that even a shortest step carries only with unbalanced forces: exit status 3, with the error."""
    words = "--elements 2 2 --passes 1 --always --errors 0.1 0.01 --limit 0.02"
    rows, summary, messages = wall(f"{words} --to 4", tmp_path / "rows.csv", status=3)
    assert summary["end"] == pytest.approx(rows[-1, 0]) and summary["end"] < 4.0
    assert "the last pass has an error of" in messages
    assert summary["e_t"] <= 0.02


def test_a_run_by_passes_goes_on(tmp_path: Path) -> None:
    """From the files of a run that ended earlier."""
    whole, part = tmp_path / "whole.csv", tmp_path / "part.csv"
    words = "--elements 2 2 --tau 0.05 --always --passes 2"
    wall(f"{words} --to 0.3", part)
    resumed, _, _ = wall(f"{words} --to 0.3 0.6 --resume", part)
    assert resumed == pytest.approx(wall(f"{words} --to 0.3 0.6", whole)[0], abs=1e-8)


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        ("--passes -1", "--passes -1: expected at least 0"),
        ("--limit 0", "--limit 0.0: expected between 0 and 1"),
        ("--errors 0.1 2", "--errors [0.1, 2.0]: expected 2 numbers between 0 and 1"),
        ("--always --passes 0", "--always True: expected with --passes of at least 1"),
    ],
)
def test_bad_options(words: str, expected: str) -> None:
    """A value out of range is named with what was expected."""
    done = done_by(words)
    assert done.returncode == 2 and expected in done.stderr


@pytest.mark.parametrize("limit", [0.02, 0.001])
def test_no_step_exceeds_the_limit(limit: float, tmp_path: Path) -> None:
    """Also not a step that is as accurate as `--errors` asks for; the wall snaps, and ends there."""
    words = f"--elements 2 2 --to 2.6 --errors 0.2 0.2 --limit {limit}"
    rows, summary, _ = wall(words, tmp_path / "rows.csv", status=3)
    assert 0.0 < rows[:, 7].max() == pytest.approx(summary["e_t"]) and summary["e_t"] <= limit
