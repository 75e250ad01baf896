"""Constants from shear-box tests: found within their intervals, doubts reported, bad arguments rejected."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from asperity import Interface, Material, ModelWarning, Pattern, Step
from asperity.tools.fit import ShearTest, failed_checks, fit, read_tests
from asperity.tools.fit import result as outcome
from asperity.tools.fit.checks import shows_dilation
from asperity.tools.fit.model import residual_ratio
from asperity.tools.fit.report import case_of, report

from harness.studies import synthetic as study

TRUTH, SOME = study.TRUTH, study.SET
AT_TRUTH, ALL = {name: TRUTH[name] for name in study.FREE}, dict(TRUTH)
MATERIAL = {name: TRUTH[name] for name in ("sigma0", "Gc", "eta", "mu", "kc")}
RT = {"theta": 20.0, "flat": 0.3333}
SLIP = np.linspace(0.0, 0.6, 61)[1:]
SHORT, ENVELOPE = "slip,tau,sigma_N\n", "sigma_N,peak,residual,slip\n"
ROWS = "".join(f"{0.1 * i:.1f},{min(i, 4) * 0.2:.1f},{0.02 * i:.2f},-1\n" for i in range(1, 8))


def rows(*columns: Any) -> str:
    """Rows of a CSV file."""
    return "".join(",".join(f"{x:.9g}" for x in row) + "\n" for row in np.broadcast(*columns))


def written(folder: Path, text: str, name: str = "record.csv") -> Path:
    """File of a test."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


# --- recovery -----------------------------------------------------------------------------------------------


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::asperity.ModelWarning")
def test_record_without_noise() -> None:
    """The constants of tests without noise are identified."""
    slips = np.linspace(0.0, 0.8, 401)
    joint = Interface(Material(**MATERIAL), Pattern.regular(study.SIDES, TRUTH["theta"], TRUTH["flat"]))
    tests = []
    for sigma_N in (-1.0, -4.0):
        one = joint.confined_slip(0.0, slips, sigma_N, preload=50)
        s_N = one.separation[1:, 0] - one.separation[0, 0]
        tests.append(ShearTest("", slips[1:], one.traction[1:, 1], s_N, sigma_N))
    found = fit(tests, fixed=SOME, start=AT_TRUTH | {"mu": 0.7, "theta": 10.0, "Gc": 0.4}, starts=1)
    # increments and roots are the same, so only the tolerances of the least squares remain
    assert {name: found.values[name] for name in AT_TRUTH} == pytest.approx(AT_TRUTH, rel=1e-6)


@pytest.mark.long
@pytest.mark.parametrize("noise", [0.01, 0.03, 0.10])
def test_intervals_hold_at_their_rate(noise: float) -> None:
    """95 % intervals of every constant and of the ratio: at most 4 of 16 miss (odds of 0.1 %).

    noise: standard deviation, as a fraction of the range of tau and of s_N in each test.
    """
    repetitions, most, held, misses = 16, 4, [], 0
    clean = study.synthetic(0.0, 0)
    for seed in range(repetitions):
        rng = np.random.default_rng(seed)
        noisy = lambda y: study.noisy(y, noise, rng)  # noqa: B023, E731
        tests = [replace(one, tau=noisy(one.tau), s_N=noisy(one.s_N)) for one in clean]
        found = fit(tests, study.FREE, SOME, start=AT_TRUTH, starts=1)
        intervals = [(TRUTH[name], one) for name, one in found.estimates.items()]
        intervals.append((residual_ratio(TRUTH), found.of(residual_ratio)))
        held.append([one.low <= value <= one.high for value, one in intervals])
        # intervals that are too wide would pass, too: the scatter must be the noise (which widens the range),
        # and 50 % intervals of the same fits must miss
        assert abs(np.log(found.scatter[0] / noise)) < 0.2 + 5.0 * noise
        misses += int(np.sum(np.abs(found.x - found.problem.x(TRUTH)) > 0.6745 * found.errors))
    shares = np.mean(held, axis=0)
    assert np.all(shares >= 1.0 - most / repetitions), shares
    assert 0.25 < misses / (repetitions * len(AT_TRUTH)) < 0.75


@pytest.mark.slow
def test_increments_of_a_cycle() -> None:
    """Without noise the constants of a cycle are identified, because the increments are refined.

    The 200 increments at first shift mu by 0.5 %.
    """
    tests = study.synthetic(0.0, 0, sigma_N=(-1.0,), **study.CYCLIC)
    found = fit(tests, fixed=SOME, start=AT_TRUTH | {"mu": 0.7, "theta": 25.0}, starts=1)
    # the error is of first order: dividing increments by four removes three quarters of it
    most = 2.0 * outcome.ENOUGH * outcome.LEAST_ERROR
    assert {name: found.values[name] for name in AT_TRUTH} == pytest.approx(AT_TRUTH, rel=most)


def box(sigma_N: Any) -> np.ndarray:
    """Shear traction of a ridge at SLIP; sigma_N of each row, or of all."""
    path = [Step(t_N=float(np.ravel(sigma_N)[0]), increments=50), Step(t_N=sigma_N, slip=SLIP, increments=10)]
    return Interface(Material(**MATERIAL), Pattern.regular(2, **RT)).run(path).traction[59::10, 1]


def refitted(tests: Any, **free: float) -> dict[str, float]:
    """Values of the free constants, fitted from a start."""
    fixed = {name: value for name, value in (MATERIAL | RT).items() if name not in free}
    found = fit(tests, tuple(free), fixed, start=free, starts=1, sides=2).values
    return {name: found[name] for name in free}


@pytest.mark.slow
def test_other_kinds_of_test(tmp_path: Path) -> None:
    """k_N, a measured path of sigma_N, the slip of the machine, and peaks give the constants back."""
    tests = study.synthetic(0.01, 0, sigma_N=(-2.0,), turns=study.CYCLE, k_N=study.K_N)
    found = fit(tests, fixed=SOME, start=AT_TRUTH, starts=1)
    assert {name: found.values[name] for name in AT_TRUTH} == pytest.approx(AT_TRUTH, rel=0.05)
    text = case_of(found)
    assert "&sweep" not in text and "this case keeps their initial normal traction constant" in text
    assert "&step t_N = -2," in text and "slip = 0.5, -0.5, 0.5," in text
    assert "2 reversals" in report(found)
    with pytest.raises(ValueError, match=r"^stiffness = -1.*: expected >= 0"):
        found.interface.confined_slip(0.0, [0.1], -1.0, stiffness=-1.0)
    sigma_N = -1.0 - 2.0 * SLIP
    path = written(tmp_path, SHORT + rows(SLIP, box(sigma_N), sigma_N))
    with pytest.raises(ValueError, match=r"is more than 5% off the mean .*: .* or --sigma-N-path"):
        read_tests(path)
    tests = read_tests(path, sigma_N_path=True)
    assert tests[0].pressed == pytest.approx(-2.2)
    assert refitted(tests, Gc=0.2, mu=0.6) == pytest.approx({"Gc": 0.15, "mu": 0.5}, rel=2e-3)
    tau = box(-1.0)
    path = written(tmp_path, SHORT + rows(SLIP + tau / 40.0, tau, -1.0))
    assert read_tests(path, k_T=40.0)[0].slip == pytest.approx(SLIP, abs=1e-7)
    text = ENVELOPE
    for pressure in (-0.5, -1.0, -2.0, -4.0):
        tau = box(pressure)
        text += rows(pressure, tau.max(), tau[-1], SLIP[-1])
    tests = read_tests(written(tmp_path, text))
    assert len(tests) == 4 and all(test.envelope for test in tests)
    # the rows of the curve are 0.01 mm apart, and the peak is a kink
    assert refitted(tests, sigma0=1.2, mu=0.6) == pytest.approx({"sigma0": 1.5, "mu": 0.5}, rel=0.02)


# --- what cannot be known -----------------------------------------------------------------------------------


def test_coupling_without_dilation() -> None:
    """Without dilation mu and theta are not separated; the residual ratio is known, as reported."""
    found = fit(study.synthetic(0.03, 0, dilation=False), study.FREE, SOME, start=AT_TRUTH, starts=1)
    correlation, ratio = found.coupled[("mu", "theta")], found.of(residual_ratio)
    assert correlation < -outcome.COUPLED
    assert ratio.low <= residual_ratio(TRUTH) <= ratio.high
    mu = found.estimates["mu"]
    assert (mu.high - mu.low) / mu.value / ((ratio.high - ratio.low) / ratio.value) > 5.0
    text = f"mu and theta cannot be separated (correlation {correlation:.4f}): set one of them"
    assert text in failed_checks(found)


def test_residual_alone_does_not_tell_the_bond() -> None:
    """A test that begins with full damage (s_L > s_f) determines neither sigma0 nor Gc."""
    late = []
    for test in study.synthetic(0.01, 0):
        some = test.slip > 3.0 * 2.0 * TRUTH["Gc"] / TRUTH["sigma0"]
        late.append(ShearTest(test.name, test.slip[some], test.tau[some], test.s_N[some], test.sigma_N))  # type: ignore[index]
    found = fit(late, fixed=SOME, start=AT_TRUTH, starts=1)
    assert found.undetermined == ["Gc", "sigma0"]
    text = report(found)
    assert len(re.findall(r"^\S+ .* not determined  ", text, re.MULTILINE)) >= 2
    assert "no result: Gc is not determined: rows beyond the peak" in text


def test_doubts_are_told() -> None:
    """A constant at its bound is reported; test_fit_verdict.py has a model that cannot fit."""
    tests = [replace(one, s_N=1e-3 * one.s_N) for one in study.synthetic(0.03, 0)]  # type: ignore[operator]
    found = fit(tests, ("mu", "theta"), SOME | {"sigma0": 1.5, "Gc": 0.15}, starts=2)
    assert "no result: theta is at its lower bound 0.5, where its interval has no meaning" in report(found)


def test_dilation_that_is_noise() -> None:
    """A saw-cut joint, whose dilation is the noise of the gauge, is flat; with a signal below it is not."""
    random, slip = np.random.default_rng(3), np.linspace(0.0, 3.0, 101)[1:]

    def box(sigma_N: float, opening: float) -> ShearTest:
        tau = np.minimum(20.0 * slip, -0.62 * sigma_N) * (1.0 + 0.01 * random.standard_normal(100))
        s_N = 0.002 * random.standard_normal(100) + opening * slip
        return ShearTest(f"box {sigma_N:g}", slip, tau, s_N, sigma_N)

    with pytest.warns(ModelWarning, match="the dilation of the tests is noise: the joint is taken as flat"):
        found = fit([box(-0.5, 0.0), box(-1.0, 0.0)])
    assert not failed_checks(found)
    assert found.values["theta"] == 0.0
    assert found.estimates["mu"].low <= 0.62 <= found.estimates["mu"].high
    assert not shows_dilation([box(-0.5, 0.0), box(-1.0, 0.0)]) and shows_dilation([box(-1.0, 0.002)])


@pytest.mark.slow
@pytest.mark.parametrize("turn", [0.03, 0.04, 0.06])
def test_rupture_energy_needs_rows_beyond_the_peak(turn: float) -> None:
    """Tests that end just beyond the peak do not determine Gc: it has a true interval, or none."""
    found = fit(study.synthetic(0.01, 40, turns=(turn,)), start=ALL, starts=1, joint="mortar")
    gc = found.estimates["Gc"]
    assert "Gc" in found.undetermined or gc.low <= TRUTH["Gc"] <= gc.high
    assert ("Gc is not determined: rows beyond the peak" in " ".join(failed_checks(found))) == (turn < 0.045)


# --- arguments ----------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"tests": []}, "tests = []: expected a list of tests"),
        ({"free": "mu,theta"}, "free = 'mu,theta': expected a sequence of names"),
        ({"free": ()}, "free: none: expected names"),
        ({"fixed": SOME, "model_error": -0.1}, "model_error = -0.1: expected a fraction of the range, 0 to "),
        ({"free": ("sigma0", "Gc", "mu", "theta"), "sides": 0}, "expected inclined planes"),
        ({"fixed": {"theta": 18.0}, "sides": 0}, "set: theta: expected inclined planes"),
        ({"fixed": SOME, "start": {"eta": 0.5}}, "start: eta: expected one of the free ones, sigma0, Gc"),
        ({"free": ("Gc", "sigma0", "mu"), "fixed": {"theta": 0.35}}, "theta = 0.35: expected degrees, 0 or "),
        ({"sides": -3}, "sides = -3: expected 0 or 2 to 64"),
        ({"direction": np.nan}, "direction = nan: expected a finite angle in degrees"),
        ({"free": tuple(TRUTH)}, "14 values in 1 tests: expected more than 14, twice the 7 free"),
        ({"joint": "rock", "free": ("sigma0",)}, "sigma0: expected without ks"),
        ({"joint": "clay"}, "joint = 'clay': expected rock, mortar or auto"),
    ],
)
def test_bad_arguments(arguments: dict[str, Any], message: str, tmp_path: Path) -> None:
    """Errors have the argument, its value and the expectation."""
    tests = read_tests(written(tmp_path, "slip,tau,dilation,sigma_N\n" + ROWS))
    with pytest.raises(ValueError, match=re.escape(message)):
        fit(**({"tests": tests} | arguments))
