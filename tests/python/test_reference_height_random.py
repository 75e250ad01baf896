"""Finite asperity height and wear in the NumPy reference: energies and invariance on random histories."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest
from support_height import (
    CURVED,
    RP_4,
    TABLE_2,
    THETA,
    broken,
    random_walk,
    worn_share,
)

from tests.oracle.reference import (
    HEADER,
    PER_PLANE,
    STICK,
    Parameters,
    regular_pattern,
    replay,
    update,
    virgin,
)

pytestmark = pytest.mark.slow

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

    Half the increments give a quarter of the error (median of 200) for a soft contact.  A wearing facet
    in a stiff contact loses its elastic slip within a few increments of any size: this error does not vanish.
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
