"""Increments that are long for some points: these alone have accounts by parts, and iterates have none."""

from __future__ import annotations

import numpy as np
import pytest
from asperity import Interface, Material, Pattern
from support_calls import LIBRARY, Written, c_update
from test_oracle import OPTIONS

POINTS = 130
"""More than the library takes at a time, and no multiple of the vectors."""

LONG = 3, 40, 70, 129
"""Points that move far, in three of the groups that the library takes together."""

DISSIPATED = [2, 3]
"""STATEV 3 and 4, from 0; the energy of crushing is the last of all."""

KINDS = OPTIONS | {
    "fc": {"fc": 4.0, "Gfc": 1.0, "kc": 20.0, "height": 0.3},
    "fc and a dashpot": {"fc": 4.0, "Gfc": 1.0, "c": 6.0},
}


def walk(option: str) -> tuple[Interface, list[tuple[np.ndarray, ...]]]:
    """An interface, and two steps in which few points move far: s, state, separation at the start."""
    constants = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5} | KINDS[option]
    joint = Interface(Material(**constants), Pattern.regular(5, 30.0, 0.3, 20.0))
    rng, far = np.random.default_rng(64), np.full((POINTS, 1), 1e-4)
    far[LONG, 0] = 3.0, 30.0, 0.5, 8.0
    s_old, state, steps = np.zeros((POINTS, 3)), np.zeros((POINTS, joint.nstatv)), []
    for _ in range(2):
        s = s_old + joint.material.s_0 * far * rng.standard_normal((POINTS, 3))
        steps.append((s, state, s_old))
        state, s_old = joint.update(s, state, s_old, 0.1).state, s
    return joint, steps


def by_c(function: str, joint: Interface, s: np.ndarray, state: np.ndarray, s_old: np.ndarray) -> Written:
    """A call of the C API for all points."""
    s, s_old = (np.asfortranarray(rows.T) for rows in (s, s_old))
    return c_update(LIBRARY, joint.props(), 0.1, s_old, s, state.T, function=function)


@pytest.mark.parametrize("option", KINDS)
def test_a_point_has_its_accounts_alone(option: str) -> None:
    """A point has the same bits alone and among others of which few move far."""
    joint, steps = walk(option)
    for s, state, s_old in steps:
        whole = joint.update(s, state, s_old, 0.1)
        for i in (0, *LONG):
            alone = joint.update(s[i : i + 1], state[i : i + 1], s_old[i : i + 1], 0.1)
            for name in ("traction", "state", "tangent"):
                assert np.array_equal(getattr(alone, name)[0], getattr(whole, name)[i]), (name, i)


@pytest.mark.parametrize("option", KINDS)
def test_an_iterate_has_all_but_the_energies(option: str) -> None:
    """The bits of asperity_update, but for dissipated energies that are NaN: such a state is no start."""
    joint, steps = walk(option)
    dissipated = [*DISSIPATED, -1] if joint.material.fc else DISSIPATED
    for s, state, s_old in steps:
        end, iterate = (by_c(f"asperity_{name}", joint, s, state, s_old) for name in ("update", "iterate"))
        assert (end.status, iterate.status) == (0, 0)
        assert np.isnan(iterate.state[dissipated]).all()
        assert end.state[DISSIPATED].max() > 0.0
        iterate.state[dissipated] = end.state[dissipated]
        for name in ("stress", "state", "tangent"):
            assert np.array_equal(getattr(end, name), getattr(iterate, name)), name
    iterate.state[dissipated] = np.nan
    further = by_c("asperity_iterate", joint, s, iterate.state.T, s_old)
    assert further.status == 6 and "STATEV(3) rupture = NaN" in further.message
    assert np.array_equal(further.state, iterate.state, equal_nan=True)


@pytest.mark.parametrize("option", ("paper", "fc"))
def test_an_iterate_of_no_points(option: str) -> None:
    """No points are admissible, as in asperity_update."""
    joint, _ = walk(option)
    none = np.zeros((0, 3))
    assert by_c("asperity_iterate", joint, none, np.zeros((0, joint.nstatv)), none).status == 0
