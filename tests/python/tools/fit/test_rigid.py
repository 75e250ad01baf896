"""Curves whose slope or softening has another shape than that of the law, by the command."""

from __future__ import annotations

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas
import pytest
from asperity.tools.fit import ShearTest, fit
from asperity.tools.fit.rigid import (
    DECAYING,
    FREE,
    LAW,
    LEAST,
    SHAPES,
    SLOPES,
    SOFTENINGS,
    WITHOUT,
    crushed,
    rigid_curve,
)
from scipy.special import gamma

from harness.studies import fits, other_laws
from harness.studies.other_laws import slips_behind_spring

pytestmark = [pytest.mark.usefixtures("folder"), pytest.mark.filterwarnings("ignore::asperity.ModelWarning")]


def found() -> dict:
    """What the fit wrote beside its case."""
    return json.loads(Path("joint.fit.json").read_text())


@pytest.mark.parametrize("name", SLOPES)
def test_profiles(name: str) -> None:
    """The dilation of a profile is the integral of its slope, from the largest slope on to the height."""
    slope, height = 0.3, 0.8
    u = np.linspace(0.0, 60.0 * height / slope, 600001)
    left, z = SHAPES[name].profile(u, slope, height)
    steps = 0.5 * (left[1:] + left[:-1]) * np.diff(u)
    # the trapezoidal rule, and a hyperbola that has not ended
    assert np.abs(slope * np.cumsum(steps) - z[1:]).max() < 1e-6
    assert left.max() == pytest.approx(1.0, abs=1e-6) and z[-1] == pytest.approx(height, rel=0.02)


def test_shapes_of_the_page() -> None:
    """The page lists all shapes with their names, and its formulas are those of the fit."""
    page = (Path(__file__).parents[4] / "docs" / "how-to" / "fit.md").read_text()
    slopes, bonds = (
        dict(re.findall(r"^\| (\S[^|]+) \| ([^|]+) \|$", part.partition("\n\n")[0], re.MULTILINE))
        for part in page.split("| shape of")[1:]
    )
    assert {*slopes} == {"of the law", *SLOPES}
    assert {*bonds} == {"of the law", *SOFTENINGS, WITHOUT}
    assert {*SHAPES} == {LAW, *SLOPES, *SOFTENINGS, WITHOUT, f"{WITHOUT}, {DECAYING}"}
    names = {"exp": np.exp, "cos": np.cos, "max": np.maximum, "min": np.minimum, "pi": np.pi}
    x, peak = np.linspace(0.01, 5.0, 200), 0.3

    def same(text: str, expected: np.ndarray) -> None:
        formula = re.sub(r"(?<=[\w.)]) (?=[a-z(])", "*", text.split("`")[1].replace("^", "**"))
        # three digits
        np.testing.assert_allclose(
            eval(formula, names | {"x": x, "p": peak}), expected, atol=0.01, err_msg=text
        )

    for name in (LAW, *SLOPES):
        same(slopes[name or "of the law"], SHAPES[name].profile(x, 1.0, 1.0)[0])
    for name in (LAW, *SOFTENINGS):
        same(bonds[name or "of the law"], SHAPES[name].softening(x, peak))


@pytest.mark.parametrize("of_bond", [LAW, DECAYING])
def test_slope_without_friction(of_bond: str) -> None:
    """The strength is that of a flat joint under the same opening, the dilation that of the law."""
    values = {"mu": 0.6, "theta": 20.0, "height": 0.4, "sigma0": 0.5, "Gc": 0.1, "kT": 10.0, "eta": 0.999}
    u = np.linspace(0.0, 2.0, 21)
    test = ShearTest("a", u[1:], u[1:], None, -1.0)
    name = f"{WITHOUT}, {of_bond}".removesuffix(", ")
    tau, s_N = rigid_curve(test, u, values, SHAPES[name])
    np.testing.assert_array_equal(tau, rigid_curve(test, u, values | {"theta": 0.0}, SHAPES[of_bond])[0])
    np.testing.assert_array_equal(s_N, rigid_curve(test, u, values)[1])


@pytest.mark.slow
def test_share_of_crushed_asperities() -> None:
    """Shares are those of bisections, also of asperities so steep that a side locks."""
    rng, tolerance, draws = np.random.default_rng(3), 1e-6, (3000, 1)
    mu, slope = rng.uniform(0.1, 1.5, draws), np.tan(np.radians(rng.uniform(5.0, 75.0, draws)))
    crush, p = 10.0 ** rng.uniform(-2.0, 2.0, draws), 10.0 ** rng.uniform(-2.0, 1.0, (3000, 8))
    low, high = np.zeros_like(p), np.ones_like(p)
    for _ in range(60):
        t = 0.5 * (low + high) * slope
        x = 2.0 * p / crush * np.sqrt(1.0 + t**2) / np.maximum(1.0 - mu * t, FREE)
        x = np.maximum(x * np.maximum(1.0 - mu * (slope - t), 0.0), LEAST)
        above = t / slope > np.log1p(x) / x
        low, high = np.where(above, low, t / slope), np.where(above, t / slope, high)
    joints = zip(p, *(column.ravel().tolist() for column in (mu, slope, crush)), strict=True)
    shares = [crushed(lambda _, p=p: p, mu, slope, crush, 8) for p, mu, slope, crush in joints]
    np.testing.assert_allclose(shares, high, rtol=tolerance)


def pulled(shape: str, seed: int, strength: float = 8.0, end: float = 1.2) -> float:
    """Write a bond without pressure behind a machine, with 2 % noise; its energy."""
    u = np.linspace(0.0, 3.0 * end, 6001)
    if shape == "exponential":
        stress, energy = strength * np.minimum(u / 0.02, np.exp(-4.0 * (u - 0.02) / end)), 0.25 * end + 0.01
    else:
        first = 0.2 * end
        stress = strength * np.clip(np.minimum((u / first) ** 0.4, (end - u) / (end - first)), 0.0, 1.0)
        energy = first / 1.4 + 0.5 * (end - first)
    outside = np.maximum.accumulate(u + stress / 200.0) + 1e-9 * u
    slip = np.linspace(0.02, 1.6 * end, 80)
    tau = np.interp(slip, outside, stress) + 0.02 * strength * np.random.default_rng(seed).normal(size=80)
    pandas.DataFrame({"slip [mm]": slip, "tau [MPa]": tau}).to_csv("tests.csv", index=False)
    return strength * energy


@pytest.mark.parametrize(
    ("shape", "name"),
    [("exponential", "exponential softening"), ("Model Code", "bond that rises with a power")],
)
def test_bond_of_another_shape(shape: str, name: str, said: Callable) -> None:
    """Strength and energy are those of the curve, although the law misses its rows; the shape is named."""
    for seed in (1, 2):
        energy = pulled(shape, seed)
        text, _ = said("fit tests.csv --sigma-N 0 -o joint.nml --force", 0)
        content = found()
        for constant, truth in (("sigma0", 8.0), ("Gc", energy)):
            low, high = content["intervals"][constant]
            margin = 0.5 * (high - low)  # a 0.95 interval
            assert low - margin <= truth <= high + margin and high < 1.3 * low
        assert f"the tests have another shape than the law, {name}" in text
        # nothing about the friction, and no pressure is asked for
        assert "mu" not in content["parameters"] and "second pressure" not in text
        assert content["errors"]["scatter"] > 0.05


def test_peak_of_a_bell(said: Callable) -> None:
    """Asperities whose slope falls as a bell: their slope is inside, and no peak of the law is higher."""
    mu, theta, length = 0.59, 16.0, 2.5
    slope, rows = np.tan(np.radians(theta)), []
    for seed, pressure in enumerate((1.1, 1.4)):
        rng, slips = np.random.default_rng(seed), np.linspace(0.1, 9.0, 60)

        def strength(u: float, pressure: float = pressure) -> float:
            now = slope * np.exp(-((u / length) ** 2))
            return float(pressure * (mu + now) / (1.0 - mu * now))

        own = slips_behind_spring(slips, strength, 8.0)
        tau = np.array([strength(u) if u > 0.0 else 8.0 * s for u, s in zip(own, slips, strict=True)])
        steps = np.linspace(0.0, 1.0, 401) * own[:, None]
        opening = np.trapezoid(slope * np.exp(-((steps / length) ** 2)), steps, axis=1)
        columns = {"test": f"joint {seed}", "slip": slips, "tau": tau + 0.01 * rng.normal(size=60)}
        columns |= {"dilation": opening + 0.005 * rng.normal(size=60), "sigma_N": pressure}
        rows.append(pandas.DataFrame(columns))
    pandas.concat(rows).to_csv("tests.csv", index=False)
    text, _ = said("fit tests.csv -o joint.nml", 0)
    content = found()
    low, high = content["intervals"]["theta"]
    assert low <= theta <= high and "slope of a bell" in text
    for test in content["tests"]:
        # the noise of a peak of three rows, twice
        assert test["fitted"]["peak"] < test["measured"]["peak"] + 2.0 * 0.01 / np.sqrt(3.0)


WAVE = (2.0, lambda part: np.cos(0.5 * np.pi * part) ** 2)
PARABOLA = (3.0, lambda part: (1.0 - part) ** 2)
"""End of the slope over height/slope, and share of the slope at parts of it."""


@pytest.mark.parametrize(("shape", "name"), [(WAVE, "of a wave"), (PARABOLA, "along a parabola")])
def test_slope_that_ends(shape: tuple[float, Callable], name: str, said: Callable) -> None:
    """A slope that ends as half a wave or a parabola: its largest value is inside, also with a height."""
    mu, theta, height, pressure, rng = 0.55, 14.0, 0.6, 1.2, np.random.default_rng(1)
    slope = np.tan(np.radians(theta))
    end = shape[0] * height / slope
    slips = np.linspace(0.02, 2.0, 120) * end

    def strength(u: float) -> float:
        now = slope * shape[1](min(1.0, u / end))
        return float(pressure * (mu + now) / (1.0 - mu * now))

    own = slips_behind_spring(slips, strength, 8.0)
    tau = np.array([strength(u) if u > 0.0 else 8.0 * s for u, s in zip(own, slips, strict=True)])
    parts = np.linspace(0.0, 1.0, 401) * np.minimum(1.0, own / end)[:, None]
    opening = slope * end * np.trapezoid(shape[1](parts), parts, axis=1)
    columns = {"slip": slips, "tau": tau + 0.01 * rng.normal(size=120), "sigma_N": pressure}
    columns["dilation"] = opening + 0.005 * rng.normal(size=120)
    pandas.DataFrame(columns).to_csv("tests.csv", index=False)
    for known in ("", f" --joint rock --set height={height}"):
        text, _ = said(f"fit tests.csv -o joint.nml --force{known}", 0)
        low, high = found()["intervals"]["theta"]
        assert low <= theta <= high
        if known:  # the parabola is close to the law, whose height may be another
            assert high < 1.2 * low and f"another shape than the law, slope {name}" in text


@pytest.mark.parametrize("known", ["", " --set theta=14"], ids=["free", "theta known"])
def test_dilation_that_may_end_with_the_rows(known: str, said: Callable) -> None:
    """A slope that ends sooner than any known shape, after the rows: the interval of the height says so."""
    mu, theta, height, rng, rows = 0.6, 14.0, 0.6, np.random.default_rng(5), []
    slope = np.tan(np.radians(theta))
    length = height / (slope * gamma(1.0 + 1.0 / 3.0))  # the integral of exp(-u^3)
    fine = np.linspace(0.0, length, 4001)
    now = slope * np.exp(-((fine / length) ** 3))
    z = np.append(0.0, np.cumsum(0.5 * (now[1:] + now[:-1]) * np.diff(fine)))
    slips = np.linspace(0.0055, 0.55, 100) * length
    for pressure in (0.6, 1.5):

        def strength(u: float, pressure: float = pressure) -> float:
            steep = float(np.interp(u, fine, now))
            return pressure * (mu + steep) / (1.0 - mu * steep)

        own = slips_behind_spring(slips, strength, 24.0)
        tau = np.array([strength(u) if u > 0.0 else 24.0 * s for u, s in zip(own, slips, strict=True)])
        opening = np.interp(own, fine, z)
        columns = {
            "test": f"p {pressure}",
            "slip": slips,
            "tau": tau + 0.015 * tau.max() * rng.normal(size=100),
        }
        columns["dilation"] = opening + 0.015 * opening.max() * rng.normal(size=100)
        rows.append(pandas.DataFrame(columns | {"sigma_N": -pressure}))
    pandas.concat(rows).to_csv("tests.csv", index=False)
    said(f"fit tests.csv --joint rock -o joint.nml{known}", 0)
    content = found()
    low, high = content["intervals"]["height"]
    assert low <= height <= high and high > 1.5 * height  # no shape knows the end
    # and begins near the dilation that the rows show
    assert low == pytest.approx(opening.max(), rel=0.25)


def test_one_row_that_slides_is_no_strength() -> None:
    """An elastic line whose last row lies below it has not slid."""
    slip = np.arange(1, 11) * 0.05
    tau = 2.0 * slip
    tau[-1] = 0.915
    result = fit([ShearTest("one", slip, tau, None, -1.0)], "rock")
    assert any("end before the joint slides" in text for text in result.reasons)


def test_joint_that_closes_before_it_opens(said: Callable) -> None:
    """Gauges stay as they are, and the largest slope of the dilation is that of the constants."""
    mu, theta, rows = 0.6, 14.0, []
    slope = np.tan(np.radians(theta))
    fine = np.linspace(0.0, 12.0, 2401)
    # the joint closes by 0.009 mm within the first half millimetre, twice the noise
    shape = np.exp(-fine / 3.5) - 1.4 * np.exp(-fine / 0.35)
    now = slope * shape / shape.max()
    z = np.append(0.0, np.cumsum(0.5 * (now[1:] + now[:-1]) * np.diff(fine)))
    assert z.min() < -0.008
    for seed, pressure in enumerate((0.8, 1.2, 2.0)):
        rng, slips = np.random.default_rng(seed), np.linspace(0.1, 10.0, 100)

        def strength(u: float, pressure: float = pressure) -> float:
            steep = float(np.interp(u, fine, now))
            return pressure * (mu + steep) / (1.0 - mu * steep)

        own = slips_behind_spring(slips, strength, 12.0)
        tau = np.array([strength(u) if u > 0.0 else 12.0 * s for u, s in zip(own, slips, strict=True)])
        columns = {"test": f"joint {seed}", "slip": slips, "tau": tau + 0.01 * rng.normal(size=100)}
        # the law itself has no contraction, and misses these rows by more than a fair fit may
        opening = np.interp(own, fine, z) + 0.005 * rng.normal(size=100)
        rows.append(pandas.DataFrame(columns | {"dilation": opening, "sigma_N": pressure}))
    pandas.concat(rows).to_csv("tests.csv", index=False)
    text, _ = said("fit tests.csv -o joint.nml", 3)
    low, high = found()["intervals"]["theta"]
    assert low <= theta <= high < 1.2 * theta and "the law misses the scatter" in text
    assert "slope after a contraction" in text and "was not set to zero" not in text


def test_bond_beside_a_slope_without_friction(said: Callable) -> None:
    """A bond that softens exponentially beside a dilation that adds no strength is inside, and told."""
    mu, bond, energy, height, slope, rows = 0.8, 0.56, 0.12, 0.05, 0.2, []
    for seed, pressure in enumerate((0.2, 0.5, 0.9)):
        rng, slips = np.random.default_rng(seed), np.linspace(0.02, 2.0, 70)

        def strength(u: float, pressure: float = pressure) -> float:
            return float(mu * pressure + bond * np.exp(-u * bond / energy))

        own = slips_behind_spring(slips, strength, 60.0)
        tau = np.array([strength(u) if u > 0.0 else 60.0 * s for u, s in zip(own, slips, strict=True)])
        opening = height * (1.0 - np.exp(-own * slope / height))
        columns = {"test": f"joint {seed}", "slip": slips, "tau": tau + 0.01 * rng.normal(size=70)}
        columns |= {"dilation": opening + 0.0005 * rng.normal(size=70), "sigma_N": pressure}
        rows.append(pandas.DataFrame(columns))
    pandas.concat(rows).to_csv("tests.csv", index=False)
    text, _ = said("fit tests.csv --joint mortar -o joint.nml", 0)
    low, high = found()["intervals"]["sigma0"]
    # with and without the friction of the slope
    assert low <= bond <= high < 4.0 * low
    assert "the slope of the dilation adds less friction than that of the law" in text


def test_tests_that_alone_show_less(said: Callable) -> None:
    """Two strengths under a stiffness: alone each hardly tells friction from slope."""
    mu, theta, height, k_N, rows = 0.65, 18.0, 0.8, 3.0, []
    slope = np.tan(np.radians(theta))
    for seed, pressure in enumerate((0.6, 1.8)):
        rng, slips = np.random.default_rng(seed), np.linspace(0.1, 10.0, 100)

        def strength(u: float, pressure: float = pressure) -> float:
            left = float(np.exp(-u * slope / height))
            steep, opening = slope * left, height * (1.0 - left)
            return (pressure + k_N * opening) * (mu + steep) / (1.0 - mu * steep)

        own = slips_behind_spring(slips, strength, 9.0)
        tau = np.array([strength(u) if u > 0.0 else 9.0 * s for u, s in zip(own, slips, strict=True)])
        columns = {"test": f"joint {seed}", "slip": slips, "tau": tau + 0.02 * rng.normal(size=100)}
        rows.append(pandas.DataFrame(columns | {"sigma_N": pressure}))
    pandas.concat(rows).to_csv("tests.csv", index=False)
    said(f"fit tests.csv --k-N {k_N} -o joint.nml", 0)
    intervals = found()["intervals"]
    for name, truth in (("mu", mu), ("theta", theta), ("height", height)):
        low, high = intervals[name]
        assert low <= truth <= high < 2.5 * low


def test_bond_that_stays_elastic(said: Callable) -> None:
    """A line without an end shows a stiffness, and no strength: exit code 3 with the reason."""
    for factor, reason in (
        (7.0, "the joint slides: the strength of the bond"),
        (3.0, "no result"),
    ):
        rows = [f"{slip:.4g},{factor * slip:.4g}" for slip in np.linspace(0.01, 1.0, 60)]
        Path("tests.csv").write_text("\n".join(["slip [mm],tau [MPa]", *rows]), encoding="utf-8")
        assert reason in said("fit tests.csv --sigma-N 0", 3)[0]


def test_flat_joint(said: Callable) -> None:
    """--sides 0 is a joint without slopes, also where its rows have a dilation."""
    drawn = other_laws.mohr_coulomb(np.random.default_rng([3, 1]), 2, 40)
    frames = [
        pandas.DataFrame(
            {"test": i, "slip": test.slip, "tau": test.tau, "dilation": test.s_N, "sigma_N": -test.sigma_N}
        )
        for i, test in enumerate(fits.tests_of(drawn))
    ]
    pandas.concat(frames).to_csv("tests.csv", index=False)
    from asperity.cli import main

    assert main(["fit", "tests.csv", "--joint", "rock", "--sides", "0", "-o", "joint.nml"]) in (0, 3)
    assert found()["parameters"] == ["mu"] and "sides = 0" in Path("joint.nml").read_text()
    assert "expected a whole number, 0 or more" in said("fit tests.csv --sides=-1", 1)[1]
