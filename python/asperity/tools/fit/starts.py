"""Where the tests of a file begin and end."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...contract import Floats
from .checks import warn_if

if TYPE_CHECKING:
    from pandas import DataFrame

LEAP, RETURN, LEAST_WAY, REVERSED = 3.0, 0.3, 0.1, -0.1
"""Where the slip jumps back the next test begins: smallest jump over the usual step and over the way so far;
smallest way over that of the file; and smallest tau over the largest one, because a joint that slips back in
a cycle has reversed tau.
"""

RESTING, SURELY, LATE, PART = 0.5, 0.25, 4.0, 0.05
"""Traction over the largest one below which a joint rests, and rests without any dilation; slip of a first
row over the usual step (half of it where the joint surely rests), and slip or dilation over the range, beyond
which it is late.
"""

DEVIATIONS, LEAST_NOISE, FIRST_ROWS = 4.0, 6, 8
"""Standard deviations of the noise that an offset of the dilation exceeds; rows that show the noise; first
rows that lead to the dilation at the start.
"""

UNLOADED, OF_CYCLE, ELASTIC = 0.5, 0.05, 0.1
"""Traction of the last row over that at the largest slip below which the joint was unloaded; reversed
traction over the largest one that belongs to a cycle; return of the slip over its range that is more than
elastic.
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


def from_start(
    slip: Floats, tau: Floats, s_N: Floats | None, sigma_N: Floats, places: Sequence[str]
) -> tuple[Floats, Floats | None]:
    """Slip and dilation (T,) counted from the start of the slip, where the first row shows another start.

    Where the joint still rests in the first row, a slip or dilation there is that of a gauge which was not
    set to zero: it is taken off, and a ModelWarning says so.  sigma_N (T,): as measured.  places: of rows.
    Raises ValueError where the joint slides in the first row already, so that the start is not known.
    """
    ratio = tau / np.abs(sigma_N) if (sigma_N != 0.0).all() else tau
    top, steps = float(np.abs(ratio).max()), np.abs(np.diff(slip))
    share = float(np.abs(ratio[0])) / max(top, 1e-300)
    usual = float(np.median(steps[steps > 0.0])) if steps.any() else 0.0
    way = max((LATE if share >= SURELY else 0.5 * LATE) * usual, PART * float(np.ptp(slip)))
    state = f"where {share:.0%} of the largest traction acts"
    strong = int(np.argmax(np.abs(ratio) >= RESTING * top))
    zero = float(slip[0])
    if share < RESTING and slip[strong] != slip[0]:
        zero -= float(ratio[0] * (slip[strong] - slip[0]) / (ratio[strong] - ratio[0]))
    late = min(abs(zero), abs(float(slip[0]))) > way
    text = f"{places[0]}, column slip: {slip[0]:g}"
    if late and share >= RESTING:
        raise ValueError(f"{text} in the first row, {state}: expected slips from 0 on, as those of the model")
    warn_if(late, f"{text} {state}: the slip is counted from {zero:.4g} on")
    slip = slip - zero if late else slip
    if s_N is None:
        return slip, s_N
    noise = float(np.std(np.diff(s_N, 2))) / np.sqrt(6.0) if s_N.size > LEAST_NOISE else 0.0
    least = max(PART * float(np.ptp(s_N)), DEVIATIONS * noise)
    text, first = f"{places[0]}, column dilation: {s_N[0]:g}", slice(0, FIRST_ROWS)
    if share < SURELY:
        away = float(np.mean(slip[first] - slip[0]))
        rise = float(np.mean(s_N[first] - s_N[0])) / away if away else 0.0
        # what grows in proportion to the slip is no offset
        proportional = float(np.clip(rise * slip[0] / s_N[0], 0.0, 1.0)) if s_N[0] else 0.0
        start = float(s_N[0]) * (1.0 - proportional)
        offset = abs(start) > least
        warn_if(offset, f"{text} {state}: it is counted from {start:.4g} on")
        return slip, s_N - start if offset else s_N
    grows = s_N.size > FIRST_ROWS and (np.diff(slip[first]) * np.sign(slip[-1]) > 0.0).all()
    # rows in which most of the dilation happens are too far apart
    if grows and np.ptp(s_N[first]) < RESTING * np.ptp(s_N):
        start = float(np.polynomial.Polynomial.fit(slip[first], s_N[first], 2)(0.0))
        if start > 2.0 * least:
            wanted = "expected the change since the start of the slip"
            raise ValueError(
                f"{text} in the first row, where the rows lead to {start:.3g} at slip 0: {wanted}"
            )
    return slip, s_N


def loaded_until(slip: Floats, tau: Floats) -> int:
    """Number of rows before the unloading at the end of a test, of all rows (T,) where there is none.

    After the largest slip the traction falls without being reversed, and the slip returns by little.
    """
    size = np.abs(slip)
    top = int(np.argmax(size))
    side, after = float(np.sign(slip[top])), slice(top + 1, None)
    rest = side * tau[after]
    if not rest.size or side * tau[top] <= 0.0:
        return slip.size
    unloads = rest[-1] < UNLOADED * side * tau[top] and rest.min() > -OF_CYCLE * float(np.abs(tau).max())
    small = size[top] - size[after].min() < ELASTIC * float(np.ptp(slip))
    return top + 1 if unloads and small else slip.size
