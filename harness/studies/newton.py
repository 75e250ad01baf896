"""Newton's method without safeguards, as in an FE code, to measure tangents and steps on one point."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import count, takewhile

import numpy as np
from asperity import _core
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.pattern import direction_vector
from numpy.typing import ArrayLike

TANGENTS: tuple[str, ...] = tuple(
    takewhile(bool, (_core.newton_tangent(kind).decode("ascii").rstrip() for kind in count(1)))
)
"""Matrices that Newton's method can use (module asperity_naive_newton): consistent, symmetrised, transposed,
secant, start (of the increment), elastic (virgin), numerical (differences), zero, reversed (wrong sign)."""

ENDS = ("converged", "too many iterations", "singular matrix", "separation out of range")
"""Possible ends of an increment."""


@dataclass(frozen=True, eq=False)
class NewtonStudy:
    """Increments of Newton's method without safeguards, up to the first that fails.

    separation and traction (T, 3), state (T, nstatv): at the end of each increment, or of the last trial of a
    failed one.  iterations (T,): linear systems solved.  updates (T,): of the law.  residuals: of every
    increment, before each iteration and at its end, over the strength plus the prescribed traction.  end: one
    of ENDS.
    """

    separation: Floats
    traction: Floats
    state: Floats
    iterations: tuple[int, ...]
    updates: tuple[int, ...]
    residuals: tuple[Floats, ...]
    end: str

    @property
    def converged(self) -> bool:
        """Whether every increment converged."""
        return self.end == ENDS[0]


def newton_path(
    interface: Interface,
    targets: ArrayLike,
    held: Sequence[bool] = (True, False, False),
    tangent: str = "consistent",
    tolerance: float = 1e-10,
    most: int = 25,
    spring: ArrayLike = (0.0, 0.0, 0.0),
    dt: float | None = None,
) -> NewtonStudy:
    """Take a virgin point along targets (T, 3), each in one increment, until an increment does not converge.

    Where `held` is true for a component (N, Tx, Ty), the target is its traction plus spring (stress per
    length) times separation, elsewhere its separation.  tolerance: residual over strength plus prescribed
    traction; most: iterations of an increment; dt: duration of an increment, required if tau_v > 0.  Raises
    ValueError for wrong shapes and names.
    """
    targets = np.asarray(targets, dtype=float, order="C")
    if targets.ndim != 2 or targets.shape[1] != 3 or not np.isfinite(targets).all():
        raise ValueError(f"targets have shape {targets.shape}: expected (T, 3) of finite numbers")
    if tangent not in TANGENTS:
        raise ValueError(f"tangent = {tangent!r}: expected one of {', '.join(TANGENTS)}")
    if not (tolerance > 0.0 and most >= 1):
        raise ValueError(f"tolerance = {tolerance:g}, most = {most}: expected > 0 and at least 1 iteration")
    if dt is None and interface.material.tau_v > 0.0:
        raise ValueError(f"dt is missing: expected for viscous damage, tau_v = {interface.material.tau_v:g}")
    n = len(targets)
    separation, traction = np.zeros((n, 3)), np.zeros((n, 3))
    state, residuals = np.zeros((n, interface.nstatv)), np.full((n, most + 1), -1.0)
    iterations, updates = np.zeros(n, dtype=np.int32), np.zeros(n, dtype=np.int32)
    done = ended = 0
    if n > 0:  # f2py accepts no empty arrays
        done, ended = _core.newton_path(
            interface._props, np.asarray(held, dtype=np.int32), np.asarray(spring, dtype=float), targets.T,
            np.full(n, dt or 0.0), TANGENTS.index(tangent) + 1, tolerance,
            separation.T, traction.T, state.T, iterations, updates, residuals.T,
        )  # fmt: skip
    rows = min(done + 1, n)
    return NewtonStudy(
        separation[:rows],
        traction[:rows],
        state[:rows],
        tuple(iterations[:rows].tolist()),
        tuple(updates[:rows].tolist()),
        tuple(row[row >= 0.0] for row in residuals[:rows]),
        ENDS[ended],
    )


def newton_study(
    interface: Interface,
    direction_deg: float,
    slips: ArrayLike,
    sigma_N: float,
    preload: int = 100,
    tangent: str = "consistent",
    tolerance: float = 1e-10,
    most: int = 25,
    dt: float | None = None,
) -> NewtonStudy:
    """Run `Interface.confined_slip` by Newton's method without safeguards; the preload comes first.

    slips (T,), length, along direction_deg (degrees) under the normal traction sigma_N, stress, which is
    applied in `preload` increments. Raises ValueError as `newton_path` does.
    """
    slips = np.asarray(slips, dtype=float)
    targets = np.zeros((preload + len(slips), 3))
    targets[:, 0] = sigma_N * np.minimum(1.0, np.arange(1, len(targets) + 1) / max(preload, 1))
    targets[preload:, 1:] = np.outer(slips, direction_vector(direction_deg))
    return newton_path(interface, targets, tangent=tangent, tolerance=tolerance, most=most, dt=dt)
