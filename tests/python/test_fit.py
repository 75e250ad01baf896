"""Parameters from shear-box tests: identified within their intervals, doubts reported, bad files rejected."""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from pathlib import Path
from typing import Any

import asperity
import numpy as np
import pytest
from asperity import contract
from asperity.case_files import read_case, slip_tests
from asperity.cli import main
from asperity.fit import fitting, outcome
from asperity.fit import model as fit_model
from asperity.fit.constants import to_scale
from asperity.fit.fitting import fit
from asperity.fit.outcome import residual_ratio
from asperity.fit.records import read_tests
from asperity.fit.report import case_of, doubts_of, report
from asperity.fit.search import COVARIANCE, HEADING
from asperity.fit.shear_test import ShearTest
from asperity.options import PICTURES, may_replace

from harness.studies import synthetic as study
from tests.oracle import reference

TRUTH = study.TRUTH
SOME = study.SET
AT_TRUTH = {name: TRUTH[name] for name in study.FREE}
HEADER = "slip,tau,dilation,sigma_N\n"
WITH_UNITS = "slip [mm],tau [MPa],dilation [mm],sigma_N [MPa]\n"
ROWS = "".join(f"{0.1 * i:.1f},{min(i, 4) * 0.2:.1f},{0.02 * i:.2f},-1\n" for i in range(1, 8))


def write(folder: Path, text: str, name: str = "record.csv") -> Path:
    """A file."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def three_percent() -> outcome.Fit:
    """Fit of tests with 3 % noise, from random starts."""
    return fit(study.synthetic(0.03, 0), fixed=study.SET)


@pytest.fixture(scope="module")
def no_dilation() -> outcome.Fit:
    """Fit of the same tests without dilation."""
    tests = study.synthetic(0.03, 0, dilation=False)
    return fit(tests, study.FREE, study.SET, start=AT_TRUTH, starts=1)


# --- constant normal stiffness ------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize("sides", [0, 2, 5])
def test_normal_stiffness_against_reference(sides: int) -> None:
    """Along the same separations the reference has t_N = sigma_N - k (s_N - s_N at the start)."""
    sigma_N, k, preload = -3.0, 4.0, 4
    material = {"sigma0": 3.0, "Gc": 0.3, "eta": 0.9, "mu": 0.5, "kc": 10.0}
    interface = asperity.Interface(asperity.Material(**material), asperity.Pattern.regular(sides, 25.0))
    slips = np.concatenate([[0.0], np.linspace(0, 0.3, 40)[1:], np.linspace(0.3, -0.1, 40)[1:]])
    path = interface.confined_slip(20.0, slips, sigma_N, preload, stiffness=k)
    before = [
        interface.confined_slip(20.0, [0.0], sigma_N * i / preload, i).separation[0]
        for i in range(1, preload + 1)
    ]
    law = reference.replay(
        reference.Parameters(**material),
        reference.regular_pattern(sides, 25.0),
        np.concatenate([before, path.separation]),
    )
    traction = law.traction[preload:]
    rise = path.separation[:, 0] - path.separation[0, 0]
    assert sides == 0 or np.ptp(rise) > 0.05
    # tolerance of the solver, relative to the largest terms
    assert np.allclose(traction[:, 0], sigma_N - k * rise, rtol=0.0, atol=1e-9)
    assert np.allclose(traction, path.traction, rtol=0.0, atol=1e-9)


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_normal_stiffness_refused() -> None:
    """A negative or non-finite stiffness is rejected."""
    flat = asperity.Interface(asperity.Material(3.0, 0.3, 0.9, 0.5), asperity.Pattern.regular(0, 0.0))
    for bad in (-1.0, np.nan, np.inf):
        with pytest.raises(ValueError, match=r"^stiffness = .*: expected >= 0"):
            flat.confined_slip(0.0, [0.1], -1.0, stiffness=bad)


# --- recovery -----------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_record_of_the_reference_model() -> None:
    """The parameters of tests computed by the independent reference, without noise, are identified."""
    slips = np.linspace(0.0, 0.8, 401)[1:]
    parameters = reference.Parameters(**{name: TRUTH[name] for name in ("sigma0", "Gc", "eta", "mu", "kc")})
    pattern = reference.regular_pattern(study.SIDES, TRUTH["theta"], TRUTH["flat"])
    tests = []
    for sigma_N in (-1.0, -4.0):
        rows = reference.confined_slip(
            parameters, pattern, 0.0, np.concatenate([[0.0], slips]), sigma_N, preload_increments=50
        )
        s_N = rows.separation[1:, 0] - rows.separation[0, 0]
        tests.append(ShearTest("reference", slips, rows.traction[1:, 1], s_N, sigma_N))
    found = fit(tests, fixed=study.SET, start=AT_TRUTH | {"mu": 0.7, "theta": 10.0, "Gc": 0.4}, starts=1)
    for name, value in AT_TRUTH.items():
        # increments and roots are the same, so only the tolerances of the least squares remain
        assert found.values[name] == pytest.approx(value, rel=1e-6), name


NOISES = (0.01, 0.03, 0.10)
"""Standard deviations of the noise, as a fraction of the range of tau and of s_N in each test."""


def noisy_fit(clean: list[ShearTest], noise: float, seed: int) -> outcome.Fit:
    """Fit of tests with noise from the true constants."""
    rng = np.random.default_rng(seed)
    tests = [
        replace(one, tau=study.noisy(one.tau, noise, rng), s_N=study.noisy(one.s_N, noise, rng))
        for one in clean
    ]
    return fit(tests, study.FREE, study.SET, start=AT_TRUTH, starts=1, seed=seed)


def holds(found: outcome.Fit) -> list[bool]:
    """Whether the interval of each free parameter, then of the residual ratio, contains the true value."""
    intervals = [(TRUTH[name], one) for name, one in found.estimates.items()]
    intervals.append((residual_ratio(TRUTH), found.of(residual_ratio)))
    return [one.low <= value <= one.high for value, one in intervals]


@pytest.mark.long
@pytest.mark.parametrize("noise", NOISES)
def test_intervals_hold_at_their_rate(noise: float) -> None:
    """95 % intervals of every parameter and of the ratio: at most 4 of 16 miss (odds of 0.1 %)."""
    repetitions, most = 16, 4
    clean = study.synthetic(0.0, 0)
    fits = [noisy_fit(clean, noise, seed) for seed in range(repetitions)]
    shares = np.mean([holds(one) for one in fits], axis=0)
    assert np.all(shares >= 1.0 - most / repetitions), shares
    # intervals that are too wide would pass, too: the scatter must be the noise (which widens the range), and
    # 50 % intervals of the same fits must miss
    assert all(abs(np.log(one.scatter[0] / noise)) < 0.2 + 5.0 * noise for one in fits)
    misses = 0
    for one in fits:
        half = 0.6745 * np.sqrt(np.diag(one.covariance))
        exact = [float(to_scale(name, TRUTH[name])) for name in one.problem.free]
        misses += int(np.sum(np.abs(one.x - exact) > half))
    of = repetitions * len(AT_TRUTH)
    assert 0.25 < misses / of < 0.75


@pytest.mark.slow
def test_increments_of_a_cycle(monkeypatch: pytest.MonkeyPatch) -> None:
    """Without noise the parameters of a cycle are identified, because the increments are refined.

    The 200 requested increments alone shift mu by 0.5 %, which is reported.
    """
    tests = study.synthetic(0.0, 0, sigma_N=(-1.0,), **study.CYCLIC)
    start = AT_TRUTH | {"mu": 0.7, "theta": 25.0}
    found = fit(tests, fixed=study.SET, start=start, starts=1)
    assert found.problem.increments == fit_model.INCREMENTS and found.problem.refinement > 1
    assert found.shift <= outcome.ENOUGH
    # the error is of first order: dividing increments by four removes three quarters of it
    most = 2.0 * outcome.ENOUGH * outcome.LEAST_ERROR
    for name, value in AT_TRUTH.items():
        assert found.values[name] == pytest.approx(value, rel=most), name
    monkeypatch.setattr(fitting, "REFINEMENTS", 0)
    coarse = fit(tests, fixed=study.SET, start=start, starts=1)
    assert coarse.problem.refinement == 1 and coarse.shift > outcome.ENOUGH
    assert abs(coarse.values["mu"] / TRUTH["mu"] - 1.0) > 0.003
    assert "the increments are too long: finer ones change" in "\n".join(doubts_of(coarse))


@pytest.mark.slow
def test_own_starts_and_derivatives(three_percent: outcome.Fit, monkeypatch: pytest.MonkeyPatch) -> None:
    """Random starts find the minimum near the true values; derivatives with a smaller step agree."""
    problem = three_percent.problem
    truth = np.array([float(to_scale(name, TRUTH[name])) for name in problem.free])
    assert three_percent.result.chisqr <= float(np.sum(problem.residuals(truth) ** 2))
    assert three_percent.agreeing > 1
    small = 0.1 * fitting.STEP
    finer = fitting.differences(problem.residuals, three_percent.x, small) - three_percent.jacobian
    assert (np.linalg.norm(finer, axis=0) < 1e-3 * np.linalg.norm(three_percent.jacobian, axis=0)).all()


@pytest.mark.slow
def test_normal_stiffness_is_fitted() -> None:
    """The constants of tests under a normal stiffness are identified."""
    found = fit(study.synthetic(0.01, 0, k_N=study.K_N), fixed=study.SET, start=AT_TRUTH, starts=1)
    for name, value in AT_TRUTH.items():
        assert found.values[name] == pytest.approx(value, rel=0.05), name


# --- what cannot be known -----------------------------------------------------------------------------------


def test_coupling_without_dilation(no_dilation: outcome.Fit, three_percent: outcome.Fit) -> None:
    """Without dilation mu and theta are not separated; the residual ratio is known, as reported."""
    free = no_dilation.problem.free
    i, j = free.index("mu"), free.index("theta")
    assert no_dilation.correlation[i, j] < -outcome.COUPLED
    assert abs(three_percent.correlation[i, j]) < outcome.COUPLED
    ratio = no_dilation.of(residual_ratio)
    assert ratio.low <= residual_ratio(TRUTH) <= ratio.high
    mu = no_dilation.estimates["mu"]
    worse = (mu.high - mu.low) / mu.value / ((ratio.high - ratio.low) / ratio.value)
    assert worse > 5.0
    [text] = [one for one in doubts_of(no_dilation) if one.startswith("no dilation")]
    assert "no dilation: mu and theta cannot be separated" in text
    assert f"= {ratio.value:.5g} is known" in text and f"{no_dilation.correlation[i, j]:.4f}" in text
    assert "are separated by the dilation" in doubts_of(three_percent)[0]


def test_residual_alone_does_not_tell_the_bond() -> None:
    """A test that begins with full damage (s_L > s_f) determines neither sigma0 nor Gc."""
    late = []
    for test in study.synthetic(0.01, 0):
        rows = test.slip > 3.0 * 2.0 * TRUTH["Gc"] / TRUTH["sigma0"]
        assert test.s_N is not None
        late.append(ShearTest(test.name, test.slip[rows], test.tau[rows], test.s_N[rows], test.sigma_N))
    found = fit(late, fixed=study.SET, start=AT_TRUTH, starts=1)
    text = "\n".join(doubts_of(found))
    assert "sigma0 and Gc cannot be separated (correlation 1.0000)" in text, text
    assert found.undetermined == ["Gc", "sigma0"]
    # tau hardly changes, so that its range is the noise; this is no poor fit
    assert "poor" not in text, text
    assert len(re.findall(r"^\S+ .* not determined  ", report(found), re.MULTILINE)) >= 2
    assert "rows between peak and residual strength would" in report(found)


def test_bounds_and_ends_are_told(three_percent: outcome.Fit, monkeypatch: pytest.MonkeyPatch) -> None:
    """A parameter at its bound and a fit that did not converge are reported."""
    tests = three_percent.problem.tests
    found = fit(tests, fixed=study.SET, bounds={"mu": (0.6, 0.9)}, starts=2)
    text = "\n".join(doubts_of(found))
    assert "mu and theta cannot be separated" in text
    assert "mu = 0.6 is at one of its bounds, 0.6 to 0.9" in text
    assert found.converged
    monkeypatch.setattr(fitting, "MOST_EVALUATIONS", 2)
    found = fit(tests, fixed=study.SET, starts=1)
    assert "ended before they converged" in "\n".join(doubts_of(found))


def test_model_that_does_not_fit_is_reported() -> None:
    """A flat joint cannot dilate, so that neighbouring residuals are correlated."""
    found = fit(study.synthetic(0.01, 0), ("sigma0", "Gc", "mu"), sides=0, starts=1)
    assert found.neighbours > 0.9
    text = "\n".join(doubts_of(found))
    assert "intervals are too narrow" in text and "the fit is poor: the residuals are" in text


# --- records ------------------------------------------------------------------------------------------------


@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "slip,shear,sigma_N\n1,2,-1\n",
            r"record.csv: line 1: columns slip, shear, sigma_N: expected tau, too",
        ),
        ("slip,slip,tau,sigma_N\n", "line 1: column slip is there twice"),
        ("", "no rows: expected a header"),
        (HEADER, "no rows: expected a header"),
        (HEADER + "0.1,1,0.1,-1\n", "record.csv: 1 rows: expected at least 5"),
        (HEADER + "".join(ROWS.splitlines(True)[:4]), "record.csv: 4 rows: expected at least 5"),
        (HEADER + ROWS + "0.9,1,0.1,inf\n", "line 9, column sigma_N: inf: expected a finite number"),
        (HEADER + ROWS + "0.9,high,0.1,-1\n", "line 9, column tau: high: expected a finite number"),
        (
            HEADER + ROWS + "0.9,high,0.1,-1\n1,1,low,-1\n",
            "line 10, column dilation: low: expected a finite number",
        ),
        (HEADER + ROWS + "0.9,1,0.1\n", "line 9: 3 values: expected 4"),
        (HEADER + ROWS.replace(",-1", ",1"), "line 2, column sigma_N: 1 is tension: expected compression"),
        (HEADER + ROWS + '"0,9",1,0.1,-1\n', "line 9: 0,9 beside 0."),
        (
            "slip [mm],tau [kPa],sigma_N\n",
            "line 1: column sigma_N has no unit: expected one for every column, as slip [mm] has, or none",
        ),
        (
            "slip [mmm],tau [MPa],sigma_N [MPa]\n",
            "line 1: slip [mmm]: expected m, cm, mm, um, in or ft",
        ),
        (
            "slip [mm],tau [mm],sigma_N [MPa]\n",
            "line 1: tau [mm]: expected Pa, kPa, MPa, N/mm2, kN/m2, bar, psi or ksi",
        ),
        (
            "slip [mm],tau [MPa],sigma_N [MPa],k_N [kN/mm]\n",
            "k_N [kN/mm]: expected a unit of stress/length, such as MPa/mm",
        ),
        (
            HEADER + "".join(f"{i},{-i},{0.1 * i},-9\n" for i in range(1, 8)),
            "columns slip, tau: the work of tau along the slip is -24.5 < 0: expected tau > 0 where the slip",
        ),
        (
            HEADER + "".join(f"0.{i},{500 + i},0.0{i},-1\n" for i in range(1, 8)),
            "column tau: 507 at the end where |sigma_N| is 1: expected the same unit (a ratio of 0.01 to",
        ),
        (
            HEADER + "".join(f"0.{i},{i},{5 + 0.01 * i},-1\n" for i in range(1, 8)),
            "line 2, column dilation: 5.01 at slip 0.1: expected the change since the start of the slip",
        ),
        (
            "slip,tau,dilation,k_N,sigma_N\n"
            + "".join(f"{i},{i},{0.1 * i},1,{-1 - 100 * i}\n" for i in range(7)),
            "column k_N: 1 times the dilation changes sigma_N by up to 0.6, the column by 600: expected",
        ),
        (
            "slip,tau,dilation,k_N,sigma_N\n"
            + "".join(f"{i},{i},{-0.1 * i},1,{-1 - 0.1 * i}\n" for i in range(7)),
            "and dilation > 0 where it opens",
        ),
        (HEADER + ROWS + "0.9,1,0.1,-2\n", "line 9, column sigma_N: -2 is more than 5% off the mean -1.125"),
        (
            HEADER + ROWS.replace(",-1", ",-1e6"),
            "column tau: 0.8 at the end where |sigma_N| is 1e+06: expected the",
        ),
        (HEADER + ROWS.replace(",-1", ",-1e-6"), "column tau: 0.8 at the end where |sigma_N| is 1e-06"),
        (
            HEADER + "".join(f"{i},1,0,-1\n" for i in range(7)),
            "column tau is 1 in all rows: expected values that",
        ),
        (
            HEADER + "".join(f"{i}e-3,{i},{i},-1\n" for i in range(7)),
            "line 8, column dilation: 6 over slips up",
        ),
        (
            "slip,tau,sigma_N,k_N\n" + "".join(f"{i},{i},-1,{-i}\n" for i in range(7)),
            "column k_N: 7 values: expected one a test",
        ),
        (
            "slip,tau,sigma_N,k_N\n" + "".join(f"{i},{i},-1,-2\n" for i in range(7)),
            "line 2, column k_N: -2: expected a stiffness >= 0",
        ),
        (
            HEADER.replace("\n", ",k_N\n") + "".join(f"{i},{i},{i},-1,1e6\n" for i in range(7)),
            "column k_N: 1e+06 changes sigma_N by 6e+06: expected stress/length",
        ),
    ],
)
def test_bad_records(text: str, message: str, tmp_path: Path) -> None:
    """Errors have file, line, column, value and expectation."""
    path = write(tmp_path, text)
    with pytest.raises(ValueError, match=re.escape(message)) as caught:
        read_tests([path])
    assert "record.csv" in str(caught.value)


def test_files_of_instruments(tmp_path: Path) -> None:
    """Semicolons, decimal commas, other names of columns and gaps give the same test, without the gaps."""
    [plain] = read_tests([write(tmp_path, HEADER + ROWS)])
    text = (HEADER + ROWS).replace(",", ";").replace(".", ",")
    [test] = read_tests([write(tmp_path, text)])
    for name in ("slip", "tau", "s_N", "sigma_N"):
        assert np.array_equal(getattr(test, name), getattr(plain, name)), name
    other = text.replace("slip", "Shear displacement (mm)").replace("tau", "Shear stress (MPa)")
    other = other.replace("dilation", "dilation (mm)").replace("sigma_N", "sigma_N (MPa)")
    path = write(tmp_path, other)
    [test] = read_tests([path])
    assert np.array_equal(test.slip, plain.slip) and np.array_equal(test.tau, plain.tau)
    other = other.replace("Shear displacement", "Weg oben").replace("Shear stress", "S1")
    path = write(tmp_path, other)
    with pytest.raises(
        ValueError, match=r"expected slip, tau, too .*slip=HEADER, in Python columns="
    ):
        read_tests([path])
    names = {"slip": "weg Oben", "tau": "S1"}
    [test] = read_tests([path], columns=names)
    assert np.array_equal(test.tau, plain.tau) and test.units == {"length": "mm", "stress": "MPa"}
    with pytest.raises(ValueError, match=r"line 1: columns Weg oben.*: expected Weg, too"):
        read_tests([path], columns={"slip": "Weg"})
    lines = text.splitlines()
    lines[2:2] = ["0,15;;0,01;-1", "0,16;1;;-1"]
    with pytest.warns(asperity.ModelWarning, match=r"a cell is empty: 2 \(line 3, 4\)"):
        [test] = read_tests([write(tmp_path, "\n".join(lines))])
    assert np.array_equal(test.slip, plain.slip) and 3 not in test.lines and 4 not in test.lines


def test_all_errors_at_once(tmp_path: Path) -> None:
    """The errors of all rows and files are listed together."""
    first = write(tmp_path, HEADER + ROWS + "0.9,high,0.1,-1\n1,1,low,-1\n")
    second = write(tmp_path, HEADER + "0.9,1,0.1\n", "second.csv")
    with pytest.raises(ValueError, match="line 9") as caught:
        read_tests([first, second])
    told = str(caught.value).splitlines()
    assert (
        len(told) == 3 and "line 10, column dilation: low" in told[1] and "second.csv: line 2: 3" in told[2]
    )


def test_files_that_cannot_be_read(tmp_path: Path) -> None:
    """Errors have the file and the expectation."""
    with pytest.raises(FileNotFoundError, match=r"none.csv: no such file or directory: expected a CSV file"):
        read_tests([tmp_path / "none.csv"])
    with pytest.raises(
        IsADirectoryError, match=r": is a directory: expected a CSV file with slip, tau, sigma_N"
    ):
        read_tests([tmp_path])
    path = tmp_path / "old.xls"
    path.write_bytes(b"\xd0\xcf\x11\xe0\0\0\0")
    with pytest.raises(ValueError, match=r"old.xls is no text: expected a CSV file with slip, tau, sigma_N"):
        read_tests([path])
    path = write(tmp_path, HEADER + ROWS)
    with pytest.raises(ValueError, match=r"record.csv: given twice: expected each file once"):
        read_tests([path, tmp_path / "." / "record.csv"])
    other = write(tmp_path, WITH_UNITS + ROWS, "other.csv")
    with pytest.raises(
        ValueError, match=r"record.csv: no units in the header: expected units in every file, as in .*other"
    ):
        read_tests([other, path])


def test_units_are_converted(tmp_path: Path) -> None:
    """Numbers are converted from the units of their column to mm and MPa, or to those that are asked for."""
    slip, tau, s_N, sigma_N, k_N = (
        np.linspace(0.1, 0.7, 7),
        np.arange(1.0, 8.0),
        0.02 * np.arange(7.0),
        -2.0,
        5.0,
    )
    spellings = [
        ("mm", "MPa", "mm", "N/mm^2", "N/mm3", 1.0, 1.0, 1.0, 1.0, 1.0),
        ("m", "Pa", "cm", "kPa", "MPa/m", 1e-3, 1e6, 0.1, 1e3, 1e3),
        (
            "in",
            "psi",
            "\N{MICRO SIGN}m",
            "ksi",
            "kN/m3",
            1 / 25.4,
            1 / 0.006894757293168,
            1e3,
            1 / 6.894757,
            1e6,
        ),
    ]
    for units in spellings:
        a, b, c, d, e = units[5:]
        text = "slip [{}],tau [{}],dilation [{}],sigma_N [{}],k_N [{}]\n".format(*units[:5])
        for i in range(7):
            row = (slip[i] * a, tau[i] * b, s_N[i] * c, (sigma_N - k_N * s_N[i]) * d, k_N * e)
            text += ",".join(f"{number:.9g}" for number in row) + "\n"
        path = write(tmp_path, text)
        [test] = read_tests([path])
        assert test.units == {"length": "mm", "stress": "MPa"} and test.lines == tuple(range(2, 9))
        for found, expected in ((test.slip, slip), (test.tau, tau), (test.s_N, s_N), (test.sigma_N, sigma_N)):
            assert found == pytest.approx(expected, rel=1e-6)
        assert test.k_N == pytest.approx(k_N, rel=1e-6)
        [test] = read_tests([path], target=("m", "kPa"))
        assert test.units == {"length": "m", "stress": "kPa"}
        assert test.slip == pytest.approx(1e-3 * slip, rel=1e-6) and test.tau == pytest.approx(
            1e3 * tau, rel=1e-6
        )
        assert test.sigma_N == pytest.approx(1e3 * sigma_N, rel=1e-6)
        assert test.k_N == pytest.approx(1e6 * k_N, rel=1e-6)


def test_unusual_sizes_are_told(tmp_path: Path) -> None:
    """Stresses of a gigapascal, a joint that closes and one that hardly dilates give a warning."""
    for text, message in (
        (WITH_UNITS + ROWS.replace(",-1\n", ",-500\n"), "the largest stress is 500 MPa, which is unusual"),
        (
            HEADER + re.sub(r",(0\.\d\d,)", r",-\1", ROWS),
            "dilation: -0.14 at the end, the joint closes as it slips",
        ),
        (
            HEADER + re.sub(r",0\.(\d\d,)", r",0.000\1", ROWS),
            "dilation changes by 0.00012 over slips of 0.6: expected the",
        ),
    ):
        with pytest.warns(asperity.ModelWarning, match=re.escape(message)):
            read_tests([write(tmp_path, text)])


def test_normal_traction_under_a_stiffness(tmp_path: Path) -> None:
    """sigma_N at the start is extrapolated by the dilation, or without dilation taken from the first row."""
    rng = np.random.default_rng(3)
    text = "test,slip,tau,dilation,k_N,sigma_N\n"
    for i in range(1, 101):
        measured = -2.0 - 5.0 * 0.002 * i + rng.normal(0.0, 0.02)
        text += f"a,{0.01 * i},{i},{0.002 * i},5,{measured}\nb,{0.01 * i},{i},,5,{measured}\n"
        text += f"c,{0.01 * i},{i},{0.002 * i},5,-2\n"
    a, b, c = read_tests([write(tmp_path, text)])
    first = float(text.splitlines()[1].rsplit(",", 1)[1])
    assert abs(first + 2.0) > 0.01 and b.sigma_N == first and c.sigma_N == -2.0
    # standard error of the mean 0.002
    assert a.sigma_N == pytest.approx(-2.0, abs=0.008)


def test_rows_out_of_order(tmp_path: Path) -> None:
    """Shuffled rows give a warning; a cycle and noise on the slip do not."""
    rng = np.random.default_rng(1)
    up, cycle = np.linspace(0.01, 0.6, 60), np.interp(np.arange(90.0), [0, 30, 60, 89], [0.0, 0.5, -0.5, 0.5])
    for slips, told in ((rng.permutation(up), True), (up + rng.normal(0.0, 0.01, 60), False), (cycle, False)):
        text = "slip,tau,sigma_N\n" + "".join(f"{slip},{i},-1\n" for i, slip in enumerate(slips))
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            read_tests([write(tmp_path, text)])
        texts = [str(one.message) for one in caught]
        assert any("expected the rows in the order of the test" in one for one in texts) == told, texts


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"tau": np.ones(6)}, "t: column tau is 1 in all rows: expected values that change"),
        ({"tau": np.arange(5.0)}, r"t: tau has shape \(5,\): expected finite numbers of shape \(6,\)"),
        ({"s_N": np.full(6, np.nan)}, "t: s_N has shape"),
        ({"sigma_N": 1.0}, "t: sigma_N = 1: expected a finite compression"),
        ({"k_N": -1.0}, "t: k_N = -1: expected a finite stiffness"),
    ],
)
def test_tests_that_cannot_be(values: dict[str, Any], message: str) -> None:
    """A test that a script constructs is also checked."""
    good = {"slip": np.arange(6.0), "tau": np.arange(6.0), "s_N": None, "sigma_N": -1.0}
    with pytest.raises(ValueError, match=message):
        ShearTest("t", **(good | values))


def test_records_of_all_kinds(tmp_path: Path) -> None:
    """Units in the header, comments, mixed tests, an alias, unused columns and several files are read."""
    text = "# a box\nTest,Slip (mm),TAU [N/mm^2],s_n [mm],sigma_N [ MPa ],k_N [N/mm3],time [s],,\n"
    for i in range(1, 7):
        text += f"a,{i},{i},{0.1 * i},2,,{i},,\n\nb,{-i},{-i},{0.2 * i},3,4,{i}\n"
    path = write(tmp_path, text)
    plain = write(
        tmp_path,
        "slip [mm],tau [MPa],sigma_N [MPa]\n" + "".join(f"{i},{i},1\n" for i in range(6)),
        "plain.csv",
    )
    with pytest.warns(asperity.ModelWarning, match=r"record.csv: columns not used: time"):
        a, b, c = read_tests([path, plain], k_N=7.0, compression_positive=True)
    assert (a.sigma_N, a.k_N, b.sigma_N, b.k_N) == pytest.approx((-2.0, 7.0, -3.0, 4.0)) and c.k_N == 7.0
    assert a.units == c.units == {"length": "mm", "stress": "MPa"}
    assert "test a" in a.name and c.s_N is None and b.slip.tolist() == [-1, -2, -3, -4, -5, -6]
    assert a.s_N is not None and a.s_N.tolist() == pytest.approx([0.1, 0.2, 0.3, 0.4, 0.5, 0.6])
    assert ShearTest("", np.array([0, 1, 2, 1, -1, 0.5]), a.tau, None, -1.0).turns == [2.0, -1.0, 0.5]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"free": ("sigma0", "cohesion")}, "free: cohesion: expected one of sigma0, Gc"),
        ({"free": ()}, "free: none: expected names"),
        ({"free": ("mu",), "fixed": {"mu": 0.5}}, "mu: free or set: expected one of the two"),
        (
            {"fixed": SOME, "model_error": -0.1},
            "model_error = -0.1: expected a fraction of the range, 0 to 1",
        ),
        (
            {"free": ("sigma0", "Gc", "mu")},
            "theta: expected it among the free ones, or a value, --set theta=",
        ),
        ({"free": ("sigma0", "Gc", "mu", "theta"), "sides": 0}, "expected inclined planes"),
        ({"fixed": {"eta": 1.5}}, "eta = 1.5"),
        ({"bounds": {"mu": (0.5, 0.1)}}, "bounds: mu = 0.5, 0.1: expected 0 < low < high"),
        ({"fixed": SOME, "start": {"eta": 0.5}}, "start: eta: expected one of the free ones, sigma0, Gc"),
        (
            {"fixed": SOME, "start": {"theta": 0.35}},
            "start: theta = 0.35: expected 0.5 to 75, its bounds in degrees",
        ),
        (
            {"fixed": SOME, "bounds": {"eta": (0.1, 0.5)}},
            "bounds: eta: expected one of the free ones, sigma0, Gc",
        ),
        (
            {"free": ("Gc", "sigma0", "mu"), "fixed": {"theta": 0.35}},
            "theta = 0.35: expected degrees, 0 or at",
        ),
        ({"sides": -3}, "sides = -3: expected 0 or 2 to 64"),
        ({"direction": np.nan}, "direction = nan: expected a finite angle in degrees"),
        ({"starts": 0}, "starts = 0: expected 1 to"),
        ({"increments": 10**9}, "increments = 1000000000: expected 1 to"),
        ({"fixed": SOME, "confidence": 1.0}, "confidence = 1: expected between 0 and 1"),
        (
            {"free": ("mu", "theta"), "fixed": {"sigma0": 1.5, "Gc": 150e-6}},
            "column slip: up to 0.7 where s_f = 2 Gc/sigma0 is 0.0002 to 0.0002: expected the unit",
        ),
        ({"free": tuple(TRUTH)}, "14 values in 1 tests: expected more than 14, twice the 7 free"),
    ],
)
def test_bad_arguments(arguments: dict[str, Any], message: str, tmp_path: Path) -> None:
    """Errors have the parameter, its value and the expectation."""
    tests = read_tests([write(tmp_path, HEADER + ROWS)])
    with pytest.raises(ValueError, match=re.escape(message)):
        fit(tests, **arguments)
    with pytest.raises(ValueError, match="no tests: expected at least one"):
        fit([])


# --- command ------------------------------------------------------------------------------------------------


def test_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """The command writes report, picture and a case that driver, card and select read."""
    monkeypatch.chdir(tmp_path)
    study.write_record(Path("record.csv"), study.synthetic(study.DEFAULT_NOISE, 0))
    start = " ".join(f"{name}={value}" for name, value in AT_TRUTH.items())
    options = [
        "--set",
        "kc=20 eta=0.9 flat=0.3333333",
        "--start",
        start,
        "--starts",
        "1",
        "--plot",
        "fit.png",
        "-o",
        "fit.nml",
    ]
    assert main(["fit", "record.csv", *options, "--card", "abaqus"]) == 0
    printed = capsys.readouterr().out
    assert "*User Material" in printed and "MPa mm" in printed
    assert printed.endswith("fit.png\nfit.nml\nfit.fit.json\n")
    for name, start in (("fit.png", PICTURES[".png"]), ("fit.nml", HEADING), ("fit.fit.json", COVARIANCE)):
        assert may_replace(Path(name), start)
    line = re.search(r"^PROPS\((\d+)\)   (.*)$", printed, re.MULTILINE)
    assert line and int(line[1]) == contract.N_FIXED_PROPS
    case = read_case(Path("fit.nml"))
    interface = case.runs[0].interface
    assert [float(text) for text in line[2].split(",")] == pytest.approx(interface.props().tolist(), rel=1e-5)
    tests = list(slip_tests(case))
    assert [test.sigma_N for test in tests] == list(study.SIGMA_N)
    assert tests[0].slips[-1] == pytest.approx(study.TURNS[-1])
    assert main(["card", "abaqus", "fit.nml"]) == 0
    assert "*User Material" in capsys.readouterr().out
    assert main(["run", "fit.nml", "-o", "rows.csv"]) == 0


def test_case_without_a_sweep() -> None:
    """The case of one cyclic test under a stiffness has no sweep and states that the spring is left out."""
    tests = study.synthetic(0.03, 0, sigma_N=(-2.0,), turns=study.CYCLE, k_N=study.K_N)
    found = fit(tests, fixed=study.SET, start=AT_TRUTH, starts=1)
    text = case_of(found)
    assert "&sweep" not in text and "this case keeps their initial normal traction constant" in text
    assert "&step t_N = -2," in text and "slip = 0.5, -0.5, 0.5," in text
    assert "1 reversal" not in report(found) and "2 reversals" in report(found)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--set", "eta"], "--set eta: expected NAME=VALUE"),
        (["--bounds", "mu=0.1"], "--bounds mu=0.1: expected NAME=LOW,HIGH"),
        (["--plot", "fit.jpg"], "--plot fit.jpg: expected a name that ends in .png or .pdf"),
        (["--units", "mm"], "--units mm: expected LENGTH,STRESS"),
        (["--units", "mm,mm"], "--units mm,mm: [mm]: expected Pa, kPa, MPa, N/mm2"),
        (
            ["--free", "sigma0,mu"],
            "Gc: expected it among the free ones, or a value, --set Gc=",
        ),
        (["--set", "kc=2", "--set", "kc=3"], "--set kc=3: kc is given twice: expected one value"),
        (["--plot", "none/fit.png"], "--plot none/fit.png: no folder none: expected one that is there"),
        (["-o", "."], "-o .: expected a file that can be written"),
        (["--k-N", "-1"], "k_N = -1: expected a finite stiffness >= 0"),
        (["--compression-positive"], "line 2, column sigma_N: -1 is tension: expected compression"),
    ],
)
def test_bad_options(
    options: list[str],
    message: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Errors go to standard error, with exit code 1, before the fit starts."""
    monkeypatch.setattr(fit_model.Problem, "residuals", lambda *_: pytest.fail("fitted"))
    assert main(["fit", str(write(tmp_path, WITH_UNITS + ROWS)), *options]) == 1
    assert message in capsys.readouterr().err


@pytest.mark.slow
def test_units_of_the_results(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The results have the units of the option, which are those of numbers without units."""
    monkeypatch.chdir(tmp_path)
    study.write_record(Path("record.csv"), study.synthetic(0.01, 0))
    options = ["--set", "kc=20 eta=0.9 flat=0.3333", "--starts", "1", "--increments", "60"]
    found = {}
    for units, unit in (("mm,MPa", "MPa mm"), ("m,kPa", "kPa m"), ("in,psi", "psi in")):
        assert main(["fit", "record.csv", *options, "--units", units]) == 0
        line = re.search(rf"^Gc +(\S+) .* {unit}$", capsys.readouterr().out, re.MULTILINE)
        assert line
        found[unit] = float(line[1])
    # five digits are printed; 1 kPa m is 1 MPa mm, 1 MPa mm is 1e3 J/m2, a psi in is 175.127 J/m2
    assert found["kPa m"] == pytest.approx(found["MPa mm"], rel=1e-4)
    assert found["psi in"] == pytest.approx(found["MPa mm"] * 1e3 / 175.127, rel=1e-4)
    text = Path("record.csv").read_text(encoding="utf-8")
    write(tmp_path, re.sub(r" \[[^]]*\]", "", text))
    assert main(["fit", "record.csv", *options]) == 0
    assert re.search(r"^Gc .* stress length$", capsys.readouterr().out, re.MULTILINE)
    assert main(["fit", "record.csv", *options, "--units", "m,kPa"]) == 0
    assert re.search(r"^Gc .* kPa m$", capsys.readouterr().out, re.MULTILINE)


def test_arguments_of_the_functions() -> None:
    """Lists are data as arrays are; what is no test, no name and no whole number is refused by its name."""
    slip, tau = [0.1, 0.2, 0.3, 0.4, 0.5], [1.0, 2.0, 1.5, 1.0, 1.0]
    test = ShearTest("box", slip, tau, None, -1)  # type: ignore[arg-type]
    assert test.slip.tolist() == slip and test.sigma_N == -1.0
    for given, message in (
        ({"tests": test}, "tests = ShearTest.*: expected tests"),
        ({"tests": "record.csv"}, "tests = 'record.csv': expected tests"),
        ({"free": "mu,theta"}, "free = 'mu,theta': expected a sequence of names"),
        ({"starts": 1.5}, "starts = 1.5: expected 1 to .*, a whole number"),
        ({"seed": -1}, "seed = -1: expected a whole number"),
    ):
        with pytest.raises(ValueError, match=message):
            fit(**({"tests": [test]} | given))  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="box: slip has no rows"):
        ShearTest("box", [], [], None, -1.0)  # type: ignore[arg-type]
