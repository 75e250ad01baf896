"""Asperities that the pressure crushes (PROPS 22): numbers of an independent model, closed form, energies."""

from __future__ import annotations

import numpy as np
import pytest
from asperity import History, Interface, Material, Pattern, Step
from scipy.optimize import brentq

from harness.studies.extensions_crush import JOINTS, envelope

CRUSH, THETA, MU = 2.0, 30.0, 0.6

PRINTED = 1e-4
"""Largest difference of numbers with four decimals: half of the last one, and as much again."""


def joint(crush: float = CRUSH, height: float = 0.0, **others: float) -> Interface:
    """Joint without bond of two planes that face each other."""
    material = Material(3.0, 0.3, 0.99, MU, kc=100.0, damage0=1.0, crush=crush, height=height, **others)
    return Interface(material, Pattern.regular(2, THETA, flat=0.0))


def sheared(
    interface: Interface, increments: int = 1000, pressure: float = 1.0, slip: float = 1.0
) -> History:
    """Slip under a constant pressure."""
    steps = [Step(t_N=-pressure, increments=20), Step(slip=slip, increments=increments)]
    return interface.run(steps)


@pytest.mark.parametrize(
    ("height", "crush", "row", "expected"),
    [
        (1.0, CRUSH, 220, (0.0647, 1.1051)),
        (1.0, CRUSH, -1, (0.2591, 0.8942)),
        (0.0, CRUSH, -1, (0.3410, 1.1832)),
        (1.0, 0.0, -1, (None, 1.1472)),
        (0.0, 0.0, -1, (None, 1.8014)),
    ],
)
def test_numbers(height: float, crush: float, row: int, expected: tuple[float | None, float]) -> None:
    """Dilation and shear traction after a slip of 0.201 and of 1.0 are those of an independent model."""
    rows = sheared(joint(crush, height))
    s_N, tau = expected
    assert rows.traction[row, 1] == pytest.approx(tau, abs=PRINTED)
    if s_N is not None:
        assert rows.separation[row, 0] == pytest.approx(s_N, abs=PRINTED)
    if row == 220:
        assert rows.worn(1)[row] == pytest.approx(0.4092, abs=PRINTED)
        assert rows.worn(2)[row] == 0.0


def closed_form(pressure: float) -> float:
    """Shear traction of the joint that slides up one plane, whose pressure crushes it."""

    def excess(p: float) -> float:
        slope = np.tan(np.radians(THETA)) * np.log1p(p / CRUSH) / (p / CRUSH)
        c = 1.0 / np.hypot(1.0, slope)
        return 0.5 * p * c * (1.0 - slope * MU) - pressure

    p = brentq(excess, 1e-9, 1e3 * pressure)
    slope = np.tan(np.radians(THETA)) * np.log1p(p / CRUSH) / (p / CRUSH)
    return 0.5 * p * (slope + MU) / np.hypot(1.0, slope)


@pytest.mark.parametrize("pressure", [0.1, 1.0, 10.0])
def test_strength_over_pressure(pressure: float) -> None:
    """The strength follows the closed form, whose ratio to the pressure falls with the pressure.

    The pressure of the first row that slides crushes the asperity: increments much shorter than the elastic
    slip of the friction lead to the strength within 1e-4, longer ones to one that is lower by at most 7 %.
    """
    elastic = MU * pressure / joint().material.K
    fine = sheared(joint(), 3200, pressure, 60.0 * elastic)
    assert fine.traction[-1, 1] == pytest.approx(closed_form(pressure), rel=1e-4)
    coarse = sheared(joint(), 20, pressure, 60.0 * elastic)
    assert 0.93 < coarse.traction[-1, 1] / closed_form(pressure) <= 1.0
    assert closed_form(10.0) / 10.0 < 0.8 * closed_form(0.1) / 0.1


@pytest.mark.parametrize(("height", "tau"), [(1.0, 0.8865), (0.0, 1.1650)])
def test_coarse_increments(height: float, tau: float) -> None:
    """A slip of 1.0 in 100 increments gives the numbers of an independent model."""
    assert sheared(joint(height=height), 100).traction[-1, 1] == pytest.approx(tau, abs=PRINTED)


def test_energies() -> None:
    """Along a cycle the work is stored or dissipated, and no row takes energy back from friction and wear."""
    steps = [Step(t_N=-1.0, increments=50), Step(slip=[0.4, -0.4, 0.4], increments=[400, 800, 800])]
    for interface in (joint(height=0.5), joint(), joint(W0=2.0), joint(closure=0.05, height=0.5)):
        rows = interface.run(steps)
        spent = rows.stored + rows.rupture + rows.friction
        # the work of the trapezoidal rule, of second order in the increment
        assert np.abs(rows.work - spent).max() < 2e-3 * rows.work[-1]
        assert np.all(np.diff(rows.friction) >= 0.0)


def test_second_law_on_random_paths() -> None:
    """Friction and wear are never negative, whatever the separations."""
    rng = np.random.default_rng(22)
    for height, guard in ((0.0, False), (0.3, True), (0.05, False)):
        material = Material(3.0, 0.3, 0.9, 0.5, kc=10.0, crush=1.0, height=height, guard=guard)
        interface = Interface(material, Pattern.regular(5, 35.0, turn=10.0))
        state, s_old = np.zeros((2000, interface.nstatv)), np.zeros((2000, 3))
        for _ in range(50):
            s = s_old + material.s_0 * rng.standard_normal((2000, 3))
            after = interface.update(s, state, s_old).state
            friction = after[:, 3] - state[:, 3]
            assert friction.min() >= 0.0
            assert np.all(after[:, interface.nstatv - 10 :: 2] >= state[:, interface.nstatv - 10 :: 2])
            state, s_old = after, s


def test_flat_planes_and_opened_planes_are_not_crushed() -> None:
    """A flat plane has no asperity; a plane without pressure keeps its asperity."""
    interface = Interface(Material(3.0, 0.3, 0.9, 0.5, crush=1.0), Pattern.regular(2, 30.0, flat=0.5))
    pressed = interface.run([Step(s_N=[-0.01, 0.02], increments=10)])
    assert np.all(pressed.worn(1) == 0.0)
    assert pressed.worn(2)[-1] > 0.0
    opened = interface.run([Step(s_N=0.02, increments=10)])
    assert np.all(opened.worn(2) == 0.0)


def test_envelopes_of_barton() -> None:
    """One plane with crush follows each envelope of Barton; without crush the best one is off by a tenth."""
    for joint in JOINTS:
        for crushed, least, most in ((True, 0.008, 0.014), (False, 0.1, 0.2)):
            _, peaks, law = envelope(*joint, crushed)
            assert least < np.sqrt(np.mean((law / peaks - 1.0) ** 2)) < most
