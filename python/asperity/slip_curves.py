"""Many confined slip tests at once: directions and normal tractions of an interface, on all processors."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, contract
from .contract import Floats
from .interface import Interface
from .pattern import direction_vector

ROW = 6
"""Numbers of a row: s_N, the three components of the traction, damage, work."""


@dataclass(frozen=True, eq=False)
class SlipCurves:
    """C curves of confined slip tests over T slips; rows without equilibrium are NaN.

    direction (C,), degrees; sigma_N (C,), stress; slips (T,) and s_N (C, T), length; tau_L (along the
    direction) and tau_across (left of it), (C, T), stress; damage (C, T); work (C, T) with that of the
    preload, stress*length; rows (C,): number of converged rows; iterations (C,) of Newton's method.
    """

    direction: Floats
    sigma_N: Floats
    slips: Floats
    s_N: Floats
    tau_L: Floats
    tau_across: Floats
    damage: Floats
    work: Floats
    rows: NDArray[np.int32]
    iterations: NDArray[np.int32]


def slip_curves(
    interface: Interface,
    direction_deg: ArrayLike,
    slips: ArrayLike,
    sigma_N: ArrayLike = 0.0,
    preload: int = 100,
    threads: int | None = None,
) -> SlipCurves:
    """`Interface.confined_slip` for every pair of direction_deg and sigma_N, which are broadcast to (C,).

    A curve that loses equilibrium ends there, without an error.  threads: by default one for each processor.
    Raises ValueError for values that are not finite, an empty path and a preload below 1.
    """
    angles, held = np.broadcast_arrays(
        np.atleast_1d(contract.array("direction_deg", direction_deg)), contract.array("sigma_N", sigma_N)
    )
    s_L = contract.array("slips", slips)
    for name, value in (("direction_deg", angles), ("sigma_N", held), ("slips", s_L)):
        if value.ndim != 1 or value.size == 0 or not np.all(np.isfinite(value)):
            raise ValueError(f"{name} has shape {value.shape}: expected a list of finite numbers")
    if preload < 1:
        raise ValueError(f"preload = {preload}: expected at least 1 increment")
    props = interface.props()
    count, workers = angles.size, threads or os.cpu_count() or 1
    rows, free = np.empty((count, s_L.size, ROW)), np.zeros(count)

    def solve(part: Sequence[int]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
        block = slice(part[0], part[-1] + 1)
        return _core.interface_slip_curves(
            props, angles[block].copy(), held[block].copy(), free[block], s_L, int(preload), rows[block].T
        )

    # several chunks for each worker, because curves differ in their cost
    parts = [range(count)[i : i + _part(count, workers)] for i in range(0, count, _part(count, workers))]
    if workers == 1 or len(parts) == 1:
        done = [solve(part) for part in parts]
    else:
        with ThreadPoolExecutor(workers) as pool:
            done = list(pool.map(solve, parts))
    n_done = np.concatenate([np.atleast_1d(part[0]) for part in done])
    iterations = np.concatenate([np.atleast_1d(part[1]) for part in done])

    rows[np.arange(s_L.size)[None, :] >= n_done[:, None]] = np.nan
    s_N, _, t_x, t_y, damage, work = np.moveaxis(rows, -1, 0)
    e_x, e_y = direction_vector(angles).T
    return SlipCurves(
        angles.copy(),
        held.copy(),
        s_L.copy(),
        s_N,
        t_x * e_x[:, None] + t_y * e_y[:, None],
        t_y * e_x[:, None] - t_x * e_y[:, None],
        damage,
        work,
        n_done,
        iterations,
    )


def _part(count: int, workers: int) -> int:
    return max(1, count // (4 * workers))
