"""The guard in package, driver and host routines (PROPS 17): agreement with the reference, and its effect."""

from __future__ import annotations

import re
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from asperity import Interface, Material, Pattern, contract
from asperity.installed import driver

from tests.oracle import reference

TABLE_2 = Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=0.5)
GUARDED = replace(TABLE_2, guard=True)
RP_4 = Pattern.regular(4, 30.0)
S_0, K = 0.02, 150.0

ROUNDING = 1e-12
"""Tolerance in multiples of K |s|, |s|, K |s|^2 and 1: sums over five planes after tens of increments."""

EITHER = "0, 1, .true. or .false."
"""What the driver takes for the guard."""

CASE = """\
&material sigma0 = 3.0, Gc = 0.3, eta = 0.9, mu = 0.5, guard = GUARD /
&pattern sides = 0 /
&step s_Tx = 0.03, increments = 50 /
&step s_N = -0.2, increments = 50 /
&step s_Tx = -0.05, increments = 200 /
"""


def clamped_path(seed: int, rows: int) -> np.ndarray:
    """Slip without pressure, then reversals under closure: Y has either sign and damage grows."""
    rng = np.random.default_rng([18, seed])
    S = np.cumsum(S_0 * rng.standard_normal((rows, 3)), axis=0) * np.linspace(0.3, 1.2, rows)[:, None]
    S[:, 0] = -20 * S_0 - 2 * np.abs(S[:, 0])
    S[0] = S_0 * np.array([0.1, 2.0, 1.0])
    return S


@pytest.mark.parametrize("sides", [0, 4])
def test_guard_is_the_reference(sides: int) -> None:
    """Histories with the guard have traction, state and tangent of the reference; the guard acts often."""
    pattern, planes = Pattern.regular(sides, 30.0), reference.regular_pattern(sides, 30.0)
    p = reference.Parameters(**GUARDED.values())
    guarded, plain = Interface(GUARDED, pattern), Interface(TABLE_2, pattern)
    differ = 0
    for seed in range(20):
        S = clamped_path(seed, 40)
        ours, theirs = guarded.replay(S), reference.replay(p, planes, S)
        np.testing.assert_allclose(ours.traction, theirs.traction, rtol=0, atol=ROUNDING * K)
        np.testing.assert_allclose(ours.state, theirs.state, rtol=0, atol=ROUNDING * K)
        np.testing.assert_allclose(
            guarded.update(S[1:], ours.state[:-1], S[:-1]).tangent, theirs.tangent[1:], rtol=0, atol=1e-8 * K
        )
        assert np.all(np.diff(ours.state[:, 2]) >= 0.0)
        differ += int(np.any(plain.replay(S).state != ours.state))
    assert differ >= 5


def test_guard_is_part_of_the_material() -> None:
    """Materials with and without guard differ, and PROPS and cards contain the guard."""
    guarded = Interface(GUARDED, RP_4)
    assert guarded != Interface(TABLE_2, RP_4) and Material(3.0, 0.3, 0.9, 0.5).guard is False
    assert guarded.props()[contract.index("guard")] == 1.0
    constants = re.search(r"constants=(\d+).*\n((?:[-\d].*\n)+)", guarded.card("abaqus"))
    assert constants
    values = [float(value) for value in constants[2].replace("\n", " ").replace(",", " ").split()]
    assert len(values) == int(constants[1]) and values == guarded.props().tolist()
    for bad in (2, 0.5, -1):
        with pytest.raises(ValueError, match=rf"guard = {bad}: expected 0 or 1"):
            replace(TABLE_2, guard=bad)


def run(folder: Path, case: str) -> subprocess.CompletedProcess[str]:
    """Run a case."""
    (folder / "case.nml").write_text(case, encoding="utf-8")
    return subprocess.run([driver(), "case.nml"], cwd=folder, capture_output=True, text=True, check=False)


def rupture(folder: Path) -> np.ndarray:
    """Column of the rupture energy."""
    header, *rows = [
        line.split(",") for line in (folder / "case.csv").read_text(encoding="utf-8").splitlines()
    ]
    return np.array([float(row[header.index("rupture")]) for row in rows])


def test_driver_replay(tmp_path: Path) -> None:
    """UMAT and VUMAT have the guard: a replay of the path gives the rupture energy of the steps."""
    assert run(tmp_path, CASE.replace("GUARD", "1")).returncode == 0
    energy = rupture(tmp_path)
    (tmp_path / "case.csv").rename(tmp_path / "path.csv")
    head = CASE.split("&step")[0].replace("GUARD", ".true.")
    for through in ("umat", "vumat"):
        done = run(tmp_path, head + f"&replay file = 'path.csv', through = '{through}' /\n")
        assert done.returncode == 0, done.stderr
        np.testing.assert_allclose(rupture(tmp_path), energy, rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("guard", "expected"),
    [("maybe", EITHER), ("2", "0 or 1"), ("0.5", "0 or 1"), ("1, 1", EITHER)],
)
def test_driver_bad_guard(tmp_path: Path, guard: str, expected: str) -> None:
    """A value of guard that is neither logical nor 0 or 1 is an error."""
    done = run(tmp_path, CASE.replace("GUARD", guard))
    assert done.returncode == 1 and f"guard = {guard}: expected {expected}" in done.stderr
