"""Where a test ends: rows in which the box is unloaded are none of the slip."""

from __future__ import annotations

import numpy as np

from ...contract import Floats

UNLOADED, REVERSED, RETURN = 0.5, 0.05, 0.1
"""Traction of the last row over that at the largest slip below which the joint was unloaded; reversed
traction over the largest one that belongs to a cycle; return of the slip over its range that is more than
elastic.
"""


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
    unloads = rest[-1] < UNLOADED * side * tau[top] and rest.min() > -REVERSED * float(np.abs(tau).max())
    small = size[top] - size[after].min() < RETURN * float(np.ptp(slip))
    return top + 1 if unloads and small else slip.size
