"""Work-precision studies: error against measured cost.

The studies vary increments (step size), planes (pattern), precision (single or double) and tangents.  The
parameters are those of Table 2, in mm and MPa.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from .. import _core, contract
from ..contract import Floats
from ..interface import Interface, work_along
from ..material import Material
from ..pattern import Pattern, direction_vector, unit_vector
from ..slip_curves import SlipCurves, slip_curves
from .fracture_energy import fracture_energy
from .newton import NewtonStudy, newton_path

SIGMA_N = (0.0, -1.0, -5.0, -10.0)
"""Normal tractions, MPa."""

SLIP = 0.6
"""Slip of a monotonic path, mm."""

AMPLITUDE = 0.4
"""Amplitude A of a cycle 0, +A, -A, +A, mm."""

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


# --- increments -------------------------------------------------------------------------------------


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

STEP_DIRECTION = 20.0
"""Direction of slip, degrees, which is no plane of symmetry of RP-4."""

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
    curve = slip_curves(interface, np.full(times, STEP_DIRECTION), slips, sigma_N, PRELOAD, threads=1)
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


# --- planes -----------------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False)
class Candidate:
    """Pattern of a family; sides: order of its symmetry; planes: number of all planes."""

    family: str
    sides: int
    planes: int
    pattern: Pattern

    @property
    def directions(self) -> Floats:
        """Directions from one plane of symmetry to the next, degrees; all others are equivalent to these."""
        return np.linspace(0.0, 180.0 / self.sides, DIRECTIONS)


DIRECTIONS = 9
"""Number of slip directions of a pattern."""

FLAT = 1.0 / 3.0
"""Weight of the flat plane, as in Table 4."""

REFERENCE_SIDES = 64
"""Sides of the reference; its spread over directions is 0.09 % at 30 degrees and mu = 0.5."""

EVEN = (4, 6, 8, 10, 12, 16, 24, 32, 48, 64)
ODD = (3, 5, 7, 9, 11, 13, 17, 25, 33, 49, 63)
RINGS = (3, 4, 5, 6, 8, 12, 16)

STAGGER = (2.5, 5.0)
"""Differences of the inclinations of two rings from that of the reference, degrees; 0 gives RP-2m."""


def regular(sides: int, theta: float) -> Candidate:
    """RP-m with the inclination of the reference."""
    family = "even" if sides % 2 == 0 else "odd"
    return Candidate(family, sides, sides + 1, Pattern.regular(sides, theta, FLAT))


def two_rings(sides: int, theta: float, difference: float) -> Candidate:
    """m planes at theta + difference and m at theta - difference, rotated by 180/m; costs as RP-2m."""
    normals, weights = [(1.0, 0.0, 0.0)], [FLAT]
    for k in range(2 * sides):
        angle = np.pi * k / sides
        slope = np.tan(np.radians(theta + (difference if k % 2 == 0 else -difference)))
        normals.append((1.0, *(-slope * unit_vector(angle))))
        weights.append((1.0 - FLAT) / (2 * sides))
    return Candidate(f"rings ±{difference:g}°", sides, 2 * sides + 1, Pattern.planes(normals, weights))


def candidates(theta: float) -> list[Candidate]:
    """All families."""
    rings = [two_rings(m, theta, difference) for difference in STAGGER for m in RINGS]
    return [*(regular(m, theta) for m in sorted(EVEN + ODD)), *rings]


def residual_spread(sides: int, theta: float, mu: float) -> float:
    """Ratio of the residual strengths up a plane and between two planes, minus 1."""
    facing, between = material(mu).residual_strength(theta, [0.0, 180.0 / sides])
    return float(facing / between - 1.0)


@dataclass(frozen=True)
class PlaneError:
    """Errors of a pattern against RP-64 of the same flat weight in the worst direction, and spreads.

    tau_L, across, s_N: L2 norms over the monotonic path, relative to tau_L and s_N of the reference. work:
    spread (largest over smallest, minus 1) over the directions of the work of that path, which is G_T at
    sigma_N = 0. loop: the same for the work of a closed loop of a cycle. seconds: time for one curve.
    """

    family: str
    sides: int
    planes: int
    theta: float
    mu: float
    sigma_N: float
    seconds: float
    tau_L: float
    across: float
    s_N: float
    work: float
    loop: float


PLANE_INCREMENTS = {"monotonic": 240, "cyclic": 800}
"""Number of increments of 0.0025 mm; their error is about the same for all patterns and directions."""

ENERGY_TOLERANCE = 1.0e-5
"""G_T counts as converged if the last halving of the steps changes it by at most this fraction of Gc."""


def plane_errors(
    chosen: Iterable[Candidate],
    theta: float,
    mu: float,
    tractions: Sequence[float] = SIGMA_N,
    repeats: int = 3,
    tick: Tick = lambda: None,
) -> Iterator[PlaneError]:
    """Errors of candidates at each of the normal tractions."""
    slips = monotonic(PLANE_INCREMENTS["monotonic"])
    loops = cycle(PLANE_INCREMENTS["cyclic"])
    held = np.array(tractions)
    reference = slip_curves(
        Interface(material(mu), Pattern.regular(REFERENCE_SIDES, theta, FLAT)), 0.0, slips, held, PRELOAD
    )
    for candidate in chosen:
        interface = Interface(material(mu), candidate.pattern)
        angles = candidate.directions
        for i, sigma_N in enumerate(held):
            curves, seconds = timed(
                lambda: slip_curves(interface, angles, slips, sigma_N, PRELOAD, threads=1),  # noqa: B023
                repeats,
            )
            tau, s_N = reference.tau_L[i], reference.s_N[i]
            everywhere = np.tile(tau, (len(angles), 1))
            yield PlaneError(
                candidate.family,
                candidate.sides,
                candidate.planes,
                theta,
                mu,
                float(sigma_N),
                seconds / len(angles),
                relative(curves.tau_L - tau, everywhere),
                relative(curves.tau_across, everywhere),
                relative(curves.s_N - s_N, np.tile(s_N, (len(angles), 1))),
                # at sigma_N = 0 the error of the increments exceeds the spread of fine patterns
                _spread(curves.work[:, -1])
                if sigma_N < 0.0
                else fracture_energy(material(mu), candidate.pattern, angles, ENERGY_TOLERANCE).spread,
                _spread(_loops(slip_curves(interface, angles, loops, sigma_N, PRELOAD)))
                if sigma_N < 0.0
                else np.nan,
            )
            tick()


def _spread(values: Floats) -> float:
    return float(values.max() / values.min() - 1.0)


def _loops(curves: SlipCurves) -> Floats:
    """Work of the closed loop of the last two strokes of a cycle."""
    first = curves.slips.size // 5 - 1
    tau, s = curves.tau_L[:, first:], curves.slips[first:]
    return np.sum(0.5 * (tau[:, 1:] + tau[:, :-1]) * np.diff(s), axis=1)


def pareto(points: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Pareto front: points (cost, error) such that no other point is smaller in both."""
    front: list[tuple[float, float]] = []
    for cost, error in sorted(points):
        if not front or error < front[-1][1]:
            front.append((cost, error))
    return front


# --- tangents ---------------------------------------------------------------------------------------

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


# --- precision --------------------------------------------------------------------------------------

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
