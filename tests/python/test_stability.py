"""Stability of joints: eigenvalues against NumPy, columns of the driver, the direction of a fall."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from asperity import EquilibriumLost, Interface, Material, ModelWarning, Pattern, Step, read_case
from asperity.installed import named_case
from support_umat import ONSET, planted

JOINT = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5), Pattern.regular(4, 30.0))
CASE = """&case stability = T{more} /
&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5 /
&pattern sides = 4, theta = 30.0 /
&step t_N = -1.0, increments = 4 /
&step slip = 0.3, direction = 20, increments = 20 /
"""
COLUMNS = ["second_order", "least_real", "flutter", "mode_N", "mode_Tx", "mode_Ty"]
NO_FORK = "step 1: fork = 1: no other branch crosses in this step: expected fork = 0"
ROUNDING = 1.0e-12
"""Rounding errors of eigenvalues over the stiffness of the bond."""


def expected(tangent: np.ndarray, stiffness: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Smallest eigenvalue of the symmetric part, smallest real and largest imaginary part, by NumPy."""
    D = tangent / stiffness
    values = np.linalg.eigvals(D)
    symmetric = np.linalg.eigvalsh(0.5 * (D + D.transpose(0, 2, 1)))[:, 0]
    return symmetric, values.real.min(axis=1), values.imag.max(axis=1)


def test_eigenvalues() -> None:
    """Along a slip, and for random tangents with complex eigenvalues, the numbers are those of NumPy."""
    along = JOINT.confined_slip(20.0, np.linspace(0.0, 0.6, 61)[1:], -1.0).tangent
    drawn = JOINT.material.K * np.random.default_rng(2015).normal(size=(200, 3, 3))
    for tangent in (along, drawn):
        stability = JOINT.stability(tangent)
        for numbers, right in zip(stability, expected(tangent, JOINT.material.K), strict=False):
            assert np.abs(numbers - right).max() < ROUNDING
        D = tangent / JOINT.material.K
        along_mode = np.einsum("ni,nij,nj->n", stability.mode, D, stability.mode)
        assert np.abs(along_mode - stability.second_order).max() < ROUNDING
        assert np.abs(np.linalg.norm(stability.mode, axis=1) - 1.0).max() < ROUNDING
    assert JOINT.stability(drawn).flutter.max() > 0.1
    assert [numbers.shape for numbers in JOINT.stability(np.zeros((0, 3, 3)))] == [(0,), (0,), (0,), (0, 3)]


def test_tangent_of_a_history() -> None:
    """The rows of a run have the tangent of an update over their increment."""
    history = JOINT.confined_slip(20.0, np.linspace(0.0, 0.3, 31)[1:], -1.0)
    s, state = history.separation, history.state
    again = JOINT.update(s[1:], state[:-1], s[:-1]).tangent
    assert np.abs(again - history.tangent[1:]).max() < ROUNDING * JOINT.material.K


@pytest.mark.parametrize("more", ["", ", planes = T", ", tolerance = 1e-3"])
def test_columns_of_the_driver(run, more: str) -> None:
    """The columns of a file are those of Python; they stand behind the event, before the planes."""
    done = run(CASE.format(more=more))
    at = done.header.index("event") + 1
    assert done.header[at : at + 6] == COLUMNS and (done.header[at + 6 :] != []) == ("planes" in more)
    tolerance = 1.0e-3 if "tolerance" in more else None
    steps = Step(t_N=-1.0, increments=4), Step(slip=0.3, direction=20.0, increments=20)
    history = JOINT.rows(steps, tolerance=tolerance)[0]
    columns = np.column_stack(JOINT.stability(history.tangent))
    numbers = np.array([[float(cell) for cell in row[at : at + 6]] for row in done.rows])
    assert np.abs(numbers - columns).max() < ROUNDING


def test_replay_has_no_stability(run) -> None:
    """The rows of a replay are those of a host: asking for their stability is refused."""
    text = CASE.format(more="").split("&step")[0] + "&replay file = 'x.csv' /\n"
    assert "case.nml:1: &case: stability with &replay" in run(text, code=1).messages


def test_direction_of_a_fall() -> None:
    """A joint under too much tension opens; one under too much shear slides along it."""
    with pytest.raises(EquilibriumLost, match="none found"):
        JOINT.run(Step(t_N=4.0))
    flat = Interface(Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, height=0.1), Pattern.regular(2, 30.0))
    steps = Step(t_N=-1.0, increments=10), Step(t_Tx=20.0, increments=100)
    with pytest.raises(
        EquilibriumLost, match=r"leaves its last equilibrium in the direction \((\S+), 0?"
    ) as lost:
        flat.run(steps)
    text = str(lost.value).split("in the direction (")[1].split(")")[0]
    N, Tx, Ty = map(float, text.split(", "))
    assert Tx > 0.5 and N > 0.0 and Ty == pytest.approx(0.0, abs=1e-9)


def test_jump_of_the_law() -> None:
    """The error names the tractions at both sides of the foot of closed facets: none between is carried."""
    mu, theta, height, pressure = 0.0, 30.0, 0.2, 0.3
    cracked = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=mu, height=height, damage0=1.0)
    steps = Step(t_N=-pressure, increments=10), Step(t_Tx=1.0e-3)
    with pytest.raises(EquilibriumLost, match=r"jumps from t_Tx = .* least stable in the direction") as lost:
        Interface(cracked, Pattern.regular(2, theta, flat=0.0)).run(steps)
    below, above = map(float, str(lost.value).split("t_Tx = ")[1].split(" there")[0].split(" to "))
    # two facets in contact by the closure g change their shear by p sin(theta)^2 tan(theta) g/H
    slope = np.radians(theta)
    p = pressure / np.cos(slope)
    jump = p * np.sin(slope) ** 2 * np.tan(slope) * p / cracked.K / height
    assert above == pytest.approx(jump / 2.0, rel=1.0e-3)
    assert below == pytest.approx(-jump / 2.0, rel=1.0e-3)


def test_refused() -> None:
    """A tangent of another shape, or with a number that is not finite, is named."""
    with pytest.raises(ValueError, match=r"tangent.*\(n, 3, 3\)"):
        JOINT.stability(np.zeros((3, 3)))
    with pytest.raises(ValueError, match=r"tangent\[1\]: expected finite numbers"):
        JOINT.stability([np.eye(3), np.full((3, 3), np.nan)])


def test_kink_is_no_fork() -> None:
    """Where planes open, the branch has a kink and no fork; it is the stable path, as nothing snaps."""
    joint = Interface(
        Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.0, kc=100.0), Pattern.regular(12, 56.24, flat=0.0)
    )
    steps = [Step(t_N=-3.1368, t_Ty=0.0, increments=1), Step(s_Tx=0.1261, follow="branch", arc=0.2)]
    history = joint.run(steps)
    stable = joint.run([steps[0], Step(s_Tx=0.1261, increments=100)])
    names = {name for _, text in history.events for name in text.split("+")}
    assert "open" in names and not names & {"fork", "turn", "snap"} and not stable.snaps
    np.testing.assert_allclose(history.separation[-1], stable.separation[-1], rtol=0, atol=1e-9)
    for fork in (1, -1):
        with pytest.raises(ValueError, match=f"^step 2: fork = {fork}: no other branch crosses in this step"):
            joint.run([steps[0], replace(steps[1], fork=fork)])


def test_kink_beyond_a_fork() -> None:
    """A fork is where the determinant of the tangent vanishes, not the kink where its sign jumps."""
    material = Material(3.0, 0.3, 0.6, 0.0, sigma02=4.56, Gc2=0.25, kc=3.9)
    joint = Interface(material, Pattern.regular(3, 59.3))
    with pytest.warns(ModelWarning, match="differ from mode I"):
        history = joint.run(Step(s_Tx=0.14, t_N=0.0, t_Ty=0.0, follow="branch", arc=0.3))
    names = {row: text.split("+") for row, text in history.events}
    forks = [row for row, here in names.items() if "fork" in here]
    onset = next(row for row, here in names.items() if "onset" in here)
    size = np.linalg.det(history.tangent)[onset:] / abs(np.linalg.det(history.tangent[onset]))
    fork, kink = np.flatnonzero(size[:-1] * size[1:] < 0.0)
    assert forks == [onset + fork + 1]
    # a fork is found by bisection of a step; a hundredth of the largest determinant is no rounding error
    assert abs(size[fork + 1]) < 1e-6 and min(abs(size[kink : kink + 2])) > 1e-2


def test_nothing_holds_across() -> None:
    """A joint that slides on one facet without friction stays where nothing holds it across: no fork."""
    material = Material(3.0, 0.3, 0.9, 0.0, kc=100.0, crush=2.0, closure=0.03)
    rough = Interface(material, Pattern.regular(3, 33.06))
    preload = Step(t_N=-0.3805467508590463, t_Ty=0.0, increments=5)
    branch = rough.run([preload, Step(s_Tx=0.2, follow="branch")])
    stable = rough.run([preload, Step(s_Tx=0.2, increments=200)])
    assert branch.alpha(1)[-1] == 1.0 and len(branch) < 500
    assert abs(branch.tangent[-1, 2, 2]) < 1e-9 and not branch.separation[:, 2].any()
    np.testing.assert_allclose(branch.separation[-1], stable.separation[-1], rtol=0, atol=1e-9)
    for fork in (1, -1):
        with pytest.raises(ValueError, match=f"^step 2: fork = {fork}: no other branch crosses in this step"):
            rough.run([preload, Step(s_Tx=0.2, follow="branch", fork=fork)])


def test_missed_fork(run, library: Path, tmp_path: Path) -> None:
    """The driver keeps the rows up to the step whose fork is not there, of a UMAT of others, too."""
    steps = "&step s_N = {0}, t_Tx = 0.0, follow = 'branch', fork = 1, arc = 1 /\n&step s_N = 0.0 /\n"
    for law, far in ((CASE.split("&step")[0].format(more=""), 0.02), (planted(library), 2.0 * ONSET)):
        result = run(law + steps.format(far), "--report", "r.json", "--force", code=2)
        assert f"case.nml: {NO_FORK}" in result.messages
        assert {row[0] for row in result.rows} == {"1"}
        assert float(result.rows[-1][result.header.index("s_N")]) == far
        report = json.loads((tmp_path / "r.json").read_text())
        assert (report["code"], report["message"], report["lost"]) == (2, NO_FORK, False)


def test_fork() -> None:
    """The case of a fork: both branches are followed, mirrored; `fork` without a branch is refused."""
    run = read_case(named_case("stability/fork")).runs[0]
    ends = {}
    for fork in (0, 1, -1):
        steps = run.steps[0], replace(run.steps[1], fork=fork)
        history, lost = run.interface.rows(steps)
        assert not lost and sum("fork" in text.split("+") for _, text in history.events) == 1
        ends[fork] = history.separation[-1]
    s_f = run.material.s_f
    assert abs(ends[0][2]) < ROUNDING and abs(ends[1][2]) > 0.1 * s_f
    assert np.abs(ends[1] * [1.0, 1.0, -1.0] - ends[-1]).max() < 1.0e-6 * s_f
    with pytest.raises(ValueError, match=f"^{NO_FORK}$"):
        run.interface.run([Step(s_Tx=0.01, t_N=0.0, follow="branch", fork=1), Step(s_Tx=0.02)])
    with pytest.raises(ValueError, match="fork without follow = 'branch'"):
        JOINT.run(Step(slip=0.1, fork=1))
    with pytest.raises(ValueError, match="fork = 2: expected -1, 0 or 1"):
        JOINT.run(Step(slip=0.1, follow="branch", fork=2))
