"""Samples of uncertain constants through a load path: quantiles of the curves, and of peak, end and work."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from ... import contract
from ...case_files import Case, Run, read_case
from ...contract import Floats
from ...history import SEPARATION
from ...load_path import rows_of
from ...parallel import map_in_order
from ...pattern import direction_vector
from ...steps import Step, numbers_of, prescribed, thinned
from ..fit.written import with_constants
from .distribution import Distribution, bad_constant, distribution_of

CURVES = ("traction", "dilation", "damage")
"""Curves of a sample: traction along the slip (without slip along N), s_N and damage."""

MOST_SAMPLES = 1_000_000  # a sample takes up to 3 kB of memory
BATCH = 250  # samples of a task, whatever the number of workers
ROUNDING = 1.0e-9  # of a slip, over the largest one
MOST_POINTS = 121
"""Largest number of points of a curve for which quantiles are computed; ends and reversals are among them."""

RESULTS = ("peak traction", "at slip", "traction at the end", "s_N at the end", "work")
"""Numbers of a sample; the peak is the largest size, and the work that of the traction on the whole path."""


@dataclass(frozen=True, eq=False)
class LoadPath:
    """Load path of one run of a case, as PROPS -> curves over the abscissa x (n,), which is prescribed.

    slips: whether x is a slip (or an opening).  first: first row of the path on the curves, where 0 is the
    virgin point before them.  e (3,): direction of x, in which the traction is shown.  spring: stiffness in
    series with the joint, 0 without one; x is then the slip of both.
    """

    run: Run
    x: Floats
    slips: bool
    first: int
    e: Floats
    spring: float = 0.0

    def curve(self, props: Floats) -> tuple[Floats, Floats]:
        """Curves of a joint with these constants, (n, 3), and work (n,); n is smaller where it is lost."""
        rows, _ = rows_of(props, self.run.steps)
        values = np.column_stack([rows.traction @ self.e, rows.dilation, rows.damage])
        with_start = np.vstack([np.zeros(3), values])
        return with_start[self.first :], np.append(0.0, rows.work)[self.first :]


def load_path(path: Path, run: Run) -> LoadPath:
    """Load path of a run of a case; raises ValueError for one without a prescribed x or that is lost."""
    if run.start != "virgin" or not run.steps:
        what = f"&{run.start}" if run.steps else "&replay"
        raise ValueError(f"{path}: {what}: expected &step from a virgin state")
    if run.tolerance is not None or any(step.follow == "branch" for step in run.steps):
        what = "tolerance" if run.tolerance is not None else "follow = 'branch'"
        raise ValueError(f"{path}: {what}: expected increments, which all samples share")
    e, spring = _abscissa(path, run.steps)
    rows, lost = run.interface.rows(run.steps)
    x = np.append(0.0, rows.separation @ e + (rows.traction @ e / spring if spring else 0.0))
    if lost:
        raise ValueError(
            f"the case itself loses equilibrium beyond {x[-1]:g}: expected one to the end of its path"
        )
    # the row before x moves is the start of the curve; the slip of a spring has the rounding errors of both
    first = int(np.argmax(np.abs(np.diff(x)) > (ROUNDING * np.abs(x).max() if spring else 0.0)))
    return LoadPath(run, x[first:], bool(e[0] == 0.0), first, e, spring)


def _abscissa(path: Path, steps: Sequence[Step]) -> tuple[Floats, float]:
    """Unit vector (3,) of the prescribed separation over which curves are drawn, and the spring in series.

    The separation is a slip or s_N.  A shear box with a spring in series prescribes the tractions t_Tx, t_Ty
    = k times the slip of both, beside springs k_Tx = k_Ty = k of the joint.
    """
    unit = dict(zip(SEPARATION, np.eye(3), strict=True))
    for names in (("slip", "s_Tx", "s_Ty"), ("s_N",)):
        for step in steps:
            moved = [name for name in names if getattr(step, name) is not None]
            if moved:
                along = direction_vector(step.direction or 0.0)
                e = np.array([0.0, *along]) if moved[0] == "slip" else unit[moved[0]]
                if not any(traction[i] for traction in prescribed(steps) for i in np.flatnonzero(e)):
                    return e, 0.0
                break
    boxes = [step for step in steps if step.k_Tx and step.k_Tx == step.k_Ty and step.t_Tx is not None]
    if boxes and boxes[0] is steps[-1]:
        numbers = numbers_of(boxes[0])
        first = np.array([0.0, numbers["t_Tx"][0], numbers.get("t_Ty", (0.0,))[0]])
        if np.linalg.norm(first) > 0.0:
            return first / np.linalg.norm(first), numbers["k_Tx"][0]
    raise ValueError(f"{path}: expected &step with a prescribed slip or opening, over which curves are drawn")


@dataclass(frozen=True, eq=False)
class Spread:
    """Quantiles of a load path over the samples that have all of it.

    distribution: of the constants.  points (R,): rows of the path.  levels (L,).  curves (L, R, 3): in the
    order of CURVES.  results (k, 5): of each sample, in the order of RESULTS.  out: samples without a result,
    by the reason.  case: curves (n, 3) and results (5,) of the case itself.
    """

    path: LoadPath
    distribution: Distribution
    points: np.ndarray
    levels: Floats
    curves: Floats
    results: Floats
    out: Counter[str]
    case: tuple[Floats, Floats]

    @property
    def left_out(self) -> float:
        """Fraction of the samples that the quantiles do not contain."""
        return self.out.total() / (self.out.total() + len(self.results))


def spread(
    path: LoadPath,
    distribution: Distribution,
    samples: int,
    seed: int,
    levels: Floats,
    executor: Executor | None = None,
    tick: Callable[[], object] = lambda: None,
) -> Spread:
    """Quantiles over samples of a distribution; tick: called after each batch.

    Raises ValueError where no sample has the whole path.
    """
    case = path.curve(np.array(path.run.props))
    points = thinned(path.x, MOST_POINTS)
    drawn = np.hstack([distribution.draw(samples, seed), distribution.factors(samples, seed)])
    batches = [drawn[i : i + BATCH] for i in range(0, samples, BATCH)]
    done = map_in_order(partial(_batch, path, distribution.names, points), batches, executor, tick)
    curves, results = (np.concatenate(part) for part in list(zip(*done, strict=True))[:2])
    out: Counter[str] = sum((reasons for *_, reasons in done), Counter())
    if not len(results):
        why = ", ".join(f"{count} {reason}" for reason, count in out.items())
        raise ValueError(f"none of {samples} samples has the whole path: {why}")
    quantiles = np.stack([np.quantile(curves[:, i], levels, axis=0) for i in range(len(points))], axis=1)
    of_case = (case[0], _results(path.x, *case))
    return Spread(path, distribution, points, levels, quantiles, results, out, of_case)


def uncertainty(
    case: Case | str | Path,
    sd: Mapping[str, float] | None = None,
    correlations: Mapping[tuple[str, str], float] | None = None,
    fit: str | Path | None = None,
    samples: int = 10_000,
    seed: int = 0,
    levels: Sequence[float] = (0.05, 0.5, 0.95),
    executor: Executor | None = None,
    tick: Callable[[], object] = lambda: None,
) -> list[Spread]:
    """Quantiles of the load path of a case whose constants are uncertain, one for each value of its sweep.

    case: with a prescribed slip or opening, or its file.  sd, correlations: standard deviations by name,
    about the values of the case, and correlations of pairs of names.  fit: file of `asperity fit -o` with the
    covariance; None: that beside the case, unless sd is given.  samples: their number.  seed: of the random
    numbers.  levels: of the quantiles, increasing.  executor: as in `parallel.map_in_order`; the result is
    the same with any.  tick: called after each batch of samples.  Raises ValueError for a case or a
    distribution that does not fit, and where no sample has the whole path.

    Examples
    --------
    >>> from asperity.installed import named_case
    >>> from asperity.tools.uncertainty import uncertainty
    >>> [spread] = uncertainty(named_case("figure05b"), sd={"mu": 0.05}, samples=50)
    >>> spread.curves.shape[0], len(spread.results), spread.left_out
    (3, 50, 0.0)
    """
    known = case if isinstance(case, Case) else read_case(case)
    distribution = distribution_of(known, None if fit is None else Path(fit), sd, correlations)
    if not 2 <= contract.number("samples", samples) <= MOST_SAMPLES or samples != int(samples):
        raise ValueError(f"samples = {samples!r}: expected a whole number, 2 to {MOST_SAMPLES}")
    if not 0 <= contract.number("seed", seed) < np.inf or seed != int(seed):
        raise ValueError(f"seed = {seed!r}: expected a whole number >= 0")
    wanted = contract.array("levels", levels)
    if wanted.ndim != 1 or not wanted.size or not (np.diff([0.0, *wanted, 1.0]) > 0.0).all():
        text = "expected increasing numbers between 0 and 1, for quantiles"
        raise ValueError(f"levels = {contract.shown(levels)}: {text}")
    arguments = distribution, int(samples), int(seed), wanted, executor, tick
    return [spread(load_path(known.path, run), *arguments) for run in known.runs]


def _batch(
    path: LoadPath, names: tuple[str, ...], points: np.ndarray, samples: Floats
) -> tuple[np.ndarray, Floats, Counter[str]]:
    """Curves (k, R, 3) and results (k, 5) of a batch of samples, and the reasons of those without.

    The curves are in single precision, to save memory.
    """
    curves = np.zeros((len(samples), len(points), len(CURVES)), dtype=np.float32)
    results, out = list[Floats](), Counter[str]()
    for *sample, of_tau, of_dilation in samples:
        props = with_constants(path.run.props, names, sample)
        bad = bad_constant(props, names)
        values, work = path.curve(props) if bad is None else (np.zeros((0, 3)), np.zeros(0))
        if len(work) < path.x.size:
            out["without equilibrium on the whole path" if bad is None else f"out of the range of {bad}"] += 1
            continue
        # the law misses the tests by so much
        values, work = values * [of_tau, of_dilation, 1.0], work * of_tau
        curves[len(results)] = values[points]
        results.append(_results(path.x, values, work))
    return curves[: len(results)], np.array(results).reshape(-1, len(RESULTS)), out


def _results(x: Floats, values: Floats, work: Floats) -> Floats:
    """Numbers of a curve in the order of RESULTS."""
    traction, s_N, _ = values.T
    peak = int(np.argmax(np.abs(traction)))
    return np.array([abs(traction[peak]), x[peak], traction[-1], s_N[-1], work[-1]])
