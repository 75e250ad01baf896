"""Newton's method without safeguards, as in an FE code: given increments, no cuts, no check of the branch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from asperity.contract import Floats
from asperity.interface import Interface
from numpy.typing import ArrayLike

ENDS = ("converged", "too many iterations", "singular matrix", "separation out of range")
"""Possible ends of an increment."""

TOLERANCE = 1e-10
"""Residual at which an increment has converged, over the strength plus the prescribed traction."""

SINGULAR = 1e-15
"""Smallest singular value of an invertible matrix, over the stiffness of the virgin interface."""

FARTHEST = 1e6
"""Largest separation over s_f plus the given separations; iterates beyond it diverge."""


@dataclass(frozen=True, eq=False)
class NewtonStudy:
    """Increments of one point, up to the first that fails.

    separation and traction (T, 3), state (T, nstatv): at the end of each increment, or of the last trial of a
    failed one.  residuals: before each iteration of an increment and at its end, over the strength plus the
    prescribed traction.  end: one of ENDS.
    """

    separation: Floats
    traction: Floats
    state: Floats
    residuals: tuple[Floats, ...]
    end: str

    @property
    def converged(self) -> bool:
        """Whether every increment converged."""
        return self.end == ENDS[0]

    @property
    def iterations(self) -> tuple[int, ...]:
        """Linear systems solved in each increment."""
        return tuple(max(len(known) - 1, 0) for known in self.residuals)


def newton_path(
    interface: Interface,
    targets: ArrayLike,
    given: Sequence[bool] = (True, False, False),
    tangent: str = "consistent",
    most: int = 25,
    spring: ArrayLike = (0.0, 0.0, 0.0),
) -> NewtonStudy:
    """Take one virgin point along targets (T, 3), each in one increment, until an increment fails.

    Where `given` is true for a component (N, Tx, Ty), the target is its traction plus spring (stress per
    length) times separation, elsewhere its separation.  tangent: "consistent", that of the law;
    "symmetrised", its symmetric part; "elastic", that of the virgin interface.  most: iterations of an
    increment.
    """
    targets, free, springs = np.asarray(targets, dtype=float), np.array(given), np.broadcast_to(spring, 3)
    virgin = old = interface.update(np.zeros((1, 3)))
    strength = min(interface.material.sigma0, interface.material.sigma02 or np.inf)
    farthest = FARTHEST * (interface.material.s_f + np.abs(targets[:, ~free]).max(initial=0.0))
    rows: list[tuple[Floats, Floats, Floats]] = []
    residuals, end, s_old = [], ENDS[0], np.zeros(3)
    for target in targets:
        s, new, sizes = np.where(free, s_old, target), old, []
        while True:
            if not np.abs(s).max() <= farthest:
                end = ENDS[3]
                break
            new = interface.update(s[None], old.state, s_old[None])
            residual = (new.traction[0] + springs * s - target)[free]
            sizes.append(np.abs(residual).max(initial=0.0) / (strength + np.abs(target[free]).sum()))
            if sizes[-1] <= TOLERANCE:
                break
            if len(sizes) > most:
                end = ENDS[1]
                break
            matrix = (virgin if tangent == "elastic" else new).tangent[0]
            if tangent == "symmetrised":
                matrix = 0.5 * (matrix + matrix.T)
            matrix = (matrix + np.diag(springs))[np.ix_(free, free)]
            if not np.linalg.svd(matrix, compute_uv=False)[-1] > SINGULAR * np.abs(virgin.tangent).max():
                end = ENDS[2]
                break
            s[free] -= np.linalg.solve(matrix, residual)
        rows.append((s, new.traction[0], new.state[0]))
        residuals.append(np.array(sizes))
        if end != ENDS[0]:
            break
        old, s_old = new, s
    return NewtonStudy(*map(np.array, zip(*rows, strict=True)), tuple(residuals), end)


def newton_study(
    interface: Interface, slips: ArrayLike, sigma_N: float, preload: int = 100, most: int = 25
) -> NewtonStudy:
    """Run a slip test along Tx by Newton's method without safeguards; the preload comes first.

    slips (T,), length, under the normal traction sigma_N, stress, which is applied in `preload` increments.
    """
    slips = np.asarray(slips, dtype=float)
    targets = np.zeros((preload + len(slips), 3))
    targets[:, 0] = sigma_N * np.minimum(1.0, np.arange(1, len(targets) + 1) / max(preload, 1))
    targets[preload:, 1] = slips
    return newton_path(interface, targets, most=most)


def work_along(separation: Floats, traction: Floats) -> Floats:
    """Work (T,) of a traction (T, 3) along separations (T, 3) that start at zero, by the trapezoidal rule."""
    before = np.concatenate([np.zeros((1, 3)), traction])[:-1]
    change = np.diff(separation, axis=0, prepend=0.0)
    return np.cumsum(0.5 * np.sum((before + traction) * change, axis=1))
