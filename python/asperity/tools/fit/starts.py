"""Where the tests of a file begin."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from pandas import DataFrame

LEAP, RETURN, LEAST_WAY, REVERSED = 3.0, 0.3, 0.1, -0.1
"""Where the slip jumps back the next test begins: smallest jump over the usual step and over the way so far;
smallest way over that of the file; and smallest tau over the largest one, because a joint that slips back in
a cycle has reversed tau.
"""


def starts_of(rows: DataFrame) -> list[int]:
    """First rows of the tests below the first: the slip has jumped back there, and tau is not reversed."""
    slip, tau, starts = rows.slip.to_numpy(), rows.tau.to_numpy(), [0]
    steps = np.abs(np.diff(slip))
    usual = np.median(steps[steps > 0.0]) if steps.any() else 0.0
    for i in (np.flatnonzero(steps > LEAP * usual) + 1).tolist():
        way = slip[starts[-1] : i + 1] - slip[starts[-1]]
        reach, side = float(np.abs(way).max()), float(np.sign(way[-2]))
        # a row that is misread is followed by a jump forward
        jumps = (steps[i - 1 : i + 1] > RETURN * reach).tolist()
        beyond = max(side * slip[i], side * way[-1]) < -RETURN * reach
        back = jumps in ([True], [True, False]) and side * (way[-1] - way[-2]) < 0.0 and not beyond
        upright = tau[i] * side > REVERSED * np.abs(tau).max()
        if back and upright and reach > LEAST_WAY * np.ptp(slip):
            starts.append(i)
    return starts[1:]
