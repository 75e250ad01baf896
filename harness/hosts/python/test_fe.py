"""The law in scikit-fem, compared with closed forms on small meshes. `make hosts` runs these tests."""

from __future__ import annotations

import numpy as np
import pytest

pytest.importorskip("skfem", reason="scikit-fem is not installed")

import snap_back


@pytest.mark.parametrize("share", [0.5, 1.5, 2.2, 5.0])
def test_bar_snaps_back(share: float) -> None:
    """Bars over the limit snap back: dissipation control follows the closed form, the plain method stops."""
    length = share * snap_back.LIMIT
    peak = snap_back.S_0 + snap_back.BOND.sigma0 * length / snap_back.MODULUS
    curve = snap_back.by_dissipation(snap_back.bar(length), snap_back.BOND.Gc / 30)
    opening = curve.moved - curve.force * length / snap_back.MODULUS
    # the residual is 1e-10 of the strength
    moved, force = snap_back.closed_form(opening, length)
    np.testing.assert_allclose(curve.force, force, rtol=0, atol=1e-8 * snap_back.BOND.sigma0)
    np.testing.assert_allclose(curve.moved, moved, rtol=0, atol=1e-8 * snap_back.S_F)
    assert curve.broken == 1.0 and curve.force.max() > 0.95 * snap_back.BOND.sigma0
    # the trapezoidal rule over steps of 0.3 % of the energy
    assert snap_back.work(curve) == pytest.approx(snap_back.BOND.Gc, rel=5e-3)
    broken = int(np.argmax(opening >= snap_back.S_F))
    turns = np.diff(curve.moved[: broken + 1]) < 0.0
    plain = snap_back.by_displacement(snap_back.bar(length), 1.2 * max(peak, snap_back.S_F), 200)
    if share < 1.0:
        assert plain.broken == 1.0 and not turns.any()
    else:
        assert turns.sum() > 10
        assert plain.broken == 0.0 and plain.moved[-1] == pytest.approx(peak, rel=0.01)
