"""Akantu's cohesive elements with the law: run by `make hosts`, which installs asperity[akantu] first."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern

pytest.importorskip("akantu", reason="asperity[akantu] is not installed")

sys.path.insert(0, str(Path(__file__).parent.parent))
import paraview_check
import two_blocks
from two_blocks import PRELOAD_STEPS, PRESSURE

LAST = 1.0e-7
"""Error of the force at the end: Newton's method is linear here and ends at 1e-9 N."""


@pytest.mark.parametrize("dimension", [2, 3])
def test_two_blocks(dimension: int, tmp_path: Path) -> None:
    """Every point has the law on its own history; the force ends at that of the closed form."""
    joint = Interface(two_blocks.JOINT.material, Pattern.regular(2 * (dimension - 1), theta=30.0))
    result = two_blocks.run(tmp_path, dimension, joint)
    counts = result.iterations
    print(f"{dimension}D: {len(counts)} steps, {sum(counts)} iterations, at most {max(counts)}")
    for k in range(result.separation.shape[1]):
        expected = joint.replay(result.separation[:, k])
        assert np.abs(result.traction[:, k] - expected.traction).max() <= 1e-12 * joint.material.sigma0
    residual = joint.material.residual_strength(30.0) * PRESSURE
    print(f"force at the end {result.force[-1, 0]:.9f} N, closed form {residual:.9f} N")
    assert result.force[-1, 0] == pytest.approx(residual, rel=LAST)
    rise = np.diff(result.rise[-5:]) / np.diff(result.slip[-5:])
    assert rise == pytest.approx(np.tan(np.radians(30.0)), rel=1e-6)
    assert np.ptp(result.separation[PRELOAD_STEPS:, :, 0], axis=1).max() > 0.0
    two_blocks.write_paraview(tmp_path / "blocks.pvd", result)
    paraview_check.against_the_law(tmp_path / "blocks.pvd", joint, 1e-12)
    paraview_check.places(tmp_path / "blocks.pvd", 2 ** (dimension - 1), up=dimension - 1)


def test_symmetric_storage(tmp_path: Path) -> None:
    """Without friction the tangent is symmetric, and Newton's method needs fewer iterations."""
    smooth = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.0, kc=4.0), Pattern.regular(2, theta=30.0))
    counts = [sum(two_blocks.run(tmp_path, 2, one).iterations) for one in (two_blocks.JOINT, smooth)]
    print(f"iterations: {counts[0]} with friction, {counts[1]} without")
    assert counts[0] > 1.5 * counts[1]


def test_direction_along_the_normal(tmp_path: Path) -> None:
    """Tx has no direction where it is along the normal: the message has both."""
    code = (
        "import two_blocks, pathlib; from asperity.hosts import akantu; old = two_blocks.register; "
        "two_blocks.register = lambda joint, name: old(joint, name, tx=[0.0, 1.0, 0.0]); "
        f"two_blocks.run(pathlib.Path({str(tmp_path)!r}), 2)"
    )
    here = Path(__file__).parent
    done = subprocess.run([sys.executable, "-c", code], cwd=here, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "tx = [0.0, 1.0, 0.0]: expected a direction across the normal" in done.stderr
