"""Compressive strength of a joint in series with the NumPy reference, by bisection.

A plastic closure kappa >= 0 of the joint takes what its pressure p exceeds: the law sees s_N + kappa, and
p <= sqrt(fc(kappa)^2 - Css tau^2), 0 where the root is not real, with the tractions of the law.  kappa flows
along N only.  The state is that of the law and, behind it, kappa and the energy p dkappa.
"""

from __future__ import annotations

import functools
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from . import frozen, reference
from .plane import Floats, Parameters

BETWEEN = 60
"""Closures that are tried between that at the start and one at which nothing is exceeded."""


@dataclass(frozen=True)
class Cap:
    """Strength fc, energy Gfc of the softening, weight Css of the shear, closure kp at the peak, residual."""

    fc: float
    Gfc: float
    Css: float = 9.0
    kp: float = 0.0
    fcr: float = 0.1

    def strength(self, kappa: Floats) -> Floats:
        """Strength (Lourenco 1996) at a closure: a parabola from fc/3 to fc at kp, then an exponential."""
        falls = (1.0 - self.fcr) * self.fc
        softened = self.fcr * self.fc + falls * np.exp(-np.maximum(kappa - self.kp, 0.0) * falls / self.Gfc)
        if self.kp == 0.0:
            return softened
        x = np.minimum(kappa / self.kp, 1.0)
        return np.where(x < 1.0, self.fc * (1.0 + 2.0 * np.sqrt(2.0 * x - x * x)) / 3.0, softened)

    def largest_pressure(self, traction: Floats, kappa: Floats) -> Floats:
        """Largest pressure (...,) beside the shear of a traction (..., 3)."""
        left = self.strength(kappa) ** 2 - self.Css * (traction[..., 1] ** 2 + traction[..., 2] ** 2)
        return np.sqrt(np.maximum(left, 0.0))


AT_ONCE, MOST = 500, 31
"""Points whose law runs at once, and most closures of each that are tried at once."""

BITS = 55
"""Halvings of the bracket of a closure, two more than a number has."""

NEIGHBOURHOOD = 1e-3
"""Half width of what a secant leaves of a bracket, over its width."""

SECANTS = 8
"""Number of secants: six of them narrow a bracket 500^6 times, which is beyond NARROW."""

NARROW = 1e-14
"""Width of a bracket over its closure above which sections follow, as across a jump."""

Excess = Callable[[Floats], Floats]
"""What the pressure of points exceeds its bound by at closures (m, n)."""


def virgin(pattern: reference.Pattern, wears: bool = False) -> Floats:
    """State of a virgin point: that of the law, kappa and its energy."""
    return np.zeros(len(reference.virgin(pattern, wears)) + 2)


def update(
    parameters: Parameters,
    cap: Cap,
    pattern: reference.Pattern,
    s: Floats,
    state: Floats,
    s_old: Floats,
    dt: float = 0.0,
    tried: Floats | None = None,
) -> tuple[Floats, Floats]:
    """Traction (n, 3) and state of points after an increment; arguments as in `reference.update`.

    tried: closures (n,) that are tried, too: the excess may fall to zero between others and rise again.
    """
    of_law, kappa_old = state[:, :-2], state[:, -2]
    start = _closed(s_old, kappa_old)

    def exceeding(some: NDArray[np.intp]) -> Excess:
        """What the pressure of some points exceeds its bound by; below zero it is a tension."""
        seen = s[some]
        law = reference.tractions(parameters, pattern, of_law[some], start[some], dt)

        def excess(kappas: Floats) -> Floats:
            t = law(_closed(seen, kappas))
            return -t[..., 0] - cap.largest_pressure(t, kappas)

        return excess

    kappa = _smallest(exceeding, kappa_old, parameters.s0, tried)
    end = reference.update(parameters, pattern, _closed(s, kappa), of_law, start, dt, tangent=False)
    # wear by the work so far belongs to the increment, not to its start
    still = replace(parameters, W0=np.inf) if parameters.W0 > 0.0 else parameters
    begin = reference.update(still, pattern, start, of_law, start, tangent=False)
    pressures = np.maximum(-begin.traction[:, 0], 0.0) + np.maximum(-end.traction[:, 0], 0.0)
    spent = 0.5 * pressures * (kappa - kappa_old)
    if parameters.c == 0.0:
        # no more than the work leaves beside the other energies, of which friction is too much in a jump
        work = 0.5 * ((begin.traction + end.traction) * (s - s_old)).sum(axis=1)
        others = end.state[:, 1] - begin.state[:, 1] + (end.state - of_law)[:, 2:4].sum(axis=1)
        spent = np.maximum(np.minimum(spent, work - others), 0.0)
    return end.traction, np.column_stack([end.state, kappa, state[:, -1] + spent])


def frozen_traction(
    parameters: Parameters,
    cap: Cap,
    pattern: reference.Pattern,
    aim: Floats,
    s: Floats,
    state: Floats,
    s_old: Floats,
    dt: float = 0.0,
    tried: Floats | None = None,
) -> Floats:
    """Traction (n, 3) at s with the variables of the aim and its largest pressure; tried as in `update`."""
    at_aim, new = update(parameters, cap, pattern, aim, state, s_old, dt, tried)
    most = cap.largest_pressure(at_aim, new[:, -2])
    given = _closed(aim, new[:, -2]), state[:, :-2], _closed(s_old, state[:, -2])

    def exceeding(some: NDArray[np.intp]) -> Excess:
        """What the pressure of some points exceeds its bound by."""

        @functools.cache
        def law(m: int) -> Callable[[Floats], Floats]:
            """The law of m times these points."""
            return frozen.law(parameters, pattern, *(np.tile(a[some], (m, 1)) for a in given), dt)

        def excess(kappas: Floats) -> Floats:
            m = len(kappas)
            pressure = -law(m)(_closed(np.tile(s[some], (m, 1)), kappas.ravel()))[:, 0]
            return pressure.reshape(kappas.shape) - most[some]

        return excess

    kappa = _smallest(exceeding, state[:, -2], parameters.s0)
    return frozen.law(parameters, pattern, *given, dt)(_closed(s, kappa))


def _closed(s: Floats, kappa: Floats) -> Floats:
    """Separation (..., n, 3) that the law sees with a plastic closure (..., n)."""
    return s + kappa[..., None] * [1.0, 0.0, 0.0]


def _smallest(
    exceeding: Callable[[NDArray[np.intp]], Excess],
    start: Floats,
    length: float,
    tried: Floats | None = None,
) -> Floats:
    """Plastic closures (n,) from the start on at which nothing is exceeded, by sections.

    They are sought of the points alone that exceed something at the start.
    """
    kappa, every = start.copy(), np.arange(len(start))
    some = every[exceeding(every)(start[None])[0] > 0.0]
    if len(some):
        excess, further = exceeding(some), None if tried is None else tried[some]
        low, kappa[some] = _secants(excess, *_bracket(excess, start[some], length, further))
        left = kappa[some] - low > NARROW * kappa[some]
        if left.any():
            some = some[left]
            kappa[some] = _sections(exceeding(some), low[left], kappa[some])
    return kappa


def _at_once(n: int) -> int:
    """Closures of each of n points that are tried at once; many of few points."""
    return min(MOST, max(1, AT_ONCE // n))


def _between(excess: Excess, low: Floats, high: Floats, grid: Floats) -> tuple[Floats, ...]:
    """The last closure (n,) before the first of a grid (m, n) that exceeds nothing, this one, both excesses.

    An excess is NaN where the closure is not one of the grid.
    """
    below, above = np.full((2, len(low)), np.nan)
    for middle, value in zip(grid, excess(grid), strict=True):
        more, less = (value > 0.0) & (middle < high), (value <= 0.0) & (middle <= high)
        low, below = np.where(more, middle, low), np.where(more, value, below)
        high, above = np.where(less, middle, high), np.where(less, value, above)
    return low, high, below, above


def _bracket(excess: Excess, start: Floats, length: float, tried: Floats | None) -> tuple[Floats, Floats]:
    """Closures (n,) with an excess and, behind them, without one, of points with an excess at the start."""
    m = _at_once(len(start))
    growth, step, low, high = 1.5 ** np.arange(m)[:, None], 1e-4 * length, start, start
    exceeded = np.ones(len(start), dtype=bool)
    while exceeded.any():
        grid = start + step * growth
        above = excess(grid) > 0.0
        high = np.where(exceeded & ~above.all(0), grid[np.argmin(above, axis=0), np.arange(len(start))], high)
        exceeded = exceeded & above.all(0)
        step *= 1.5**m
    # an excess may fall below zero, rise and fall again: the first of some closures between
    first, last = low, high
    grid = first + np.linspace(0.0, 1.0, BETWEEN)[1:-1, None] * (last - first)
    if tried is not None:
        further = [tried, tried + 1e-12 * length, tried + 1e-9 * length]
        grid = np.sort(np.clip(np.vstack([grid, *further]), first, last), axis=0)
    for some in np.array_split(grid, -(-len(grid) // m)):
        low, high, *_ = _between(excess, low, high, some)
    return low, high


def _secants(excess: Excess, low: Floats, high: Floats) -> tuple[Floats, Floats]:
    """Brackets (n,) that are narrower: the neighbourhood of the root of a secant, or a half of them."""
    below, above = excess(np.array([low, high]))
    for _ in range(SECANTS):
        width = high - low
        root = low + width * below / np.where(below > above, below - above, 1.0)
        grid = np.array([root - NEIGHBOURHOOD * width, 0.5 * (low + high), root + NEIGHBOURHOOD * width])
        grid = np.sort(np.clip(grid, low, high), axis=0)
        low, high, *values = _between(excess, low, high, grid)
        below, above = (
            np.where(np.isnan(new), old, new) for new, old in zip(values, (below, above), strict=True)
        )
    return low, high


def _sections(excess: Excess, low: Floats, high: Floats) -> Floats:
    """Closures (n,) at the ends of brackets that are divided to the last bit."""
    m = _at_once(len(low))
    sections = np.arange(1, m + 1)[:, None] / (m + 1)
    for _ in range(int(np.ceil(BITS / np.log2(m + 1)))):
        low, high, *_ = _between(excess, low, high, low + sections * (high - low))
    return high
