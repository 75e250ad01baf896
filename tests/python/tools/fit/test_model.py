"""Tests whose gauges were not set to zero: the constants of drawn joints, read from files."""

from __future__ import annotations

import warnings
from pathlib import Path

import numpy as np
import pytest
from asperity.tools.fit import Fit, fit, read_tests

from harness.studies.other_laws import slips_behind_spring

MU, THETA, LENGTH, STIFFNESS, END = 0.6, 18.0, 3.0, 5.0, 8.0
SLOPE = float(np.tan(np.radians(THETA)))
HEIGHT = SLOPE * LENGTH


def identified(
    folder: Path, slip: float, s_N: float = 0.0, rows: int = 100, seed: int = 1, first: int = 0
) -> Fit:
    """Fit of three files of Mohr and Coulomb with a decaying dilation, 2 % noise, and offsets."""
    rng, paths = np.random.default_rng(seed), []
    for number, pressure in enumerate((0.5, 1.0, 2.0)):
        slips = np.linspace(0.0, END, rows + 1)[first:]

        def strength(u: float, pressure: float = pressure) -> float:
            now = SLOPE * np.exp(-u / LENGTH)
            return float(pressure * (MU + now) / (1.0 - MU * now))

        own = slips_behind_spring(slips, strength, STIFFNESS)
        tau = np.array([strength(u) if u > 0.0 else STIFFNESS * s for u, s in zip(own, slips, strict=True)])
        tau += rng.normal(0.0, 0.02 * tau.max(), slips.size) * (slips > 0.0)
        opening = HEIGHT * (1.0 - np.exp(-own / LENGTH))
        opening += rng.normal(0.0, 0.01 * opening.max(), slips.size) * (slips > 0.0)
        columns = np.transpose([slips + slip, tau, opening + s_N, np.full(slips.size, pressure)])
        paths.append(folder / f"test{number}.csv")
        header = "slip,tau,dilation,sigma_N"
        np.savetxt(paths[-1], columns, "%.5g", ",", header=header, comments="")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return fit(read_tests(paths), "rock")


def inside(result: Fit) -> bool:
    """Whether the constants of the drawn joint lie within the intervals of the fit."""
    truth = {"mu": MU, "theta": THETA, "height": HEIGHT}
    return all(
        result.estimates[name].low <= value <= result.estimates[name].high for name, value in truth.items()
    )


@pytest.mark.slow
@pytest.mark.parametrize("slip", [0.2, 0.06, -0.3])
def test_slip_of_a_gauge_that_was_not_set_to_zero(slip: float, tmp_path: Path) -> None:
    """Other starts are among the assumptions, so that the constants lie within the intervals."""
    result = identified(tmp_path, slip)
    assert result.is_result and inside(result)
    assert any(assumption.name == "gauge offsets" for assumption in result.assumptions)


@pytest.mark.slow
def test_dilation_of_few_rows(tmp_path: Path) -> None:
    """A dilation offset of a twentieth in files of 20 rows lies within the intervals."""
    result = identified(tmp_path, 0.0, s_N=0.05, rows=20, first=1)
    assert inside(result)


@pytest.mark.slow
@pytest.mark.parametrize("first", [0, 1])
def test_gauges_that_were_set_to_zero(first: int, tmp_path: Path) -> None:
    """The intervals stay as narrow as the tests allow that may be different specimens."""
    result = identified(tmp_path, 0.0, first=first)
    assert result.is_result and inside(result)
    # three specimens show a slope to 17 %
    assert result.estimates["theta"].half < 0.2
