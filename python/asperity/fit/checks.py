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

LARGEST_RATIO = 1.0e3
"""Largest ratio of two lengths or two stresses: more indicates mixed units, such as MPa and kPa."""

LARGEST_FRICTION = 100.0
"""Largest ratio of tau at the end of a test to |sigma_N| without units; its inverse is the smallest.

A friction of 0.8 on planes of 45 degrees gives 9; a ratio of kPa to MPa is near 1000.
"""

END = 0.1
"""Fraction of the rows that counts as the end of a test."""

STEEPEST = 20.0
"""Largest ratio of dilation to slip: that of planes of 87 degrees."""

SPRING = 0.7
"""Largest fraction of a change of the normal traction that k_N times the dilation need not explain."""

OFFSET = 0.5
"""Largest first dilation, as a fraction of its range, that counts as measured from the start of slip."""

LONGEST_PATH, MOST_TURNS = 5.0, 1.0 / 3.0
"""Length of the slip path over its range, and fraction of rows with a reversal.

If both are exceeded, the rows are taken to be out of order.
"""

SHALLOWEST = 1.0e-3
"""Smallest ratio of dilation to slip that is not doubted: less is hardly measured, or has another unit."""

CLOSES = 3.0
"""Ratio of the largest closure to the largest opening above which the sign of the dilation is doubted."""

USUAL = {"length": (1e-6, 1.0), "stress": (1e3, 2e8)}
"""Usual sizes of the largest slip, in metres, and of the largest stress, in pascals, of a shear-box test."""


def of_rows(test: ShearTest, sigma_N: Floats) -> None:
    """Check one test; sigma_N (T,): as measured.  Raises ValueError or gives a ModelWarning."""
    _work(test)
    _dilation(test)
    if test.k_N > 0.0:
        _spring(test, sigma_N)
    _order(test)


def of_all(tests: Sequence[ShearTest]) -> None:
    """Check the tests of a fit against each other.  Raises ValueError or gives a ModelWarning."""
    with_units = [test.name for test in tests if test.units]
    if 0 < len(with_units) < len(tests):
        without = next(test.name for test in tests if not test.units)
        raise ValueError(
            f"{without}: no units in the header: expected units in every file, as in {with_units[0]}, or in "
            "none"
        )
    pressed = max(abs(test.pressed) for test in tests)
    tau = max(float(np.abs(test.tau).max()) for test in tests)
    for test in tests:
        opening = 0.0 if test.s_N is None else float(np.ptp(test.s_N))
        change, most = test.k_N * opening, LARGEST_RATIO * max(tau, pressed)
        if change > most:
            raise ValueError(
                f"{test.name}: column k_N: {test.k_N:g} changes sigma_N by {change:g}: expected stress/"
                f"length in the units of tau and slip (a change up to {most:g})"
            )
        _friction(test)
    if with_units:
        _sizes(tests)


def _warn(text: str) -> None:
    warnings.warn(text, ModelWarning, stacklevel=5)


def _place(test: ShearTest, row: int) -> str:
    return f"{test.name}: line {test.lines[row]}" if test.lines else test.name


def _dilation(test: ShearTest) -> None:
    """Raise ValueError for a dilation in another unit than the slip, or not measured from its start."""
    if test.s_N is None:
        return
    s_N = test.s_N
    if np.ptp(s_N) > STEEPEST * np.ptp(test.slip):
        worst = int(np.argmax(np.abs(s_N)))
        raise ValueError(
            f"{_place(test, worst)}, column dilation: {s_N[worst]:g} over slips up to "
            f"{np.abs(test.slip).max():g}: expected the unit of slip (at most {STEEPEST:g} times it)"
        )
    if 0.0 < np.ptp(s_N) < SHALLOWEST * np.ptp(test.slip):
        _warn(
            f"{test.name}: column dilation changes by {np.ptp(s_N):.3g} over slips of "
            f"{np.ptp(test.slip):.3g}: expected the unit of slip, or no such column for a joint that "
            "does not dilate"
        )
    first, reached = float(s_N[0]), STEEPEST * abs(float(test.slip[0]))
    if abs(first) > reached + OFFSET * float(np.ptp(s_N)):
        raise ValueError(
            f"{_place(test, 0)}, column dilation: {first:g} at slip {test.slip[0]:g}: expected the "
            "change since the start of the slip"
        )
    if -float(s_N.min()) > CLOSES * max(float(s_N.max()), 0.0) and -float(s_N[-1]) > OFFSET * np.ptp(s_N):
        _warn(
            f"{test.name}: column dilation: {s_N[-1]:g} at the end, the joint closes as it slips: expected "
            "dilation > 0 where the joint opens"
        )


def _spring(test: ShearTest, sigma_N: Floats) -> None:
    """Raise ValueError where the change of the measured sigma_N differs from -k_N times the dilation."""
    if test.s_N is None or np.ptp(sigma_N) <= HELD * float(np.abs(sigma_N).max()):
        return
    expected = -test.k_N * (test.s_N - test.s_N[0])
    left = float(np.abs(sigma_N - sigma_N[0] - expected).max())
    if left > SPRING * max(float(np.ptp(sigma_N)), float(np.ptp(expected))):
        raise ValueError(
            f"{test.name}: column k_N: {test.k_N:g} times the dilation changes sigma_N by up to "
            f"{np.ptp(expected):g}, the column by {np.ptp(sigma_N):g}: expected stress/length in the units "
            "of tau and slip, and dilation > 0 where it opens"
        )


def _order(test: ShearTest) -> None:
    """Issue a ModelWarning where the slip reverses so often that the rows seem to be out of order."""
    way = float(np.abs(np.diff([0.0, *test.slip])).sum() / np.ptp([0.0, *test.slip]))
    turns = len(test.turns) - 1
    if way > LONGEST_PATH and turns > MOST_TURNS * test.slip.size:
        _warn(
            f"{test.name}: the slip reverses at {turns} of {test.slip.size} rows and covers {way:.0f} "
            "times its range: expected the rows in the order of the test"
        )


def _work(test: ShearTest) -> None:
    """Raise ValueError where tau gives work instead of taking it, as with the sign of one column changed."""
    slip, tau = (np.concatenate([[0.0], column]) for column in (test.slip, test.tau))
    work = float(np.sum(0.5 * (tau[1:] + tau[:-1]) * np.diff(slip)))
    if work < 0.0:
        raise ValueError(
            f"{test.name}: columns slip, tau: the work of tau along the slip is {work:.3g} < 0: expected tau "
            "> 0 where the slip grows; change the sign of one of the columns"
        )


def _friction(test: ShearTest) -> None:
    """Raise ValueError where tau at the end and sigma_N differ as two units do."""
    most = LARGEST_RATIO if test.units else LARGEST_FRICTION
    rows = max(1, int(END * test.slip.size))
    held = abs(test.sigma_N - (0.0 if test.s_N is None else test.k_N * float(test.s_N[-1])))
    held = held if test.path_N is None else abs(float(test.path_N[-1]))
    tau = float(np.mean(np.abs(test.tau[-rows:])))
    if held > 0.0 and not 1.0 / most <= tau / held <= most:
        raise ValueError(
            f"{test.name}: column tau: {tau:.3g} at the end where |sigma_N| is {held:.3g}: expected the same "
            f"unit (a ratio of {1.0 / most:g} to {most:g}); numbers are converted if "
            "the header has units, such as tau [kPa], sigma_N [MPa]"
        )


def _sizes(tests: Sequence[ShearTest]) -> None:
    """Issue a ModelWarning where the largest slip or stress is unusual for its unit."""
    slip = max(float(np.abs(test.slip).max()) for test in tests)
    stress = max(max(float(np.abs(test.tau).max()), abs(test.pressed)) for test in tests)
    for what, kind, size in (("slip", "length", slip), ("stress", "stress", stress)):
        unit = tests[0].units[kind]
        low, high = USUAL[kind]
        if not low <= size * units.size(kind, unit) <= high:
            _warn(
                f"the largest {what} is {size:.3g} {unit}, which is unusual for a shear box: check the units "
                "of the header"
            )
