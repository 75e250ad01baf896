"""The law in scikit-fem, compared with closed forms on small meshes. `make hosts` runs these tests."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("skfem", reason="asperity[fe] is not installed")

import crack
import snap_back

PAGE = Path(__file__).parents[3] / "docs/validation/benchmarks.md"


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


@pytest.mark.parametrize("kind", ["friction", "pressure", "dilation"])
def test_crack_converges_to_the_closed_form(kind: str) -> None:
    """Slip and opening converge at the order of the mesh; the compression on the crack is uniform."""
    cracks = {n: crack.run(kind, n) for n in (4, 8, 16)}
    errors = [one.error(kind) for one in cracks.values()]
    print(kind, errors)
    # elements at the tips shrink with the square of n; the square root there allows an order of nearly 2
    assert errors[-1] < 0.005
    cells = " | ".join(f"{100 * error:.2f}" for error in errors[1:])
    assert f"| {kind} | {cells} |" in PAGE.read_text(encoding="utf-8")
    assert all(before / after > 2**1.6 for before, after in pairwise(errors))
    opening, slip, normal = crack.closed_form(kind)
    finest = cracks[16]
    at = np.abs(finest.x) < 0.9 * crack.B
    assert finest.traction[at, 0] == pytest.approx(normal, rel=0.005)
    resistance = np.tan(crack.FRICTION + np.arctan(opening / slip if slip else 0.0))
    assert finest.traction[at, 1] == pytest.approx(-resistance * normal, rel=0.005)


def test_crack_friction_has_the_published_numbers() -> None:
    """The closed form is that of Phan (2003): largest slip 3.80785 mm, normal traction -11.698 MPa."""
    opening, slip, normal = crack.closed_form("friction")
    assert opening == 0.0
    assert slip * crack.B == pytest.approx(3.80785, abs=5e-6)
    assert normal == pytest.approx(-11.698, abs=5e-4)


def test_crack_with_asperities_of_finite_height() -> None:
    """Points are those of a material point at their pressure; opening and slip follow from the tractions."""
    found = crack.run("height", 8)
    opening, slip = found.separation[:, 0], found.separation[:, 1]
    for i in np.flatnonzero(np.abs(found.x) < 0.9 * crack.B):
        slips = np.linspace(0, slip[i], 11)[1:]
        point = crack.interface("height").confined_slip(0.0, slips, found.traction[i, 0])
        # Newton's tolerance is 1e-10 of the largest force
        assert opening[i] == pytest.approx(point.separation[-1, 0], rel=1e-7)
        assert found.traction[i, 1] == pytest.approx(point.traction[-1, 1], rel=1e-7)
    assert found.imbalance("height") == pytest.approx(0.0, abs=0.03)
    flat, steep = (crack.closed_form(kind) for kind in ("friction", "dilation"))
    assert steep[1] < slip.max() / crack.B < flat[1]
    assert steep[2] < found.traction[np.abs(found.x).argmin(), 0] < flat[2]
