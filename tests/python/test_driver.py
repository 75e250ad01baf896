"""The driver `rie_driver` on the cases of the paper and on load paths: closed forms, control, events."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from support_driver import CASES, COLUMNS, FLAT, MATERIAL, RP_4, Result, assert_traction, call


@pytest.mark.parametrize("name", sorted(path.stem for path in CASES.glob("*.nml")))
def test_shipped_cases_end_as_expected(driver: Path, tmp_path: Path, name: str) -> None:
    """Every shipped case ends with exit code 0, few Newton iterations in a row and balanced energies."""
    process = call(driver, CASES / f"{name}.nml", folder=tmp_path)
    assert process.returncode == 0, process.stderr
    results = [Result(process, path) for path in tmp_path.glob("*.csv")]
    assert results
    for result in results:
        assert result.header == COLUMNS
        regular = [i for i, event in enumerate(result.events) if not event & {"lost", "substeps"}]
        assert len(regular) >= len(result.rows) - 1
        iterations = result["iterations"][regular]
        assert (iterations <= 6).sum() >= 0.9 * len(iterations)  # quadratic convergence with some switches
        assert iterations.max() <= 100  # where the branch has to be followed in smaller steps
        ledger = result["stored"] + result["rupture"] + result["friction"]
        # The error is of second order in the step of 0.0025 mm = s_0/8 (1.25 s_0 for eta = 0.99). The largest
        # is 0.0043 N/mm.
        assert np.abs(result["work"] - ledger).max() < 0.005
        assert (np.diff(result["friction"]) >= 0).all()


def test_rows_and_targets(run) -> None:
    """Each increment of lists, cycles and steps has a row with its time, and the targets are met exactly."""
    result = run(
        MATERIAL + FLAT + "&step s_N = 0.001, time = 3.0 /\n"
        "&step s_Tx = 0.4, -0.4, increments = 10, 20, cycles = 2, time = 6.0 /\n"
        "&step s_Tx = 0.1, 0.2, 0.3, t_N = -1.0, -2.0, increments = 1, 2, time = 3.0, 5.0, 1.0 /\n"
    )
    assert [int(row[0]) for row in result.rows] == [1] * 100 + [2] * 60 + [3] * 5
    assert [int(row[1]) for row in result.rows] == [*range(1, 101), *range(1, 61), *range(1, 6)]
    times = [*np.arange(1, 101) * 0.03, *(3 + np.arange(1, 61) * 0.1), 12.0, 14.5, 17.0, 17.5, 18.0]
    np.testing.assert_allclose(result["time"], times, rtol=1e-14)
    slip = result["s_Tx"][100:]
    assert list(slip[[9, 29, 39, 59, 60, 62, 64]]) == [0.4, -0.4, 0.4, -0.4, 0.1, 0.2, 0.3]
    # a shorter list repeats its last value
    assert_traction(result["t_N"][[160, 162, 164]], np.array([-1.0, -2.0, -2.0]))
    assert slip[19] == 0.0 and slip[14] == pytest.approx(0.2)
    assert (result["s_N"][100:160] == 0.001).all() and (result["s_Ty"] == 0.0).all()


def test_slip_along_a_direction(run) -> None:
    """A slip follows its direction, without any error along the axes, and so does the next step."""
    for degrees in (0.0, 30.0, 90.0, 180.0, 270.0, -90.0, 450.0):
        result = run(MATERIAL + RP_4 + f"&step slip = 0.01, direction = {degrees} /\n&step slip = 0.02 /\n")
        slip = np.repeat([0.01, 0.02], 100) * 0.01 * np.tile(np.arange(1, 101), 2)
        slip[100:] = 0.01 + 0.0001 * np.arange(1, 101)
        angle = math.radians(degrees)
        np.testing.assert_allclose(result["s_Tx"], slip * math.cos(angle), rtol=0, atol=1e-16)
        np.testing.assert_allclose(result["s_Ty"], slip * math.sin(angle), rtol=0, atol=1e-16)
        if degrees % 90 == 0:
            assert (result["s_Tx"] == 0).all() or (result["s_Ty"] == 0).all()


def test_normal_stiffness(run) -> None:
    """With a spring t_N = t_N0 - k (s_N - s_N0), where 0 is the start of the step, until k_N is set to 0."""
    k = 20.0
    result = run(
        MATERIAL + RP_4 + f"&step t_N = -1.0 /\n&step k_N = {k}, slip = 0.3, 0.6 /\n&step slip = 0.5 /\n"
        "&step k_N = 0.0, slip = 0.6 /\n&step k_N = 5.0, t_N = -4.0 /\n"
    )
    s, t, step = result["s_N"], result["t_N"], result["step"]
    springy = (step == 2) | (step == 3)
    assert_traction(t[springy], -1.0 - k * (s[springy] - s[99]))
    assert t[step == 2][-1] < -3.0  # the dilation has raised the pressure
    before = t[step == 3][-1]
    assert_traction(t[step == 4], before)
    s_start = s[step == 4][-1]
    ramp = before + (-4.0 - before) * np.arange(1, 101) / 100
    assert_traction(t[step == 5], ramp - 5.0 * (s[step == 5] - s_start))


def test_columns_per_plane(run) -> None:
    """--planes and `planes = .true.` add columns of each plane; the weighted alphas sum to the damage."""
    path = MATERIAL + RP_4 + "&step t_N = -5.0 /\n&step slip = 0.1, direction = 10.0 /\n"
    result = run(path, "--planes")
    names = [f"{name}_{k}" for k in range(1, 6) for name in ("alpha", "s_dit", "s_dih")]
    assert result.header == COLUMNS + names
    weights = [1 / 3] + [1 / 6] * 4
    total = sum(w * result[f"alpha_{k}"] for k, w in enumerate(weights, 1))
    np.testing.assert_allclose(total, result["damage"], rtol=1e-14, atol=1e-16)
    assert np.abs(result["s_dit_2"]).max() > 0 and np.abs(result["s_dih_1"]).max() > 0
    assert run("&case planes = .true. /\n" + path).header == result.header
    assert run("&case planes = F /\n" + path).header == COLUMNS


def test_numbers_come_back_exactly(run) -> None:
    """A value that is read back has the same bits."""
    result = run(MATERIAL + FLAT + "&step s_N = 0.1234567890123456789 /\n")
    assert result["s_N"][-1] == 0.1234567890123456789
