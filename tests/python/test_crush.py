"""Asperities that the pressure crushes: strength in closed form, continuity, energies, steep facets.

Random updates of all options are in test_oracle.py, load paths with known numbers in test_decks.py.
"""

from __future__ import annotations

import numpy as np
import pytest
from asperity import History, Interface, Material, Pattern, Step
from test_oracle import POINTS, by_c

from tests.oracle import reference

pytestmark = pytest.mark.filterwarnings("ignore::asperity.ModelWarning")

CRUSH, THETA, MU, KC = 2.0, 30.0, 0.6, 100.0


def joint(crush: float = CRUSH, height: float = 0.0, **others: float) -> Interface:
    """Joint without bond of two planes that face each other."""
    material = Material(3.0, 0.3, 0.99, MU, kc=KC, damage0=1.0, crush=crush, height=height, **others)
    return Interface(material, Pattern.regular(2, THETA, flat=0.0))


def sheared(
    interface: Interface, increments: int = 1000, pressure: float = 1.0, slip: float = 1.0
) -> History:
    """Slip under a constant pressure."""
    steps = [Step(t_N=-pressure, increments=20), Step(slip=slip, increments=increments)]
    return interface.run(steps)


def closed_form(pressure: float, slip: float = np.inf) -> float:
    """Shear traction of the joint that slides up one plane, whose pressure crushes it.

    The contact closes by c along its normal: w = rho z - c sqrt(1 + t^2), which is rho z after a long slip.
    """
    T, K = np.tan(np.radians(THETA)), joint().material.K
    rho = 1.0
    for _ in range(200):
        t = rho * T
        c = 1.0 / np.hypot(1.0, t)
        p = 2.0 * pressure / (c * (1.0 - MU * t))
        below = (1.0 - rho) + p / (KC * K) / c / (slip * T)
        x = p / CRUSH * max(1.0 - MU * T * below, 0.0)
        rho = np.log1p(x) / x if x > 0.0 else 1.0
    return 0.5 * p * c * (t + MU)


@pytest.mark.parametrize("pressure", [0.1, 1.0, 10.0])
def test_strength_over_pressure(pressure: float) -> None:
    """The strength follows the closed form from the onset of the slip on, in increments of any length.

    Its ratio to the pressure falls with the pressure.
    """
    slip = 60.0 * MU * pressure / joint().material.K
    for increments in (800, 10):
        rows = sheared(joint(), increments, pressure, slip)
        expected = [closed_form(pressure, row) for row in np.linspace(0.0, slip, increments + 1)[1:]]
        over = rows.traction[-increments:, 1] / expected - 1.0
        assert over.max() < 1e-8
        assert np.abs(over[increments // 10 :]).max() < 1e-8
    assert expected[-1] == pytest.approx(closed_form(pressure), rel=1e-2 if pressure > 1.0 else 1e-3)
    assert closed_form(10.0) / 10.0 < 0.8 * closed_form(0.1) / 0.1


def test_increment_of_length_zero() -> None:
    """A facet that is pressed and then climbed is crushed at once: the same separation has the same traction.

    That at the start of the increment has no effect on the traction.
    """
    for interface in (joint(), joint(height=1.0), joint(closure=0.05)):
        pressed, slid = interface.run([Step(t_N=-1.0), Step(slip=0.01)]).state, [[0.001, 0.01, 0.0]]
        first = interface.update(slid, pressed[:1])
        again = interface.update(slid, first.state, slid)
        assert first.state[0, -4] > 0.0
        assert again.traction == pytest.approx(first.traction, rel=1e-12)


@pytest.mark.parametrize(("sides", "direction"), [(3, 45.0), (5, 10.0), (8, 20.0)])
def test_planes_that_share_the_pressure(sides: int, direction: float) -> None:
    """Facets share a pressure and give way as if on springs: the increments have little effect."""
    material = Material(3.0, 0.3, 0.99, MU, kc=KC, damage0=1.0, crush=CRUSH, height=1.0)
    interface = Interface(material, Pattern.regular(sides, THETA, flat=0.0))
    along = np.cos(np.radians(direction)), np.sin(np.radians(direction))
    few, many = (
        interface.run(
            [Step(t_N=-1.0, increments=20), Step(s_Tx=0.3 * along[0], s_Ty=0.3 * along[1], increments=n)]
        ).traction[20:, 1:]
        @ along
        for n in (60, 240)
    )
    assert np.abs(few[9:] / many[39::4] - 1.0).max() < 0.01


@pytest.mark.slow
def test_energies() -> None:
    """Along a cycle the work is stored or dissipated, and no row takes energy back from friction and wear."""
    steps = [Step(t_N=-1.0, increments=50), Step(slip=[0.4, -0.4, 0.4], increments=[400, 800, 800])]
    for interface in (joint(height=0.5), joint(), joint(W0=2.0), joint(closure=0.05, height=0.5)):
        rows = interface.run(steps)
        spent = rows.stored + rows.rupture + rows.friction
        # the work of the trapezoidal rule, of second order in the increment
        assert np.abs(rows.work - spent).max() < 2e-3 * rows.work[-1]
        assert np.all(np.diff(rows.friction) >= 0.0)


# --- without a jump ---

SOFT = Interface(
    Material(3.0, 0.3, 0.9, 0.3, kc=1.0, damage0=1.0, crush=2.0), Pattern.regular(2, 40.0, flat=0.0)
)
"""Steep planes on a soft contact: the equilibrium folds back."""
PRESS = Step(t_N=-5.0, increments=20)


def test_snap_releases_energy() -> None:
    """Where the equilibrium ends the point jumps, and the jump releases energy; no row gains any."""
    rows = SOFT.run([PRESS, Step(slip=0.4, increments=400)])
    [snap] = rows.snaps
    assert rows.traction[:, 1].max() == pytest.approx(7.6, abs=0.05)
    assert 0.0 < snap.released < 0.01
    spent = rows.work - (rows.stored + rows.rupture + rows.friction)
    assert np.abs(np.diff(spent)).max() < 1e-5 and np.all(np.diff(rows.friction) >= 0.0)


def test_branch_is_followed() -> None:
    """The share belongs to the separation: the branch through the snap-back ends where the jump ends."""
    jumped = SOFT.run([PRESS, Step(slip=0.4, increments=400)])
    rows = SOFT.run([PRESS, Step(slip=0.4, follow="branch")])
    back = np.diff(rows.separation[20:, 1])
    assert back.min() < 0.0 < back[-1] and not rows.snaps
    assert rows.traction[-1] == pytest.approx(jumped.traction[-1], abs=1e-6)
    assert rows.separation[-1] == pytest.approx(jumped.separation[-1], abs=1e-6)


@pytest.mark.parametrize("crush", [2.0, 0.2])
def test_no_jump(crush: float) -> None:
    """A plane is pressed, slides back and forward: shorter increments change the tractions by less.

    A damage of 1e-12 changes nothing.
    """
    normal = np.array([[np.cos(np.radians(42.0)), -np.sin(np.radians(42.0)), 0.0]])
    for damage0 in (0.0, 1e-12):
        material = Material(3.0, 0.3, 0.9, 0.3, kc=1.0, damage0=damage0, crush=crush)
        planes, changes = Interface(material, Pattern.planes(normal, [1.0])), []
        for n in (400, 800, 1600):
            steps = (Step(s_N=-0.05), Step(s_Tx=-0.03, s_Ty=0.0), Step(s_Tx=0.1, s_Ty=0.0))
            rows = planes.run([Step(**{**vars(step), "increments": n}) for step in steps])
            changes.append(np.abs(np.diff(rows.traction, axis=0)).max())
        assert changes[1] < 0.6 * changes[0] and changes[2] < 0.6 * changes[1]
        if damage0 == 0.0:
            bonded = rows.traction[-1]
    assert rows.traction[-1] == pytest.approx(bonded, rel=1e-9)


@pytest.mark.parametrize("closure", [0.0, 0.05])
def test_steep_facets(closure: float) -> None:
    """The share of facets up to 89 degrees is the only root, which bisection finds, too."""
    rng = np.random.default_rng(89)
    crushed = 0
    for theta in (*rng.uniform(65.0, 89.0, 20), 89.0):
        T = np.tan(np.radians(theta))
        constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.2 / T, "height": 0.5, "damage0": 1.0}
        constants |= {
            "kc": 10.0 ** rng.uniform(0, 2),
            "crush": 10.0 ** rng.uniform(-2, 3),
            "closure": closure,
        }
        interface = Interface(Material(**constants), Pattern.regular(2, theta, 0.0))
        u = 0.5 / T * 10.0 ** rng.uniform(-2, 0.7, POINTS)
        z = 0.5 * -np.expm1(-u * T / 0.5)
        # up to twice the largest closure along the normal
        slope = T * np.exp(-u * T / 0.5)
        s = np.stack([z - np.hypot(1.0, slope) * 10.0 ** rng.uniform(-4, -1, POINTS), u, 0.0 * u], axis=1)
        start = np.zeros((POINTS, interface.nstatv))
        theirs = reference.update(
            reference.Parameters(**constants), reference.regular_pattern(2, theta, 0.0), s, start, 0.0 * s
        )
        _, state, tangent = by_c(interface.props(), s, start, 0.0 * s, 0.0)
        assert np.abs(state[:, -4] - theirs.state[:, -4]).max() < SHARE
        crushed += np.count_nonzero((state[:, -4] > 0.01) & (state[:, -4] < 0.99))
        assert np.all(np.isfinite(tangent))
    assert crushed > 50


SHARE = 1e-10
"""Of a share: six steps leave 1e-11 at 89 degrees, and rounding is magnified by the slope, 57, twice."""


def test_tangent_is_finite_where_nothing_is_left() -> None:
    """A tiny `crush` flattens facets to rounding; on either side of the foot the tangents are finite."""
    rng = np.random.default_rng(20)
    for crush in (1e-20, 1e-3, 1e20):
        material = Material(3.0, 0.3, 0.9, 0.5, kc=20.0, damage0=1.0, crush=crush, height=0.3)
        interface = Interface(material, Pattern.regular(4, 30.0, 0.0))
        s = rng.standard_normal((400, 3)) * [0.01, 0.05, 0.05]
        s[::4, 1], s[1::4, 2], s[2::4, 0] = 0.0, 0.0, 0.0
        start = np.zeros((len(s), interface.nstatv))
        traction, state, tangent = by_c(interface.props(), s, start, 0.0 * s, 0.0)
        assert np.all(np.isfinite(traction)) and np.all(np.isfinite(tangent)) and np.all(np.isfinite(state))
        worn = state[:, -8::2]
        assert np.all((worn >= 0.0) & (worn <= 1.0))
    assert worn.max() < 1e-15
