"""Finite asperity height and wear in the NumPy reference: kinematics, limits, tangent."""

from __future__ import annotations

from dataclasses import replace
from decimal import Decimal, localcontext
from itertools import product

import numpy as np
import pytest
from support_height import (
    CURVED,
    EPSILON,
    FLAT,
    ROUNDING,
    RP_4,
    TABLE_2,
    THETA,
    along,
    broken,
    random_walk,
    worn_share,
)

from tests.oracle.facet import arc_length, arc_length_by_rho, facets, profile, uphill_axes
from tests.oracle.reference import (
    HEADER,
    OPEN,
    PER_PLANE,
    SLIP,
    STICK,
    Parameters,
    confined_slip,
    frames,
    regular_pattern,
    replay,
    update,
    virgin,
)

pytestmark = pytest.mark.slow

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
