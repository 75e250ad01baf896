"""The equilibrium that the driver finds: snaps, lost equilibrium, starts, branches."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from asperity import EquilibriumLost, Interface, Material, Pattern, read_case
from support_driver import (
    COLUMNS,
    FLAT,
    GC,
    MATERIAL,
    PARTS,
    RP_4,
    S_0,
    S_F,
    SIGMA0,
    TRACTION_TOLERANCE,
    K,
    Result,
    call,
)  # fmt: skip

SLOPE = math.tan(math.radians(30.0))
TABLE_2 = Material(3.0, 0.3, 0.9, 0.5)


@pytest.mark.parametrize("steps", [20, 400, 4000])
def test_fold_is_reported(run, steps: int) -> None:
    """RP-16 snaps to s_N = s_L tan(theta) at the same slip for all increments; RP-12 does not snap.

    Python has the same snap.
    """
    case = "&pattern sides = {}, theta = 30.0 /\n&step t_N = 0.0, increments = 1 /\n"
    case += "&step slip = 0.2, increments = {} /\n"
    assert not any("snap" in event for event in run(MATERIAL + case.format(12, steps)).events)
    result = run(MATERIAL + case.format(16, steps))
    (row,) = [i for i, event in enumerate(result.events) if "snap" in event]
    told = r"step 2 increment (\d+): snap from s = \((\S+), (\S+), 0\) to \((\S+), \S+, 0\), (\S+) released"
    (reported,) = re.findall(told, result.messages)
    assert int(reported[0]) == row  # row 0 is the preload
    s_n, s_l, s_n_after, released = map(float, reported[1:])
    # The last equilibrium is 2^-20 of an increment away from the fold, its s_N the square root of that.
    assert [s_n, s_l] == pytest.approx([0.0926, 0.1736], abs=2e-4)
    assert s_n_after == pytest.approx(0.1002, abs=1e-4) and released == pytest.approx(9.75e-6, rel=0.01)
    np.testing.assert_allclose(result["s_N"][row:], SLOPE * result["s_Tx"][row:], rtol=0, atol=1e-11)
    slips = np.linspace(0.0, 0.2, steps + 1)
    plain, history = (
        Interface(TABLE_2, Pattern.regular(sides, 30.0)).confined_slip(0.0, slips, 0.0) for sides in (12, 16)
    )
    (snap,) = history.snaps
    assert plain.snaps == () and [i for i, text in history.events if "snap" in text] == [snap.row]
    assert "substeps" in dict(history.events)[snap.row] and slips[snap.row - 1] < s_l <= slips[snap.row]
    told = [*snap.before, *snap.after, snap.released]
    assert told == pytest.approx([s_n, s_l, 0.0, s_n_after, s_l, 0.0, released], rel=1e-3, abs=1e-6)


INCLINED = "&pattern normals = 1, 0, 0, 0.9, 0.3, 0.1, weights = 0.4, 0.6 /\n"
PLAIN, LISTED = MATERIAL + FLAT, MATERIAL + INCLINED
LOSES = MATERIAL + FLAT + "&step t_N = 2.0 /\n&step slip = 0.1, increments = 100 /\n"


COMPLETES = MATERIAL + FLAT + "&step s_N = 0.1, increments = 7 /\n"


@pytest.mark.parametrize(
    ("case", "expect", "code", "fragments"),
    [
        (LOSES, "end = 'lost'", 0, []),
        (LOSES, "end = 'lost', slip = 0.031, s_Tx = 0.031, t_N = 2.0, tolerance = 1e-4", 0, []),
        (LOSES, "end = 'lost', slip = 0.05, tolerance = 1e-4", 2, ["expected 0.05 within", "line 5"]),
        (LOSES, "end = 'complete'", 2, ["equilibrium lost"]),
        (COMPLETES, "end = 'lost'", 2, ["loss of equilibrium was expected"]),
        (COMPLETES, "t_N = 1.0, damage = 0.5, tolerance = 0.01", 2, ["t_N = 1.66", "damage = 0.8", "line 4"]),
        (COMPLETES, "t_N = 1.6667, tolerance = 0.001", 0, []),
    ],
)
def test_expected_end(run, tmp_path: Path, case: str, expect: str, code: int, fragments: list[str]) -> None:
    """The exit code is 0 if the run ends as the case states, and 2 otherwise; all rows are there.

    OUT.failed.nml is written after a loss that the case does not state.
    """
    result = run(case + f"&expect {expect} /\n", code=code)
    assert all(fragment in result.messages for fragment in fragments)
    assert len(result.rows) == (7 if case == COMPLETES else 100 + 31 + 1)
    assert len(list(tmp_path.glob("*.failed.nml"))) == ("'complete'" in expect)


NONE_FOUND = "none found: the motion under the prescribed tractions reaches no equilibrium within 1000 s_f"
SHEAR = "&step t_N = -5.0, t_Tx = 0.0, t_Ty = 0.0 /\n&step t_Tx = 25.0"
SMOOTH = PLAIN.replace("mu = 0.5", "mu = 0.0")
WAY = "&step s_N = 0.05, slip = 0.1, increments = 1 /\n&step t_N = -0.7, slip = {}, increments = 1 /\n"


@pytest.mark.parametrize(
    ("case", "fragment"),
    {
        PLAIN + "&step t_N = 2.0 /\n&step slip = 0.1, increments = 100 /\n": "; tension is positive",
        SMOOTH + "&step t_N = 3.5, increments = 70 /\n": "in the direction (1, 0, 0); tension is",
        SMOOTH + "&step t_N = 0.0, t_Tx = -4.0 /\n": NONE_FOUND,
        LISTED + SHEAR + ", increments = 3 /\n": NONE_FOUND,
        # the tension is lost on the way to a compression that is carried
        PLAIN + WAY.format(0.27): NONE_FOUND,
        MATERIAL + RP_4 + "&initial traction = 2, 0, 0 /\n&step t_N = 2.0, increments = 1 /\n"
        "&step slip = 0.1, increments = 100 /\n": "tension is positive",
        MATERIAL + RP_4 + "&initial traction = -5, 1, 0, damage = 0.5 /\n"
        "&step t_N = -5.0, t_Tx = 25.0 /\n": "beyond step 1 increment",
    }.items(),
)
def test_failed_increment_alone(run, driver: Path, tmp_path: Path, case: str, fragment: str) -> None:
    """A failed increment is reported; OUT.failed.nml, with the offset of an initial state, fails as well."""
    result = run(case, code=2)
    assert fragment in result.messages
    assert "the failed increment was written to case.failed.nml" in result.messages
    assert "lost" in result.events[-1]
    start = read_case(tmp_path / "case.failed.nml").runs[0].state
    assert (start.state[5:8] != 0.0).any() == ("&initial" in case)
    process = call(driver, "case.failed.nml", "-o", "again.csv", folder=tmp_path)
    reason = re.search(r"equilibrium lost beyond [^:]*: (.*)", result.messages)[1]
    assert process.returncode == 2 and reason[:60] in process.stderr
    again = Result(process, tmp_path / "again.csv")
    assert len(again.rows) == 1 and "lost" in again.events[0]
    # The states are equal to rounding; at a fold s_N has the square root of this error.
    for name in ("s", "t"):
        np.testing.assert_allclose(again.vector(name)[0], result.vector(name)[-1], rtol=1e-6, atol=1e-6)
    for name in ("damage", "stored", "rupture", "friction", "work"):
        assert again[name][0] == pytest.approx(result[name][-1], rel=1e-6, abs=1e-9)


def test_state(run) -> None:
    """A run that starts from a row of another run continues as that run."""
    path = "&step t_N = -5.0, increments = 10 /\n&step slip = 0.1, increments = 20 /\n"
    whole = run(MATERIAL + RP_4 + path, "--planes")
    row = 19
    names = ["damage", "stored", "rupture", "friction"]
    planes = whole.header[len(COLUMNS) :]
    statev = [whole[name][row] for name in names] + [1, 0, 0, 0] + [whole[name][row] for name in planes]
    state = "&state separation = {}, statev = {}, work = {} /\n".format(
        *(", ".join(repr(float(x)) for x in values) for values in (whole.vector("s")[row], statev)),
        float(whole["work"][row]),
    )
    rest = run(MATERIAL + RP_4 + state + "&step t_N = -5.0, slip = 0.1, increments = 10 /\n", "--planes")
    for name in [*COLUMNS[3:14], *planes]:
        np.testing.assert_allclose(rest[name], whole[name][row + 1 :], rtol=1e-9, atol=1e-12, err_msg=name)
    assert rest.events[1:] == whole.events[row + 2 :]  # the state does not say whether a plane slides


# --- initial states: decks have sheared, far slipped and partly damaged joints ------------------------------

THREE_PLANES = "&pattern normals = 1, 0, 0, 0.9, 0.3, 0.1, 0.8, -0.2, 0.3, weights = 0.4, 0.3, 0.3 /\n"
VISCOUS, GUARDED = ", tau_v = 0.5 /", ", guard = .true. /"


@pytest.mark.parametrize(
    ("extra", "pattern", "damage", "steps"),
    [
        ("", RP_4, "0.3", "&step t_N = -4, increments = 1 /\n&step {s_Tx}, {s_Ty}, increments = 60 /\n"),
        ("", RP_4, "0.9", "&step k_N = 20.0, t_N = -4, {s_Tx}, {s_Ty}, increments = 60 /\n"),
        ("", THREE_PLANES, "0", "&step t_N = -4, {s_Tx}, t_Ty = 0.0, increments = 60 /\n"),
        ("", THREE_PLANES, "1", "&step t_N = -1, t_Tx = 0, t_Ty = 0, increments = 60 /\n"),
        ("", RP_4, "1", "&step t_N = 0.0, {s_Tx}, {s_Ty}, increments = 40 /\n"),
        (VISCOUS, RP_4, "0.3", "&step t_N = -4, {s_Tx}, {s_Ty}, increments = 60, time = 2.0 /\n"),
        (GUARDED, RP_4, "0.3", "&step t_N = -4, {s_Tx}, {s_Ty}, increments = 60 /\n"),
    ],
)
def test_initial_state_is_a_preload(run, extra: str, pattern: str, damage: str, steps: str) -> None:
    """A path from an initial state is that of a run that applied the traction first, less its separation."""
    head = MATERIAL.replace(" /", extra or " /") + pattern
    planes = 5 if pattern == RP_4 else 3
    traction = {"t_N": -4.0, "t_Tx": 0.8, "t_Ty": -0.4}

    def path(s: list[float]) -> str:
        targets = [f"s_Tx = {s[1] + 0.05!r}, {s[1] - 0.1!r}", f"s_Ty = {s[2] + 0.1!r}, {s[2] + 0.02!r}"]
        return steps.format(s_Tx=targets[0], s_Ty=targets[1])

    histories = f", {damage}, 0, 0" * planes
    state = f"&state separation = 3*0, statev = 8*0{histories} /\n"
    # The preload is so slow that viscous damage is in equilibrium, to 1e-9 of its growth.
    preload = f"{', '.join(f'{name} = {value}' for name, value in traction.items())}, time = 1e9"
    before = head + state + f"&step {preload}, increments = {PARTS} /\n"
    offset = run(before, "--planes").vector("s")[-1]
    loaded = run(before + path(offset.tolist()), "--planes")
    values = ", ".join(str(value) for value in traction.values())
    initial = run(
        head + f"&initial traction = {values}, damage = {damage} /\n" + path([0.0, 0.0, 0.0]), "--planes"
    )
    assert len(initial.rows) == len(loaded.rows) - PARTS
    # The state does not record that a plane slides. Sliding may be due to rounding, as may the contact of
    # fully damaged planes.
    ignored = {"slip", "open", "close"} if damage == "1" else {"slip"}
    events = [[event - ignored for event in result.events] for result in (initial, loaded)]
    assert events[0] == events[1][PARTS:]
    tolerance, first = 1e-9, slice(PARTS, None)
    size = np.abs(loaded.vector("t")).max()
    np.testing.assert_allclose(initial.vector("t"), loaded.vector("t")[first], rtol=0, atol=tolerance * size)
    np.testing.assert_allclose(
        initial.vector("s"), loaded.vector("s")[first] - offset, rtol=0, atol=tolerance * S_F
    )
    # rupture and friction count from the initial state on, and the work from its stored energy on
    before = {name: loaded[name][PARTS - 1] for name in ("rupture", "friction")}
    before["work"] = loaded["work"][PARTS - 1] - loaded["stored"][PARTS - 1]
    for name in ("damage", "stored", "rupture", "friction", "work", "alpha_1", "s_dit_2", "s_dih_3"):
        scale = max(np.abs(loaded[name]).max(), GC)
        expected = loaded[name][first] - before.get(name, 0.0)
        np.testing.assert_allclose(initial[name], expected, rtol=0, atol=tolerance * scale, err_msg=name)


# --- branches: their rows and ends, in Python, too ----------------------------------------------------------

STEEP = "&pattern sides = 8, theta = 60.0, flat = 0.0, turn = 298.64 /\n"


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
