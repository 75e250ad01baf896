"""Error against the number of increments."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from ...contract import Floats
from ...interface import Interface
from ...parallel import Serial
from ...pattern import Pattern
from ...slip_curves import slip_curves
from ...style import COLOURS, TWO, new_figure
from .chart_axes import AIMS, log_axes, signed, table
from .common import (
    PATHS,
    PRELOAD,
    SIGMA_N,
    STEP_DIRECTION,
    Tick,
    largest,
    material,
    timed,
)


@dataclass(frozen=True)
class StepError:
    """Errors of one curve in tau_L, s_N and work, each relative to the largest value of the curve.

    seconds: time for the curve.
    """

    path: str
    sigma_N: float
    rows: int
    seconds: float
    tau_L: float
    s_N: float
    work: float


INCREMENTS = tuple(30 * 2**k for k in range(9))
"""Fixed increments, 30 to 7680."""

TIMES = 8
"""Number of curves in a timed run; the call itself takes as long as 100 increments."""

FINER = 8
"""Factor from the increments of the finest run to those of the reference."""


@dataclass(frozen=True, eq=False)
class _Path:
    """Curve over the length of the slip path (T,), mm, from 0 on; work at its end."""

    way: Floats
    tau_L: Floats
    s_N: Floats
    work: float


def step_errors(
    increments: Sequence[int] = INCREMENTS,
    repeats: int = 3,
    tick: Tick = lambda: None,
) -> Iterator[StepError]:
    """Errors of RP-4, 30 degrees."""
    interface = Interface(material(), Pattern.regular(4, 30.0))
    for path, slips in PATHS.items():
        for sigma_N in SIGMA_N:
            reference = _fixed(interface, slips(FINER * increments[-1]), sigma_N, 1)
            for n in increments:
                run, seconds = timed(lambda: _fixed(interface, slips(n), sigma_N, TIMES), repeats)  # noqa: B023
                yield _step_error(path, sigma_N, seconds / TIMES, run, reference)
                tick()


def _fixed(interface: Interface, slips: Floats, sigma_N: float, times: int) -> _Path:
    """Curves of a timed run, which computes the same curve several times."""
    curve = slip_curves(interface, np.full(times, STEP_DIRECTION), slips, sigma_N, PRELOAD, executor=Serial())
    return _Path(_way(slips), curve.tau_L[0], curve.s_N[0], float(curve.work[0, -1]))


def _way(s_L: Floats) -> Floats:
    return np.cumsum(np.abs(np.diff(s_L, prepend=0.0)))


def _step_error(path: str, sigma_N: float, seconds: float, run: _Path, reference: _Path) -> StepError:
    """Errors of a run compared with a run in fine increments; before the first slip tau_L is zero."""
    tau_L, s_N = (np.interp(run.way, reference.way, y) for y in (reference.tau_L, reference.s_N))
    return StepError(
        path,
        sigma_N,
        len(run.way),
        seconds,
        largest(run.tau_L - tau_L, reference.tau_L),
        largest(run.s_N - s_N, reference.s_N),
        abs(run.work / reference.work - 1.0),
    )


QUANTITIES = (("tau_L", r"$\tau_L$"), ("s_N", "$s_N$"), ("work", "work"))


def draw_increments(quick: bool, tick: Tick) -> tuple[dict[str, Figure], str]:
    """Run the study of increments; return its pictures by name and its tables."""
    sizes = (30, 60) if quick else INCREMENTS
    errors = list(step_errors(sizes, 1 if quick else 5, tick))
    figure, axes = new_figure(TWO, 4.6, nrows=2, ncols=3, sharex=True)
    for ax, (path, (name, label)) in zip(
        axes, [(path, q) for path in PATHS for q in QUANTITIES], strict=True
    ):
        _by_traction(ax, [e for e in errors if e.path == path], name)
        log_axes(ax, "increments of the path", f"relative error of {label}")
        _orders(ax, sizes)
        ax.set_title(path)
    axes[2].legend(title=r"$\sigma_N$ [MPa]")
    return {"increments": figure}, _increment_table(errors)


def _by_traction(ax: Axes, errors: Sequence[StepError], name: str) -> None:
    """Draw a line for each normal traction."""
    for i, sigma_N in enumerate(SIGMA_N):
        chosen = [e for e in errors if e.sigma_N == sigma_N]
        ax.plot(
            [e.rows for e in chosen],
            [getattr(e, name) for e in chosen],
            "o-",
            color=COLOURS[i],
            markersize=2.5,
            linewidth=1.0,
            label=signed(sigma_N),
        )


def _increment_table(errors: Sequence[StepError]) -> str:
    """Table: orders of convergence, and increments for each target error."""
    rows = []
    for path in PATHS:
        for sigma_N in SIGMA_N:
            here = [e for e in errors if (e.path, e.sigma_N) == (path, sigma_N)]
            cells = [_order(here, name) for name, _ in QUANTITIES]
            cells += [_text(_needed(here, n, aim), here) for n, _ in QUANTITIES for aim in AIMS[1:]]
            rows.append([path, signed(sigma_N), *cells])
    names = ("τ_L", "s_N", "work")
    head = ["path", "σ_N [MPa]", *(f"order, {q}" for q in names)]
    return table([*head, *(f"{q} to {aim:.0e}" for q in names for aim in AIMS[1:])], rows)


def _orders(ax: Axes, sizes: Sequence[int]) -> None:
    """Draw slopes of first and second order in the lower left corner, below the curves."""
    low = ax.get_ylim()[0]
    ax.set_ylim(bottom=low / 30.0)
    x = np.array([sizes[0], sizes[min(2, len(sizes) - 1)]], dtype=float)
    for order, style in ((1, ":"), (2, "-.")):
        y = low / 20.0 * (x / x[-1]) ** -order
        ax.plot(x, y, style, color="grey", linewidth=1.0)
        align = "top" if order == 1 else "bottom"
        ax.annotate(f"order {order}", (x[0], y[0]), color="grey", va=align)


def _order(chosen: Sequence[StepError], name: str) -> str:
    """Order of convergence by least squares."""
    x = np.log([e.rows for e in chosen])
    y = np.log([max(getattr(e, name), 1e-300) for e in chosen])
    return f"{-np.polyfit(x, y, 1)[0]:.1f}"


def _needed(chosen: Sequence[StepError], name: str, aim: float) -> StepError | None:
    """Coarsest run such that its error and those of all finer runs are below the target."""
    found = None
    for e in reversed(chosen):
        if not getattr(e, name) <= aim:
            break
        found = e
    return found


def _text(found: StepError | None, tried: Sequence[StepError]) -> str:
    return str(found.rows) if found else f"> {tried[-1].rows}"
