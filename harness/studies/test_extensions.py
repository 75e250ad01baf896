"""Finite asperity height and wear: the statements of docs/extensions.md, warnings, fit."""

from __future__ import annotations

import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, ModelWarning, Pattern, Step, read_case
from asperity.installed import driver
from asperity.model_checks import model_warnings
from asperity.tools.fit import ShearTest
from asperity.tools.fit.fitting import fit
from asperity.tools.fit.report import case_of, report

from harness.studies import extensions
from harness.studies.extensions import PRESSURE, TABLE_2, path

RT = Pattern.regular(2, 30.0)
STIFF = replace(TABLE_2, kc=100.0)
BOND = {"sigma0": 3.0, "Gc": 0.3, "mu": 0.5}

pytestmark = pytest.mark.filterwarnings("ignore::asperity.ModelWarning")


def test_snap_vanishes() -> None:
    """The jump of RP-16 without pressure shrinks with the height; below 2.5 s_f the branch does not end."""
    jumps = [extensions.snap(height).snaps for height in (0.0, 2.0, 1.0, 0.5)]
    sizes = [jump.after[0] - jump.before[0] for [jump] in jumps[:3]]
    assert np.all(np.diff(sizes) < 0.0) and sizes[-1] > 0.0 and jumps[3] == ()


def wear_out(share: np.ndarray, slips: np.ndarray) -> float:
    """Cycles until the share of the slope that is left falls to extensions.ROUGH_LEFT; nan if it does not."""
    below = np.flatnonzero(share <= extensions.ROUGH_LEFT)
    way = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(slips)))])
    return float(way[below[0]] / (4.0 * extensions.AMPLITUDE)) if below.size else np.nan


@pytest.mark.parametrize("pressure", extensions.PRESSURES)
def test_wear_out_is_that_of_plesha(pressure: float) -> None:
    """About half a cycle more than by Plesha's law: the first strokes break the bond and wear less."""
    slips, ours, plesha = extensions.shares(pressure)
    law, expected = (wear_out(share, slips) for share in (ours, plesha))
    assert 0.0 < law - expected < 0.6
    # worn asperities slide at mu |sigma_N|: the work of a cycle is 4 a mu |sigma_N|, half of it on each facet
    work = 2.0 * extensions.AMPLITUDE * 0.5 * -pressure / RT.weights[1]
    assert expected == pytest.approx(-np.log(extensions.ROUGH_LEFT) * extensions.SLOW / work, rel=0.2)


def test_driver_and_python_print_the_same_sentences(tmp_path: Path) -> None:
    """Every warning of a run has the same words and numbers in driver and Python."""
    case = tmp_path / "doubtful.nml"
    case.write_text(
        "&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, Gc2 = 0.4, W0 = 0.5, height = 0.15,"
        " closure = 0.001 /\n&pattern sides = 2, theta = 1.0 /\n"
        "&step t_N = -10.0, increments = 20 /\n&step slip = 0.05, increments = 20 /\n"
    )
    done = subprocess.run([driver(), case], cwd=tmp_path, capture_output=True, text=True, check=True)
    printed = [line.partition("warning: ")[2] for line in done.stderr.splitlines() if "warning: " in line]
    with pytest.warns(ModelWarning) as caught:
        read_case(case).runs[0].history()
    assert printed == [str(warning.message) for warning in caught]
    assert [text for text in printed if "0.995025 of the largest closure Vm, expected at most 0.99" in text]
    assert "increment of slip in an FE code: expected at most W0/(mu z dp/dc)" in done.stderr


def drop(joint: Interface, direction: float, slips: np.ndarray, sigma_N: float) -> float:
    """Largest drop of the traction in an increment, over its largest value."""
    tau = np.hypot(*joint.confined_slip(direction, slips, sigma_N).traction[:, 1:].T)
    return float(-np.diff(tau).min() / tau.max())


@pytest.mark.parametrize(("W0", "jumps"), [(2.0, False), (0.05, True)])
def test_wear_runs_away_only_beyond_the_limit(W0: float, jumps: bool) -> None:
    """Below the limit the traction has no jump; far above it a facet wears off in one."""
    joint = Interface(replace(STIFF, W0=W0), RT)
    assert (drop(joint, 0.0, path(0.4, step=0.0005), PRESSURE) > 0.1) == jumps


@pytest.mark.parametrize(
    ("sides", "direction", "W0", "jumps"),
    [(4, 45.0, 20.0, False), (4, 45.0, 3.75, True), (2, 0.0, 0.94, False)],
)
def test_shared_pressure_wears_in_jumps(sides: int, direction: float, W0: float, jumps: bool) -> None:
    """Two facets that a slip climbs at once wear in jumps where a warning says so; opposite ones do not."""
    joint = Interface(replace(STIFF, height=0.5, W0=W0), Pattern.regular(sides, 30.0))
    assert (drop(joint, direction, np.linspace(0.0, 0.6, 601), -1.0) > 0.05) == jumps
    warnings = model_warnings(joint.material, joint.pattern, -1.0, slip=0.6)
    assert any("share the pressure" in text for text in warnings) == jumps


@pytest.mark.parametrize("parts", [1, 2])
def test_fall_by_wear_is_a_snap(parts: int) -> None:
    """A locked joint that loses its contact by wear reports the fall and books what it had stored."""
    material = replace(TABLE_2, eta=0.99, mu=1.2, kc=10.0, height=0.365, W0=0.0433)
    joint = Interface(material, Pattern.regular(3, 56.8, flat=0.1))
    press = Step(t_N=-0.937, increments=20)
    test = joint.run([press, Step(slip=0.2, direction=334.65, increments=60 * parts)])
    fall = int(np.argmin(np.diff(test.separation[:, 0]))) + 1
    lost = test.stored[fall - 1] - test.stored[fall]
    assert lost > 0.3 * test.stored.max()
    assert np.ptp(test.separation[fall - 1 : fall + 1, 0]) > 0.5 * test.separation[:, 0].max()
    [snap] = [snap for snap in test.snaps if snap.row == fall]
    assert snap.before == tuple(test.separation[fall - 1]) and snap.after == tuple(test.separation[fall])
    ledger = test.work - test.stored - test.rupture - test.friction
    # the error of the steps of the fall
    assert abs(snap.released) < 0.01 * lost
    assert ledger[fall] - ledger[fall - 1] == pytest.approx(snap.released, abs=1e-12)


def test_guard_decides_by_the_increment() -> None:
    """An update at the same separation changes the traction with the guard in few rows, and once."""
    rng = np.random.default_rng(4)
    changes = []
    for _ in range(200):
        mu, kc = rng.choice([0.3, 0.5, 0.8]), rng.choice([1.0, 10.0, 100.0])
        material = replace(TABLE_2, mu=mu, kc=kc, guard=True)
        joint = Interface(material, Pattern.regular(int(rng.choice([2, 3, 4])), rng.uniform(0.0, 50.0)))
        s, state = np.zeros((1, 3)), np.zeros((1, joint.nstatv))
        for _ in range(60):
            old, s = s, s + 0.02 * rng.uniform(0.1, 1.0) * rng.normal(size=(1, 3))
            s[0, 0] = np.clip(s[0, 0], -0.1, 0.05)
            first = joint.update(s, state, old)
            state = first.state
            second = joint.update(s, state, s)
            third = joint.update(s, second.state, s)
            scale = max(np.linalg.norm(first.traction), TABLE_2.sigma0)
            changes.append(np.linalg.norm(second.traction - first.traction) / scale)
            assert np.linalg.norm(third.traction - second.traction) < 1e-12 * scale
    changed = np.array(changes) > 1e-9
    assert 0 < changed.mean() < 0.01 and max(changes) < 0.2


# --- crushed asperities -----------------------------------------------------------------------------------


def test_envelopes_of_barton() -> None:
    """One plane with crush follows each envelope of Barton; without crush the best one is off by a tenth."""
    for joint in extensions.JOINTS:
        for crushed, least, most in ((True, 0.005, 0.012), (False, 0.1, 0.2)):
            _, peaks, law = extensions.envelope(*joint, crushed)
            assert least < np.sqrt(np.mean((law / peaks - 1.0) ** 2)) < most


@pytest.mark.parametrize("seed", range(100, 112))
def test_energies_of_random_walks(seed: int) -> None:
    """Along a random walk friction never decreases, and work and energies agree to second order."""
    rows = [extensions.walk(seed, n) for n in (100, 800)]
    assert all(np.all(np.diff(run.friction) >= 0.0) for run in rows)
    # an eighth of the length: 1/64 where the order is reached, 1/8 where energy jumps
    assert extensions.imbalance(rows[1]) < extensions.imbalance(rows[0]) / 16.0


# --- fit ----------------------------------------------------------------------------------------------------


def slip_tests_of(material: Material, slips: np.ndarray, sides: int = 8) -> list[ShearTest]:
    """Slip tests without noise."""
    joint = Interface(material, Pattern.regular(sides, 25.0))
    tests = []
    for sigma_N in (-1.0, -2.0):
        history = joint.confined_slip(0.0, slips, sigma_N, 50)
        s_N = history.separation[:, 0] - history.separation[0, 0]
        tests.append(ShearTest(f"{sigma_N:g}", slips[1:], history.traction[1:, 1], s_N[1:], sigma_N))
    return tests


SHORT, LONG = np.linspace(0.0, 0.4, 161), np.linspace(0.0, 0.8, 401)
WITHOUT_BOND = Material.from_joint(kn=40.0, ks=20.0, mu=0.5, closure=0.02, height=0.3)
KNOWN = BOND | {"eta": 0.9, "flat": 1 / 3}
FITS = {
    "height": (replace(STIFF, height=0.4), LONG, 8, KNOWN | {"kc": 100.0}, {"theta": 25.0, "height": 0.4}),
    "no bond": (WITHOUT_BOND, SHORT, 8,
                {"kc": 2.0, "theta": 25.0, "height": 0.3, "closure": 0.02, "flat": 1 / 3},
                {"ks": 20.0, "mu": 0.5}),
    "wear": (replace(TABLE_2, kc=20.0, W0=4.0), path(0.3, -0.3, 0.3), 2,
             KNOWN | {"kc": 20.0, "theta": 25.0}, {"W0": 4.0}),
}  # fmt: skip
"""Joint, slips, sides, constants that are given, and truth of the others."""


@pytest.mark.slow
@pytest.mark.parametrize("name", [*list(FITS)[:2], pytest.param("wear", marks=pytest.mark.long)])
def test_fit_finds(name: str, tmp_path: Path) -> None:
    """Constants of tests without noise are identified; the report names them, the case has them."""
    joint, slips, sides, fixed, free = FITS[name]
    tolerance = 0.02  # the fit has 150 increments along a test
    result = fit(slip_tests_of(joint, slips, sides), free=tuple(free), fixed=fixed, sides=sides)
    for constant, truth in free.items():
        assert result.values[constant] == pytest.approx(truth, rel=tolerance)
        assert re.search(rf"^{constant} ", report(result), re.MULTILINE)
    (tmp_path / "joint.nml").write_text(case_of(result))
    written = read_case(tmp_path / "joint.nml").runs[0].material
    for constant in ("K", "mu", "kc", "height", "damage0", "closure", "W0"):
        assert getattr(written, constant) == pytest.approx(
            getattr(joint, constant), rel=max(tolerance, 1e-3)
        ), constant
