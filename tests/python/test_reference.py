"""The NumPy reference of the law for one increment: patterns, one plane, tangent, invariance, the 2D law."""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
from support_reference import (
    FLAT,
    ROUNDING,
    RT,
    TABLE_2,
    THETA,
    facing_plane,
)

from tests.oracle import planar
from tests.oracle.reference import (
    HEADER,
    OPEN,
    SLIP,
    STICK,
    Parameters,
    frames,
    listed_pattern,
    regular_pattern,
    replay,
    update,
    virgin,
)

# --- patterns and parameters --------------------------------------------------------------------------------


def test_patterns_are_those_of_the_tables():
    """Tables 1 and 3 and the weights of Table 4; the order is that of (41)-(43), flat plane first."""
    c, s = np.cos(np.radians(THETA)), np.sin(np.radians(THETA))
    normals, weights = RT  # Table 1, whose planes 2 and 3 (41)-(43) list in the other order
    assert np.allclose(normals, [[1, 0, 0], [c, -s, 0], [c, s, 0]], atol=1e-15)
    assert np.allclose(weights, 1.0 / 3.0)
    normals, weights = regular_pattern(4, THETA, flat=0.2)  # Table 3
    assert np.allclose(normals, [[1, 0, 0], [c, -s, 0], [c, 0, -s], [c, s, 0], [c, 0, s]], atol=1e-15)
    assert np.allclose(weights, 0.2)
    for sides, share in ((3, 0.22222), (6, 0.11111), (32, 0.02083)):  # Table 4
        assert np.allclose(regular_pattern(sides, THETA)[1][1:], share, atol=5e-6)


def test_degenerate_patterns():
    """Patterns without inclined or flat plane; listed planes keep their order and are normalised."""
    assert FLAT[0].tolist() == [[1.0, 0.0, 0.0]] and FLAT[1].tolist() == [1.0]
    assert len(regular_pattern(4, THETA, flat=0.0)[1]) == 4
    assert len(regular_pattern(4, THETA, flat=1.0)[1]) == 1
    normals, _ = listed_pattern([[2.0, 0.0, 0.0], [3.0, 0.0, 4.0]], [0.25, 0.75])
    assert np.allclose(normals, [[1, 0, 0], [0.6, 0, 0.8]], rtol=0, atol=1e-15)


def test_frames_follow_equation_1():
    """The frames are the cross products (1); the frame of the flat plane has the global axes."""
    normals, _ = regular_pattern(5, 40.0, turn_deg=13.0)
    frame = frames(normals)
    for n, (n_row, t, h) in zip(normals[1:], frame[1:], strict=True):
        across = np.cross([1.0, 0.0, 0.0], n)
        assert np.allclose(h, across / np.linalg.norm(across), atol=1e-15)
        assert np.allclose(t, np.cross(n, h), atol=1e-15)
        assert np.array_equal(n, n_row)
    assert np.array_equal(frame[0], np.eye(3))


# --- one plane ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_bilinear_law_of_figure_2(axis):
    """Pure modes with different mode II values: peak, slope and area of the triangle."""
    p = Parameters(3.0, 0.3, 0.9, 0.0, sigma02=5.0, Gc2=0.7)
    strength, energy = ((p.sigma0, p.Gc), (5.0, 0.7))[axis > 0]
    s_f = 2.0 * energy / strength
    s = np.linspace(0.0, 1.2 * s_f, 601)
    path = np.zeros((601, 3))
    path[:, axis] = s
    s_0 = (1.0 - p.eta) * s_f
    expected = np.where(s <= s_0, strength * s / s_0, np.maximum(0.0, strength * (s_f - s) / (s_f - s_0)))
    got = replay(p, FLAT, path).traction
    assert np.abs(got[:, axis] - expected).max() <= ROUNDING * strength
    assert not got[:, [i for i in range(3) if i != axis]].any()


def test_compression_is_elastic_with_the_closing_stiffness():
    """The normal stiffness is kc Kn in closing and Kn in opening, virgin or fully damaged."""
    for kc in (1.0, 7.0):
        p = Parameters(3.0, 0.3, 0.9, 0.5, kc=kc)
        broken = replay(p, FLAT, [[0.3, 0.0, 0.0], [-0.01, 0.0, 0.0]])
        assert broken.state[-1, 0] == 1.0
        assert broken.traction[-1, 0] == pytest.approx(-0.01 * kc * p.Kn, rel=ROUNDING)
        assert update(p, FLAT, [-0.01, 0, 0]).traction[0] == pytest.approx(-0.01 * kc * p.Kn, rel=ROUNDING)
        assert update(p, FLAT, [0.01, 0, 0]).traction[0] == pytest.approx(0.01 * p.Kn, rel=ROUNDING)


def test_friction_strength_scales_with_the_closing_stiffness():
    """The friction strength is mu times the contact pressure kc Kn |s_n|."""
    p = Parameters(3.0, 0.3, 0.9, 0.5, kc=7.0)
    r = update(p, FLAT, [-0.01, 0.0, 2.0])  # fully damaged because |s_T| > s_f, and slipping
    assert r.traction[2] == pytest.approx(p.mu * 0.01 * p.kc * p.Kn, rel=ROUNDING)


def test_compression_damages_inclined_planes_once_their_slip_exceeds_s02():
    """An inclined plane slips by |s_N| sin(theta) under pure closing; the flat one has no damage."""
    onset = TABLE_2.s02 / np.sin(np.radians(THETA))
    normals, _ = pattern = regular_pattern(4, THETA)
    assert update(TABLE_2, pattern, [-0.999 * onset, 0, 0]).state[0] == 0.0
    r = 1.25
    state = update(TABLE_2, pattern, [-r * onset, 0, 0]).state
    assert np.allclose(state[HEADER + 3 :: 3], (1.0 - 1.0 / r) / TABLE_2.eta, rtol=ROUNDING)
    assert state[HEADER] == 0.0 and len(normals) == 5


def test_offset_in_the_state_is_added_to_the_separation():
    """Entries 6-8 of the state are added to both separations of an increment and do not change."""
    pattern = regular_pattern(3, THETA)
    shift = np.array([-0.01, -0.02, 0.03])
    first, second = np.array([0.004, 0.005, 0.006]), np.array([0.01, 0.02, 0.05])
    state = virgin(pattern)
    state[5:8] = shift
    shifted = update(TABLE_2, pattern, first, state)
    plain = update(TABLE_2, pattern, shift + first)
    shifted_on = update(TABLE_2, pattern, second, shifted.state, first)
    plain_on = update(TABLE_2, pattern, shift + second, plain.state, shift + first)
    for one, other in ((shifted, plain), (shifted_on, plain_on)):
        assert np.allclose(one.traction, other.traction, rtol=ROUNDING)
        assert np.allclose(one.state[HEADER:], other.state[HEADER:], rtol=ROUNDING)
        assert np.array_equal(one.state[5:8], shift) and one.state[4] == 1.0
    energies = slice(2, 4)
    gained = (shifted_on.state - shifted.state)[energies]
    assert np.allclose(gained, (plain_on.state - plain.state)[energies], rtol=1.0e-9)
    assert (np.abs(gained) > 1.0e-5).all()


def test_batches_equal_single_points():
    """Leading axes are independent points."""
    rng = np.random.default_rng(7)
    pattern = regular_pattern(5, 25.0, flat=0.1, turn_deg=20.0)
    path = np.cumsum(rng.normal(0.0, TABLE_2.s0, (20, 6, 3)), axis=0)
    batch = replay(TABLE_2, pattern, path)
    for j in range(6):
        single = replay(TABLE_2, pattern, path[:, j])
        assert np.allclose(batch.traction[:, j], single.traction, rtol=0, atol=1e-14)
        assert np.allclose(batch.state[:, j], single.state, rtol=0, atol=1e-14)
        assert np.allclose(batch.tangent[:, j], single.tangent, rtol=0, atol=1e-11)
        assert np.array_equal(batch.branch[:, j], single.branch)


# --- tangent ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("kc", [1.0, 5.0])
@pytest.mark.parametrize("inclination", [0.0, 35.0])
def test_tangent_in_every_branch(kc, inclination):
    """Central differences to 1e-6 of K; rounding leaves 1e-16 |t|/step, truncation the square of step/s0."""
    p = Parameters(3.0, 0.3, 0.9, 0.5, sigma02=4.0, Gc2=0.5, kc=kc)
    pattern = facing_plane(inclination)
    rng = np.random.default_rng(11)
    points = 6000
    s = p.sf * rng.uniform(-0.6, 0.6, (points, 3))
    state = np.tile(virgin(pattern), (points, 1))
    state[:, HEADER] = np.clip(rng.uniform(-0.3, 1.2, points), 0.0, 1.0)
    near = (s @ frames(pattern[0])[0].T)[:, 1:]
    state[:, HEADER + 1 :] = near + p.sf * rng.normal(0.0, 0.15, (points, 2))
    centre = update(p, pattern, s, state)
    step = 1.0e-6 * p.s0
    smooth = np.ones(points, dtype=bool)
    numerical = np.empty((points, 3, 3))
    for j in range(3):
        move = step * np.eye(3)[j]
        ahead, behind = update(p, pattern, s + move, state), update(p, pattern, s - move, state)
        numerical[:, :, j] = (ahead.traction - behind.traction) / (2.0 * step)
        for side in (ahead, behind):
            smooth &= (side.branch == centre.branch).all(-1) & (side.damaging == centre.damaging).all(-1)
            smooth &= (side.state[:, HEADER] == 1.0) == (centre.state[:, HEADER] == 1.0)
    scale = max(p.Kn, p.Kt) * max(kc, 1.0)
    error = np.abs(centre.tangent - numerical).max(axis=(1, 2)) / scale
    branch, damaging = centre.branch[:, 0], centre.damaging[:, 0]
    fresh = damaging & (centre.state[:, HEADER] < 1.0)
    for which, grows in product((OPEN, STICK, SLIP), (False, True)):
        here = smooth & (branch == which) & (fresh == grows)
        assert here.sum() >= 100, (which, grows, here.sum())
        assert error[here].max() <= 1.0e-6, (which, grows)
    assert smooth.mean() > 0.99
    slipping = smooth & (branch == SLIP)
    skew = np.abs(centre.tangent - np.swapaxes(centre.tangent, 1, 2)).max(axis=(1, 2))
    assert skew[slipping & (centre.state[:, HEADER] > 0.5)].max() > 0.1 * scale


def test_tangent_of_whole_patterns_on_random_histories():
    """The tangent of several planes in global components is checked as that of single planes."""
    rng = np.random.default_rng(3)
    for sides, turn in ((0, 0.0), (2, 10.0), (3, 0.0), (6, 33.0)):
        pattern = regular_pattern(sides, THETA, turn_deg=turn)
        path = np.cumsum(rng.normal(0.0, TABLE_2.s0, (12, 200, 3)), axis=0)
        before = replay(TABLE_2, pattern, path[:-1]).state[-1]
        s, step = path[-1], 1.0e-6 * TABLE_2.s0
        centre = update(TABLE_2, pattern, s, before)
        numerical = np.empty((200, 3, 3))
        smooth = np.ones(200, dtype=bool)
        for j in range(3):
            sides_of = [update(TABLE_2, pattern, s + sign * step * np.eye(3)[j], before) for sign in (1, -1)]
            numerical[:, :, j] = (sides_of[0].traction - sides_of[1].traction) / (2.0 * step)
            for side in sides_of:
                smooth &= (side.branch == centre.branch).all(-1) & (side.damaging == centre.damaging).all(-1)
        assert smooth.sum() > 190
        assert np.abs(centre.tangent - numerical)[smooth].max() <= 1.0e-6 * TABLE_2.Kn


# --- invariance and the 2D law ------------------------------------------------------------------------------


def random_path(seed: int, steps: int = 60) -> np.ndarray:
    """Random walks of 40 points, (steps, 40, 3)."""
    return np.cumsum(np.random.default_rng(seed).normal(0.0, 1.5 * TABLE_2.s0, (steps, 40, 3)), axis=0)


def test_turning_pattern_and_separation_together():
    """A rotation of pattern and separations rotates the tractions and does not change the energies."""
    angle = 37.0
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    turn = np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])  # (43)
    path = random_path(1)
    plain = replay(TABLE_2, regular_pattern(3, THETA), path)
    turned = replay(TABLE_2, regular_pattern(3, THETA, turn_deg=angle), path @ turn.T)
    assert np.allclose(turned.traction, plain.traction @ turn.T, rtol=0, atol=1e-12)
    assert np.allclose(turned.state[..., :4], plain.state[..., :4], rtol=0, atol=1e-11)


def test_mirror():
    """On a pattern symmetric about Tx the mirrored path gives the mirrored traction."""
    mirror = np.array([1.0, 1.0, -1.0])
    path = random_path(2)
    plain = replay(TABLE_2, regular_pattern(5, THETA), path)
    mirrored = replay(TABLE_2, regular_pattern(5, THETA), path * mirror)
    assert np.allclose(mirrored.traction, plain.traction * mirror, rtol=0, atol=1e-12)


def test_units():
    """Results in mm, MPa and in m, Pa differ by the factors 1e-3 (length), 1e6 (stress) and 1e3 (energy)."""
    si = Parameters(3.0e6, 300.0, 0.9, 0.5)
    path = random_path(3)
    plain = replay(TABLE_2, regular_pattern(4, THETA), path)
    scaled = replay(si, regular_pattern(4, THETA), 1e-3 * path)
    assert np.allclose(1e-6 * scaled.traction, plain.traction, rtol=0, atol=1e-12)
    assert np.allclose(1e-3 * scaled.state[..., 1:4], plain.state[..., 1:4], rtol=0, atol=1e-11)
    assert np.allclose(1e-9 * scaled.tangent, plain.tangent, rtol=0, atol=1e-9)


@pytest.mark.parametrize("theta_deg", [0.0, 15.0, 30.0, 45.0])
@pytest.mark.parametrize("kc", [1.0, 4.0])
def test_3d_equals_2d_on_random_paths(theta_deg, kc):
    """Tractions of the two codes; every branch is met."""
    p = Parameters(3.0, 0.3, 0.9, 0.5, sigma02=4.0, Gc2=0.5, kc=kc)
    pattern, planes = regular_pattern(2, theta_deg), planar.trapezoid(theta_deg)
    path = np.zeros((400, 3))
    kicks = np.random.default_rng(13).normal(0.0, p.s0, (400, 2))
    for row in range(1, 400):
        path[row, :2] = 0.9 * path[row - 1, :2] + kicks[row]
    response = replay(p, pattern, path)
    history = None
    seen = set()
    for row, (s_N, s_T, _) in enumerate(path):
        flat = planar.update(p, planes, s_N, s_T, history)
        history = flat.history
        assert response.traction[row] == pytest.approx([*flat.traction, 0.0], abs=1e-12 * p.Kt)
        seen |= set(response.branch[row].tolist())
    assert seen == {OPEN, STICK, SLIP}
