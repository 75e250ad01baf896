"""Many confined slip tests at once: directions and normal tractions of an interface."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .. import contract
from ..contract import Floats
from ..interface import Interface
from ..parallel import map_in_order
from ..steps import slip_path

COLUMNS = 5  # columns of a curve: s_N, tau_L, tau_across, damage, work


@dataclass(frozen=True, eq=False)
class SlipCurves:
    """C curves of confined slip tests over T slips; rows without equilibrium are NaN.

    direction (C,), degrees; sigma_N (C,), stress; slips (T,) and s_N (C, T), length; tau_L (along the
    direction) and tau_across (left of it), (C, T), stress; damage (C, T); work (C, T) with that of the
    preload, stress*length; rows (C,): number of converged rows.
    """

    direction: Floats
    sigma_N: Floats
    slips: Floats
    s_N: Floats
    tau_L: Floats
    tau_across: Floats
    damage: Floats
    work: Floats
    rows: NDArray[np.int_]


def slip_curves(
    interface: Interface,
    direction: ArrayLike,
    slips: ArrayLike,
    sigma_N: ArrayLike = 0.0,
    preload: int = 100,
    executor: Executor | None = None,
) -> SlipCurves:
    """`Interface.confined_slip` for every pair of direction and sigma_N, which are broadcast to (C,).

    A curve that loses equilibrium ends there, without an error.  executor: as in `parallel.map_in_order`, by
    default a thread for each processor.  Raises ValueError for values that are not finite, an empty path and
    a preload below 1.
    """
    angles, held = np.broadcast_arrays(
        np.atleast_1d(contract.array("direction", direction)), contract.array("sigma_N", sigma_N)
    )
    s_L = contract.array("slips", slips)
    for name, value in (("direction", angles), ("sigma_N", held), ("slips", s_L)):
        if value.ndim != 1 or value.size == 0 or not np.all(np.isfinite(value)):
            raise ValueError(f"{name} has shape {value.shape}: expected a list of finite numbers")
    if preload < 1:
        raise ValueError(f"preload = {preload}: expected at least 1 increment")
    pairs = zip(angles.tolist(), held.tolist(), strict=True)
    done = map_in_order(partial(_solve, interface, s_L, int(preload)), pairs, executor)
    columns, n_done = map(np.array, zip(*done, strict=True))
    s_N, tau_L, tau_across, damage, work = np.moveaxis(columns, 1, 0)
    return SlipCurves(angles.copy(), held.copy(), s_L.copy(), s_N, tau_L, tau_across, damage, work, n_done)


def _solve(
    interface: Interface, slips: Floats, preload: int, pair: tuple[float, float]
) -> tuple[Floats, int]:
    """Columns of the curve of a direction and a normal traction, and the number of its rows."""
    angle, sigma_N = pair
    history, lost = interface.rows(slip_path(angle, slips, sigma_N, preload))
    in_preload = bool(lost) and len(history) < preload
    history = history.after_step(1)
    n = len(history)
    columns = np.full((COLUMNS, slips.size), np.nan)
    along, across = history.tau_along(angle), history.tau_along(angle + 90.0)
    columns[:, :n] = history.dilation, along, across, history.damage, history.work
    return columns, -1 if in_preload else n
