"""Connection elements of OpenRadioss by central differences beside the joints of FEniCSx."""

from __future__ import annotations

import pytest
from on_ranks import WITH_FENICSX, done_by

from harness.studies.validation import wall_runs

pytestmark = WITH_FENICSX


def test_block_on_a_shaken_base() -> None:
    """A block slides as far by the engine's calls as by `Shake`, and as a rigid one."""
    [(_, (called, shaken, rigid, _))] = wall_runs.printed_by("block", "connected", run=done_by)
    # of the vibration of the block, which the rigid one does not have
    assert called == pytest.approx(shaken, rel=0.02)
    assert shaken == pytest.approx(rigid, rel=0.02)


def test_cantilever() -> None:
    """Arms that are opened have the crack and the energy of the joint of FEniCSx."""
    [(_, (crack, known, energy, expected, _))] = wall_runs.printed_by("cantilever", "connected", run=done_by)
    assert crack == pytest.approx(known, rel=0.02) and energy == pytest.approx(expected, rel=0.02)
    assert known > 10.0
