"""Error of the law in single precision."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from asperity import _core, contract
from asperity.contract import Floats
from asperity.interface import Interface, work_along
from asperity.pattern import Pattern, direction_vector
from asperity.slip_curves import slip_curves
from asperity.style import COLOURS, LINES, TWO, new_figure
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from .chart_axes import log_axes, table
from .common import (
    PRELOAD,
    STEP_DIRECTION,
    Tick,
    cycle,
    material,
)

WAYS = {
    1: "total separations",
    2: "increments, added up (VUMAT)",
    3: "increments, compensated sums",
}
"""Forms in which the single-precision law receives the separation."""

CYCLE_ROWS = 20000
"""Increments of a cycle of the long path."""

REPLAY = 1_000_000
"""Increments of the long path."""


@dataclass(frozen=True, eq=False)
class Drift:
    """Errors of the single-precision law over the number of increments (R,); each is the largest so far.

    traction: relative to the largest traction of the path; friction and work: relative errors of the sums.
    """

    pattern: str
    way: str
    increments: Floats
    traction: Floats
    friction: Floats
    work: Floats
    seconds: float


def long_path(interface: Interface, sigma_N: float, increments: int, rows: int = CYCLE_ROWS) -> Floats:
    """Separations (T, 3) of cycles along 20 degrees: one cycle under a constant sigma_N, repeated."""
    quarter = rows // 4
    slips = cycle(5 * quarter)
    curve = slip_curves(interface, STEP_DIRECTION, slips, sigma_N, PRELOAD)
    s = np.column_stack([curve.s_N[0], np.outer(slips, direction_vector(STEP_DIRECTION))])
    loop = s[-4 * quarter :]
    times = int(np.ceil(max(increments - quarter, 0) / len(loop)))
    return np.concatenate([s[:quarter], *[loop] * times])[:increments].copy()


def single_replay(interface: Interface, way: int, s: Floats, stride: int) -> tuple[Floats, Floats, Floats]:
    """Traction (R, 3), damage (R,) and rupture, friction, work (R, 3) of every stride-th row.

    In single precision; way: WAYS.  Raises ValueError for constants beyond the range of single precision.
    """
    rows = len(s) // stride
    traction, damage, work = np.empty((rows, 3)), np.empty(rows), np.empty((rows, 3))
    status = _core.interface_single_replay(interface.props(), way, s.T, stride, traction.T, damage, work.T)
    if status != 0:
        raise ValueError(f"status {status}: expected constants within the range of single precision")
    return traction, damage, work


def drifts(
    increments: int = REPLAY, rows: int = CYCLE_ROWS, sigma_N: float = -1.0, tick: Tick = lambda: None
) -> Iterator[Drift]:
    """Single against double precision along cycles, for the flat plane and RP-4."""
    # The stride does not divide the increments of a cycle, so the rows lie at all stages of the cycle.
    stride = max(1, increments // 1000 - 3)
    for name, pattern in (("flat", Pattern.regular(0, 0.0)), ("RP-4", Pattern.regular(4, 30.0))):
        interface = Interface(material(), pattern)
        s = long_path(interface, sigma_N, increments, rows)
        traction, sums = _rows(interface, s, stride)
        tick()
        count = np.arange(1, len(traction) + 1) * stride
        for way, label in WAYS.items():
            start = time.perf_counter()
            found, _, work = single_replay(interface, way, s, stride)
            seconds = time.perf_counter() - start
            error = np.abs(found - traction).max(axis=1) / np.abs(traction).max()
            ledger = np.abs(work - sums) / np.abs(sums).max(axis=0)
            friction, total = (np.maximum.accumulate(ledger[:, i]) for i in (1, 2))
            yield Drift(name, label, count, np.maximum.accumulate(error), friction, total, seconds)
            tick()


def _rows(interface: Interface, s: Floats, stride: int) -> tuple[Floats, Floats]:
    """Traction (R, 3) and rupture, friction, work (R, 3) of every stride-th row in double precision."""
    traction, state = np.empty_like(s), np.empty((len(s), interface.nstatv))
    status, message = _core.interface_replay(interface.props(), s.T, np.zeros(len(s)), traction.T, state.T)
    if status != 0:
        raise ValueError(message.decode("ascii").rstrip())
    rupture, friction = (state[:, contract.statev_index(name)] for name in ("rupture", "friction"))
    sums = np.column_stack([rupture, friction, work_along(s, traction)])
    return traction[stride - 1 :: stride].copy(), sums[stride - 1 :: stride].copy()


REACH = 1000.0
"""End of a long slide, mm: 5000 s_f."""

SLIDE = 100_000
"""Increments of a long slide."""

START = 1.0
"""Slip at which the slide starts, mm: all planes are fully damaged there."""

CARRIED = "increments, gap and elastic part carried"
"""Fully damaged planes with the state (s_n, s_T - s_di) instead of s and s_di."""


@dataclass(frozen=True, eq=False)
class Distance:
    """Relative error of the traction over the slip (R,), mm; the largest error so far."""

    pattern: str
    way: str
    slip: Floats
    traction: Floats


def distances(
    increments: int = SLIDE, reach: float = REACH, sigma_N: float = -1.0, tick: Tick = lambda: None
) -> Iterator[Distance]:
    """Single against double precision along a long monotonic slide of RP-4, at its residual strength."""
    interface = Interface(material(), Pattern.regular(4, 30.0))
    slips = np.concatenate([START * np.arange(1, 401) / 400.0, np.linspace(START, reach, increments + 1)[1:]])
    curve = slip_curves(interface, STEP_DIRECTION, slips, sigma_N, PRELOAD)
    s = np.column_stack([curve.s_N[0], np.outer(slips, direction_vector(STEP_DIRECTION))])
    traction, state = np.empty_like(s), np.empty((len(s), interface.nstatv))
    _core.interface_replay(interface.props(), s.T, np.zeros(len(s)), traction.T, state.T)
    tick()
    size = np.abs(traction[400:]).max()
    for way, label in WAYS.items():
        found, _, _ = single_replay(interface, way, s, 1)
        error = np.abs(found - traction).max(axis=1)[400:] / size
        yield Distance("RP-4", label, slips[400:], np.maximum.accumulate(error))
        tick()
    found = _carried(interface, s[399:], state[399])
    error = np.abs(found - traction[400:]).max(axis=1) / size
    yield Distance("RP-4", CARRIED, slips[400:], np.maximum.accumulate(error))
    tick()


def _carried(interface: Interface, s: Floats, state: Floats) -> Floats:
    """Tractions (T - 1, 3) of fully damaged planes from s[0] on, in single precision, by increments.

    This is the law of section 3 of docs/theory.md for alpha = 1, with s_T - s_di as the state and a
    compensated sum for s_n.
    """
    kind = np.float32
    m, p = interface.material, interface.pattern
    stiffness = kind(m.K)
    n = p.normals
    slope = np.linalg.norm(n[:, 1:], axis=1)
    h = np.where(
        slope[:, None] > 0.0, np.cross([1.0, 0.0, 0.0], n) / np.maximum(slope, 1e-9)[:, None], (0, 0, 1)
    )
    t = np.where(slope[:, None] > 0.0, np.cross(n, h), (0.0, 1.0, 0.0))
    planes = state[contract.plane_statev(1) :].reshape(len(n), 3)
    tangents = np.stack([t, h], axis=1)
    elastic = (np.einsum("kij,j->ki", tangents, s[0]) - planes[:, 1:]).astype(kind)
    gap, low = (n @ s[0]).astype(kind), np.zeros(len(n), kind)
    weighted = (p.weights[:, None] * n).astype(kind), (p.weights[:, None, None] * tangents).astype(kind)
    n, tangents, mu = n.astype(kind), tangents.astype(kind), kind(m.mu)
    steps = np.diff(s, axis=0).astype(kind)
    found = np.empty(steps.shape)
    for i, ds in enumerate(steps):
        part = n @ ds - low
        total = gap + part
        gap, low = total, (total - gap) - part
        elastic = elastic + tangents @ ds
        closed = np.minimum(gap, 0)
        limit = -mu * closed
        size = np.sqrt(np.sum(elastic**2, axis=1))
        keep = np.where(size <= limit, kind(1), limit / np.maximum(size, np.finfo(kind).tiny))
        elastic = elastic * keep[:, None]
        found[i] = stiffness * (closed @ weighted[0] + np.einsum("ki,kij->j", elastic, weighted[1]))
    return found


def draw_precision(quick: bool, tick: Tick) -> tuple[dict[str, Figure], str]:
    """Run the study of precision; return its picture by name and its tables."""
    if quick:
        shown = list(drifts(20000, 2000, tick=tick))
        slides = list(distances(500, 5.0, tick=tick))
    else:
        shown = list(drifts(tick=tick))
        slides = list(distances(tick=tick))
    figure, axes = new_figure(TWO, 3.2, ncols=3)
    shades = dict(zip([*WAYS.values(), CARRIED], COLOURS, strict=False))
    for ax, name, label in (
        (axes[0], "traction", "error of the traction [-]"),
        (axes[1], "work", "error of the work [-]"),
    ):
        for d in shown:
            ax.plot(d.increments, getattr(d, name), LINES[d.pattern == "flat"], color=shades[d.way])
        log_axes(ax, "increments [-]", label)
    axes[0].set_title("cycles of ±0.4 mm")
    axes[1].set_title("cycles of ±0.4 mm")
    for d in slides:
        axes[2].plot(d.slip, d.traction, color=shades[d.way])
    log_axes(axes[2], "slip [mm]", "error of the traction [-]")
    axes[2].set_title("slide up a plane of RP-4" if not quick else "slide")
    handles = [Line2D([], [], color=shade, label=way) for way, shade in shades.items()]
    handles += [
        Line2D([], [], color="grey", label="RP-4"),
        Line2D([], [], color="grey", linestyle="--", label="flat"),
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return {"precision": figure}, _precision_table(shown, slides)


def _precision_table(drifts: Sequence[Drift], slides: Sequence[Distance]) -> str:
    rows = [
        [
            d.pattern,
            d.way,
            f"{d.increments[-1]:.0e}",
            f"{d.traction[-1]:.1e}",
            f"{d.friction[-1]:.1e}",
            f"{d.work[-1]:.1e}",
        ]
        for d in drifts
    ]
    first = table(["pattern", "separation of the law", "increments", "traction", "friction", "work"], rows)
    ends = [10.0, 100.0, slides[0].slip[-1]]
    rows = []
    for d in slides:
        cells = [
            f"{d.traction[np.searchsorted(d.slip, end * (1 - 1e-9))]:.1e}"
            for end in ends
            if end <= d.slip[-1]
        ]
        rows.append([d.way, *cells])
    head = ["separation of the law", *(f"{end:g} mm" for end in ends if end <= slides[0].slip[-1])]
    second = table(head, rows)
    return f"Relative errors after the cycles:\n\n{first}\n\nof the traction, after a slide:\n\n{second}"
