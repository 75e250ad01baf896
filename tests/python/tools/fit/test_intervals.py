"""Curves of several specimens, bonds that end at zero, and the intervals of predictions."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas
import pytest
from asperity.tools.fit import ShearTest, fit
from asperity.tools.fit.intervals import Spread, quantiles

from harness.studies import fits, other_laws

pytestmark = [pytest.mark.usefixtures("folder"), pytest.mark.filterwarnings("ignore::asperity.ModelWarning")]

NO_RESULT = 3
"""Exit code of a fit whose constants must not be used."""

CONSTANTS = ("mu", "theta", "height")


def write(tests: list[ShearTest], path: str = "tests.csv") -> None:
    """Write tests as a laboratory does."""
    frames = []
    for test in tests:
        columns = {"test": test.name, "slip [mm]": test.slip, "tau [MPa]": test.tau}
        columns |= {} if test.s_N is None else {"dilation [mm]": test.s_N}
        frames.append(pandas.DataFrame(columns | {"sigma_N [MPa]": -test.sigma_N}))
    pandas.concat(frames).to_csv(path, index=False, float_format="%.4g")


def of_fit(said: Callable, code: int | None = None, more: str = "") -> tuple[str, dict]:
    """Report of `asperity fit`, and the file beside its case."""
    from asperity.cli import main

    Path("joint.fit.json").unlink(missing_ok=True)
    if code is None:
        assert main(["fit", "tests.csv", "-o", "joint.nml", "--force"]) in (0, NO_RESULT)
        return "", json.loads(Path("joint.fit.json").read_text())
    text, _ = said(f"fit tests.csv -o joint.nml --force {more}", code)
    return text, json.loads(Path("joint.fit.json").read_text())


@pytest.mark.slow
def test_intervals_contain_the_mean_of_the_specimens(said: Callable) -> None:
    """The population's constants lie inside, or nearly; what ends with 3 says which test differs, or how.

    How often they do is measured by `harness.studies.fits`.
    """
    inside, total = 0, 0
    for count, number in ((2, 10), (3, 3)):
        specimens = other_laws.specimens(np.random.default_rng([40, number]), count, count)
        truth = specimens.truth
        write(fits.tests_of(specimens))
        _, found = of_fit(said)
        for name in CONSTANTS:
            if name in found["intervals"]:
                low, high = found["intervals"][name]
                total, inside = total + 1, inside + (low <= truth[name][0] <= high)
        if found["no result"]:
            assert re.search(r"the tests differ|most in|not determined", found["no result"][0])
    # of six numbers that lie inside with 0.95 more than one lies outside in one of 30 draws
    assert total >= 5 and inside >= total - 1


def two(frictions: tuple[float, float]) -> list[ShearTest]:
    """Two specimens that have the same slope, under two pressures."""
    slip, tests = np.linspace(0.05, 4.0, 80), []
    for i, (pressure, mu) in enumerate(zip((1.0, 2.0), frictions, strict=True)):
        slope, rng = 0.25 * np.exp(-1.5 * slip), np.random.default_rng(i)
        tau = np.minimum(10.0 * slip, pressure * (mu + slope) / (1.0 - mu * slope))
        dilation = 0.25 / 1.5 * (1.0 - np.exp(-1.5 * slip))
        tau = tau + 0.01 * rng.normal(size=slip.size)
        tests.append(ShearTest(f"{i}", slip, tau, dilation + 0.001 * rng.normal(size=slip.size), -pressure))
    return tests


@pytest.mark.slow
@pytest.mark.parametrize("frictions", [(0.54, 0.62), (0.58, 0.58)])
def test_two_specimens_are_wide(said: Callable, frictions: tuple[float, float]) -> None:
    """The interval of mu of two specimens is as wide as others would need, also where they agree by chance.

    Student's t of three degrees of freedom, one of these two and two of specimens that scatter by 7 %.
    """
    write(two(frictions))
    _, found = of_fit(said)
    low, high = found["intervals"]["mu"]
    apart = np.log(frictions[1] / frictions[0])
    half = 3.182 * np.sqrt((0.5 * apart**2 + 2.0 * 0.07**2) / 3.0 / 2.0)
    assert low <= min(frictions) and max(frictions) <= high
    assert np.log(high / low) == pytest.approx(2.0 * half, rel=0.15)


@pytest.mark.slow
def test_grade_leaves_out_what_differs_between_specimens(said: Callable) -> None:
    """Five joints whose heights differ by 18 % are a result: the law predicts their mean."""
    slip = np.linspace(0.05, 6.0, 60)
    tests = []
    factors = (0.79, 1.2, 1.15, 0.84, 1.06)
    for i, (pressure, factor) in enumerate(zip((0.6, 1.1, 1.6, 2.2, 2.8), factors, strict=True)):
        slope, height, mu, rng = 0.3, 0.4 * factor, 0.6, np.random.default_rng(i)
        now = slope * np.exp(-slip * slope / height)
        tau = np.minimum(9.0 * slip, pressure * (mu + now) / (1.0 - mu * now))
        dilation = height * (1.0 - np.exp(-slip * slope / height))
        tau, dilation = (y + 0.02 * np.ptp(y) * rng.normal(size=slip.size) for y in (tau, dilation))
        tests.append(ShearTest(f"joint {i}", slip, tau, dilation, -pressure))
    write(tests)
    text, found = of_fit(said, 0)
    assert found["errors"]["blind dilation"] > 0.15 and re.search(r"the tests differ .*dilation 1\d%", text)
    low, high = found["intervals"]["height"]
    assert low < 0.4 < high


def test_nonsense_of_several_pressures_is_no_specimen(said: Callable) -> None:
    """What differs between tests is left out of the grade only where it is as small as in specimens."""
    rng = np.random.default_rng(3)
    slip = np.linspace(0.1, 3.0, 40)
    tests = []
    for i, (pressure, strength) in enumerate(((0.5, 0.9), (1.0, 0.25), (2.0, 1.9), (3.0, 0.8))):
        tau = strength * (1.0 - np.exp(-slip / 0.1)) + 0.01 * rng.normal(size=slip.size)
        tests.append(ShearTest(f"joint {i}", slip, tau, None, -pressure))
    write(tests)
    _, found = of_fit(said, NO_RESULT)
    assert found["grade"] == "poor"


def test_bond_without_pressure(said: Callable) -> None:
    """A pulled bond that ends at 0 has strength and energy, and nothing about the friction."""
    strength, end, stiffness = 5.2, 0.26, 115.0
    for number in (1, 2):
        rng = np.random.default_rng(number)
        own = np.linspace(0.0, 1.6 * end, 70)
        tau = strength * np.maximum(0.0, 1.0 - own / end)
        slip = own + tau / stiffness
        slip, tau = (
            np.append(np.linspace(0.005, slip[0], 8)[:-1], slip),
            np.append(stiffness * np.linspace(0.005, slip[0], 8)[:-1], tau),
        )
        tau = tau + 0.01 * strength * rng.normal(size=tau.size)
        write([ShearTest("pulled", slip, tau, None, 0.0)])
        text, found = of_fit(said, 0)
        assert "mu" not in found["intervals"] and found["pressures"] == [0.0, 0.0]
        for name, truth in (("sigma0", strength), ("Gc", 0.5 * strength * end)):
            low, high = found["intervals"][name]
            assert low <= truth <= high and high < 1.5 * low
        # noise at the end, over a tenth of the peak
        assert found["errors"]["residual"] < 0.1
        assert "nothing is known about the friction" in text
    said("fit tests.csv --joint rock", 1)


@pytest.mark.slow
def test_pressure_that_was_not_counted(said: Callable) -> None:
    """A ratio of strength to pressure that falls as if a weight were missing is named, with its size."""
    slip, missing, mu = np.linspace(0.05, 3.0, 60), 0.06, 0.6
    tests = []
    for i, pressure in enumerate((0.1, 0.2, 0.4)):
        rng = np.random.default_rng(i)
        slope = 0.2 * np.exp(-2.0 * slip)
        tau = np.minimum(8.0 * slip, (pressure + missing) * (mu + slope) / (1.0 - mu * slope))
        dilation = 0.1 * (1.0 - np.exp(-2.0 * slip))
        tau, dilation = (y + 0.01 * np.ptp(y) * rng.normal(size=slip.size) for y in (tau, dilation))
        tests.append(ShearTest(f"joint {i}", slip, tau, dilation, -pressure))
    write(tests)
    text, _ = said("fit tests.csv", NO_RESULT)
    shown = re.search(r"as if a pressure of ([\d.]+) had not been counted", text)
    # two digits
    assert shown and float(shown[1]) == pytest.approx(missing, rel=0.1)


def test_prediction_has_intervals(said: Callable) -> None:
    """`predict` prints the intervals by which its errors must be judged, and what lies outside."""
    rng, c, mu = np.random.default_rng(8), 0.3, 0.7
    pressures = np.repeat([0.2, 0.6, 1.0, 1.5], 2)
    peaks = (c + mu * pressures) * (1.0 + 0.03 * rng.normal(size=pressures.size))
    rows = "".join(f"{p:g},{t:.4g}\n" for p, t in zip(pressures, peaks, strict=True))
    Path("peaks.csv").write_text("sigma_N,peak\n" + rows)
    said("fit peaks.csv -o joint.nml")
    Path("new.csv").write_text(f"sigma_N,peak\n0.8,{c + 0.8 * mu:.4g}\n1.2,{1.4 * (c + 1.2 * mu):.4g}\n")
    text, _ = said("predict joint.nml new.csv", NO_RESULT)
    below = text[text.index("predicted, 0.95 interval") :]
    ends = [tuple(map(float, pair)) for pair in re.findall(r"([\d.]+) to ([\d.]+)", below)][:2]
    content = json.loads(Path("joint.fit.json").read_text())
    for (low, high), pressure in zip(ends, (0.8, 1.2), strict=True):
        assert low < c + mu * pressure < high
        # it contains twice the model error on both sides
        assert high - low > 3.9 * content["model error of tau and s_N"][0] * 0.5 * (low + high)
    assert (
        "inside      1 of 2 measured numbers lie in their intervals; outside: peak of new.csv: line 3" in text
    )
    Path("joint.fit.json").write_text(json.dumps(content | {"values": []}))
    _, message = said("predict joint.nml new.csv", 1)
    assert "joint.fit.json: expected a file that this version of asperity fit -o has written" in message
    Path("joint.fit.json").unlink()
    text, _ = said("predict joint.nml new.csv", NO_RESULT)
    assert "interval" not in text


@pytest.mark.slow
def test_teeth_that_wear_sooner_under_pressure(said: Callable) -> None:
    """A slope that the work of friction wears is no crushed one: theta is not that of an extrapolation."""
    mu, slope, spring, tests = 0.6, np.tan(np.radians(18.0)), 10.0, []
    for i, pressure in enumerate((0.8, 1.9)):
        own, work, left = np.linspace(0.0, 6.0, 1201), 0.0, []
        for step in np.diff(own, append=6.0):
            now = slope * np.exp(-work / 1.2)
            left.append(now)
            work += (pressure * (mu + now) / (1.0 - mu * now) - pressure * now) * step
        steep = np.array(left)
        strength = pressure * (mu + steep) / (1.0 - mu * steep)
        opening = np.append(0.0, np.cumsum(steep[:-1] * np.diff(own)))
        slip, outside = np.linspace(0.05, 6.0, 100), np.maximum.accumulate(own + strength / spring)
        outside = np.append(0.0, outside + 1e-9 * own)
        tau = np.interp(slip, outside, np.append(0.0, strength))
        dilation = np.interp(slip, outside, np.append(0.0, opening))
        rng = np.random.default_rng(i)
        tau, dilation = (y + 0.01 * np.ptp(y) * rng.normal(size=slip.size) for y in (tau, dilation))
        tests.append(ShearTest(f"teeth {i}", slip, tau, dilation, -pressure))
    write(tests)
    _, found = of_fit(said)
    low, high = found["intervals"]["theta"]
    assert found["no result"] or low < 18.0 < high
    low, high = found["intervals"]["mu"]
    assert low < mu < high


def test_specimens_whose_shape_is_almost_one() -> None:
    """The scatter of specimens widens the intervals of all constants, also where 1.01 eta would exceed 1."""
    rng, tests, stiffness = np.random.default_rng(12), [], 0.0075
    slip = np.concatenate([np.linspace(0.002, 0.05, 25), np.linspace(0.06, 2.6, 90)])
    for factor, pressure in ((1.25, 0.3), (0.8, 0.6), (1.1, 1.0), (0.85, 1.3)):
        # a bond of the strength 0.9 and the energy 0.9, whose friction waits for the damage
        bond = (
            0.9
            * factor
            * np.where(slip < 2.0 * stiffness, slip / (2.0 * stiffness), np.maximum(0.0, 1.0 - 0.5 * slip))
        )
        damage = np.clip(1.0 - 2.0 * stiffness * bond / (0.9 * factor * slip), 0.0, 1.0)
        tau = bond + 0.6 * pressure * damage + 0.01 * rng.normal(size=slip.size)
        tests.append(ShearTest(f"{pressure}", slip, tau, None, -pressure))
    result = fit(tests, free=("sigma0", "Gc", "mu", "eta"))
    assert result.values["eta"] > 0.991
    assert np.isfinite(result.covariance).all()
    spread = next(spread for spread in result.intervals.spreads if spread.of_tests)
    for name in ("sigma0", "Gc"):
        assert result.intervals.by_tests(name)
        # four specimens that scatter by a fifth, and others by 15 %
        assert result.estimates[name].half > 0.25
    assert spread.covariance[3, 3] < spread.covariance[0, 0]


def test_quantiles_are_those_of_tables() -> None:
    """Student's t at 0.975."""
    assert quantiles([1.0, 3.0, 10.0]) == pytest.approx([12.706, 3.182, 2.228], abs=5e-4)


def test_covariance_that_is_not_finite() -> None:
    """It is an error, as it would widen nothing."""
    with pytest.raises(ValueError, match="expected finite numbers"):
        Spread(np.array([[np.nan]]), 1.0)
