"""Points that are shaken: impacts and base motion on the dashpot in closed form; units m, MN, s, kt.

Each test has its own mass on a joint, and integrates in time by central differences.  test_validation.py has
the block that rocks, whose numbers are also those of a page.
"""

from __future__ import annotations

import numpy as np
import pytest

from harness.studies.validation.shaken_points import (
    MASS,
    G,
    joint,
    pulse,
    rest,
    restitution,
    ride,
    shaken,
)


@pytest.mark.parametrize(
    ("xi", "theta"), [(0.1, 0.0), (0.3, 0.0), (0.7, 0.0), (0.99, 0.0), (2.0, 0.0), (0.3, 20.0)]
)
def test_impacts(xi: float, theta: float) -> None:
    """The ratio of restitution is that of the closed form; friction obeys impulses: d v_t = mu (1 + e) v_n.

    On an inclined plane the components are those along its normal and its line of steepest ascent.
    """
    kn, mu, v_n, v_t = 2e4, 0.3, 0.01, 0.1
    omega = np.sqrt(kn / MASS)
    law = joint(theta, mu, kn, 2.0 * xi * np.sqrt(kn * MASS))
    a = np.radians(theta)
    axes = np.array([[np.cos(a), -np.sin(a), 0.0], [np.sin(a), np.cos(a), 0.0]])
    none = np.zeros(3)
    _, v, _ = ride(law, 2e-3 / omega, 2600, lambda _: none, none, [-v_n, v_t] @ axes)
    after = axes @ v[-1]
    e = restitution(xi)
    # of the step: omega dt = .002
    assert after[0] / v_n == pytest.approx(e, abs=5e-4)
    assert v_t - after[1] == pytest.approx(mu * (1.0 + after[0] / v_n) * v_n, rel=1e-3)


@pytest.mark.parametrize("xi", [0.0, 0.1, 0.5, 1.0])
def test_explicit_step(xi: float) -> None:
    """A mass that stays in contact is stable up to (2/omega)(sqrt(1 + xi^2) - xi), and not much further."""
    kn = 2e4
    law, omega = joint(0.0, 0.5, kn, 2.0 * xi * np.sqrt(kn * MASS)), np.sqrt(kn / MASS)
    down = np.array([-G, 0.0, 0.0])
    at, limit = rest(law), 2.0 / omega * (np.sqrt(1.0 + xi**2) - xi)
    for share, stable in ((0.97, True), (1.03, False)):
        start = at * [1.001, 1.0, 1.0]
        s, _, _ = ride(law, share * limit, 300, lambda _: down, start, np.zeros(3))
        largest = np.abs(s[-30:, 0] - at[0]).max()
        assert (largest < 2e-3 * abs(at[0])) == stable


# --- base motion --------------------------------------------------------------------------------------------


def test_pulse_on_a_flat_joint() -> None:
    """Newmark's sliding block, and the error that the spring makes: C/(omega t0)."""
    mu, A, t0, kn, dt = 0.5, 1.0, 0.1, 2e5, 1e-4
    V = A * G * t0
    rigid = V**2 / (2.0 * mu * G) * (1.0 - mu / A)
    phi = np.arccos(1.0 - mu / A)
    C = 2.0 * (A * np.sin(phi) - (A - mu) * phi) / (A - mu)
    error = C / (np.sqrt(0.4 * kn / MASS) * t0)
    s, ledger = shaken(joint(0.0, mu, kn), pulse(A, t0, dt), 0.35, dt)
    assert 1e3 * rigid == pytest.approx(49.05)
    assert s[-1, 1] == pytest.approx(rigid * (1.0 + error), rel=2e-4)
    assert ledger < 1e-5
    # with the critical dashpot the stuck mass does not swing on
    damped, ledger = shaken(joint(0.0, mu, kn, 2.0 * np.sqrt(kn * MASS)), pulse(A, t0, dt), 0.35, dt)
    assert rigid < damped[-1, 1] < rigid * (1.0 + 0.5 * error)
    assert ledger < 1e-3


def test_harmonic_base() -> None:
    """Den Hartog's always sliding block, mu .25: peak to peak 38.453 mm, and .82 % more on this spring."""
    mu, A, kn, dt = 0.25, 0.5, 2e5, 2e-4
    w = 4.0 * np.pi
    closed = 2.0 * A * G / w**2 * np.sqrt(1.0 - (0.5 * np.pi * mu / A) ** 2)
    # each of 6 cycles of .5 s; the start dies out
    s, _ = shaken(joint(0.0, mu, kn), lambda t: A * G * np.sin(w * t), 3.0, dt)
    last = s[-round(0.5 / dt) :, 1]
    assert 1e3 * closed == pytest.approx(38.453, abs=5e-4)
    assert np.ptp(last) / closed - 1.0 == pytest.approx(0.0082, abs=0.0015)


def test_pulse_on_an_inclined_plane() -> None:
    """The block climbs to the closed height; with the dashpot it stays where it ends."""
    theta, mu, A, t0, kn, dt = 10.0, 0.5, 1.5, 0.1, 2e5, 2e-4
    sine, cosine = np.sin(np.radians(theta)), np.cos(np.radians(theta))
    up = A * G * cosine - G * sine - mu * G * (cosine + A * sine)
    length = 0.5 * up * t0**2 * (1.0 + up / (G * sine + mu * G * cosine))
    assert 1e3 * length == pytest.approx(67.544, abs=5e-4)
    s, _ = shaken(joint(theta, mu, kn), pulse(A, t0, dt), 0.4, dt)
    assert 1e3 * s[:, 0].max() == pytest.approx(11.78, abs=0.01)
    assert s[:, 0].max() == pytest.approx(length * sine, rel=5e-3)
    dt = 1e-4  # the dashpot lowers the stable increment
    s, _ = shaken(joint(theta, mu, kn, 2.0 * np.sqrt(kn * MASS)), pulse(A, t0, dt), 0.4, dt)
    assert np.hypot(*s[-1, :2]) == pytest.approx(length, rel=2e-3)
    assert np.ptp(s[-200:], axis=0).max() < 1e-5 * length
