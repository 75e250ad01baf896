"""A ribbed bar in its cover on FEniCSx: closed forms, and what a cover that splits takes away."""

from __future__ import annotations

from functools import cache

import pytest
from on_ranks import SEVERAL_RANKS, WITH_FENICSX, done_by

from harness.studies.validation import ribbed
from harness.studies.validation.wall_runs import printed_by

pytestmark = WITH_FENICSX

RIBS = "mu=0.5 theta=38.66 height=1 crush=3 sigma0=6.5 Gc=3"


@cache
def largest(words: str, ranks: int = 1) -> tuple[float, float]:
    """Largest force and mean pressure."""
    rows, _ = ribbed.solids(words, ranks, done_by)
    return max(row[1] for row in rows), max(row[2] for row in rows)


def test_linear_bond() -> None:
    """Force and stress along the bar are those of the bar in rigid concrete, whose section stays plane."""
    rows, bond = ribbed.solids("linear --end 0.001", run=done_by)
    # the section does not stay plane: k d/(8 G) = .3 %
    assert rows[-1][1] == pytest.approx(ribbed.linear_force(rows[-1][0]), rel=5e-3)
    for place, stress in bond:
        assert stress == pytest.approx(float(ribbed.cosh(rows[-1][1], place)), rel=5e-3)


def test_friction() -> None:
    """A bar that slides everywhere under a constant pressure: P = pi d l mu p."""
    closed = 3.14159265 * ribbed.DIAMETER * ribbed.EMBEDDED * 0.4 * 2.0
    assert largest("friction --pressure 2 --end 0.3")[0] == pytest.approx(closed, rel=1e-3)


def test_cover() -> None:
    """The cover has the stiffness of a thick ring."""
    [(_, [stiffness])] = printed_by("ring --grid 4 2 12 12", "anchored", run=done_by)
    assert stiffness == pytest.approx(ribbed.cover_stiffness(), rel=0.015)


@SEVERAL_RANKS
def test_splitting_cover() -> None:
    """A cover that splits presses as a ring between brittle and plastic, and the bar carries far less."""
    small = "--grid 2 1 4 12 --end 0.3"
    force, pressure = largest(f"split {RIBS} {small}")
    whole, _ = largest(f"cover {RIBS} {small}")
    brittle, plastic = ribbed.tepfers()
    assert brittle < pressure < plastic
    assert force < 0.3 * whole
    assert largest(f"split {RIBS} {small}", 2)[0] == pytest.approx(force, rel=1e-3)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("split sigma0=-1 theta=30 mu=0.5 Gc=1", "sigma0 = -1: expected > 0"),
        ("split theta=30", "expected the constants sigma0, Gc, mu, theta of the ribs"),
        ("split mu", "mu: expected NAME=NUMBER"),
        ("split mu=rough theta=30 sigma0=1 Gc=1", "mu=rough: expected NAME=NUMBER"),
        (f"split {RIBS} slope=3", "slope"),
        ("friction --pressure -2", "--pressure -2: expected above 0"),
        ("friction --pressure nan", "--pressure nan: expected above 0"),
        ("linear --end -0.001", "--end -0.001: expected above 0"),
        ("linear --grid 0 2 6 24", "--grid 0 2 6 24: expected at least 1"),
        ("rope", "invalid choice: 'rope'"),
    ],
)
def test_wrong_input(words: str, said: str) -> None:
    """A message names the value, without a traceback."""
    done = done_by(words, "anchored")
    assert done.returncode != 0 and said in done.stderr and "Traceback" not in done.stderr
