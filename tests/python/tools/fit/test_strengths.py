"""Tables of strengths by the command: few peaks, replicates, rows without pressure and in tension."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest

pytestmark = [pytest.mark.usefixtures("folder"), pytest.mark.filterwarnings("ignore::asperity.ModelWarning")]

HEAD = "sigma_N [MPa],peak [MPa]"

NO_RESULT = 3
"""Exit code of a fit whose constants must not be used."""


def table(rows: Sequence[Sequence[float]], head: str = HEAD) -> None:
    """Write the rows of a table of strengths, as a laboratory rounds them."""
    lines = (",".join(f"{value:.4g}" for value in row) for row in rows)
    Path("peaks.csv").write_text("\n".join([head, *lines]) + "\n")


def found() -> dict:
    """What the fit wrote beside its case."""
    return json.loads(Path("joint.fit.json").read_text())


@pytest.mark.parametrize("mu", [0.8, 1.0, 1.14, 1.3])
def test_friction_alone(mu: float, said: Callable) -> None:
    """Peaks in proportion to the pressure, also at mu = 1, whose logarithm is 0."""
    rng = np.random.default_rng([31, round(100 * mu)])
    pressures = np.array([1.2, 1.4, 2.0, 2.6])
    noise = 0.005
    table(np.transpose([pressures, mu * pressures * (1.0 + noise * rng.normal(size=4))]).tolist())
    said("fit peaks.csv --joint rock --set theta=0 -o joint.nml")
    low, high = found()["intervals"]["mu"]
    # five standard deviations of a mean of four
    margin = 5.0 * noise / 2.0 * mu
    assert low - margin <= mu <= high + margin
    assert 0.0 < high - low < 0.1 * mu


def test_three_peaks_have_one_degree_of_freedom(said: Callable) -> None:
    """Three peaks show c + phi with an interval of t = 12.7, and none if they fall."""
    c, mu, pressures = 1.0, 0.65, (1.0, 2.0, 4.0)
    for errors, determined in (((1.0, 0.999, 1.001), True), ((1.05, 0.93, 1.04), False)):
        table([(p, (c + mu * p) * e) for p, e in zip(pressures, errors, strict=True)])
        text, _ = said("fit peaks.csv -o joint.nml --force", 0 if determined else NO_RESULT)
        fitted = found()
        assert fitted["parameters"] == ["mu", "sigma0"]
        for name, truth in (("mu", mu), ("sigma0", c)):
            low, high = fitted["intervals"][name]
            assert low <= truth <= high
        assert ("sigma0" in fitted["not determined"]) != determined
        assert "does not grow" not in text
    table([(p, 2.0 / p) for p in pressures])
    said("fit peaks.csv", NO_RESULT)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_rows_without_pressure(sign: float, said: Callable) -> None:
    """Rows at no pressure are the initial shear strength: c, with either sign of compression."""
    rng, c, mu = np.random.default_rng(52), 0.25, 0.7
    pressures = np.repeat([0.0, 0.2, 0.6, 1.0], 3)
    peaks = (c + mu * pressures) * (1.0 + 0.05 * rng.normal(size=pressures.size))
    table(np.transpose([sign * pressures, peaks]).tolist())
    text, _ = said("fit peaks.csv -o joint.nml")
    low, high = found()["intervals"]["sigma0"]
    # a 0.95 interval with a margin of half of itself
    assert low - 0.25 * (high - low) <= c <= high + 0.25 * (high - low) and high < 1.5 * low
    assert "12 strengths, pressure 0 to 1 MPa" in text and found()["pressures"] == [0.0, 1.0]
    said("run joint.nml --quiet")


def test_rows_at_no_pressure_alone(said: Callable) -> None:
    """They show a bond, and nothing about the friction, which may be given."""
    table([(0.0, 0.21), (0.0, 0.25), (0.0, 0.23), (0.0, 0.26)])
    text, _ = said("fit peaks.csv -o joint.nml")
    assert found()["parameters"] == ["sigma0"] and "nothing is known about the friction" in text
    assert found()["values"][0] == pytest.approx(0.2375, rel=0.02)
    text, _ = said("fit peaks.csv --set mu=0.7 -o joint.nml --force")
    assert "the given mu is assumed" in text and "mu = 0.7" in Path("joint.nml").read_text()


def test_rows_in_tension(said: Callable) -> None:
    """Tensile tests, and shear under tension, show the tensile strength beside the cohesion."""
    c, tensile, mu = 0.4, 0.25, 0.6
    rows = [(p, c + mu * p) for p in (0.0, 0.3, 0.6, 1.0)]
    rows += [(-tensile, 0.0), (-tensile, 0.0), (-0.15, c * np.sqrt(1.0 - (0.15 / tensile) ** 2))]
    noise = 1.0 + 0.02 * np.array([1.0, -1.0, 1.0, -1.0, 1.0, -1.0, 0.5])
    rows = [(p * e, 0.0) if t == 0.0 else (p, t * e) for (p, t), e in zip(rows, noise, strict=True)]
    table(rows)
    text, err = said("fit peaks.csv -o joint.nml --plot fit.png --report page.html --residuals rows.csv")
    intervals = found()["intervals"]
    for name, truth in (("mu", mu), ("sigma0", tensile), ("sigma02", c)):
        assert intervals[name][0] <= truth <= intervals[name][1]
    assert "sigma0 is the tensile strength, and sigma02 is c" in text
    assert "line 6, 7, 8 is read as tension" in err
    said("run joint.nml --quiet")
    table([(0.5, 0.7), (0.8, 0.88)])
    said("predict joint.nml peaks.csv")
    # as many rows with each sign and size do not tell which one is compression
    table([(0.3, 0.5), (-0.3, 0.2), (0.2, 0.4)])
    _, err = said("fit peaks.csv", 1)
    assert "expected compression in all rows" in err


def test_equal_replicates_are_specimens(said: Callable) -> None:
    """Rounded replicates count each; a table that was read twice counts once, and says so."""
    rows = [(0.5, 0.48), *[(0.5, 0.44)] * 3, (1, 0.76), (1, 0.82), *[(1, 0.8)] * 2]
    rows += [(4, 2.57), (4, 2.67), (4, 2.7), (4, 2.83)]
    table(rows)
    text, _ = said("fit peaks.csv -o joint.nml")
    assert "12 strengths" in text and "counts once" not in text
    once = found()["intervals"]
    table([*rows, *rows[::-1]])
    text, _ = said("fit peaks.csv")
    assert "24 strengths" in text  # not each row is there as often as the others
    different = [(0.5, 0.46), (1.0, 0.79), (2.0, 1.45), (4.0, 2.69)]
    table(different)
    said("fit peaks.csv -o joint.nml --force")
    alone = found()["intervals"]
    table(different * 2)
    text, _ = said("fit peaks.csv -o joint.nml --force")
    assert "every row of the table stands there 2 times: each counts once" in text
    assert found()["intervals"] == alone and once["mu"][1] / once["mu"][0] < alone["mu"][1] / alone["mu"][0]


def test_numbers_without_any_scatter(said: Callable) -> None:
    """An interval of no width is no result: such numbers were computed, or copied."""
    table([(p, 0.7 * p) for p in (1.0, 2.0, 4.0)])
    text, _ = said("fit peaks.csv", NO_RESULT)
    assert "has no width" in text
    table([(1.0, 0.7)] * 3)
    text, _ = said("fit peaks.csv", NO_RESULT)
    assert "has no width" in text


@pytest.mark.parametrize("steep", [50.0, 55.0])
def test_peaks_of_a_bilinear_criterion(steep: float, said: Callable) -> None:
    """Peaks grow with the pressure where slope and crushing carry that, too, and mu is at its bound."""
    sides = np.tan(np.radians([steep, 30.0]))
    noise = (1.01, 0.99, 1.01, 0.99, 1.01, 0.99, 1.01)
    pressures = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0)
    table([(p, min(p * sides[0], 0.9 + p * sides[1]) * e) for p, e in zip(pressures, noise, strict=True)])
    text, _ = said("fit peaks.csv")
    assert "the strengths hold between" in text and "does not grow" not in text


def test_peaks_of_another_unit_than_the_pressures(said: Callable) -> None:
    """Peaks in MPa under pressures in kPa grow, and are not on the law to their last digit."""
    table([(50.0, 0.045), (100.0, 0.082), (200.0, 0.155), (400.0, 0.31)])
    text, _ = said("fit peaks.csv", NO_RESULT)
    assert "the law misses the peak by 1130%" in text
    assert not any(told in text for told in ("last digit", "does not grow", "strengths hold"))


@pytest.mark.parametrize("seed", range(12))
def test_any_table_has_intervals_or_is_refused(seed: int, said: Callable) -> None:
    """Drawn tables with zeros, tension, copies and gaps: a message, or finite intervals that have a width."""
    from asperity.cli import main

    rng = np.random.default_rng([90, seed])
    count = int(rng.integers(2, 10))
    pressures = rng.choice([0.0, 0.1, 0.5, 1.0, 2.0, 4.0, -0.05], count)
    peaks = np.maximum(0.0, (rng.uniform(0.0, 0.5) + 0.7 * pressures) * np.exp(0.1 * rng.normal(size=count)))
    rows = np.transpose([pressures, peaks, np.minimum(peaks, 0.5 * np.maximum(0.0, pressures))])
    table(rows[:, : 2 + seed % 2].tolist(), HEAD + ",residual [MPa]" * (seed % 2))
    code = main(["fit", "peaks.csv", "-o", "joint.nml", "--residuals", "rows.csv", "--report", "page.html"])
    if code == 1:
        return
    assert code in (0, NO_RESULT) and "nan" not in Path("rows.csv").read_text()
    for low, high in found()["intervals"].values():
        assert np.isfinite([low, high]).all() and (code == NO_RESULT or high > low > 0.0)
