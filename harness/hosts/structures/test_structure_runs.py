"""The structures of structure_study.py: run by `make hosts`."""

from __future__ import annotations

import sys
from pathlib import Path

import explicit_block
import numpy as np
import pytest

from harness.studies import structures

HERE = Path(__file__).parent


def test_explicit_block() -> None:
    """Slow slip by central differences: at the end the force is that of the residual strength.

    With slip straight up a plane strength and slope have closed forms.
    """
    law = structures.interface_of(4, explicit_block.DIRECTION)
    result = explicit_block.run(law, structures.PRESSURE, structures.SLIP, 8, 4, 2)
    sliding = explicit_block.LENGTH * explicit_block.DEPTH * structures.PRESSURE
    strength = law.material.residual_strength(structures.THETA)
    force = result.force[-10:].mean()
    print(f"{result.increments} increments, force {force:.1f} N, closed form {strength * sliding:.1f} N")
    assert force == pytest.approx(strength * sliding, rel=1e-2)
    slope = np.polyfit(result.slip[-20:], result.rise[-20:], 1)[0]
    assert slope == pytest.approx(np.tan(np.radians(structures.THETA)), rel=2e-2)
    assert 0.0 < result.law_seconds < result.seconds


def test_a_rejected_call_ends_the_run() -> None:
    """A separation that is no number ends the run with an error."""
    with pytest.raises(RuntimeError, match="the law rejected a call"):
        explicit_block.run(structures.interface_of(2), np.nan, structures.SLIP, 2, 1, 1)


def test_time_of_the_law(tmp_path: Path) -> None:
    """The library that measures the time changes no result."""
    needed = "KratosMultiphysics.GeoMechanicsApplication"
    pytest.importorskip(needed, reason="asperity[kratos] is not installed")
    sys.path.insert(0, str(HERE))
    import structure_study

    run = structure_study.kratos(tmp_path)
    import triplet

    turns = structures.TURNS["Kratos triplet"]
    law = structures.interface_of(2)
    small = triplet.run
    try:
        triplet.run = lambda turns, increment, **given: small((0.1,), increment, nx=4, ny=1, **given)
        found, expected = run(law), small((0.1,), 0.01, nx=4, ny=1, law=law)
    finally:
        triplet.run = small
    assert len(turns) == 2 and np.array_equal(found.force, expected.force[triplet.PRELOAD_STEPS :])
    assert 0.0 < found.law < found.seconds
