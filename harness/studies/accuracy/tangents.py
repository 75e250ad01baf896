"""Iterations and times of Newton's method with different tangents."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.pattern import Pattern, direction_vector
from asperity.style import COLOURS, LINES, TWO, new_figure
from matplotlib.figure import Figure

from ..newton import NewtonStudy, newton_path
from .chart_axes import log_axes, plain_labels, signed, table
from .common import (
    PRELOAD,
    STEP_DIRECTION,
    Tick,
    material,
    monotonic,
    timed,
)

TANGENTS = ("consistent", "symmetrised", "secant", "start", "elastic", "numerical")
"""Tangents of newton.TANGENTS without the wrong ones."""

TANGENT_INCREMENTS = 60
"""Increments of the path in the study of tangents, with errors of about 1e-3."""

TOLERANCES = tuple(10.0**-k for k in range(1, 13))
"""Tolerances on the residual over the strength plus the prescribed traction."""

MOST_ITERATIONS = 1000
"""Largest number of iterations of an increment."""

SPRING = 1.0
"""Stiffness of the springs that shear the interface, over K."""


@dataclass(frozen=True, eq=False)
class TangentRun:
    """Load path solved by Newton's method with a tangent, without safeguards.

    mean, most: iterations of an increment; updates: of the law; seconds: of the path; residuals: of the
    increment in the middle of the path; end: one of newton.ENDS.
    """

    tangent: str
    sigma_N: float
    increments: int
    tolerance: float
    mean: float
    most: int
    updates: int
    seconds: float
    residuals: Floats
    end: str


def tangent_run(
    tangent: str, sigma_N: float, increments: int, tolerance: float, repeats: int = 5
) -> TangentRun:
    """RP-4 under a constant sigma_N, sheared along 20 degrees by springs: three unknown separations."""
    interface = Interface(material(), Pattern.regular(4, 30.0))
    spring = SPRING * material().K
    targets = np.zeros((PRELOAD + increments, 3))
    targets[:, 0] = sigma_N * np.minimum(1.0, np.arange(1, len(targets) + 1) / PRELOAD)
    targets[PRELOAD:, 1:] = np.outer(spring * monotonic(increments), direction_vector(STEP_DIRECTION))

    def solve() -> NewtonStudy:
        return newton_path(
            interface, targets, (True, True, True), tangent, tolerance, MOST_ITERATIONS, (0.0, spring, spring)
        )

    study, seconds = timed(solve, repeats)
    used = study.iterations[PRELOAD:] or study.iterations
    middle = min(PRELOAD + increments // 2, len(study.residuals) - 1)
    return TangentRun(
        tangent,
        sigma_N,
        increments,
        tolerance,
        float(np.mean(used)),
        max(used),
        sum(study.updates),
        seconds,
        study.residuals[middle],
        study.end,
    )


TANGENT_SIGMA_N = -5.0
"""Normal traction of the pictures of tangents, MPa."""

STRICT = 1.0e-10
"""Tolerance on the residual in the tables of tangents."""


def draw_tangents(quick: bool, tick: Tick) -> tuple[dict[str, Figure], str]:
    """Run the study of tangents; return its picture by name and its table."""
    n = 10 if quick else TANGENT_INCREMENTS
    tolerances = (1e-2, STRICT) if quick else TOLERANCES
    sizes = (5, 10) if quick else (15, 30, 60, 120, 240, 480, 960)
    repeats = 1 if quick else 20

    def run(tangent: str, sigma_N: float, increments: int, tolerance: float) -> TangentRun:
        found = tangent_run(tangent, sigma_N, increments, tolerance, repeats)
        tick()
        return found

    figure, axes = new_figure(TWO, 3.2, ncols=3)
    for i, tangent in enumerate(TANGENTS):
        style = {"color": COLOURS[i], "markersize": 2.5, "label": tangent}
        marker = "osD^vx"[i] + LINES[i % len(LINES)]
        strict = run(tangent, TANGENT_SIGMA_N, n, STRICT)
        axes[0].semilogy(strict.residuals[:40], marker, **style)
        by_size = [run(tangent, TANGENT_SIGMA_N, size, STRICT) for size in sizes]
        whole = [r for r in by_size if r.end == "converged"]
        axes[1].plot([r.increments for r in whole], [r.mean for r in whole], marker, **style)
        by_tolerance = [run(tangent, TANGENT_SIGMA_N, n, tolerance) for tolerance in tolerances]
        whole = [r for r in by_tolerance if r.end == "converged"]
        axes[2].plot([r.updates for r in whole], [r.tolerance for r in whole], marker, **style)
    axes[0].set_xlabel("iteration of the increment in the middle")
    axes[0].set_ylabel("residual [-]")
    axes[0].set_ylim(1e-14, 0.1)
    axes[0].grid(alpha=0.3)
    log_axes(axes[1], "increments of the path", "iterations of an increment")
    plain_labels(axes[1].yaxis)
    log_axes(axes[2], "updates of the law on the path", "residual accepted [-]")
    plain_labels(axes[2].xaxis)
    handles, texts = axes[0].get_legend_handles_labels()
    figure.legend(handles, texts, loc="outside lower center", ncols=6)
    rows = []
    for sigma_N in (-1.0, -5.0, -10.0):
        runs = [run(tangent, sigma_N, n, STRICT) for tangent in TANGENTS]
        for r in runs:
            numbers = [f"{r.mean:.1f}", str(r.most), str(r.updates), f"{1e3 * r.seconds:.2f}"]
            numbers += [f"{r.seconds / runs[0].seconds:.1f}", r.end]
            rows.append([r.tangent, signed(sigma_N), *numbers])
    head = ["tangent", "σ_N [MPa]", "iterations, mean", "most", "updates", "ms", "ratio of times", "end"]
    return {"tangents": figure}, table(head, rows)
