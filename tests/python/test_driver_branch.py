"""`&step follow = 'branch'`: the whole branch in the driver and in Python, its rows, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from asperity import EquilibriumLost, Interface, Material, Pattern
from support_driver import ETA, FLAT, GC, MATERIAL, MU, RP_4, S_0, S_F, SIGMA0, TRACTION_TOLERANCE, K

STEEP = "&pattern sides = 8, theta = 60.0, flat = 0.0, turn = 298.64 /\n"
TABLE_2 = Material(SIGMA0, GC, ETA, MU)


def turns(result) -> list[int]:
    """Rows in which the prescribed values turn."""
    return [row for row, events in enumerate(result.events) if "turn" in events]


def test_bond_on_a_spring(run) -> None:
    """The rows lie on the bond's straight lines; the prescribed value turns at the strength and at s_f."""
    spring, target = 0.25 * SIGMA0 / (S_F - S_0), 5.0
    step = f"&step t_N = {target}, k_N = {spring!r}, follow = 'branch', arc = 0.2, time = 3.0 /\n"
    result = run(MATERIAL + FLAT + step)
    s, t = result["s_N"], result["t_N"]
    line = np.clip(np.minimum(K * s, SIGMA0 * (S_F - s) / (S_F - S_0)), 0.0, None)
    np.testing.assert_allclose(t, line, rtol=0, atol=TRACTION_TOLERANCE)
    first, second = turns(result)
    # a kink is passed in a step of 1e-3 s0
    assert s[first] == pytest.approx(S_0, rel=2e-3) and s[second] == pytest.approx(S_F, rel=2e-3)
    given = t + spring * s
    # a row with a turn is just beyond the fold
    assert np.all(np.diff(given[:first]) > 0) and np.all(np.diff(given[first:second]) < 0)
    assert np.all(np.diff(given[second:]) > 0) and given[-1] == pytest.approx(target, rel=1e-14)
    time = result["time"]
    assert np.all(np.diff(time) >= 0) and time[-1] == 3.0
    assert not any("snap" in events for events in result.events)


def test_branch_of_steep_planes(run) -> None:
    """RP-8 of 60 degrees: the slip turns back at the fold and forward again where all planes are damaged."""
    result = run(MATERIAL + STEEP + "&step t_N = 0.0, slip = 0.3, follow = 'branch' /\n")
    first, second = turns(result)
    assert result["s_Tx"][first] == pytest.approx(0.15265, abs=1e-4)
    assert "damaged" in result.events[second]
    slope = math.tan(math.radians(60.0)) * math.cos(math.radians(298.64 + 45.0))
    edge = slope * result["s_Tx"][second:]
    np.testing.assert_allclose(result["s_N"][second:], edge, rtol=0, atol=2e-3 * S_0)
    # all separations of a plane have the same length without a contact
    assert np.hypot(result["s_N"][second], result["s_Tx"][second]) == pytest.approx(S_F, rel=2e-3)
    length = np.linalg.norm(np.diff(result.vector("s"), axis=0), axis=1)
    assert length[:second].max() <= 1.5 * 0.05 * S_0
    energies = result["stored"] + result["rupture"] + result["friction"]
    np.testing.assert_allclose(energies, result["work"], rtol=0, atol=1e-3 * GC)


def test_branches_that_end(run) -> None:
    """A branch that does not reach its target stops with the reason; decks have other ends."""
    result = run(MATERIAL + FLAT + "&step t_N = 4.0, follow = 'branch', arc = 0.2 /\n", code=2)
    assert "the separation grows without end, or farther than that; tension is positive" in result.messages
    # the last step of the branch may lead beyond s_f, where the joint carries nothing
    assert S_F <= result["s_N"][-1] <= S_F + 0.2 * S_0 and "lost" in result.events[-1]
    result = run(MATERIAL + RP_4 + "&step t_N = 0.3 /\n&step slip = 0.4, follow = 'branch' /\n", code=2)
    assert "the branch ends" in result.messages
    result = run(MATERIAL + FLAT + "&step s_N = 1e9, follow = 'branch' /\n", code=2)
    assert "stopped at step" in result.messages and "expected a larger arc" in result.messages
    assert "equilibrium lost" not in result.messages
    rough = Interface(TABLE_2, Pattern.regular(4, 30.0))
    with pytest.raises(EquilibriumLost, match="the branch ends") as caught:
        rough.confined_slip(0.0, [0.4], 0.3, follow="branch")
    assert len(caught.value.history) > 10


def test_soft_springs_beside_a_crack(run) -> None:
    """Where all planes are damaged, soft springs move in short steps, too, and the energies balance."""
    result = run(
        f"&material sigma0 = {SIGMA0}, Gc = {GC}, eta = 0.97, mu = 0.2 /\n"
        "&pattern sides = 2, theta = 54.155745, flat = 0.2, turn = 122.333522 /\n"
        "&step t_N = -1 /\n"
        "&step t_N = 1.881, k_N = 0.5, t_Tx = 3.809, k_Tx = 5, t_Ty = 2.918, k_Ty = 80, "
        "follow = 'branch', arc = 1.0 /\n"
    )
    assert not any("snap" in events for events in result.events)
    s_0 = (1 - 0.97) * S_F
    assert np.linalg.norm(np.diff(result.vector("s"), axis=0), axis=1).max() <= 4 * s_0 * (1 + 1e-5)
    energies = result["stored"] + result["rupture"] + result["friction"]
    np.testing.assert_allclose(energies, result["work"], rtol=0, atol=8e-3 * GC)
