"""Delamination on FEniCSx: the energy of the moments is what the joint spends."""

from __future__ import annotations

import pytest
from on_ranks import WITH_FENICSX, done_by

pytestmark = WITH_FENICSX


@pytest.mark.parametrize(("mu", "least", "most"), [(0.0, 0.97, 1.06), (0.8, 1.5, 1.8)])
def test_shear(mu: float, least: float, most: float) -> None:
    """Equal turns: without friction J is Gc, with friction on steep planes half as much again."""
    code = f"from harness.hosts.fenicsx.delamination import GC, peel; print(GC, *peel(1.0, {mu}))"
    done = done_by("", code=code)
    assert done.returncode == 0, done.stderr
    Gc, moments, share, J, spent, friction = map(float, done.stdout.split())
    assert moments == pytest.approx(1.0, abs=0.3) and share == pytest.approx(1.0, abs=0.02)
    assert J == pytest.approx(spent, rel=0.05)
    assert least * Gc < J < most * Gc
    assert (friction > 0.5 * (spent - Gc)) == (mu > 0.0)
