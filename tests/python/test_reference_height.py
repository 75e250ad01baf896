"""Finite asperity height and wear in the NumPy reference: kinematics, tangent, known values, properties.

A separate program computed the known values before this reference was written.  They are printed with six
decimals or seven digits; the tolerance is half a unit of the last digit.
"""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal, localcontext
from itertools import pairwise, product

import numpy as np
import pytest
from asperity.oracle.facet import arc_length, arc_length_by_rho, facets, profile, uphill_axes
from asperity.oracle.reference import (
    HEADER,
    OPEN,
    PER_PLANE,
    SLIP,
    STICK,
    Parameters,
    SlipHistory,
    confined_slip,
    frames,
    regular_pattern,
    replay,
    update,
    virgin,
)

pytestmark = pytest.mark.slow

TABLE_2 = Parameters(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
THETA = 30.0
RT = regular_pattern(2, THETA)
RP_4 = regular_pattern(4, THETA)
FLAT = regular_pattern(0, 0.0)

EPSILON = np.finfo(float).eps
ROUNDING = 1.0e-12
"""Relative: a few operations in double precision, and the tolerance of the equilibrium solve."""

PRINTED = 5.0e-7
"""Half of the last printed decimal."""

CURVED = ({"height": 0.3}, {"W0": 1.0}, {"height": 0.3, "W0": 1.0})


def along(history: SlipHistory, direction_deg: float) -> np.ndarray:
    """Return the traction along the slip."""
    angle = np.radians(direction_deg)
    return history.traction[..., 1] * np.cos(angle) + history.traction[..., 2] * np.sin(angle)


def cycle(*ends: float, step: float) -> np.ndarray:
    """Return slips from 0 to each of the ends in turn in equal increments, 0 included."""
    legs = [np.zeros(1)]
    for start, end in zip((0.0, *ends[:-1]), ends, strict=True):
        legs.append(np.linspace(start, end, round(abs(end - start) / step) + 1)[1:])
    return np.concatenate(legs)


def rows_at(slips: np.ndarray, ends: tuple[float, ...]) -> list[int]:
    """Return the rows of monotonic slips that are nearest to the ends."""
    return [int(np.argmin(np.abs(slips - end))) for end in ends]


def broken(pattern, parameters: Parameters) -> np.ndarray:
    """Return the state of a point whose planes are all fully damaged."""
    state = virgin(pattern, parameters.wears)
    state[HEADER : HEADER + PER_PLANE * len(pattern[1]) : PER_PLANE] = 1.0
    return state


def worn_share(pattern, state: np.ndarray) -> np.ndarray:
    """Return omega of every plane."""
    return state[..., HEADER + PER_PLANE * len(pattern[1]) :: 2]


def random_walk(seed: int, increments: int, points: int, size: float = 1.5 * TABLE_2.s0) -> np.ndarray:
    """Return random separations (increments, points, 3)."""
    return np.cumsum(np.random.default_rng(seed).normal(0.0, size, (increments, points, 3)), axis=0)


# --- kinematics of the facet --------------------------------------------------------------------------------


def exact_arc(T: float, m: float, rho: float) -> tuple[float, float]:
    """Return A T/H and dA/drho T/H at u = m H/T by the closed forms of the theory in 80 digits."""
    with localcontext() as context:
        context.prec = 80
        x_0 = Decimal(rho) * Decimal(T)
        x_1 = x_0 * (-Decimal(m)).exp()

        def F(x: Decimal) -> Decimal:
            root = (1 + x * x).sqrt()
            return root - ((1 + root) / x).ln()

        root_0, root_1 = (1 + x_0 * x_0).sqrt(), (1 + x_1 * x_1).sqrt()
        return float(F(x_0) - F(x_1)), float((root_0 - root_1) / Decimal(rho))


def test_arc_length_keeps_its_digits():
    """The relative error of A and dA/drho is at most ten rounding errors.

    u T ranges from 1e-12 H to 100 H, the slope up to 89 degrees.
    """
    for T, m, rho in product(10.0 ** np.linspace(-3, 1.778, 12), 10.0 ** np.linspace(-12, 2, 29), (1.0, 0.3)):
        height = 0.7
        u = m * height / T
        expected, by_rho = exact_arc(T, u * T / height, rho)
        arguments = np.array(u), np.array(T), height, np.array(rho)
        assert arc_length(*arguments) * T / height == pytest.approx(expected, rel=10 * EPSILON)
        assert arc_length_by_rho(*arguments) * T / height == pytest.approx(by_rho, rel=10 * EPSILON)


@pytest.mark.parametrize("rho", [1.0, 0.4, 0.0])
@pytest.mark.parametrize("height", [0.0, 0.2])
def test_arc_length_is_the_integral_along_the_profile(height, rho):
    """The arc length equals the Gauss quadrature of sqrt(1 + z'^2) over [0, u] with 40 points."""
    points, weights = np.polynomial.legendre.leggauss(40)
    u, T = np.array([-0.6, -1e-3, 0.0, 1e-6, 0.05, 0.3, 0.7]), np.tan(np.radians(50.0))
    at = u[:, None] * 0.5 * (1.0 + points)
    slope = profile(at, np.array(T), height)[1]
    expected = 0.5 * u * (weights * np.sqrt(1.0 + (rho * slope) ** 2)).sum(-1)
    got = arc_length(u, np.array(T), height, np.array(rho))
    assert np.allclose(got, expected, rtol=1e-13, atol=0)


def test_mobilised_slope_and_profile():
    """The mobilised slope is tan(phi) = T exp(-u T/H) = T (1 - z/H), and z tends to H.

    The profile is straight for u <= 0 and for infinite height.
    """
    u, T, H = np.linspace(-1.0, 5.0, 61), np.array(0.8), 0.3
    z, slope, second, third = profile(u, T, H)
    up = u > 0.0
    assert np.allclose(slope[up], T * np.exp(-u * T / H)[up], rtol=ROUNDING)
    assert np.allclose(slope[up], T * (1.0 - z[up] / H), rtol=0, atol=ROUNDING)
    assert z[-1] == pytest.approx(H, rel=1e-5)
    assert np.array_equal(z[~up], T * u[~up]) and (slope[~up] == T).all()
    assert not second[~up].any() and not third[~up].any()
    assert np.allclose(second[up], -T / H * slope[up]) and np.allclose(third[up], (T / H) ** 2 * slope[up])
    assert np.array_equal(profile(u, T, 0.0)[0], u * T)


def test_uphill_is_where_the_plane_rises():
    """On the plane w = u T; e and h are horizontal, and a plane without slope has the global axes."""
    pattern = regular_pattern(5, 40.0, turn_deg=13.0)
    axes, T = uphill_axes(frames(pattern[0]))
    assert np.array_equal(axes[0], np.eye(3)) and T[0] == 0.0
    assert np.allclose(T[1:], np.tan(np.radians(40.0)))
    assert np.allclose(axes @ axes.swapaxes(-1, -2), np.eye(3), atol=1e-15)
    on_plane = axes[:, 1] + T[:, None] * axes[:, 0]
    assert np.abs((pattern[0] * on_plane).sum(-1)).max() <= 1e-15


@pytest.mark.parametrize("height", [0.0, 0.3])
def test_derivatives_of_the_facet(height):
    """G, the second derivatives and those with respect to omega equal differences in extended precision.

    Fourth-order differences with steps of 3e-4 H have an error of 1e-12; rounding adds 1e-15.
    """
    rng = np.random.default_rng(2)
    frame = frames(regular_pattern(5, 55.0, turn_deg=9.0)[0])
    s = rng.normal(0.0, 0.3, (400, 3)).astype(np.longdouble)
    omega = rng.uniform(0.0, 0.9, (400, len(frame))).astype(np.longdouble)
    step = np.longdouble(1e-4)
    here = facets(frame, s, height, omega)
    u = s @ uphill_axes(frame)[0][:, 1].T
    smooth = np.abs(u) > 3.0 * step

    def difference(field: str, ds: np.ndarray, domega: float) -> np.ndarray:
        """Return the derivative of a field along a change of the separation and of omega."""
        out = 0.0
        for k, weight in ((1, 8.0), (2, -1.0)):
            sides = [facets(frame, s + i * step * ds, height, omega + i * step * domega) for i in (k, -k)]
            out = out + weight * (getattr(sides[0], field) - getattr(sides[1], field)) / (12.0 * step)
        return out

    assert here.local.dtype == np.longdouble
    for j, ds in enumerate(np.eye(3)):
        of_local, of_gradient = difference("local", ds, 0.0), difference("gradient", ds, 0.0)
        assert np.abs(here.gradient[..., j] - of_local)[smooth].max() <= 1e-11
        assert np.abs(here.curvature[..., j] - of_gradient[..., :2, :])[smooth].max() <= 1e-9
        assert np.abs(of_gradient[..., 2, :]).max() <= 1e-14  # s_h is linear
    assert np.abs(here.by_omega - difference("local", np.zeros(3), 1.0))[smooth].max() <= 1e-11


# --- limits -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kc", [1.0, 5.0])
def test_without_height_and_wear_the_paper_s_law(kc):
    """Without height and wear the law is that of the paper.

    H = 0 and W0 = 0 give the same bits as the defaults; H = 1e12 s_f and W0 = 1e12 Gc agree to rounding.
    """
    p = replace(TABLE_2, kc=kc)
    pattern, path = regular_pattern(5, 40.0, turn_deg=11.0), random_walk(1, 60, 50)
    for guard in (False, True):
        plain = replay(replace(p, guard=guard), pattern, path)
        zero = replay(replace(p, height=0.0, W0=0.0, guard=guard), pattern, path)
        for name in ("traction", "state", "tangent", "branch", "friction", "wear"):
            assert np.array_equal(getattr(zero, name), getattr(plain, name))
    plain = replay(p, pattern, path)
    scale = p.kc * p.Kn * np.abs(path).max()
    entries = HEADER + PER_PLANE * len(pattern[1])
    for end in ({"height": 1e12 * p.sf}, {"W0": 1e12 * p.Gc}, {"height": 1e12 * p.sf, "W0": 1e12 * p.Gc}):
        far = replay(replace(p, **end), pattern, path)
        assert np.abs(far.traction - plain.traction).max() <= 1e-11 * scale
        assert np.abs(far.state[..., :entries] - plain.state).max() <= 1e-10 * scale
        assert np.abs(far.tangent - plain.tangent).max() <= 1e-8 * p.kc * p.Kn
        assert np.array_equal(far.branch, plain.branch)


def test_height_of_a_million_separations_at_rupture():
    """With H = 1e6 s_f the profile z differs from u T by (u T)^2/(2 H).

    This is 1e-6 of the traction on paths of a few s_f.
    """
    path = random_walk(2, 60, 200)
    plain = replay(TABLE_2, RP_4, path)
    far = replay(replace(TABLE_2, height=1e6 * TABLE_2.sf), RP_4, path)
    largest = np.maximum.accumulate(np.linalg.norm(path, axis=-1), axis=0)
    assert 2.0 * TABLE_2.sf < largest.max() < 6.0 * TABLE_2.sf
    error = np.abs(far.traction - plain.traction).max(axis=-1)
    assert (error <= 1e-6 * TABLE_2.Kn * largest).all()
    assert error.max() > 0.0


def test_small_height_leaves_a_flat_joint():
    """With H = 1e-6 s_f and fully damaged planes the strength is mu |sigma_N| without dilation.

    The slip is not along the horizontal direction of any plane.
    """
    p = replace(TABLE_2, height=1e-6 * TABLE_2.sf, kc=10.0)
    history = confined_slip(p, RP_4, 20.0, np.linspace(0.0, 0.1, 21), -1.0, state=broken(RP_4, p))
    assert along(history, 20.0)[-1] == pytest.approx(p.mu, rel=1e-9)
    climbed = (RP_4[0][1:, 1:] @ history.separation[-1, 1:] < 0.0).sum()  # those that face the slip
    touching = RP_4[1][0] + climbed * RP_4[1][1]
    assert climbed == 2
    assert history.separation[-1, 0] == pytest.approx(p.height - 1.0 / (touching * p.kc * p.Kn), rel=1e-3)


@pytest.mark.parametrize("more", CURVED)
def test_planes_without_slope_have_no_facet(more):
    """A flat pattern follows the law of the paper and has no wear."""
    path = random_walk(3, 60, 50)
    plain, other = replay(TABLE_2, FLAT, path), replay(replace(TABLE_2, **more), FLAT, path)
    assert np.allclose(other.traction, plain.traction, rtol=0, atol=1e-13 * TABLE_2.Kn)
    assert np.allclose(other.tangent, plain.tangent, rtol=0, atol=1e-11 * TABLE_2.Kn)
    assert np.allclose(other.state[..., : HEADER + 3], plain.state, rtol=0, atol=1e-11)
    assert not other.state[..., HEADER + 3 :].any() and not other.wear.any()


@pytest.mark.parametrize(
    ("name", "value"), [("height", -0.1), ("W0", -1.0), ("height", np.nan), ("W0", np.inf)]
)
def test_bad_parameters_are_named(name, value):
    """The error message names a height or W0 that is negative or not finite."""
    with pytest.raises(ValueError, match=name):
        replace(TABLE_2, **{name: value})


# --- tangent ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kc", [1.0, 5.0])
@pytest.mark.parametrize("more", CURVED)
def test_tangent_in_every_branch(more, kc):
    """The tangent equals fourth-order differences in extended precision to 1e-12 of K.

    omega is constant in the increment.  The cases are both sides of u = 0, open, sticking and slipping
    facets, and damage that grows or does not grow.
    """
    p = Parameters(3.0, 0.3, 0.9, 0.5, sigma02=4.0, Gc2=0.5, kc=kc, **more)
    pattern = regular_pattern(2, 40.0, flat=0.0)[0][:1], np.array([1.0])
    frame, points = frames(pattern[0]), 6000
    rng = np.random.default_rng(11)
    s, s_old = p.sf * rng.uniform(-0.6, 0.6, (2, points, 3)).astype(np.longdouble)
    s[:, 0] *= rng.choice([0.1, 1.0], points)
    omega = np.clip(rng.uniform(-0.3, 0.9, (points, 1)), 0.0, 1.0) * p.wears
    state = np.tile(virgin(pattern, p.wears), (points, 1)).astype(np.longdouble)
    state[:, HEADER] = np.clip(rng.uniform(-0.3, 1.2, points), 0.0, 1.0)
    near = facets(frame, s, p.height, omega).local[:, 0, 1:]
    state[:, HEADER + 1 : HEADER + 3] = near + p.sf * rng.normal(0.0, 0.15, (points, 2))
    if p.wears:
        state[:, HEADER + 3] = omega[:, 0]
        state[:, HEADER + 4] = rng.uniform(0.0, 2.0, points)
    centre = update(p, pattern, s, state, s_old)
    assert centre.tangent.dtype == np.longdouble

    def sides(s: np.ndarray, answer) -> np.ndarray:
        """Return the branches, which must not change between the points of a difference."""
        straight, uphill = s @ frame[0, 0], s @ uphill_axes(frame)[0][0, 1]
        full = answer.state[:, HEADER] == 1.0
        return np.stack([straight > 0, uphill > 0, full, answer.branch[:, 0], answer.damaging[:, 0]])

    step = np.longdouble(2.0e-5) * p.s0
    here = sides(s, centre)
    smooth = np.ones(points, dtype=bool)
    numerical = np.zeros((points, 3, 3), np.longdouble)
    for j, (k, weight) in product(range(3), ((1, 8.0), (-1, -8.0), (2, -1.0), (-2, 1.0))):
        moved = s + k * step * np.eye(3)[j]
        answer = update(p, pattern, moved, state, s_old)
        numerical[:, :, j] += weight * answer.traction / (12.0 * step)
        smooth &= (sides(moved, answer) == here).all(axis=0)
    error = np.abs(centre.tangent - numerical).max(axis=(1, 2)) / (max(p.Kn, p.Kt) * kc)
    fresh = here[4].astype(bool) & ~here[2].astype(bool)
    for which, grows, climbs in product((OPEN, STICK, SLIP), (False, True), (False, True)):
        chosen = smooth & (here[3] == which) & (fresh == grows) & (here[1] == climbs)
        assert chosen.sum() >= 10, (which, grows, climbs, chosen.sum())
        assert error[chosen].max() <= 1e-12, (which, grows, climbs)
    assert smooth.mean() > 0.99


def test_tangent_of_whole_patterns_on_random_histories():
    """The tangent of a whole pattern after wear equals second-order differences in double precision."""
    p = replace(TABLE_2, height=0.2, W0=0.3)
    for sides, turn in ((2, 10.0), (3, 0.0), (6, 33.0)):
        pattern = regular_pattern(sides, THETA, turn_deg=turn)
        path = random_walk(sides, 14, 200)
        before, (s_old, s) = replay(p, pattern, path[:-1]).state[-1], path[-2:]
        centre = update(p, pattern, s, before, s_old)
        assert worn_share(pattern, before).max() > 0.3
        step, numerical, smooth = 1.0e-6 * p.s0, np.empty((200, 3, 3)), np.ones(200, dtype=bool)
        for j in range(3):
            move = step * np.eye(3)[j]
            ends = [update(p, pattern, s + move, before, s_old), update(p, pattern, s - move, before, s_old)]
            numerical[:, :, j] = (ends[0].traction - ends[1].traction) / (2.0 * step)
            for end in ends:
                smooth &= (end.branch == centre.branch).all(-1) & (end.damaging == centre.damaging).all(-1)
        assert smooth.sum() > 190
        assert np.abs(centre.tangent - numerical)[smooth].max() <= 2.0e-6 * p.Kn


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
    slips = 0.0005 * np.arange(1201)
    history = confined_slip(replace(TABLE_2, kc=20.0, height=0.3), RP_4, 20.0, slips, -5.0)
    facts = [(0.1, 0.033889, 6.702041), (0.2, 0.076697, 5.496957), (0.4, 0.142035, 4.435904),
             (0.6, 0.187203, 3.782805)]  # fmt: skip
    for row, (_, s_N, tau) in zip(rows_at(slips, (0.1, 0.2, 0.4, 0.6)), facts, strict=True):
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
    """With W0 1, H .5 the dilation decreases in the cycle 0, .4, -.4, .4, -.4, .4; increments are .001."""
    p = replace(TABLE_2, kc=100.0, W0=1.0, height=0.5)
    history = confined_slip(p, RT, 0.0, cycle(0.4, -0.4, 0.4, -0.4, 0.4, step=0.001), -1.0)
    turns = 400 + 800 * np.arange(5)
    s_N = [0.113112, 0.086323, 0.034463, 0.026625, 0.010676]
    tau = [0.813697, -0.732623, 0.588265, -0.567765, 0.527038]
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


# --- properties on random histories -------------------------------------------------------------------------


@pytest.mark.parametrize("kc", [1.0, 20.0])
@pytest.mark.parametrize("more", CURVED)
def test_friction_and_wear_never_negative(more, kc):
    """Friction and wear are never negative in 200,000 increments over the six cases.

    Soft contact and closures larger than H are among the cases.
    """
    p = replace(TABLE_2, kc=kc, **{**more, **({"W0": 0.3} if "W0" in more else {})})
    path = random_walk(int(kc), 40, 850, 3.0 * p.s0)
    response = replay(p, regular_pattern(3, 40.0), path)
    assert -path[..., 0].min() > 0.3
    assert response.friction.min() >= 0.0 and response.wear.min() >= 0.0
    assert response.friction.max() > 0.0 and (response.wear.max() > 0.0) == p.wears
    assert (np.diff(response.state[..., 3], axis=0) >= 0.0).all()
    if p.wears:
        share = worn_share(regular_pattern(3, 40.0), response.state)
        assert (np.diff(share, axis=0) >= 0.0).all() and 0.0 <= share.min() and 0.9 < share.max() <= 1.0


def work_along(path: np.ndarray, traction: np.ndarray) -> np.ndarray:
    """Return the work (T, ...) of the traction (T, ..., 3) along a path from 0 by the trapezoidal rule."""
    before = np.concatenate([np.zeros_like(traction[:1]), traction[:-1]])
    return np.cumsum(0.5 * ((before + traction) * np.diff(path, axis=0, prepend=0.0)).sum(-1), axis=0)


def refined(path: np.ndarray, parts: int) -> np.ndarray:
    """Return a path from 0 with every straight piece divided into equal increments."""
    corners = np.concatenate([np.zeros_like(path[:1]), path])
    share = (np.arange(1, parts + 1) / parts)[:, None, None]
    return np.concatenate([start + share * (end - start) for start, end in pairwise(corners)])


@pytest.mark.slow
@pytest.mark.parametrize("more", CURVED)
def test_ledger_closes_at_second_order(more):
    """The error of the balance work = stored + rupture + friction and wear is of second order.

    Half the increments give a quarter of the error (median of 200) for a soft contact.  In a stiff contact a
    wearing facet loses its elastic slip within a few increments of any size, and this error does not vanish.
    """
    p = replace(TABLE_2, **more)
    path = np.cumsum(np.random.default_rng(5).normal(0.0, p.s0, (8, 200, 3)), axis=0)
    gaps = []
    for parts in (16, 32, 64):
        fine = refined(path, parts)
        response = replay(p, RP_4, fine)
        spent = response.state[..., 1:4].sum(-1)
        gaps.append(np.abs(work_along(fine, response.traction) - spent)[parts - 1 :: parts].max(axis=0))
    assert (response.wear.max() > 0.0) == p.wears
    ratios = np.median([gaps[0] / gaps[1], gaps[1] / gaps[2]], axis=1)
    assert (ratios > 3.7).all() and (ratios < 4.3).all()
    assert np.median(gaps[-1]) < 1e-4 * p.Gc / 0.3


def test_traction_steps_at_the_foot_of_a_pressed_facet():
    """The curvature of the profile is discontinuous at u = 0, so that dg/du and ds_t/du jump there.

    The traction of the damaged part along e then jumps by the factor 1 + sin^2(theta) closure/H.  The energy
    balance is therefore of first order where u changes sign under pressure.
    """
    p = replace(TABLE_2, height=0.2, kc=20.0)
    pattern = regular_pattern(2, THETA, flat=0.0)[0][:1], np.array([1.0])
    closure = 0.02
    tractions = [
        update(p, pattern, [-closure, u, 0.0], broken(pattern, p)).traction for u in (-1e-13, 0.0, 1e-13)
    ]
    factor = 1.0 + closure / p.height * np.sin(np.radians(THETA)) ** 2
    assert tractions[2][1] / tractions[1][1] == pytest.approx(factor, rel=1e-9)
    assert tractions[1][1] == pytest.approx(tractions[0][1], rel=1e-9)
    assert tractions[2][0] == pytest.approx(tractions[0][0], rel=1e-9)


def test_guard_does_not_depend_on_rounding():
    """The guard changes nothing in any of 2000 directions for slopes up to 85 degrees.

    The planes are pressed and stick, have never slipped, and move downhill or have no facet.  Y is zero
    except for rounding errors, and the damage grows.
    """
    angle = np.linspace(0.5, 1.5, 2000) * np.pi  # e is Tx
    for theta, more in product((10.0, 30.0, 60.0, 85.0), ({}, *CURVED)):
        p = replace(TABLE_2, mu=1e4, **more)
        pattern = regular_pattern(2, theta, flat=0.0)[0][:1], np.array([1.0])
        slip = 3.0 * p.s0 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
        s_N = slip[:, 0] * np.tan(np.radians(theta)) - p.s0  # s_n = -s0 cos(theta)
        s = np.column_stack([s_N, slip])
        free, guarded = update(p, pattern, s), update(replace(p, guard=True), pattern, s)
        assert (free.branch == STICK).all() and free.damaging.all()
        assert np.array_equal(guarded.state[:, HEADER], free.state[:, HEADER])


def test_guard_keeps_the_release_from_falling():
    """With facets the guard keeps every increment of the rupture energy non-negative except for rounding."""
    p = replace(TABLE_2, height=0.2, W0=0.5, kc=4.0)
    path = random_walk(18, 60, 300)
    path[..., 0] = -np.abs(path[..., 0])
    changes = [np.diff(replay(replace(p, guard=on), RP_4, path).state[..., 2], axis=0) for on in (0, 1)]
    falls = [change.min() for change in changes]
    assert falls[0] < -1e-3
    assert falls[1] >= -1e-13 * p.Kn * (path**2).sum(-1).max()


# --- invariances --------------------------------------------------------------------------------------------

WORN = replace(TABLE_2, height=0.2, W0=0.3)
"""Height and wear that matter on the random walks below."""


def test_batches_equal_single_points():
    """The leading axes are independent points."""
    pattern, path = regular_pattern(5, 25.0, flat=0.1, turn_deg=20.0), random_walk(7, 20, 6)
    batch = replay(WORN, pattern, path)
    for j in range(6):
        single = replay(WORN, pattern, path[:, j])
        for name, size in (("traction", 1e-12), ("state", 1e-12), ("tangent", 1e-9), ("wear", 1e-13)):
            assert np.allclose(getattr(batch, name)[:, j], getattr(single, name), rtol=0, atol=size)


def test_turning_pattern_and_separation_together():
    """A rotation of pattern and separation rotates the tractions and does not change energies and wear."""
    c, s = np.cos(np.radians(37.0)), np.sin(np.radians(37.0))
    turn = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])
    path = random_walk(1, 60, 40)
    plain = replay(WORN, regular_pattern(3, THETA), path)
    turned = replay(WORN, regular_pattern(3, THETA, turn_deg=37.0), path @ turn.T)
    assert np.allclose(turned.traction, plain.traction @ turn.T, rtol=0, atol=1e-10)
    inclined = HEADER + PER_PLANE  # the slip of the flat plane turns
    assert np.allclose(turned.state[..., :4], plain.state[..., :4], rtol=0, atol=1e-10)
    assert np.allclose(turned.state[..., inclined:], plain.state[..., inclined:], rtol=0, atol=1e-10)
    assert worn_share(regular_pattern(3, THETA), plain.state).max() > 0.9


def test_mirror():
    """For a pattern symmetric about Tx a mirrored path gives the mirrored traction."""
    mirror, path = np.array([1.0, 1.0, -1.0]), random_walk(2, 60, 40)
    plain = replay(WORN, regular_pattern(5, THETA), path)
    mirrored = replay(WORN, regular_pattern(5, THETA), path * mirror)
    assert np.allclose(mirrored.traction, plain.traction * mirror, rtol=0, atol=1e-10)


def test_units():
    """Results in mm, MPa and in m, Pa agree: lengths 1e-3, stresses 1e6, energies per area 1e3."""
    si = Parameters(3.0e6, 300.0, 0.9, 0.5, height=1e-3 * WORN.height, W0=1e3 * WORN.W0)
    path = random_walk(3, 60, 40)
    plain, scaled = replay(WORN, RP_4, path), replay(si, RP_4, 1e-3 * path)
    assert np.allclose(1e-6 * scaled.traction, plain.traction, rtol=0, atol=1e-10)
    assert np.allclose(1e-3 * scaled.state[..., 1:4], plain.state[..., 1:4], rtol=0, atol=1e-10)
    assert np.allclose(1e-9 * scaled.tangent, plain.tangent, rtol=0, atol=1e-6)
    assert np.allclose(worn_share(RP_4, scaled.state), worn_share(RP_4, plain.state), rtol=0, atol=1e-10)


def test_offset_in_the_state_is_added_to_the_separation():
    """The facets include the offset at both ends of an increment."""
    shift, path = np.array([-0.02, 0.03, -0.01]), random_walk(4, 20, 30)
    path[0] = 0.0
    plain = replay(WORN, RP_4, path + shift)
    state = np.tile(virgin(RP_4, True), (30, 1))
    state[:, 5:8] = shift
    s_old = np.broadcast_to(-shift, (30, 3))
    for row, s in enumerate(path):
        response = update(WORN, RP_4, s, state, s_old)
        state, s_old = response.state, s
        assert np.allclose(response.traction, plain.traction[row], rtol=0, atol=1e-10)
        assert np.allclose(state[:, HEADER:], plain.state[row, :, HEADER:], rtol=0, atol=1e-11)
