"""Newton's method without safeguards, as in an FE code: given increments, no cuts, no check of the branch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from asperity import contract
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.pattern import direction_vector
from numpy.typing import ArrayLike

TANGENTS = ("consistent", "symmetrised", "secant", "lagged", "elastic")
"""Matrices: that of the law; its symmetric part; traction over separation at constant damage and slip; that
of the law at the start of the increment (modified Newton); that of the virgin interface."""

ENDS = ("converged", "too many iterations", "singular matrix", "separation out of range")
"""Possible ends of an increment."""

SINGULAR = 1e-15
"""Smallest singular value of an invertible matrix, over the stiffness of the virgin interface."""

FARTHEST = 1e6
"""Largest separation over s_f plus the given separations; iterates beyond it diverge."""


@dataclass(frozen=True, eq=False)
class NewtonStudy:
    """Increments of one point, up to the first that fails.

    separation and traction (T, 3), state (T, nstatv): at the end of each increment, or of the last trial of a
    failed one.  iterations (T,): linear systems solved.  residuals: before each iteration of an increment and
    at its end, over the strength plus the prescribed traction.  end: one of ENDS.
    """

    separation: Floats
    traction: Floats
    state: Floats
    iterations: tuple[int, ...]
    residuals: tuple[Floats, ...]
    end: str

    @property
    def converged(self) -> bool:
        """Whether every increment converged."""
        return self.end == ENDS[0]


def newton_paths(
    interface: Interface,
    targets: ArrayLike,
    given: Sequence[bool] = (True, False, False),
    tangent: str = "consistent",
    tolerance: float = 1e-10,
    most: int = 25,
    spring: ArrayLike = (0.0, 0.0, 0.0),
    dt: float | None = None,
) -> list[NewtonStudy]:
    """Take n virgin points along targets (T, n, 3), each in one increment, until an increment fails.

    Where `given` is true for a component (N, Tx, Ty), the target is its traction plus spring (stress per
    length) times separation, elsewhere its separation.  tolerance: residual over strength plus prescribed
    traction; most: iterations of an increment; dt: duration of an increment, required if tau_v > 0.  Raises
    ValueError for wrong shapes and names.
    """
    targets = np.asarray(targets, dtype=float)
    if targets.ndim != 3 or targets.shape[2] != 3 or not np.isfinite(targets).all():
        raise ValueError(f"targets have shape {targets.shape}: expected (T, n, 3) of finite numbers")
    if tangent not in TANGENTS:
        raise ValueError(f"tangent = {tangent!r}: expected one of {', '.join(TANGENTS)}")
    if not (tolerance > 0.0 and most >= 1):
        raise ValueError(f"tolerance = {tolerance:g}, most = {most}: expected > 0 and at least 1 iteration")
    free, springs = np.array(given, dtype=bool), np.diag(np.broadcast_to(spring, 3))
    count = targets.shape[1]
    virgin = interface.update(np.zeros((count, 3)), dt=dt)
    stiffness = np.abs(virgin.tangent).max(initial=0.0)
    strength = min(interface.material.sigma0, interface.material.sigma02 or np.inf)
    farthest = FARTHEST * (interface.material.s_f + np.abs(targets[..., ~free]).max(initial=0.0))
    old = _Points(np.zeros((count, 3)), virgin.traction, np.zeros_like(virgin.state), virgin.tangent)
    rows: list[list[tuple[Floats, Floats, Floats, Floats]]] = [[] for _ in range(count)]
    ends = np.zeros(count, dtype=int)
    for target in targets:
        left = np.flatnonzero(ends == 0)
        if not left.size:
            break
        new, target = old.chosen(left), target[left]
        scale = strength + np.abs(target[:, free]).sum(axis=1)
        new.s[:, ~free] = target[:, ~free]
        residuals = np.full((left.size, most + 1), np.nan)
        todo = np.arange(left.size)  # places in `new` of the points that have not converged
        for iteration in range(most + 1):
            far = ~(np.abs(new.s[todo]).max(axis=1) <= farthest)
            ends[left[todo[far]]] = 3
            todo = todo[~far]
            if not todo.size:
                break
            before = left[todo]
            found = interface.update(new.s[todo], old.state[before], old.s[before], dt)
            new.t[todo], new.state[todo], new.tangent[todo] = found.traction, found.state, found.tangent
            residual = (found.traction + new.s[todo] @ springs - target[todo])[:, free]
            size = np.abs(residual).max(axis=1, initial=0.0) / scale[todo]
            residuals[todo, iteration] = size
            bad = size > tolerance
            todo, residual = todo[bad], residual[bad]
            if not todo.size or iteration == most:
                ends[left[todo]] = 1
                break
            if tangent == "secant":
                matrix = _secant(interface, old.state[before[bad]], new.state[todo], new.s[todo])
            elif tangent in ("lagged", "elastic"):
                matrix = (old if tangent == "lagged" else virgin).tangent[before[bad]]
            else:
                matrix = new.tangent[todo]
            if tangent == "symmetrised":
                matrix = 0.5 * (matrix + matrix.transpose(0, 2, 1))
            matrix = (matrix + springs)[:, free][:, :, free]
            least = np.abs(matrix[:, 0, 0])
            if matrix.shape[1] > 1:
                least = np.linalg.svd(matrix, compute_uv=False)[:, -1]
            singular = ~(least > SINGULAR * stiffness)
            ends[left[todo[singular]]] = 2
            todo = todo[~singular]
            change = np.linalg.solve(matrix[~singular], -residual[~singular][..., None])[..., 0]
            new.s[np.ix_(todo, free)] += change
        for i, point in enumerate(left):
            known = residuals[i][np.isfinite(residuals[i])]
            rows[point].append((new.s[i].copy(), new.t[i].copy(), new.state[i].copy(), known))
        for name in ("s", "t", "state", "tangent"):
            getattr(old, name)[left] = getattr(new, name)
    return [_study(interface, one, ENDS[end]) for one, end in zip(rows, ends, strict=True)]


def newton_path(interface: Interface, targets: ArrayLike, *arguments: object, **named: object) -> NewtonStudy:
    """Take one virgin point along targets (T, 3); the other arguments are those of `newton_paths`."""
    targets = np.asarray(targets, dtype=float)
    if targets.ndim != 2:
        raise ValueError(f"targets have shape {targets.shape}: expected (T, 3)")
    (study,) = newton_paths(interface, targets[:, None], *arguments, **named)  # type: ignore[arg-type]
    return study


def newton_study(
    interface: Interface, direction: float, slips: ArrayLike, sigma_N: float, preload: int = 100,
    tangent: str = "consistent", **named: object,
) -> NewtonStudy:  # fmt: skip
    """Run `Interface.confined_slip` by Newton's method without safeguards; the preload comes first.

    slips (T,), length, along direction (degrees) under the normal traction sigma_N, stress, which is
    applied in `preload` increments; the other arguments are those of `newton_paths`.
    """
    return newton_path(interface, slip_targets(direction, slips, sigma_N, preload), tangent=tangent, **named)


def slip_targets(direction: float, slips: ArrayLike, sigma_N: float, preload: int) -> Floats:
    """Targets (preload + T, 3) of a slip test: the normal traction, then the slips."""
    slips = np.asarray(slips, dtype=float)
    targets = np.zeros((preload + len(slips), 3))
    targets[:, 0] = sigma_N * np.minimum(1.0, np.arange(1, len(targets) + 1) / max(preload, 1))
    targets[preload:, 1:] = np.outer(slips, direction_vector(direction))
    return targets


@dataclass(eq=False)
class _Points:
    """Separation and traction (n, 3), state (n, nstatv) and tangent (n, 3, 3) of points."""

    s: Floats
    t: Floats
    state: Floats
    tangent: Floats

    def __post_init__(self) -> None:
        """Copy the arrays, which change."""
        self.s, self.t, self.state, self.tangent = map(np.array, (self.s, self.t, self.state, self.tangent))

    def chosen(self, which: np.ndarray) -> _Points:
        """Some of the points."""
        return _Points(self.s[which], self.t[which], self.state[which], self.tangent[which])


def _study(interface: Interface, rows: list[tuple[Floats, Floats, Floats, Floats]], end: str) -> NewtonStudy:
    """Rows of one point as arrays."""
    s, t, state, residuals = ([row[i] for row in rows] for i in range(4))
    return NewtonStudy(
        np.array(s).reshape(-1, 3),
        np.array(t).reshape(-1, 3),
        np.array(state).reshape(-1, interface.nstatv),
        tuple(max(len(known) - 1, 0) for known in residuals),
        tuple(residuals),
        end,
    )


def _secant(interface: Interface, before: Floats, state: Floats, s: Floats) -> Floats:
    """Sum (3) over the planes of bond and contact as springs, at the damage and the slip of a state.

    The friction of a plane counts as a spring, too: the elastic part of its slip over the trial (30).
    """
    material, normals, weights = interface.material, interface.pattern.normals, interface.pattern.weights
    if material.sigma02 or material.Gc2 or material.height or material.W0:
        raise ValueError("tangent = 'secant': expected straight planes, with mode II like mode I")
    state_of = [contract.plane_statev(k + 1) for k in range(len(weights))]
    alpha = state[:, state_of]
    slips = [np.stack([one[:, [i + 1, i + 2]] for i in state_of], axis=1) for one in (before, state)]
    s_n = s @ normals.T
    level = np.hypot(*normals[:, 1:].T)[:, None]
    across = normals[:, [0, 2, 1]] * [0.0, -1.0, 1.0] / np.where(level > 0.0, level, 1.0)
    across = np.where(level > 0.0, across, [0.0, 0.0, 1.0])
    up = np.where(level > 0.0, np.cross(normals, across), [0.0, 1.0, 0.0])
    s_t = np.stack([s @ up.T, s @ across.T], axis=-1)
    trial, kept = (np.linalg.norm(s_t - slip, axis=-1) for slip in slips)
    share = np.divide(kept, trial, out=(s_n <= 0.0).astype(float), where=trial > 0.0)
    along = material.K * (1.0 - alpha + alpha * share) * weights
    across_planes = np.where(s_n < 0.0, material.kc, 1.0 - alpha) * material.K * weights - along
    products = normals[:, :, None] * normals[:, None, :]
    return np.einsum("nk,kij->nij", across_planes, products) + along.sum(axis=1)[:, None, None] * np.eye(3)


def work_along(separation: Floats, traction: Floats) -> Floats:
    """Work (T,) of a traction (T, 3) along separations (T, 3) that start at zero, by the trapezoidal rule."""
    before = np.concatenate([np.zeros((1, 3)), traction])[:-1]
    change = np.diff(separation, axis=0, prepend=0.0)
    return np.cumsum(0.5 * np.sum((before + traction) * change, axis=1))
