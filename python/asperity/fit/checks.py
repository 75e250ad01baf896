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

UNUSUAL = 3.0
"""Ratio of tau to |sigma_N| at the end of a test above which one of them is doubted: 72 degrees."""

STEEPEST, SHALLOWEST, OFFSET, CLOSES = 20.0, 1.0e-3, 0.5, 3.0
"""Ratios of dilation to slip of planes of 87 degrees, and below which the dilation is doubted; largest first
dilation or slip over its range; ratio of closure to opening above which the sign is doubted.
"""

SPRING = 0.7
"""Largest fraction of a change of the normal traction that k_N times the dilation need not explain."""

LONGEST_PATH, MOST_TURNS = 5.0, 1.0 / 3.0
"""Length of the slip path over its range, and fraction of rows with a reversal, of rows out of order."""

USUAL = {"length": (1e-6, 1.0), "stress": (1e3, 2e8)}
"""Usual sizes of the largest slip, in metres, and of the largest stress, in pascals, of a shear-box test."""


def refuse(wrong: object, text: str) -> None:
    """Raise ValueError where something is wrong."""
    if wrong:
        raise ValueError(text)


def doubt(odd: object, text: str) -> None:
    """Give a ModelWarning where something is odd."""
    if odd:
        warnings.warn(text, ModelWarning, stacklevel=2)


def of_rows(test: ShearTest, sigma_N: Floats) -> None:
    """Check one test; sigma_N (T,): as measured.  Raises ValueError or gives a ModelWarning."""
    name, slip, slips = test.name, test.slip, float(np.ptp(test.slip))
    work = float(0.5 * (test.tau + np.append(0.0, test.tau[:-1])) @ np.diff(slip, prepend=0.0))
    refuse(
        work < 0.0,
        f"{name}: columns slip, tau: the work of tau along the slip is {work:.3g} < 0: expected tau > 0 "
        "where the slip grows; change the sign of one of the columns",
    )
    first = f"{name}: line {test.lines[0]}" if test.lines else name
    refuse(
        abs(float(slip[0])) > OFFSET * slips and not test.envelope,
        f"{first}, column slip: {slip[0]:g} in the first row: expected slips from 0 on, as those of the "
        "model",
    )
    if test.s_N is not None:
        _of_dilation(test, test.s_N, slips)
        opening, change = test.k_N * (test.s_N - test.s_N[0]), float(np.ptp(sigma_N))
        left = float(np.abs(sigma_N - sigma_N[0] + opening).max())
        varies = test.k_N > 0.0 and change > HELD * np.abs(sigma_N).max()
        refuse(
            varies and left > SPRING * max(change, float(np.ptp(opening))),
            f"{name}: column k_N: {test.k_N:g} times the dilation changes sigma_N by up to "
            f"{np.ptp(opening):g}, the column by {change:g}: expected stress/length in the units of tau and "
            "slip, and dilation > 0 where it opens",
        )
    way, turns = float(np.abs(np.diff(slip)).sum()) / slips, len(test.turns) - 1
    doubt(
        way > LONGEST_PATH and turns > MOST_TURNS * slip.size,
        f"{name}: the slip reverses at {turns} of {slip.size} rows and covers {way:.0f} times its range: "
        "expected the rows in the order of the test",
    )


def _of_dilation(test: ShearTest, s_N: Floats, slips: float) -> None:
    """Check unit, start and sign of the dilation over the range of the slips."""
    change, worst = float(np.ptp(s_N)), int(np.argmax(np.abs(s_N)))
    place, first = (f"{test.name}: line {test.lines[i]}" if test.lines else test.name for i in (worst, 0))
    refuse(
        change > STEEPEST * slips,
        f"{place}, column dilation: {s_N[worst]:g} over slips up to {np.abs(test.slip).max():g}: expected "
        f"the unit of slip (at most {STEEPEST:g} times it)",
    )
    doubt(
        0.0 < change < SHALLOWEST * slips,
        f"{test.name}: column dilation changes by {change:.3g} over slips of {slips:.3g}: expected the unit "
        "of slip, or no such column for a joint that does not dilate",
    )
    refuse(
        abs(float(s_N[0])) > STEEPEST * abs(float(test.slip[0])) + OFFSET * change,
        f"{first}, column dilation: {s_N[0]:g} at slip {test.slip[0]:g}: expected the change since the start "
        "of the slip",
    )
    doubt(
        -float(s_N.min()) > CLOSES * max(float(s_N.max()), 0.0) and -float(s_N[-1]) > OFFSET * change,
        f"{test.name}: column dilation: {s_N[-1]:g} at the end, the joint closes as it slips: expected "
        "dilation > 0 where the joint opens",
    )


def of_all(tests: Sequence[ShearTest]) -> None:
    """Check the tests of a fit against each other.  Raises ValueError or gives a ModelWarning."""
    with_units = [test.name for test in tests if test.units]
    without = [test.name for test in tests if not test.units]
    refuse(
        with_units and without,
        f"{''.join(without[:1])}: no units in the header: expected units in every file, as in "
        f"{''.join(with_units[:1])}, or in none",
    )
    size = max(max(abs(test.pressed), float(np.abs(test.tau).max())) for test in tests)
    for test in tests:
        change = test.k_N * (0.0 if test.s_N is None else float(np.ptp(test.s_N)))
        refuse(
            change > LARGEST_RATIO * size,
            f"{test.name}: column k_N: {test.k_N:g} changes sigma_N by {change:g}: expected stress/length in "
            f"the units of tau and slip (a change up to {LARGEST_RATIO * size:g})",
        )
        most = LARGEST_RATIO if test.units else LARGEST_FRICTION
        last = test.sigma_N - (0.0 if test.s_N is None else test.k_N * float(test.s_N[-1]))
        held = abs(last if test.path_N is None else float(test.path_N[-1]))
        tau = float(np.mean(np.abs(test.tau[-max(1, test.slip.size // 10) :])))
        refuse(
            held > 0.0 and not 1.0 / most <= tau / held <= most,
            f"{test.name}: column tau: {tau:.3g} at the end where |sigma_N| is {held:.3g}: expected the same "
            f"unit (a ratio of {1.0 / most:g} to {most:g}); numbers are converted if the header has units, "
            "such as tau [kPa], sigma_N [MPa]",
        )
        doubt(
            held > 0.0 and tau > UNUSUAL * held,
            f"{test.name}: tau is {tau / (held or 1.0):.3g} times |sigma_N| at the end, which is unusual: "
            "check the units",
        )
    slip = max(float(np.abs(test.slip).max()) for test in tests)
    for what, kind, largest in (("slip", "length", slip), ("stress", "stress", size)) if with_units else ():
        unit = tests[0].units[kind]
        doubt(
            not USUAL[kind][0] <= largest * units.size(kind, unit) <= USUAL[kind][1],
            f"the largest {what} is {largest:.3g} {unit}, which is unusual for a shear box: check the units "
            "of the header",
        )
