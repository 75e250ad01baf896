"""Finite asperity height and wear in the NumPy reference: known values.

A separate program computed the known values before this reference was written.  They are printed with six
decimals or seven digits; the tolerance is half a unit of the last digit.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from support_height import (
    PRINTED,
    ROUNDING,
    RP_4,
    RT,
    TABLE_2,
    THETA,
    along,
    broken,
    cycle,
    rows_at,
    worn_share,
)

from tests.oracle.reference import (
    Parameters,
    SlipHistory,
    confined_slip,
    regular_pattern,
    update,
)

pytestmark = pytest.mark.slow

# --- known values: finite height ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("height", "facts"),
    [
        (0.5, [(0.1, 0.054299, 2.718183), (0.2, 0.102793, 1.243329), (0.4, 0.184674, 1.055946),
               (0.6, 0.249665, 0.921946), (1.2, 0.374698, 0.694618)]),
        (0.2, [(0.1, 0.052479, 2.252624), (0.2, 0.087459, 0.983718), (0.4, 0.136742, 0.750291),
               (0.6, 0.164403, 0.634593), (1.2, 0.193538, 0.522801)]),
    ],
)  # fmt: skip
def test_rt_with_stiff_contact(height, facts):
    """s_N and tau of RT (kc 100, sigma_N -1) agree; the error of the step is below the printed digits."""
    slips = 0.005 * np.arange(241)
    history = confined_slip(replace(TABLE_2, kc=100.0, height=height), RT, 0.0, slips, -1.0)
    for row, (_, s_N, tau) in zip(rows_at(slips, tuple(fact[0] for fact in facts)), facts, strict=True):
        assert history.separation[row, 0] == pytest.approx(s_N, abs=PRINTED)
        assert history.traction[row, 1] == pytest.approx(tau, abs=PRINTED)


@pytest.mark.slow
def test_rp4_off_its_axes():
    """RP-4 (kc 20, sigma_N -5, H .3) in direction 20 agrees with the known values.

    The steps are .0005; the results differ by 2e-6 from those with .001.
    """
    slips = 0.0005 * np.arange(801)
    history = confined_slip(replace(TABLE_2, kc=20.0, height=0.3), RP_4, 20.0, slips, -5.0)
    facts = [(0.1, 0.033889, 6.702041), (0.2, 0.076697, 5.496957), (0.4, 0.142035, 4.435904)]
    for row, (_, s_N, tau) in zip(rows_at(slips, (0.1, 0.2, 0.4)), facts, strict=True):
        assert history.separation[row, 0] == pytest.approx(s_N, abs=PRINTED)
        assert along(history, 20.0)[row] == pytest.approx(tau, abs=PRINTED)


def test_steep_joint_unlocks():
    """A joint with mu tan(theta) > 1 is locked only until u = .0377.

    Theta is 60, mu .8, kc 100, sigma_N -1, and all planes are fully damaged.  Without finite height the
    traction continues to increase: 3.61, 11.4, 21.1 at .01, .05, .1.
    """
    pattern = regular_pattern(2, 60.0)
    p = Parameters(3.0, 0.3, 0.9, 0.8, kc=100.0, height=0.2)
    slips = 0.005 * np.arange(201)
    history = confined_slip(p, pattern, 0.0, slips, -1.0, state=broken(pattern, p))
    facts = [(0.05, 7.5760, 5e-5), (0.2, 1.4668, 5e-5), (1.0, 0.800493, PRINTED)]
    for row, (_, tau, tolerance) in zip(rows_at(slips, (0.05, 0.2, 1.0)), facts, strict=True):
        assert history.traction[row, 1] == pytest.approx(tau, abs=tolerance)
    T = np.tan(np.radians(60.0))
    assert p.height / T * np.log(p.mu * T) == pytest.approx(0.0377, abs=5e-5)
    locked = confined_slip(replace(p, height=0.0), pattern, 0.0, slips[:21], -1.0, state=broken(pattern, p))
    assert np.allclose(np.diff(locked.traction[5:, 1], 2), 0.0, atol=1e-9) and locked.traction[-1, 1] > 21.0


@pytest.mark.parametrize("mu", [0.0, 0.5])
def test_dead_joint_slides_at_the_mobilised_slope(mu):
    """tau/|sigma_N| is (mu + tan phi)/(1 - mu tan phi) up to the contact compliance; s_N -> H - closure.

    The climbing facet of RT carries all of sigma_N when the flat plane is open.  The error is the closure
    |sigma_N|/(gamma kc Kn) divided by H.
    """
    errors = []
    for kc in (1e3, 1e4):
        p = Parameters(3.0, 0.3, 0.9, mu, kc=kc, height=0.2)
        slips = 0.02 * np.arange(101)
        history = confined_slip(p, RT, 0.0, slips, -1.0, state=broken(RT, p))
        slope = np.tan(np.radians(THETA)) * np.exp(-slips * np.tan(np.radians(THETA)) / p.height)
        expected = (mu + slope) / (1.0 - mu * slope)
        closure = 1.0 / (RT[1][1] * kc * p.Kn)
        errors.append(np.abs(history.traction[5:, 1] - expected[5:]).max())
        assert errors[-1] <= 5.0 * closure / p.height
        z = p.height * (1.0 - np.exp(-slips[50] * np.tan(np.radians(THETA)) / p.height))
        assert history.separation[50, 0] == pytest.approx(z, abs=2.0 * closure)
    assert errors[0] / errors[1] == pytest.approx(10.0, rel=0.1)
    far = confined_slip(p, RT, 0.0, np.linspace(0.0, 20.0, 101), -1.0, state=broken(RT, p))
    assert far.separation[-1, 0] == pytest.approx(p.height - closure, rel=1e-9)
    assert far.traction[-1, 1] == pytest.approx(mu, abs=1e-9)


@pytest.mark.parametrize(
    ("height", "s_N", "tau", "work"),
    [(0.2, -0.042280, 7.512272, 10.551), (0.0, -0.050078, 12.605287, 10.512)],
)
def test_cycle_with_soft_contact(height, s_N, tau, work):
    """The cycle of Figure 5(b) with kc 1, sigma_N -10 has the same values at every reversal.

    The work includes that of the preload.
    """
    slips = cycle(0.4, -0.4, 0.4, step=0.002)
    history = confined_slip(replace(TABLE_2, height=height), RT, 0.0, slips, -10.0)
    turns = [200, 600, 1000]
    assert np.allclose(history.separation[turns, 0], s_N, rtol=0, atol=PRINTED)
    assert np.allclose(history.traction[turns, 1], [tau, -tau, tau], rtol=0, atol=PRINTED)
    assert history.work[-1] == pytest.approx(work, abs=5e-4)


@pytest.mark.parametrize(
    ("height", "energy"), [(0.0, 0.352453), (1.0, 0.350524), (0.5, 0.348804), (0.2, 0.344667)]
)
def test_measured_energy_at_zero_normal_traction(height, energy):
    """The energy of RT in direction 0 is converged to 5e-7 by the trapezoidal rule with steps of 5e-4."""
    slips = 5e-4 * np.arange(481)
    history = confined_slip(replace(TABLE_2, height=height), RT, 0.0, slips, 0.0)
    assert np.abs(history.traction[-1]).max() < 1e-9
    assert np.trapezoid(history.traction[:, 1], slips) == pytest.approx(energy, abs=1e-6)


# --- known values: wear -------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("height", "facts", "omega"),
    [
        (0.0, [(0.1, 0.053006, 2.395986), (0.2, 0.094164, 1.273152), (0.4, 0.126283, 0.969759),
               (0.6, 0.133325, 0.813100)], 0.614443),
        (0.5, [(0.1, 0.052479, 2.252624), (0.2, 0.090976, 1.136258), (0.4, 0.113112, 0.813697),
               (0.6, 0.110425, 0.670736)], None),
    ],
)  # fmt: skip
def test_wear_of_rt(height, facts, omega):
    """Wear of RT agrees with the known values for W0 1, kc 100, sigma_N -1; energies for H .5.

    The preload has 20 increments, the slip to .6 has 600.
    """
    slips = np.linspace(0.0, 0.6, 601)
    p = replace(TABLE_2, kc=100.0, W0=1.0, height=height)
    history = confined_slip(p, RT, 0.0, slips, -1.0)
    for row, (_, s_N, tau) in zip(rows_at(slips, (0.1, 0.2, 0.4, 0.6)), facts, strict=True):
        assert history.separation[row, 0] == pytest.approx(s_N, abs=PRINTED)
        assert history.traction[row, 1] == pytest.approx(tau, abs=PRINTED)
    share = worn_share(RT, history.state[-1])
    assert share[0] == 0.0 and share[2] == 0.0  # flat, and facing away
    if omega is not None:
        assert share[1] == pytest.approx(omega, abs=PRINTED)
        return
    stored, rupture, dissipated = history.state[-1, 1:4]
    work = history.work[-1]
    friction, wear = dissipation(p, RT, history, 20)
    assert (stored, rupture, work) == pytest.approx((0.003016, 0.314535, 0.684982), abs=PRINTED)
    assert (friction, wear) == pytest.approx((0.272140, 0.095522), abs=PRINTED)
    assert friction + wear == pytest.approx(dissipated, rel=ROUNDING)


def dissipation(p, pattern, history: SlipHistory, preload: int) -> tuple[float, float]:
    """Return friction and wear of a confined slip per unit area of the interface, summed over increments.

    The increments of the preload are not rows of the history and are not included.
    """
    assert not history.state[0, 3] and preload
    response = update(p, pattern, history.separation[1:], history.state[:-1], history.separation[:-1])
    return tuple(float((pattern[1] * part).sum()) for part in (response.friction, response.wear))


@pytest.mark.slow
def test_wear_in_cycles():
    """With W0 1, H .5 the dilation decreases in the cycle 0, .4, -.4, .4; increments are .001."""
    p = replace(TABLE_2, kc=100.0, W0=1.0, height=0.5)
    history = confined_slip(p, RT, 0.0, cycle(0.4, -0.4, 0.4, step=0.001), -1.0)
    turns = 400 + 800 * np.arange(3)
    s_N = [0.113112, 0.086323, 0.034463]
    tau = [0.813697, -0.732623, 0.588265]
    assert np.allclose(history.separation[turns, 0], s_N, rtol=0, atol=PRINTED)
    assert np.allclose(history.traction[turns, 1], tau, rtol=0, atol=PRINTED)


def test_wear_of_rp4():
    """Wear of RP-4 agrees with the known values for kc 20, H .3, W0 2, direction 20, increments of .001.

    The preload to sigma_N -5 has 50 increments.
    """
    slips = 0.001 * np.arange(601)
    history = confined_slip(replace(TABLE_2, kc=20.0, height=0.3, W0=2.0), RP_4, 20.0, slips, -5.0, 50)
    facts = [(0.033889, 6.702041), (0.027143, 2.062786), (0.036000, 2.867669), (0.027411, 2.592890)]
    for row, (s_N, tau) in zip(rows_at(slips, (0.1, 0.2, 0.4, 0.6)), facts, strict=True):
        assert history.separation[row, 0] == pytest.approx(s_N, abs=PRINTED)
        assert along(history, 20.0)[row] == pytest.approx(tau, abs=PRINTED)


@pytest.mark.parametrize("height", [0.0, 0.5])
def test_wear_is_of_first_order_with_a_small_constant(height):
    """For RT at s_L .4 increments of 0.2 s0 have an error below 0.3 %; half the size halves the error."""
    p = replace(TABLE_2, kc=100.0, W0=1.0, height=height)
    ends = []
    for parts in (100, 200, 400):
        history = confined_slip(p, RT, 0.0, np.linspace(0.0, 0.4, parts + 1), -1.0)
        ends.append(history.traction[-1, 1])
    errors = np.abs(np.array(ends[:2]) / (2.0 * ends[2] - ends[1]) - 1.0)
    assert errors[0] < 0.003
    assert 1.6 < errors[0] / errors[1] < 2.6


def test_worn_out_joint_keeps_mu():
    """After a frictional work of hundreds of W0 the strength is mu |sigma_N| and there is no dilation."""
    p = replace(TABLE_2, kc=100.0, W0=0.01, height=0.3)
    history = confined_slip(p, RT, 0.0, np.linspace(0.0, 3.0, 601), -1.0, state=broken(RT, p))
    assert history.traction[-1, 1] == pytest.approx(p.mu, rel=0.02)
    assert history.separation[:, 0].max() < 0.1 and abs(history.separation[-1, 0]) < 0.01
