"""Load paths, times and errors that the work-precision studies share."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np
from asperity.contract import Floats
from asperity.material import Material

SIGMA_N = (0.0, -1.0, -5.0, -10.0)
"""Normal tractions, MPa."""

SLIP = 0.6
"""Slip of a monotonic path, mm."""

AMPLITUDE = 0.4
"""Amplitude A of a cycle 0, +A, -A, +A, mm."""

STEP_DIRECTION = 20.0
"""Direction of slip, degrees, which is no plane of symmetry of RP-4."""

PRELOAD = 4
"""Increments of the preload. Each plane slides in one direction only, so a few increments are exact."""

Tick = Callable[[], object]
"""Function that is called after each piece of work, for a progress bar."""


def material(mu: float = 0.5) -> Material:
    """Material of Table 2 with another friction coefficient."""
    return Material(sigma0=3.0, Gc=0.3, eta=0.9, mu=mu)


def monotonic(increments: int) -> Floats:
    """Slips of a monotonic path."""
    return SLIP * np.arange(1, increments + 1) / increments


def cycle(increments: int) -> Floats:
    """Slips of a cycle 0, +A, -A, +A; increments is a multiple of 5."""
    k = increments // 5
    up, down = np.arange(1, k + 1) / k, 1.0 - np.arange(1, 2 * k + 1) / k
    return AMPLITUDE * np.concatenate([up, down, -down])


PATHS: dict[str, Callable[[int], Floats]] = {"monotonic": monotonic, "cyclic": cycle}
"""Paths by name."""

TURNS = {"monotonic": (SLIP,), "cyclic": (AMPLITUDE, -AMPLITUDE, AMPLITUDE)}
"""Reversals and end of each path, mm."""


Result = TypeVar("Result")


def timed(run: Callable[[], Result], repeats: int) -> tuple[Result, float]:
    """Result of a run on one thread, and its shortest processor time, s."""
    best = np.inf
    for _ in range(repeats):
        start = time.process_time()
        result = run()
        best = min(best, time.process_time() - start)
    return result, best


def relative(error: Floats, reference: Floats) -> float:
    """Largest ratio, over the curves, of the L2 norm of the error to that of the reference."""
    size = np.sqrt(np.nansum(reference**2, axis=-1))
    return float(np.max(np.sqrt(np.nansum(error**2, axis=-1)) / size))


def largest(error: Floats, reference: Floats) -> float:
    """Largest error over the largest value of the reference."""
    return float(np.abs(error).max() / np.abs(reference).max())
