"""Error against the number of increments, fixed and adaptive."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from asperity import _core
from asperity.contract import Floats
from asperity.interface import Interface
from asperity.parallel import Serial
from asperity.pattern import Pattern, direction_vector
from asperity.slip_curves import slip_curves
from asperity.style import COLOURS, TWO, new_figure
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from .chart_axes import AIMS, log_axes, signed, table
from .common import (
    PATHS,
    PRELOAD,
    SIGMA_N,
    STEP_DIRECTION,
    TURNS,
    Tick,
    largest,
    material,
    timed,
)


@dataclass(frozen=True)
class StepError:
    """Errors of one curve in tau_L, s_N and work, each relative to the largest value of the curve.

    line: error of tau_L with straight lines between the rows. seconds: time for the curve. tolerance:
    tolerance of adaptive increments, 0 for fixed increments.
    """

    path: str
    sigma_N: float
    tolerance: float
    rows: int
    seconds: float
    tau_L: float
    s_N: float
    work: float
    line: float


INCREMENTS = tuple(30 * 2**k for k in range(9))
"""Fixed increments, 30 to 7680."""

STEP_TOLERANCES = tuple(10.0 ** -(k / 2.0) for k in range(3, 11))
"""Tolerances of adaptive increments."""

TIMES = 8
"""Number of curves in a timed run; the call itself takes as long as 100 increments."""

FINER = 8
"""Factor from the increments of the finest run to those of the reference."""

ROOM = 8192
"""Largest number of rows of adaptive increments."""


@dataclass(frozen=True, eq=False)
class _Path:
    """Curve over the length of the slip path (T,), mm, from 0 on; work at its end."""

    way: Floats
    tau_L: Floats
    s_N: Floats
    work: float


def step_errors(
    increments: Sequence[int] = INCREMENTS,
    tolerances: Sequence[float] = STEP_TOLERANCES,
    repeats: int = 3,
    tick: Tick = lambda: None,
) -> Iterator[StepError]:
    """Errors of RP-4, 30 degrees, with fixed and with adaptive increments."""
    interface = Interface(material(), Pattern.regular(4, 30.0))
    for path, slips in PATHS.items():
        for sigma_N in SIGMA_N:
            reference = _fixed(interface, slips(FINER * increments[-1]), sigma_N, 1)
            for n in increments:
                run, seconds = timed(lambda: _fixed(interface, slips(n), sigma_N, TIMES), repeats)  # noqa: B023
                yield _step_error(path, sigma_N, 0.0, seconds / TIMES, run, reference)
                tick()
            for tolerance in tolerances:
                run, seconds = timed(
                    lambda: _adaptive(interface, TURNS[path], sigma_N, tolerance),  # noqa: B023
                    repeats,
                )
                yield _step_error(path, sigma_N, tolerance, seconds, run, reference)
                tick()


def _fixed(interface: Interface, slips: Floats, sigma_N: float, times: int) -> _Path:
    """Curves of a timed run, which computes the same curve several times."""
    curve = slip_curves(interface, np.full(times, STEP_DIRECTION), slips, sigma_N, PRELOAD, executor=Serial())
    return _Path(_way(slips), curve.tau_L[0], curve.s_N[0], float(curve.work[0, -1]))


def _adaptive(interface: Interface, turns: Sequence[float], sigma_N: float, tolerance: float) -> _Path:
    """Adaptive increments by the compiled routine, without the conversion of the rows in Python."""
    separation, traction = np.empty((ROOM, 3)), np.empty((ROOM, 3))
    state, work = np.empty((ROOM, interface.nstatv)), np.empty(ROOM)
    rows, reached, status, message = _core.interface_adaptive_slip(
        interface.props(), STEP_DIRECTION, np.array(turns), sigma_N, tolerance, np.zeros(len(turns)), 0.0,
        separation.T, traction.T, state.T, work,
    )  # fmt: skip
    if status != 0 or reached < len(turns) or rows > ROOM:
        raise ValueError(
            f"{rows} rows: expected at most {ROOM}, up to slip {turns[-1]:g}; {message.decode()}"
        )
    e = direction_vector(STEP_DIRECTION)
    s_L, tau_L = separation[:rows, 1:] @ e, traction[:rows, 1:] @ e
    return _Path(_way(s_L), tau_L, separation[:rows, 0], float(work[rows - 1]))


def _way(s_L: Floats) -> Floats:
    return np.cumsum(np.abs(np.diff(s_L, prepend=0.0)))


def _step_error(
    path: str, sigma_N: float, tolerance: float, seconds: float, run: _Path, reference: _Path
) -> StepError:
    """Errors of a run compared with a run in fine increments; before the first slip tau_L is zero."""
    tau_L, s_N = (np.interp(run.way, reference.way, y) for y in (reference.tau_L, reference.s_N))
    line = np.interp(reference.way, np.append(0.0, run.way), np.append(0.0, run.tau_L))
    return StepError(
        path,
        sigma_N,
        tolerance,
        len(run.way),
        seconds,
        largest(run.tau_L - tau_L, reference.tau_L),
        largest(run.s_N - s_N, reference.s_N),
        abs(run.work / reference.work - 1.0),
        largest(line - reference.tau_L, reference.tau_L),
    )


QUANTITIES = (("tau_L", r"$\tau_L$"), ("s_N", "$s_N$"), ("work", "work"))


def draw_increments(quick: bool, tick: Tick) -> tuple[dict[str, Figure], str]:
    """Run the study of increments; return its pictures by name and its tables."""
    sizes = (30, 60) if quick else INCREMENTS
    tolerances = (1e-2, 1e-3) if quick else STEP_TOLERANCES
    errors = list(step_errors(sizes, tolerances, 1 if quick else 5, tick))
    fixed = [e for e in errors if e.tolerance == 0.0]
    figure, axes = new_figure(TWO, 4.6, nrows=2, ncols=3, sharex=True)
    for ax, (path, (name, label)) in zip(
        axes, [(path, q) for path in PATHS for q in QUANTITIES], strict=True
    ):
        _by_traction(ax, [e for e in fixed if e.path == path], "rows", name)
        log_axes(ax, "increments of the path", f"relative error of {label}")
        _orders(ax, sizes)
        ax.set_title(path)
    axes[2].legend(title=r"$\sigma_N$ [MPa]")
    against, axes = new_figure(TWO, 5.0, nrows=2, ncols=3, sharex="col")
    for i, path in enumerate(PATHS):
        here = [e for e in errors if e.path == path]
        for ax, (x, name, x_label, label) in zip(axes[3 * i : 3 * i + 3], COSTS, strict=True):
            _by_traction(ax, [e for e in here if e.tolerance == 0.0], x, name)
            _by_traction(ax, [e for e in here if e.tolerance > 0.0], x, name, adaptive=True)
            log_axes(ax, x_label, label)
            ax.set_title(path)
    handles = [Line2D([], [], color=COLOURS[i], label=signed(s)) for i, s in enumerate(SIGMA_N)]
    handles += [
        Line2D([], [], color="grey", marker="o", markersize=2.5, label="fixed"),
        Line2D([], [], color="grey", linestyle="--", marker="^", markerfacecolor="none", label="adaptive"),
    ]
    against.legend(handles=handles, title=r"$\sigma_N$ [MPa]", loc="outside lower center", ncols=6)
    return {"increments": figure, "adaptive": against}, _increment_tables(errors)


COSTS = (
    ("rows", "line", "rows", r"error of $\tau_L$, lines between rows"),
    ("seconds", "line", "time of a curve [s]", r"error of $\tau_L$, lines between rows"),
    ("seconds", "work", "time of a curve [s]", "error of the work"),
)
"""Cost, error and labels of the columns that compare fixed and adaptive increments."""


def _by_traction(ax: Axes, errors: Sequence[StepError], x: str, y: str, adaptive: bool = False) -> None:
    """Draw a line for each normal traction."""
    for i, sigma_N in enumerate(SIGMA_N):
        chosen = [e for e in errors if e.sigma_N == sigma_N]
        ax.plot(
            [getattr(e, x) for e in chosen],
            [getattr(e, y) for e in chosen],
            "^--" if adaptive else "o-",
            color=COLOURS[i],
            markersize=2.5,
            markerfacecolor="none" if adaptive else COLOURS[i],
            linewidth=1.0,
            label=signed(sigma_N),
        )


AIMED = (("line", "curve of τ_L", 1.0e-3), ("work", "work", 1.0e-4))
"""Target errors of the table that compares fixed and adaptive increments."""


def _increment_tables(errors: Sequence[StepError]) -> str:
    """Tables: orders and increments of fixed increments; rows and times of fixed and adaptive ones."""
    orders, needs = [], []
    for path in PATHS:
        for sigma_N in SIGMA_N:
            here = [e for e in errors if (e.path, e.sigma_N) == (path, sigma_N)]
            fixed = [e for e in here if e.tolerance == 0.0]
            cells = [_order(fixed, name) for name, _ in QUANTITIES]
            cells += [_text(_needed(fixed, n, aim), fixed) for n, _ in QUANTITIES for aim in AIMS[1:]]
            orders.append([path, signed(sigma_N), *cells])
            cells = []
            for name, _, aim in AIMED:
                for chosen in (fixed, [e for e in here if e.tolerance > 0.0]):
                    found = _needed(chosen, name, aim)
                    cells += [_text(found, chosen), f"{1e3 * found.seconds:.2f}" if found else ""]
            needs.append([path, signed(sigma_N), *cells])
    head = ["path", "σ_N [MPa]"]
    names = ("τ_L", "s_N", "work")
    first = [f"order, {q}" for q in names] + [f"{q} to {aim:.0e}" for q in names for aim in AIMS[1:]]
    second = [
        f"{label} to {aim:.0e}, {method}" if unit else "ms"
        for _, label, aim in AIMED
        for method in ("fixed", "adaptive")
        for unit in (True, False)
    ]
    return (
        f"{table([*head, *first], orders)}\n\nRows and times that an aim needs, fixed increments "
        "(doubled) and "
        f"adaptive ones (tolerance by half decades):\n\n{table([*head, *second], needs)}"
    )


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
