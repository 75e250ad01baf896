"""Checks of shear-box tests: units, signs and order of rows."""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np

from ..contract import Floats
from ..material import ModelWarning
from . import units
from .shear_test import ShearTest

HELD = 0.05
"""Largest relative variation of a normal traction that counts as constant."""

LARGEST_RATIO, LARGEST_FRICTION = 1.0e3, 100.0
"""Largest ratios of two lengths or stresses, and of tau to |sigma_N| without units: more means mixed units.

A friction of 0.8 on planes of 45 degrees gives 9; a ratio of kPa to MPa is near 1000.
"""

STEEPEST, SHALLOWEST, OFFSET, CLOSES = 20.0, 1.0e-3, 0.5, 3.0
"""Ratios of dilation to slip of planes of 87 degrees, and below which the dilation is doubted; largest first
dilation over its range; ratio of closure to opening above which the sign is doubted.
"""

SPRING = 0.7
"""Largest fraction of a change of the normal traction that k_N times the dilation need not explain."""

LONGEST_PATH, MOST_TURNS = 5.0, 1.0 / 3.0
"""Length of the slip path over its range, and fraction of rows with a reversal, of rows out of order."""

USUAL = {"length": (1e-6, 1.0), "stress": (1e3, 2e8)}
"""Usual sizes of the largest slip, in metres, and of the largest stress, in pascals, of a shear-box test."""


def of_rows(test: ShearTest, sigma_N: Floats) -> None:
    """Check one test; sigma_N (T,): as measured.  Raises ValueError or gives a ModelWarning."""
    slip, tau = (np.concatenate([[0.0], column]) for column in (test.slip, test.tau))
    work = float(np.sum(0.5 * (tau[1:] + tau[:-1]) * np.diff(slip)))
    if work < 0.0:
        raise ValueError(
            f"{test.name}: columns slip, tau: the work of tau along the slip is {work:.3g} < 0: expected tau "
            "> 0 where the slip grows; change the sign of one of the columns"
        )
    if test.s_N is not None:
        _dilation(test, test.s_N)
        opening = test.k_N * (test.s_N - test.s_N[0])
        left = float(np.abs(sigma_N - sigma_N[0] + opening).max())
        changes = np.ptp(sigma_N) > HELD * np.abs(sigma_N).max()
        if test.k_N > 0.0 and changes and left > SPRING * max(np.ptp(sigma_N), np.ptp(opening)):
            raise ValueError(
                f"{test.name}: column k_N: {test.k_N:g} times the dilation changes sigma_N by up to "
                f"{np.ptp(opening):g}, the column by {np.ptp(sigma_N):g}: expected stress/length in the "
                "units of tau and slip, and dilation > 0 where it opens"
            )
    way, turns = float(np.abs(np.diff(slip)).sum() / np.ptp(slip)), len(test.turns) - 1
    if way > LONGEST_PATH and turns > MOST_TURNS * test.slip.size:
        _warn(
            f"{test.name}: the slip reverses at {turns} of {test.slip.size} rows and covers {way:.0f} "
            "times its range: expected the rows in the order of the test"
        )


def of_all(tests: Sequence[ShearTest]) -> None:
    """Check the tests of a fit against each other.  Raises ValueError or gives a ModelWarning."""
    with_units = [test.name for test in tests if test.units]
    if 0 < len(with_units) < len(tests):
        without = next(test.name for test in tests if not test.units)
        raise ValueError(
            f"{without}: no units in the header: expected units in every file, as in {with_units[0]}, or in "
            "none"
        )
    size = max(max(abs(test.pressed), float(np.abs(test.tau).max())) for test in tests)
    for test in tests:
        change = test.k_N * (0.0 if test.s_N is None else float(np.ptp(test.s_N)))
        if change > LARGEST_RATIO * size:
            raise ValueError(
                f"{test.name}: column k_N: {test.k_N:g} changes sigma_N by {change:g}: expected stress/"
                f"length in the units of tau and slip (a change up to {LARGEST_RATIO * size:g})"
            )
        most = LARGEST_RATIO if test.units else LARGEST_FRICTION
        held = abs(test.sigma_N - (0.0 if test.s_N is None else test.k_N * float(test.s_N[-1])))
        held = held if test.path_N is None else abs(float(test.path_N[-1]))
        tau = float(np.mean(np.abs(test.tau[-max(1, test.slip.size // 10) :])))
        if held > 0.0 and not 1.0 / most <= tau / held <= most:
            raise ValueError(
                f"{test.name}: column tau: {tau:.3g} at the end where |sigma_N| is {held:.3g}: expected the "
                f"same unit (a ratio of {1.0 / most:g} to {most:g}); numbers are converted if "
                "the header has units, such as tau [kPa], sigma_N [MPa]"
            )
    slip = max(float(np.abs(test.slip).max()) for test in tests)
    for what, kind, largest in (("slip", "length", slip), ("stress", "stress", size)) if with_units else ():
        unit = tests[0].units[kind]
        if not USUAL[kind][0] <= largest * units.size(kind, unit) <= USUAL[kind][1]:
            _warn(
                f"the largest {what} is {largest:.3g} {unit}, which is unusual for a shear box: check the "
                "units of the header"
            )


def _warn(text: str) -> None:
    warnings.warn(text, ModelWarning, stacklevel=5)


def _dilation(test: ShearTest, s_N: Floats) -> None:
    """Raise ValueError or warn where the dilation has another unit, start or sign than expected."""

    def place(row: int) -> str:
        return f"{test.name}: line {test.lines[row]}" if test.lines else test.name

    change, slips = float(np.ptp(s_N)), float(np.ptp(test.slip))
    if change > STEEPEST * slips:
        worst = int(np.argmax(np.abs(s_N)))
        raise ValueError(
            f"{place(worst)}, column dilation: {s_N[worst]:g} over slips up to "
            f"{np.abs(test.slip).max():g}: expected the unit of slip (at most {STEEPEST:g} times it)"
        )
    if 0.0 < change < SHALLOWEST * slips:
        _warn(
            f"{test.name}: column dilation changes by {change:.3g} over slips of {slips:.3g}: expected the "
            "unit of slip, or no such column for a joint that does not dilate"
        )
    if abs(float(s_N[0])) > STEEPEST * abs(float(test.slip[0])) + OFFSET * change:
        raise ValueError(
            f"{place(0)}, column dilation: {s_N[0]:g} at slip {test.slip[0]:g}: expected the "
            "change since the start of the slip"
        )
    if -float(s_N.min()) > CLOSES * max(float(s_N.max()), 0.0) and -float(s_N[-1]) > OFFSET * change:
        _warn(
            f"{test.name}: column dilation: {s_N[-1]:g} at the end, the joint closes as it slips: expected "
            "dilation > 0 where the joint opens"
        )
