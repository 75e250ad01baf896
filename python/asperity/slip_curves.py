"""Many confined slip tests at once: directions and normal tractions of an interface."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from . import _core, contract
from .contract import Floats
from .interface import Interface
from .parallel import map_in_order
from .pattern import direction_vector

ROW = 6
"""Numbers of a row: s_N, the three components of the traction, damage, work."""

PARTS = 32
"""Number of tasks of many curves, more than workers, because curves differ in their cost."""


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
    executor: Executor | None = None,
) -> SlipCurves:
    """`Interface.confined_slip` for every pair of direction_deg and sigma_N, which are broadcast to (C,).

    A curve that loses equilibrium ends there, without an error.  executor: as in `parallel.map_in_order`, by
    default a thread for each processor.  Raises ValueError for values that are not finite, an empty path and
    a preload below 1.
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
    size = max(1, angles.size // PARTS)
    blocks = [(angles[i : i + size], held[i : i + size]) for i in range(0, angles.size, size)]
    done = map_in_order(partial(_solve, interface.props(), s_L, int(preload)), blocks, executor)
    rows, n_done, iterations = (np.concatenate(part) for part in zip(*done, strict=True))

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


def _solve(
    props: Floats, slips: Floats, preload: int, block: tuple[Floats, Floats]
) -> tuple[Floats, NDArray[np.int32], NDArray[np.int32]]:
    """Rows of the curves of a block of directions and normal tractions, their number, and iterations."""
    angles, held = (np.array(part) for part in block)
    rows = np.empty((angles.size, slips.size, ROW))
    counts = _core.interface_slip_curves(props, angles, held, np.zeros(angles.size), slips, preload, rows.T)
    n_done, iterations = (np.atleast_1d(count) for count in counts)
    return rows, n_done, iterations
