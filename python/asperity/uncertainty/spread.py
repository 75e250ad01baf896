"""Samples of uncertain constants through a load path: quantiles of the curves, and of peak, end and work."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from functools import partial

import numpy as np

from .. import contract
from ..contract import Floats
from ..parallel import map_in_order
from ..steps import turns_of
from .distribution import bad_constant
from .paths import CURVES, Curve, LoadPath

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
) -> Spread:
    """Quantiles over samples (N, p) of the constants with these names; tick: called after each batch.

    Raises ValueError where no sample has the whole path.
    """
    case = path.curve(path.props)
    points = points_of(path.x)
    batches = [samples[i : i + BATCH] for i in range(0, len(samples), BATCH)]
    done = map_in_order(partial(_batch, path, tuple(names), points), batches, executor, tick)
    refused: Counter[str] = sum((batch.refused for batch in done), Counter())
    curves, results = (
        np.concatenate([getattr(batch, name) for batch in done]) for name in ("curves", "results")
    )
    lost = sum(batch.lost for batch in done)
    if not len(results):
        raise ValueError(
            f"none of {len(samples)} samples has the whole path: {sum(refused.values())} are out of range "
            f"({', '.join(refused) or 'no constant'}), {lost} lose equilibrium"
        )
    quantiles = np.stack([np.quantile(curves[:, i], levels, axis=0) for i in range(len(points))], axis=1)
    own = (case.values, _results(path.x, case))
    return Spread(path, points, np.array(levels), quantiles, results, refused, lost, own)


def points_of(x: Floats) -> np.ndarray:
    """Rows of a path for which quantiles are computed."""
    even = np.linspace(0, x.size - 1, MOST_POINTS).round().astype(int)
    return np.unique(np.concatenate([even, turns_of(x)]))


@dataclass(frozen=True, eq=False)
class _Batch:
    """Curves (k, R, 3), in single precision to save memory, and results (k, 5) of a batch."""

    curves: np.ndarray
    results: Floats
    refused: Counter[str]
    lost: int


def _batch(path: LoadPath, names: tuple[str, ...], points: np.ndarray, samples: Floats) -> _Batch:
    """Curves and results of a batch of samples (k, p)."""
    places = [contract.index(name) for name in names]
    curves, results, lost = [], [], 0
    refused: Counter[str] = Counter()
    for sample in samples:
        props = path.props.copy()
        props[places] = sample
        bad = bad_constant(props, names)
        if bad is not None:
            refused[bad] += 1
            continue
        curve = path.curve(props)
        if len(curve.work) < path.x.size:
            lost += 1
            continue
        curves.append(curve.values[points].astype(np.float32))
        results.append(_results(path.x, curve))
    shape = (-1, len(points), len(CURVES))
    return _Batch(
        np.array(curves, dtype=np.float32).reshape(shape),
        np.array(results, dtype=float).reshape(-1, len(RESULTS)),
        refused,
        lost,
    )


def _results(x: Floats, curve: Curve) -> Floats:
    """Numbers of a curve in the order of RESULTS."""
    traction, s_N, _ = curve.values.T
    peak = int(np.argmax(np.abs(traction)))
    return np.array([abs(traction[peak]), x[peak], traction[-1], s_N[-1], curve.work[-1]])
