"""The VUMAT in explicit dynamics, compared with closed forms. `make hosts` runs these tests."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern

sys.path.insert(0, str(Path(__file__).parent))
import explicit_block

MATERIAL = Material(sigma0=0.3, Gc=0.03, eta=0.95, mu=0.6, kc=20.0)
"""Bed joint, mm, N, MPa."""

THETA, PRESSURE, SLIP = 20.0, 0.5, 0.6


def joint(sides: int) -> Interface:
    """A plane of the joint faces the slip."""
    return Interface(MATERIAL, Pattern.regular(sides, THETA, turn=explicit_block.DIRECTION))


def test_explicit_block() -> None:
    """Slow slip by central differences: at the end the force is that of the residual strength.

    With slip straight up a plane strength and slope have closed forms.
    """
    result = explicit_block.run(joint(4), PRESSURE, SLIP, 8, 4, 2)
    sliding = explicit_block.LENGTH * explicit_block.DEPTH * PRESSURE
    assert result.force[-10:].mean() == pytest.approx(MATERIAL.residual_strength(THETA) * sliding, rel=1e-2)
    slope = np.polyfit(result.slip[-20:], result.rise[-20:], 1)[0]
    assert slope == pytest.approx(np.tan(np.radians(THETA)), rel=2e-2)


def test_a_rejected_call_ends_the_run() -> None:
    """A separation that is no number ends the run with an error."""
    with pytest.raises(RuntimeError, match="the law rejected a call"):
        explicit_block.run(joint(2), np.nan, SLIP, 2, 1, 1)
