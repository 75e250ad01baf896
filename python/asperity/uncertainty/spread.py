"""Samples of uncertain constants through a load path: quantiles of the curves, and of peak, end and work."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np

from .. import contract
from ..case_files import Case, read_case
from ..contract import Floats
from ..parallel import map_in_order
from ..steps import thinned
from .distribution import Distribution, bad_constant, distribution_of, with_constants
from .paths import CURVES, LoadPath, load_paths

MOST_SAMPLES = 1_000_000
"""A sample takes up to 3 kB of memory."""

BATCH = 250
"""Samples of a task, whatever the number of workers."""

MOST_POINTS = 121
"""Largest number of points of a curve for which quantiles are computed; ends and reversals are among them."""

RESULTS = ("peak traction", "at slip", "traction at the end", "s_N at the end", "work")
"""Numbers of a sample; the peak is the largest size, and the work that of the traction on the whole path."""


@dataclass(frozen=True, eq=False)
class Spread:
    """Quantiles of a load path over the samples that have all of it.

    points (R,): rows of the path.  levels (L,).  curves (L, R, 3): in the order of CURVES.  results (k, 5):
    of each sample, in the order of RESULTS.  refused: samples out of the range of a constant, by its name.
    lost: samples without equilibrium.  case: curves (n, 3) and results (5,) of the case itself.
    """

    path: LoadPath
    points: np.ndarray
    levels: Floats
    curves: Floats
    results: Floats
    refused: Counter[str]
    lost: int
    case: tuple[Floats, Floats]

    @property
    def left_out(self) -> float:
        """Fraction of the samples that the quantiles do not contain."""
        out = self.lost + sum(self.refused.values())
        return out / (out + len(self.results))


def spread(
    path: LoadPath,
    names: Sequence[str],
    samples: Floats,
    levels: Sequence[float],
    executor: Executor | None = None,
    tick: Callable[[], object] = lambda: None,
    errors: Floats | None = None,
) -> Spread:
    """Quantiles over samples (N, p) of the constants with these names; tick: called after each batch.

    errors (N, 2): factors on the traction and on s_N, 1 without them.

    Raises ValueError where no sample has the whole path.
    """
    case = path.curve(path.props)
    points = thinned(path.x, MOST_POINTS)
    samples = np.hstack([samples, np.ones((len(samples), 2)) if errors is None else errors])
    batches = [samples[i : i + BATCH] for i in range(0, len(samples), BATCH)]
    done = map_in_order(partial(_batch, path, tuple(names), points), batches, executor, tick)
    parts = list(zip(*done, strict=True))
    curves, results = (np.concatenate(part) for part in parts[:2])
    refused: Counter[str] = sum(parts[2], Counter())
    lost = sum(parts[3])
    if not len(results):
        raise ValueError(
            f"none of {len(samples)} samples has the whole path: {sum(refused.values())} are out of range "
            f"({', '.join(refused) or 'no constant'}), {lost} lose equilibrium"
        )
    quantiles = np.stack([np.quantile(curves[:, i], levels, axis=0) for i in range(len(points))], axis=1)
    own = (case[0], _results(path.x, *case))
    return Spread(path, points, np.array(levels), quantiles, results, refused, lost, own)


def spreads(
    case: Case,
    distribution: Distribution,
    samples: int,
    seed: int,
    levels: Sequence[float],
    executor: Executor | None = None,
    tick: Callable[[], object] = lambda: None,
) -> list[Spread]:
    """Quantiles of each run of a case, all for the same samples."""
    paths, drawn = load_paths(case), distribution.draw(samples, seed)
    errors = distribution.factors(samples, seed)
    return [spread(path, distribution.names, drawn, levels, executor, tick, errors) for path in paths]


def uncertainty(
    case: Case | str | Path,
    sd: Mapping[str, float] | None = None,
    correlations: Mapping[tuple[str, str], float] | None = None,
    fit: str | Path | None = None,
    samples: int = 10_000,
    seed: int = 0,
    levels: Sequence[float] = (0.05, 0.5, 0.95),
    executor: Executor | None = None,
) -> list[Spread]:
    """Quantiles of the load path of a case whose constants are uncertain.

    Parameters
    ----------
    case
        Case with a prescribed slip or opening, or its file.
    sd, correlations
        Standard deviations by name, about the values of the case, and correlations of pairs of names.
    fit
        File of `asperity fit -o` with the covariance; None: that beside the case, unless sd is given.
    samples, seed
        Number of samples, and seed of the random numbers.
    levels
        Of the quantiles, increasing.
    executor
        As in `parallel.map_in_order`; the result is the same with any.

    Returns
    -------
    list of Spread
        For each value of the sweep, or one: `curves` (quantiles of traction, dilation and damage at
        `points` of the path), `results` of each sample in the order of RESULTS, and `left_out`.

    Raises
    ------
    ValueError
        For a case or a distribution that does not fit, and where no sample has the whole path.

    Examples
    --------
    >>> from asperity.installed import named_case
    >>> from asperity.uncertainty import uncertainty
    >>> [found] = uncertainty(named_case("figure05b"), sd={"mu": 0.05}, samples=50)
    >>> found.curves.shape[0], len(found.results), found.left_out
    (3, 50, 0.0)
    """
    check_samples(samples, seed, levels)
    one = case if isinstance(case, Case) else read_case(case)
    distribution, _ = distribution_of(one, None if fit is None else Path(fit), sd, correlations)
    return spreads(one, distribution, int(samples), int(seed), [*map(float, levels)], executor)


def check_samples(samples: int, seed: int, levels: Sequence[float]) -> None:
    """Raise ValueError for a number of samples, a seed or levels of quantiles that are out of range."""
    if not 2 <= contract.number("samples", samples) <= MOST_SAMPLES or samples != int(samples):
        raise ValueError(f"samples = {samples!r}: expected a whole number, 2 to {MOST_SAMPLES}")
    if not 0 <= contract.number("seed", seed) < np.inf or seed != int(seed):
        raise ValueError(f"seed = {seed!r}: expected a whole number >= 0")
    wanted = contract.array("levels", levels)
    if wanted.ndim != 1 or not wanted.size or not (np.diff([0.0, *wanted, 1.0]) > 0.0).all():
        text = "expected increasing numbers between 0 and 1, for quantiles"
        raise ValueError(f"levels = {contract.shown(levels)}: {text}")


def _batch(
    path: LoadPath, names: tuple[str, ...], points: np.ndarray, samples: Floats
) -> tuple[np.ndarray, Floats, Counter[str], int]:
    """Curves (k, R, 3) and results (k, 5) of a batch of samples, those refused, and the number of those lost.

    The curves are in single precision, to save memory.
    """
    curves = np.zeros((len(samples), len(points), len(CURVES)), dtype=np.float32)
    results, refused, lost = [], Counter[str](), 0
    for sample in samples:
        *sample, of_tau, of_dilation = sample
        props = with_constants(path.props, names, np.array(sample))
        bad = bad_constant(props, names)
        if bad is not None:
            refused[bad] += 1
            continue
        values, work = path.curve(props)
        if len(work) < path.x.size:
            lost += 1
            continue
        # the law misses the tests by so much
        values, work = values * [of_tau, of_dilation, 1.0], work * of_tau
        curves[len(results)] = values[points]
        results.append(_results(path.x, values, work))
    return curves[: len(results)], np.array(results).reshape(-1, len(RESULTS)), refused, lost


def _results(x: Floats, values: Floats, work: Floats) -> Floats:
    """Numbers of a curve in the order of RESULTS."""
    traction, s_N, _ = values.T
    peak = int(np.argmax(np.abs(traction)))
    return np.array([abs(traction[peak]), x[peak], traction[-1], s_N[-1], work[-1]])
