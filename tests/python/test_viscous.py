"""Viscous damage (PROPS 13) and cut requests (PROPS 14): package, C API and driver against the reference."""

from __future__ import annotations

import dataclasses
import subprocess
from pathlib import Path

import numpy as np
import pytest
from asperity import History, Interface, Material, Pattern
from asperity.contract import N_POINT_STATEV
from asperity.installed import driver

from tests.oracle import reference

NAN, INF = float("nan"), float("inf")
TAU_V = 0.4
VISCOUS = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5, tau_v=TAU_V)
RP_4 = Interface(VISCOUS, Pattern.regular(4, 30.0))
PLANES = reference.regular_pattern(4, 30.0)
S_F = 0.2
K = 150.0

ROUNDING = 1e-12
"""Tolerance in multiples of K |s|, |s|, K |s|^2 and 1: sums over five planes after tens of increments."""

SOLVED = 1e-9
"""Tolerance over sigma0 if both solve for s_N: residuals of 1e-12 over the smallest slope, 1e-3 K."""

CASE = """\
&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, tau_v = 0.4 /
&pattern sides = 4, theta = 30.0 /
"""
STEPS = """\
&step t_N = -5.0, increments = 20, time = 0.25 /
&step slip = 0.3, -0.2, direction = 20.0, increments = 40, time = 2.0 /
"""


def parameters(material: Material) -> reference.Parameters:
    """The same material for the reference."""
    return reference.Parameters(**material.values())


def random_walk(rng: np.random.Generator, rows: int) -> np.ndarray:
    """Separations (rows, 3) through every branch of the law, a third of them with very small increments.

    The increments are not zero because a sliding plane would then be at the switch to stick, where the
    tangent is not unique.
    """
    steps = 0.03 * rng.standard_normal((rows, 3)) * np.where(rng.random((rows, 1)) > 1 / 3, 1.0, 0.01)
    return np.cumsum(steps, axis=0)


@pytest.mark.parametrize("seed", range(30))
def test_updates_are_the_reference(seed: int) -> None:
    """Traction, state and tangent of 20 points over increments of any duration, from 0 on."""
    rng = np.random.default_rng([13, seed])
    eta, mu, kc = rng.uniform(0.3, 0.95), rng.uniform(0, 1), rng.uniform(0.5, 5)
    material = dataclasses.replace(VISCOUS, eta=eta, mu=mu, kc=kc)
    scale = kc * K / (1 - eta) * 0.1
    interface, p = Interface(material, RP_4.pattern), parameters(material)
    paths = np.stack([random_walk(rng, 25) for _ in range(20)], axis=1)
    state, s_old, grown = np.zeros((20, RP_4.nstatv)), np.zeros((20, 3)), 0
    for s in paths:
        dt = float(rng.choice([0.0, TAU_V * 10 ** rng.uniform(-4, 4)], p=[0.1, 0.9]))
        ours, theirs = interface.update(s, state, s_old, dt), reference.update(p, PLANES, s, state, s_old, dt)
        np.testing.assert_allclose(ours.traction, theirs.traction, rtol=0, atol=ROUNDING * scale)
        np.testing.assert_allclose(ours.state, theirs.state, rtol=0, atol=ROUNDING * scale)
        # small trial stresses and steep damage magnify rounding errors
        np.testing.assert_allclose(ours.tangent, theirs.tangent, rtol=0, atol=1e4 * ROUNDING * scale)
        grown += int((ours.state[:, N_POINT_STATEV::3] > state[:, N_POINT_STATEV::3]).sum())
        state, s_old = ours.state, s
    assert grown > 100


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_replay_and_confined_slip_are_the_reference() -> None:
    """Histories in time agree: prescribed separations, and slip under a normal traction after a preload."""
    rng = np.random.default_rng(14)
    S, times = random_walk(rng, 60), np.cumsum(rng.exponential(0.01, 60))
    ours, theirs = RP_4.replay(S, times), reference.replay(parameters(VISCOUS), PLANES, S, times)
    np.testing.assert_allclose(ours.traction, theirs.traction, rtol=0, atol=ROUNDING * K)
    np.testing.assert_allclose(ours.state, theirs.state, rtol=0, atol=ROUNDING * K)
    assert 0.05 < ours.damage[-1] < 0.95
    slips, times = np.linspace(0.0, 0.4, 81), np.linspace(0.0, 3.0, 81)
    solved = RP_4.confined_slip(20.0, slips, -10.0, 20, times, 0.7)
    expected = reference.confined_slip(parameters(VISCOUS), PLANES, 20.0, slips, -10.0, 20, times, 0.7)
    np.testing.assert_allclose(solved.traction, expected.traction, rtol=0, atol=SOLVED * VISCOUS.sigma0)
    np.testing.assert_allclose(solved.damage, expected.damage, rtol=0, atol=SOLVED)
    sudden = RP_4.confined_slip(20.0, slips, -10.0, 20, times, 0.0)
    assert np.abs(solved.traction - sudden.traction).max() > 1e-3


@pytest.mark.parametrize("rows", [50, 500])
def test_flat_joint_breaks_without_pressure(rows: int) -> None:
    """Slip at t_N = 0 goes on as the delayed damage releases the traction: (1 - D) K s, and no opening."""
    flat = Interface(dataclasses.replace(VISCOUS, tau_v=0.03), Pattern.regular(0, 0.0))
    slips = np.linspace(0.0, 0.5, rows + 1)[1:]
    history = flat.confined_slip(0.0, slips, 0.0, times=np.arange(1.0, rows + 1.0))
    damage, expected = 0.0, []
    for rest in np.clip((1.0 - 0.1 * S_F / slips) / 0.9, 0.0, 1.0):
        damage += max(rest - damage, 0.0) / 1.03
        expected.append((1.0 - damage) * K)
    assert history.traction[:, 1] == pytest.approx(expected * slips, abs=ROUNDING * K)
    assert not np.any(history.separation[:, 0]) and not np.any(history.traction[:, 0])


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: RP_4.update([[0, 0, 0]]), "dt is missing: expected for viscous damage, tau_v = 0.4"),
        (lambda: RP_4.update([[0, 0, 0]], dt=-1.0), r"dt = -1: expected a finite time increment >= 0"),
        (lambda: RP_4.update([[0, 0, 0]], dt=NAN), "dt = NaN: expected a finite time increment >= 0"),
        (lambda: RP_4.update([[0, 0, 0]], dt=INF), "dt = Inf: expected a finite time increment >= 0"),
        (lambda: RP_4.replay([[0, 0, 0]]), "times is missing: expected for viscous damage"),
        (lambda: RP_4.replay([[0, 0, 0]], [1.0, 2.0]), r"times have shape \(2,\): expected \(1,\)"),
        (lambda: RP_4.replay([[0, 0, 0]], [-1.0]), r"times\[0\] = -1: expected a finite number from 0"),
        (lambda: RP_4.replay([[0, 0, 0]] * 3, [1, 3, 2]), r"times\[2\] = 2: expected a finite number from 3"),
        (lambda: RP_4.replay([[0, 0, 0]] * 2, [1, NAN]), r"times\[1\] = nan: expected a finite number"),
        (lambda: RP_4.replay([[0, 0, 0]], [INF]), r"times\[0\] = inf: expected a finite number"),
        (lambda: RP_4.confined_slip(0.0, [0.1], 0.0), "times is missing: expected for viscous damage"),
        (lambda: RP_4.confined_slip(0.0, [0.1], 0.0, times=[[1.0]]), r"times have shape \(1, 1\): expected"),
        (
            lambda: RP_4.confined_slip(0.0, [0.1], 0.0, times=[1.0], preload_time=-1.0),
            r"preload_time = -1.0: expected a finite time >= 0",
        ),
        (
            lambda: RP_4.confined_slip(0.0, [0.1], 0.0, times=[1.0], preload_time=NAN),
            r"preload_time = nan: expected a finite time >= 0",
        ),
    ],
)
def test_bad_times(call: object, message: str) -> None:
    """The message names a missing or inadmissible time and the expectation."""
    with pytest.raises(ValueError, match=message):
        call()


def run(folder: Path, case: str, name: str = "case") -> Path:
    """Run a case and return its rows, with the columns of the planes."""
    (folder / f"{name}.nml").write_text(case, encoding="utf-8")
    done = subprocess.run(
        [driver(), f"{name}.nml", "--planes"], cwd=folder, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return folder / f"{name}.csv"


def columns(path: Path) -> dict[str, np.ndarray]:
    """Columns of numbers by name."""
    header, *rows = [line.split(",") for line in path.read_text(encoding="utf-8").splitlines()]
    return {
        name: np.array([float(row[i]) for row in rows]) for i, name in enumerate(header) if name != "event"
    }


def test_driver_steps_take_their_time(tmp_path: Path) -> None:
    """The law uses `time` of &step: the rows are those of the package with the same times."""
    rows = columns(run(tmp_path, CASE + STEPS))
    s = np.stack([rows["s_N"], rows["s_Tx"], rows["s_Ty"]], axis=1)
    t = np.stack([rows["t_N"], rows["t_Tx"], rows["t_Ty"]], axis=1)
    expected = RP_4.replay(s, rows["time"])
    np.testing.assert_allclose(t, expected.traction, rtol=0, atol=ROUNDING * K)
    np.testing.assert_allclose(rows["damage"], expected.damage, rtol=0, atol=ROUNDING)
    assert rows["time"][-1] == pytest.approx(2.25, abs=1e-15)
    faster = columns(run(tmp_path, CASE + STEPS.replace("time = 2.0", "time = 0.2")))
    assert faster["damage"][-1] < rows["damage"][-1] - 0.05


@pytest.mark.parametrize("through", ["umat', ntens = 6, h = 0.5", "vumat', block = 21"])
def test_driver_replays_in_time(tmp_path: Path, through: str) -> None:
    """A replay of a viscous run through the host routines, with its column `time`, gives the same rows."""
    direct = run(tmp_path, CASE + STEPS, "record")
    replay = columns(run(tmp_path, CASE + f"&replay file = 'record.csv', through = '{through} /\n"))
    for name, column in columns(direct).items():
        if name not in ("step", "increment", "iterations"):
            np.testing.assert_allclose(replay[name], column, rtol=1e-12, atol=1e-11, err_msg=name)


def test_driver_replay_without_times(tmp_path: Path) -> None:
    """dtime is the time increment where the record has no column `time`."""
    S = random_walk(np.random.default_rng(17), 30)
    np.savetxt(tmp_path / "record.csv", S, delimiter=",", header="s_N,s_Tx,s_Ty", comments="", fmt="%.17g")
    rows = columns(run(tmp_path, CASE + "&replay file = 'record.csv', dtime = 0.05 /\n"))
    expected = RP_4.replay(S, 0.05 * np.arange(1, 31))
    np.testing.assert_allclose(rows["damage"], expected.damage, rtol=0, atol=1e-11)
    assert 0.01 < rows["damage"][-1] < 0.95


def test_driver_shows_cut_requests(tmp_path: Path) -> None:
    """`dalpha` of &replay is PROPS 14: rows have the event `cut` where a plane's damage grew by more."""
    plain = CASE.replace(", tau_v = 0.4", "")
    run(tmp_path, plain + STEPS, "record")
    limit = 0.02
    path = run(tmp_path, plain + f"&replay file = 'record.csv', dalpha = {limit} /\n")
    rows = columns(path)
    alpha = np.stack([rows[f"alpha_{k}"] for k in range(1, 6)], axis=1)
    growth = np.diff(alpha, axis=0, prepend=0.0).max(axis=1)
    rows_cut = [row for row, text in History.from_csv(path).events if "cut" in text]
    cut = np.isin(np.arange(len(growth)), rows_cut)
    assert np.array_equal(cut, growth > limit)
    assert 0 < cut.sum() < len(cut)
